"""Windows of a plane, and which plane it is."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from weftex.canvas import FAR, Canvas
from weftex.errors import InvalidInputError, whole_pair, wrong_value

#: What every block of a plane is, to refuse parameters that have no effect there: a hole.
A_BLOCK = Canvas(1, 2, known=np.zeros((1, 2), np.uint8), hole=np.array([[True, False]]))

#: Row and column in the plane.
Corner = tuple[int, int]


class Span(NamedTuple):
    """Pixels from `first` to `last` - 1 of an axis."""

    first: int
    last: int

    def grown(self, by: int) -> Span:
        """The same and `by` more pixels on either side."""
        return Span(self.first - by, self.last + by)


class Box(NamedTuple):
    """Rows and columns of the plane."""

    rows: Span
    columns: Span

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.rows.last - self.rows.first, self.columns.last - self.columns.first

    def grown(self, down: int, across: int) -> Box:
        """The same box, larger by a number of pixels on each side."""
        return Box(self.rows.grown(down), self.columns.grown(across))

    def has(self, other: Box) -> bool:
        """Whether another box lies in this one."""
        both = zip(self, other, strict=True)
        return all(a.first <= b.first and b.last <= a.last for a, b in both)

    def within(self, other: Box) -> tuple[slice, slice]:
        """What both share, in indices of the other one; empty where they share nothing."""
        rows, columns = (
            slice(max(a.first, b.first) - b.first, max(0, min(a.last, b.last) - b.first))
            for a, b in ((self.rows, other.rows), (self.columns, other.columns))
        )
        return rows, columns


class PlaneRequest(NamedTuple):
    """Which plane, and how it is made."""

    seed: int
    period: tuple[int, int] | None
    threads: int = 1

    @property
    def told(self) -> dict[str, Any]:
        """What a result says of it."""
        return {"seed": self.seed} | ({} if self.period is None else {"period": [*self.period]})


def around(boxes: list[Box]) -> Box:
    """The smallest box that has all of these."""
    down, across = (
        Span(min(span.first for span in spans), max(span.last for span in spans))
        for spans in zip(*boxes, strict=True)
    )
    return Box(down, across)


def canvas_of(box: Box) -> Canvas:
    """The canvas of a window; without its place where that is just beyond the farthest one."""
    corner = box.rows.first, box.columns.first
    return Canvas(*box.shape, origin=corner if max(map(abs, corner)) <= FAR else (0, 0))


def box_of(top: int, left: int, height: int, width: int) -> Box:
    """The box of a window."""
    return Box(Span(top, top + height), Span(left, left + width))


def as_period(period: int | tuple[int, int] | None) -> tuple[int, int] | None:
    """Height and width of a plane's period from one number or two; raises if out of range."""
    if period is None:
        return None
    sides = whole_pair(period, 1, FAR)
    if sides is None:
        wanted = "a whole number of pixels from 1 to 2**40, or two of them"
        raise wrong_value("period", period, wanted)
    return sides


def check_period(period: tuple[int, int] | None, least: int) -> None:
    """Raise `InvalidInputError` if a plane's period is too short for its blocks."""
    for name, length in zip(("height", "width"), period or (), strict=False):
        if length < least:
            raise InvalidInputError(
                f"period has the {name} {length}; it must be {least} or more with this sample"
            )
