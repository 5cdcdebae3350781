"""The choice of pixels among coherent candidates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.methods.ashikhmin import candidate_kernels as kernels
from weftex.methods.pixels import Growth
from weftex.progress import Progress
from weftex.random import draw
from weftex.search.windows import Windows, new_query

_FORBIDDEN = 2**62  # the cost of a forbidden place; any path costs less


def least_path(cost: NDArray[np.int64], *, closed: bool = False) -> NDArray[np.int64]:
    """The cheapest path (n,) along the first axis of `cost` (n, width), moving at most one a row.

    With `closed` the band wraps and the path ends within one of its start. Ties: the first place in
    the last row, then in the row before. Costs are 0 or more, together below 2**62.
    """
    if not closed:
        return _open_path(cost)
    crossing = _open_path(np.concatenate([cost, cost]))[len(cost)]
    held = np.concatenate([cost, cost[:1]])
    excluded = np.arange(cost.shape[1]) != crossing
    held[0, excluded] = held[-1, excluded] = _FORBIDDEN
    return _open_path(held)[:-1]


def _open_path(cost: NDArray[np.int64]) -> NDArray[np.int64]:
    total = np.full((len(cost), cost.shape[1] + 2), _FORBIDDEN)
    total[0, 1:-1] = cost[0]
    came = np.zeros(cost.shape, np.int64)
    for row in range(1, len(cost)):
        before = np.stack([total[row - 1, :-2], total[row - 1, 1:-1], total[row - 1, 2:]])
        came[row] = before.argmin(axis=0) - 1
        total[row, 1:-1] = np.minimum(before.min(axis=0), _FORBIDDEN - cost[row]) + cost[row]
    path = np.empty(len(cost), np.int64)
    path[-1] = total[-1, 1:-1].argmin()
    for row in range(len(cost) - 1, 0, -1):
        path[row - 1] = path[row] + came[row, path[row]]
    return path


#: Random places that stand in for candidates outside the sample. The paper takes one; among eight
#: one matches better, so the same pieces of the sample come back less often.
_REPLACEMENTS = 8
#: Rows over which the end of a wrapped canvas meets its beginning.
_ROWS_TO_CLOSE = 32
_CLOSING = -1  # instead of the number of a pass
_ONE = 256  # a weight of 1 in distances, which are integers


class Choice:
    """Chooses the pixels of one output.

    `guide` is the sample's, laid out as the windows' pixels, and used if `guide_weight` is above 0.
    `rows_to_close` rows, at least 2 or 0, are made twice where the canvas wraps along y.
    """

    progress: Progress

    def __init__(
        self,
        windows: Windows,
        half: int,
        guide: NDArray[np.uint8],
        guide_weight: float,
        growth: Growth,
    ) -> None:
        self._windows, self._half, self.growth = windows, half, growth
        canvas = growth.canvas
        followed = np.zeros((1, 1, 1), np.uint8)
        if canvas.guide is not None:
            followed = growth.exemplar.as_guide(canvas.guide)
        # One for each pixel that follows a guide, or only pieces that happen to be near could.
        jumps = int(canvas.guide is not None)
        #: Flat indices of the last pixel's candidates, and what was there before.
        self.candidates = np.empty((2 * half + 1) ** 2 + _REPLACEMENTS + 1, np.int32)
        self._choice = kernels.PixelChoice(
            half, jumps, new_query(half, growth.pixels.shape[2]), self.candidates,
            followed, guide, round(_ONE * guide_weight),
        )  # fmt: skip
        rows = min(_ROWS_TO_CLOSE, canvas.height // 4)
        self.rows_to_close = rows if rows > 1 and growth.hole is None and canvas.wrap[0] else 0

    def count(self, passes: int) -> int:
        """Return how many pixels are chosen in all passes."""
        canvas, hole = self.growth.canvas, self.growth.hole
        pixels = canvas.height * canvas.width if hole is None else int(hole.sum())
        return passes * pixels + self.rows_to_close * canvas.width

    def choose(self, line: NDArray[np.int32], number: int, *, around: bool = False) -> None:
        """Choose the pixels of `line`, flat indices, in turn.

        From pass `number` 1 on, a pixel's own source is a candidate too. `around` wraps windows
        along y even if the canvas does not wrap.
        """
        growth, tries = self.growth, np.arange(_REPLACEMENTS)
        at_random = random_places(
            self._windows, growth.seed, "ashikhmin", number, line[:, None], tries
        )
        kernels.choose(
            self._windows.kernel, growth.picture, self._choice,
            line, at_random, around, number > 0,
        )  # fmt: skip
        self.progress.advance(len(line))

    def close(self, lines: list[NDArray[np.int32]]) -> None:
        """Make the first lines again, below the last; cut where old and new differ least."""
        growth, rows = self.growth, len(lines)
        hidden = slice(0, rows + self._half)
        pixels, source = growth.pixels[:rows].copy(), growth.source[:rows].copy()
        growth.done[hidden] = 0
        for line in lines:
            self.choose(line, _CLOSING, around=True)
        growth.done[hidden] = 1
        apart = ((pixels.astype(np.int64) - growth.pixels[:rows]) ** 2).sum(axis=2)
        cut = least_path((apart[:-1] + apart[1:]).T, closed=growth.canvas.wrap[1])
        old = np.arange(rows)[:, None] > cut
        growth.pixels[:rows][old], growth.source[:rows][old] = pixels[old], source[old]


def random_places(
    windows: Windows, seed: int, purpose: str, *place: NDArray[np.integer] | int
) -> NDArray[np.int32]:
    """Draw centers of windows evenly, one for each place; see `weftex.random.draw`."""
    centers = windows.centers
    share = (draw(seed, purpose, *place) >> np.uint64(32)) * np.uint64(len(centers))
    places: NDArray[np.int32] = centers[share >> np.uint64(32)]
    return places
