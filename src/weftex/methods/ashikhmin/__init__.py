"""Synthesizing natural textures (Ashikhmin, 2001): pixels continue their neighbors' sources."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.methods.ashikhmin import candidate_kernels as kernels
from weftex.methods.pixels import Growth, PixelModel, WindowedMethod, square_width
from weftex.parameters import guide_parameter, parameter, window_parameter
from weftex.random import pick
from weftex.raster.masks import peeled
from weftex.search.windows import Windows, new_query, square_windows

_PROPOSED_WIDTH = 5
#: Random places that stand in for candidates outside the sample. The paper takes one; among eight
#: one matches better, so the same pieces of the sample come back less often.
_REPLACEMENTS = 8
#: Rows over which the end of a wrapped canvas meets its beginning.
_ROWS_TO_CLOSE = 32
_CLOSING = -1  # instead of the number of a pass
_ONE = 256  # a weight of 1 in distances, which are integers
_FORBIDDEN = 2**62  # the cost of a forbidden place; any path costs less


@dataclass(frozen=True)
class Ashikhmin(WindowedMethod):
    """Synthesis of natural textures from coherent candidates.

    The candidates of a pixel are the sample pixels that continue the sources of its neighbors. So
    pieces of the sample grow, in any shape, until another piece fits better. With a guide, the
    output follows another picture.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> sample = weftex.Exemplar(np.random.default_rng(0).integers(0, 255, (32, 32), np.uint8))
    >>> weftex.Ashikhmin(passes=1).fit(sample).sample((40, 50), seed=7).image.shape
    (40, 50)
    """

    slug: ClassVar[str] = "ashikhmin"
    title: ClassVar[str] = "Coherent candidates"
    paper: ClassVar[str] = (
        "M. Ashikhmin: Synthesizing natural textures. Symposium on Interactive 3D Graphics, 2001"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "guide", "many"})

    window_width: int | None = window_parameter(
        "side of the square window that is compared, odd; wider keeps larger shapes",
        "5, less for a very small sample",
    )
    passes: int = parameter(
        2,
        "number of passes over all pixels; passes after the first compare the whole window",
        low=1,
        high=100,
    )
    guide_weight: float = guide_parameter(
        "weight of the guide against the pixels made so far; higher follows the guide more closely"
    )

    def fit_exemplar(self, exemplar: Exemplar) -> PixelModel:
        """Find the whole windows of a sample and of its guide."""
        method = self.resolved(exemplar)
        width = method.window_for(0)
        windows = square_windows(exemplar, width)
        guide = windows.pixels  # the picture's channels come first, those of its maps after
        if exemplar.guide is not None:
            guide = square_windows(exemplar, width, exemplar.as_guide(exemplar.guide)).pixels
        return PixelModel(method, exemplar, Prepared(method, windows, guide), grow)

    def resolved(self, exemplar: Exemplar) -> Self:
        """See `Method.resolved`."""
        width = square_width(self.window_width, exemplar, _PROPOSED_WIDTH)
        return replace(self, window_width=width)


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for synthesis from coherent candidates."""

    method: Ashikhmin  # resolved
    windows: Windows  # the sample's whole windows
    guide: NDArray[np.uint8]  # (H, W, K): the sample's own for their pixels, or these themselves

    @property
    def half(self) -> int:
        """How far a window reaches from its center, in pixels."""
        return self.method.window_for(0) // 2


def grow(prepared: Prepared, growth: Growth) -> None:
    """Choose all pixels several times (section 3); those of a hole in layers from its border."""
    method, half = prepared.method, prepared.half
    choice = Choice(prepared, growth)
    if growth.hole is not None:
        layers = peeled(growth.hole, growth.canvas.wrap)
        for number in range(method.passes):
            for layer in layers:
                choice.choose(layer, number)
        return
    height, width = growth.canvas.shape
    lines = list(np.arange(height * width, dtype=np.int32).reshape(height, width))
    start_from_noise(prepared, growth)
    # First pass, in scan order. Each pixel has as candidates its neighbors' sources, shifted by the
    # step from the neighbor to it, and random places for those outside the sample. It is copied
    # from the one whose L-shaped window is most like its own, and the guide's like the output's:
    # see `candidate_kernels.choose` and `guide_distance` there.
    for i, line in enumerate(lines):
        if i < half and height > 2 * half:
            # Around the border, as the paper's windows go, to the random pixels above, not below.
            noise = slice(height - half + i, None)
            growth.done[noise] = 1
            choice.choose(line, 0, around=True)
            growth.done[noise] = 0
        else:
            choice.choose(line, 0)
    if choice.rows_to_close:
        choice.close(lines[: choice.rows_to_close])
    # Further passes, with the whole window and candidates from all neighbors.
    for number in range(1, method.passes):
        for line in lines:
            choice.choose(line, number)


