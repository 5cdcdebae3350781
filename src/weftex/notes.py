"""What a method says of its work while it runs, for whoever wants to see how it works.

A step of a method that is worth showing calls `note`; `weftex.explain` listens. Nobody else does,
so that it costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Listener:
    """Somebody who wants to see how one pixel of the output is made.

    Attributes
    ----------
    pixel : (int, int)
        Its row and column.
    hear : callable
        Called as ``hear(step, facts)`` for each note; arrays among the facts will change.
    """

    pixel: tuple[int, int]
    hear: Callable[[str, dict[str, Any]], None]


_LISTENER: ContextVar[Listener | None] = ContextVar("listener", default=None)


@contextmanager
def listening(listener: Listener | None) -> Iterator[None]:
    """Send the notes of all that is called meanwhile, in this thread, to a listener."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)


def note(step: str, **facts: Any) -> None:
    """Say what a step has in hand.

    Examples
    --------
    >>> with listening(Listener((0, 0), lambda step, facts: print(step, facts))):
    ...     note("cut", cost=7)
    cut {'cost': 7}
    >>> note("cut", cost=9)
    """
    listener = _LISTENER.get()
    if listener is not None:
        listener.hear(step, facts)


def pixel_asked(level: int = 0) -> tuple[int, int] | None:
    """Return the pixel that somebody asks about, at a level of a pyramid; None if nobody does."""
    listener = _LISTENER.get()
    return None if listener is None else (listener.pixel[0] >> level, listener.pixel[1] >> level)


def is_asked(box: tuple[int, int, int, int], shape: tuple[int, ...], level: int = 0) -> bool:
    """Whether the pixel asked about lies in a box (top, left, height, width), which may go around.

    Examples
    --------
    >>> with listening(Listener((1, 9), print)):
    ...     is_asked((0, 8, 4, 4), (10, 10)), is_asked((2, 8, 4, 4), (10, 10))
    (True, False)
    """
    pixel = pixel_asked(level)
    if pixel is None:
        return False
    ends = zip(pixel, box[:2], box[2:], shape, strict=False)
    return all((at - first) % n < length for at, first, length, n in ends)


def asked_among(
    places: NDArray[np.int32], columns: int, *, level: int | None = 0, top: int = 0
) -> int | None:
    """Return which of some pixels is the one asked about.

    Parameters
    ----------
    places : int32 array (n,)
        Flat indices.
    columns : int
        Of the picture.
    level : int, optional
        Of a pyramid; None for a picture that is not a part of the output.
    top : int
        Rows that the picture has above the output.
    """
    pixel = None if level is None else pixel_asked(level)
    if pixel is None:
        return None
    found = np.flatnonzero(places == (pixel[0] + top) * columns + pixel[1])
    return int(found[0]) if len(found) else None


def parts(
    places: NDArray[np.int32], columns: int, *, level: int | None = 0, top: int = 0
) -> list[tuple[slice, bool]]:
    """Split pixels that are made in turn so that the one asked about is on its own.

    Parameters are those of `asked_among`.

    Returns
    -------
    list of (slice, bool)
        Parts of `places`, and whether a part is the pixel asked about; all in one if it is not
        there.

    Examples
    --------
    >>> parts(np.arange(10, 15), 10)
    [(slice(0, 5, None), False)]
    >>> with listening(Listener((1, 2), print)):
    ...     parts(np.arange(10, 15), 10)
    [(slice(0, 2, None), False), (slice(2, 3, None), True), (slice(3, 5, None), False)]
    """
    k = asked_among(places, columns, level=level, top=top)
    if k is None:
        return [(slice(0, len(places)), False)]
    ends = [(0, k), (k, k + 1), (k + 1, len(places))]
    return [(slice(first, last), first == k) for first, last in ends if first < last]
