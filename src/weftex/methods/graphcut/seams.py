"""The seams of a canvas, to find the worst ones (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.graphcut.seam_kernels import sum_seams
from weftex.raster.boxes import box_sums

if TYPE_CHECKING:
    from weftex.canvas import Canvas
    from weftex.methods.graphcut.cutting import Picture
    from weftex.methods.graphcut.placement import Patch

_CELL = 8  # side in pixels of the squares that the costs of seams are summed over


class CanvasSeams:
    """The costs of all seams of a covered canvas, kept up to date as patches are pasted.

    The worst seams are those of the square of cells, half as wide as a patch, that costs most.
    """

    def __init__(self, picture: Picture, canvas: Canvas, patch_size: tuple[int, int]) -> None:
        self.picture, self.canvas = picture, canvas
        self.cost = np.zeros(canvas.shape, np.int32)
        self.cells = np.zeros([-(-n // _CELL) for n in canvas.shape], np.int64)
        self.tried = np.zeros_like(self.cells)
        self.idle = 0  # patches since one lowered the cost of seams
        self.spans = [
            min(max(1, size // (2 * _CELL)), n)
            for size, n in zip(patch_size, self.cells.shape, strict=True)
        ]
        # The squares of cells, half as wide as a patch, by their upper left one, and the most that
        # one of each row costs.
        last = [
            n if wraps else n - span + 1
            for n, span, wraps in zip(self.cells.shape, self.spans, canvas.wrap, strict=True)
        ]
        self.squares = np.zeros(last, np.int64)
        self.most = np.zeros(last[0], np.int64)
        self.update(0, 0, *canvas.shape)

    def update_around(self, patch: Patch) -> None:
        """Update the costs of seams that a patch may have changed."""
        change = self.update(patch.top - 1, patch.left - 1, patch.height + 1, patch.width + 1)
        self.idle = 0 if change < 0 else self.idle + 1

    def update(self, top: int, left: int, height: int, width: int) -> int:
        """Update the costs of the seams in a box, and their sums; return how much is added."""
        lines, cells = [], []
        for start, length, n, wraps in zip(
            (top, left), (height, width), self.canvas.shape, self.canvas.wrap, strict=True
        ):
            if wraps:
                line = (start + np.arange(min(length, n))) % n
            else:
                line = np.arange(max(start, 0), min(start + length, n))
            lines.append(line.astype(np.int32))
            cells.append(np.unique(line // _CELL))
        before = int(self.cells[np.ix_(*cells)].sum())
        sum_seams(self.picture.labeling, lines[0], lines[1], self.cost, self.cells, _CELL)
        self._sum_up([int(line[0]) // _CELL for line in lines], [len(c) for c in cells])
        return int(self.cells[np.ix_(*cells)].sum()) - before

    def _sum_up(self, first: Sequence[int], length: Sequence[int]) -> None:
        """Sum up the squares that have one of these cells.

        A cell that was tried counts half as much the next time, or one seam that cannot be mended
        would keep the others from it.
        """
        squares, cells = [], []
        for start, count, span, last, n in zip(
            first, length, self.spans, self.squares.shape, self.cells.shape, strict=True
        ):
            at = np.arange(start - span + 1, start + count)
            at = at[:n] % n if last == n else at[(at >= 0) & (at < last)]
            if not len(at):
                return
            squares.append(at)
            cells.append((at[0] + np.arange(len(at) + span - 1)) % n)
        here = np.ix_(*cells)
        cost = self.cells[here] >> np.minimum(self.tried[here], 62)
        self.squares[np.ix_(*squares)] = box_sums(cost, *self.spans)
        self.most[squares[0]] = self.squares[squares[0]].max(axis=1)

    def worst(self) -> tuple[int, int] | None:
        """The middle of the square, half a patch wide, whose seams cost most; None if none do."""
        row = int(self.most.argmax())
        if self.most[row] == 0:
            return None
        first = row, int(self.squares[row].argmax())
        middle, cells = [], []
        for at, span, count, n, wraps in zip(
            first, self.spans, self.cells.shape, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            cells.append((at + np.arange(span)) % count)
            center = at * _CELL + span * _CELL // 2
            middle.append(center % n if wraps else min(center, n - 1))
        self.tried[np.ix_(*cells)] += 1
        self._sum_up(first, self.spans)
        return middle[0], middle[1]
