"""The seams of a canvas, to find the worst ones (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.raster.boxes import box_sums

if TYPE_CHECKING:
    from weftex.canvas import Canvas
    from weftex.methods.graphcut.cutting import Picture
    from weftex.methods.graphcut.placement import Place

_CELL = 8  # side in pixels of the squares by which the worst seams are looked for
_ROWS_AT_A_TIME = 64  # of the canvas, when all its seams are priced


class CanvasSeams:
    """The costs of all seams, kept up to date as patches are pasted.

    Parameters
    ----------
    picture : Picture
        The covered canvas.
    canvas : Canvas
        Its size, and whether it goes around.
    patch_size : (int, int)
        Height and width of the patches that will cover the worst seams.
    """

    def __init__(self, picture: Picture, canvas: Canvas, patch_size: tuple[int, int]) -> None:
        self.picture, self.canvas = picture, canvas
        self.cost = np.zeros(canvas.height * canvas.width, np.int32)
        self.cells = np.zeros([-(-n // _CELL) for n in canvas.shape], np.int64)
        self.tried = np.zeros_like(self.cells)
        self.idle = 0  # patches since one made the seams cheaper
        self.spans = [
            min(max(1, size // (2 * _CELL)), n)
            for size, n in zip(patch_size, self.cells.shape, strict=True)
        ]
        for top in range(0, canvas.height, _ROWS_AT_A_TIME):
            self.price(top, 0, min(_ROWS_AT_A_TIME, canvas.height - top), canvas.width)

    def price_around(self, place: Place) -> None:
        """Price the seams that a patch in this box may have changed."""
        before = int(self.cells.sum())
        self.price(place.top - 1, place.left - 1, place.height + 1, place.width + 1)
        self.idle = 0 if int(self.cells.sum()) < before else self.idle + 1

    def price(self, top: int, left: int, height: int, width: int) -> None:
        """Price the seams in a box, and sum them up by cells."""
        rows, columns = (
            (start + np.arange(min(length, n))) % n
            if wraps
            else np.arange(max(start, 0), min(start + length, n))
            for start, length, n, wraps in zip(
                (top, left), (height, width), self.canvas.shape, self.canvas.wrap, strict=True
            )
        )
        places = (rows[:, None] * self.canvas.width + columns).astype(np.int32)
        before = self.cost[places]
        self.picture.price_seams(places, self.cost)
        change = self.cost[places] - before
        np.add.at(self.cells, (rows[:, None] // _CELL, columns // _CELL), change)

    def worst(self) -> tuple[int, int] | None:
        """The middle of the square, half as wide as a patch, whose seams cost most; None if none.

        A square that was tried counts half as much the next time, or one seam that cannot be
        mended would keep the others from it.
        """
        total = self.cells >> np.minimum(self.tried, 62)
        around = [
            (0, (span - 1) * wraps)
            for span, wraps in zip(self.spans, self.canvas.wrap, strict=True)
        ]
        sums = box_sums(np.pad(total, around, mode="wrap"), *self.spans)
        best = int(sums.argmax())
        if sums.flat[best] == 0:
            return None
        middle, cells = [], []
        for first, span, count, n, wraps in zip(
            divmod(best, sums.shape[1]), self.spans, total.shape, self.canvas.shape,
            self.canvas.wrap, strict=True,
        ):  # fmt: skip
            cells.append((first + np.arange(span)) % count)
            at = first * _CELL + span * _CELL // 2
            middle.append(at % n if wraps else min(at, n - 1))
        self.tried[np.ix_(*cells)] += 1
        return middle[0], middle[1]
