"""Notes of a method while it runs, from which `weftex.explanation.explain` makes its stages.

A step of a method calls `note`; without a listener that costs nothing.
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
    """A callback `record(step, facts)` for how one `pixel` (row, column) of the output is made.

    Arrays among the facts will change later.
    """

    pixel: tuple[int, int]
    record: Callable[[str, dict[str, Any]], None]


_LISTENER: ContextVar[Listener | None] = ContextVar("listener", default=None)


@contextmanager
def listening(listener: Listener | None) -> Iterator[None]:
    """Send the notes of all calls in this context to a listener."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)


def note(step: str, **facts: Any) -> None:
    """Report a step and its values to the listener, if there is one."""
    listener = _LISTENER.get()
    if listener is not None:
        listener.record(step, facts)


def pixel_asked(level: int = 0) -> tuple[int, int] | None:
    """Return the pixel that is explained, at a level of a pyramid; None without a listener."""
    listener = _LISTENER.get()
    return None if listener is None else (listener.pixel[0] >> level, listener.pixel[1] >> level)


def is_asked(box: tuple[int, int, int, int], shape: tuple[int, ...], level: int = 0) -> bool:
    """Whether the listener's pixel lies in a box (top, left, height, width), which may wrap."""
    pixel = pixel_asked(level)
    if pixel is None:
        return False
    ends = zip(pixel, box[:2], box[2:], shape, strict=False)
    return all((at - first) % n < length for at, first, length, n in ends)


def asked_among(
    places: NDArray[np.int32], columns: int, *, level: int | None = 0, top: int = 0
) -> int | None:
    """The position of the listener's pixel among flat indices `places` (n,), or None.

    `level` is the pyramid level, None for a picture outside the output; `top` counts extra rows
    above.
    """
    pixel = None if level is None else pixel_asked(level)
    if pixel is None:
        return None
    found = np.flatnonzero(places == (pixel[0] + top) * columns + pixel[1])
    return int(found[0]) if len(found) else None


def parts(
    places: NDArray[np.int32], columns: int, *, level: int | None = 0, top: int = 0
) -> list[tuple[slice, bool]]:
    """Split `places` into slices so that the listener's pixel is alone; each with whether it is."""
    k = asked_among(places, columns, level=level, top=top)
    if k is None:
        return [(slice(0, len(places)), False)]
    ends = [(0, k), (k, k + 1), (k + 1, len(places))]
    return [(slice(first, last), first == k) for first, last in ends if first < last]
