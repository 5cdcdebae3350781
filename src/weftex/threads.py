"""How many threads to use."""

from __future__ import annotations

import os

from weftex.errors import InvalidInputError


def thread_count(threads: int | None) -> int:
    """Return how many threads to use: at most `threads`, by default one a processor.

    Raises
    ------
    InvalidInputError
        If it is not an integer of 1 or more.
    """
    if threads is not None and (type(threads) is not int or threads < 1):
        raise InvalidInputError(f"threads is {threads!r}; it must be an integer of 1 or more")
    return threads or os.cpu_count() or 1
