"""The repetition penalty of a sample and its oriented copies: whichever copy shows a feature."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.raster.turning import TURNS, turned_pixels
from weftex.repeats import repeat_kernels as kernels
from weftex.repeats.salience import UNIT, Sight

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.raster.turning import Box
    from weftex.repeats import Offsets, Output, Repetition

# What an offset shows within a third of a side of another copy of it costs by its share, at most.
_BESIDE, _NEAR, _MOST = 10.0, 0.35, 4.0
# A feature beside its mirror image is seen at once, and costs nothing to cut between. So an offset
# with more than a share within a seventh of a side is taken only where there is no other.
_CLOSE, _SHARE, _NEVER = 0.15, 0.05, 1e6


class OrientedPenalty:
    """`SaliencePenalty` where the sample is a picture of oriented copies, see `prepare.turned`.

    `boxes` are those of the copies; the first is the sample, of these pixels.
    """

    def __init__(
        self,
        policy: Repetition,
        exemplar: Exemplar,
        output: Output,
        pixels: NDArray[np.uint8],
        usable: NDArray[np.uint8],
        boxes: list[Box],
    ) -> None:
        self.policy, self.output = policy, output
        self.sight = sight = Sight(output, pixels, usable)
        height, width = sight.count
        side = sight.cell
        rows, columns = (np.arange(n) // side for n in sight.shape)
        own = (rows[:, None] * width + columns).astype(np.int32)
        assert exemplar.turn is not None
        #: Of each pixel of the picture of copies, the cell of the sample, and the copy.
        self.cell_of = turned_pixels(own, exemplar.turn)
        self.copy_of = np.zeros(exemplar.shape, np.int32)
        self.cells = []
        for number, (top, left, high, wide) in enumerate(boxes):
            self.copy_of[top : top + high, left : left + wide] = number
            middles = [
                np.minimum(np.arange(0, n, side) + side // 2, n - 1) + start
                for n, start in ((high, top), (wide, left))
            ]
            self.cells.append(np.ascontiguousarray(self.cell_of[np.ix_(*middles)]))
        salience = np.zeros((height, width), np.int32)
        salience[: sight.salience.shape[0], : sight.salience.shape[1]] = sight.salience
        self.salience = salience.ravel()
        copies = [copy for row in TURNS[exemplar.turn] for copy in row]
        self.mirrored = np.array([mirrored for _, mirrored in copies], np.int32)
        near, close = (int((far * min(height, width)) ** 2) for far in (_NEAR, _CLOSE))
        self.near = np.array([near, close if self.mirrored.any() else -1], np.int32)
        reach = [-(-int(sight.far * n) // side) for n in sight.shape]
        self.weights = np.empty([2 * n + 1 for n in reach], np.int32)
        kernels.weigh_cells(sight.distances, self.weights)

    def next_patch(self, pixel: tuple[int, int]) -> None:
        """See `Penalty.next_patch`."""
        sight, source, cell_of = self.sight, self.output.source, self.cell_of.ravel()
        rows, columns = sight.lines(pixel)
        shown = source[np.ix_(rows[0], columns[0])]
        v, u = np.nonzero(shown >= 0)
        label = shown[v, u]
        cell, copy = cell_of[label], self.copy_of.ravel()[label]
        order = np.argsort(cell, kind="stable")
        at = [rows[1][v] // sight.cell, columns[1][u] // sight.cell, copy, self.mirrored[copy]]
        self._where = np.ascontiguousarray(np.stack(at, 1).astype(np.int32)[order])
        some = source[:: sight.cell, :: sight.cell]
        counts = np.bincount(cell_of[some[some >= 0]], minlength=len(self.salience))
        self._mean = max(float(counts.mean()), 1.0 / len(counts))
        first = np.searchsorted(cell[order], np.arange(len(self.salience) + 1))
        self._cells = np.zeros((3, len(first)), np.int32)
        self._cells[0], self._cells[1, :-1], self._cells[2, :-1] = first, counts, self.salience
        self._missing = sight.missing(pixel, *[max(self.cells[0].shape)] * 2)

    def of(self, offsets: Offsets) -> NDArray[np.float64]:
        """See `Penalty.of`."""
        own, strength = self.cells[offsets.copy], self.policy.strength
        rows, columns, cells = self.sight.cells_of(offsets, list(own.shape))
        sums = np.zeros((*own.shape, 6), np.int64)
        copy = np.array([offsets.copy, self.mirrored[offsets.copy]], np.int32)
        kernels.sum_copies(
            self._cells, self._where, self.weights, self.near, own, copy, self._missing, cells, sums
        )
        repeats, salience, used, beside, area, mirrored = np.moveaxis(sums, 2, 0)
        factors = self.policy.factors(
            nearby=repeats / np.maximum(UNIT * salience, 1),
            use=used / np.maximum(area * self._mean, 1),
        )
        factors += strength * np.minimum(_BESIDE * beside / np.maximum(area, 1), _MOST)
        factors[mirrored > _SHARE * own.size] += strength * _NEVER
        result: NDArray[np.float64] = factors[np.ix_(rows, columns)]
        return result