def start_from_noise(prepared: Prepared, growth: Growth) -> None:
    """Fill the last rows, which the windows of the first see above them, with random pixels."""
    rows = slice(max(0, growth.canvas.height - prepared.half), None)
    index = np.arange(growth.source.size).reshape(growth.source.shape)[rows]
    source = pick(prepared.windows.centers, growth.seed, "ashikhmin start", index)
    growth.source[rows] = source
    growth.pixels[rows] = prepared.windows.pixels.reshape(-1, growth.pixels.shape[2])[source]


class Choice:
    """Chooses the pixels of one output.

    `rows_to_close` rows, at least 2 or 0, are made twice where the canvas wraps along y.
    """

    def __init__(self, prepared: Prepared, growth: Growth) -> None:
        self.growth, self._windows, self._half = growth, prepared.windows, prepared.half
        canvas, half, weight = growth.canvas, prepared.half, 0
        followed = np.zeros((1, 1, 1), np.uint8)
        if canvas.guide is not None:
            followed = growth.exemplar.as_guide(canvas.guide)
            weight = round(_ONE * prepared.method.guide_weight)
        # One for each pixel that follows a guide, or only pieces that happen to be near could.
        jumps = int(canvas.guide is not None)
        #: Flat indices of the last pixel's candidates, and what was there before.
        self.candidates = np.empty((2 * half + 1) ** 2 + _REPLACEMENTS + 1, np.int32)
        self._choice = kernels.PixelChoice(
            half, jumps, new_query(half, growth.pixels.shape[2]), self.candidates,
            followed, prepared.guide, weight,
        )  # fmt: skip
        rows = min(_ROWS_TO_CLOSE, canvas.height // 4)
        self.rows_to_close = rows if rows > 1 and growth.hole is None and canvas.wrap[0] else 0
        pixels = canvas.height * canvas.width if growth.hole is None else int(growth.hole.sum())
        total = prepared.method.passes * pixels + self.rows_to_close * canvas.width
        self._progress = growth.progress(total, "pixels")

    def choose(self, line: NDArray[np.int32], number: int, *, around: bool = False) -> None:
        """Choose the pixels of `line`, flat indices, in turn.

        From pass `number` 1 on, a pixel's own source is a candidate too. `around` wraps windows
        along y even if the canvas does not wrap.
        """
        growth, tries = self.growth, np.arange(_REPLACEMENTS)
        at_random = pick(
            self._windows.centers, growth.seed, "ashikhmin", number, line[:, None], tries
        )
        sample, again = self._windows.kernel, number > 0
        kernels.choose(sample, growth.picture, self._choice, line, at_random, around, again)
        self._progress.advance(len(line))

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


def least_path(cost: NDArray[np.int64], *, closed: bool = False) -> NDArray[np.int64]:
    """The cheapest path (n,) along the first axis of `cost` (n, width), moving at most one a row.

    With `closed` the band wraps and the path ends within one of its start. Ties: the first place in
    the last row, then in the row before. Costs are 0 or more, together below 2**62.
    """
    if not closed:
        return _open_path(cost)
    crossing = _open_path(np.concatenate([cost, cost]))[len(cost)]
    around = np.concatenate([cost, cost[:1]])
    excluded = np.arange(cost.shape[1]) != crossing
    around[0, excluded] = around[-1, excluded] = _FORBIDDEN
    return _open_path(around)[:-1]


def _open_path(cost: NDArray[np.int64]) -> NDArray[np.int64]:
    """`least_path` of a band that does not wrap."""
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
