"""Windows of a plane, and which plane it is."""

from __future__ import annotations

from typing import Any, NamedTuple

from weftex.canvas import FAR, Canvas


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
        """The same and so many more pixels on either side."""
        return Box(self.rows.grown(down), self.columns.grown(across))

    def within(self, other: Box) -> tuple[slice, slice]:
        """What both share, in indices of the other one; empty where they share nothing."""
        rows, columns = (
            slice(max(a.first, b.first) - b.first, max(0, min(a.last, b.last) - b.first))
            for a, b in ((self.rows, other.rows), (self.columns, other.columns))
        )
        return rows, columns


class Asked(NamedTuple):
    """Which plane, and how it is made."""

    seed: int
    period: tuple[int, int] | None
    threads: int = 1

    @property
    def told(self) -> dict[str, Any]:
        """What a result says of it."""
        return {"seed": self.seed} | ({} if self.period is None else {"period": [*self.period]})


def canvas_of(box: Box) -> Canvas:
    """The canvas of a window; without its place where that is just beyond the farthest one."""
    corner = box.rows.first, box.columns.first
    return Canvas(*box.shape, origin=corner if max(map(abs, corner)) <= FAR else (0, 0))


def box_of(top: int, left: int, height: int, width: int) -> Box:
    """The box of a window."""
    return Box(Span(top, top + height), Span(left, left + width))
