"""Texture synthesis with tree-structured vector quantisation (Wei and Levoy, 2000)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from weftex.errors import InvalidInputError
from weftex.method import parameter
from weftex.methods.pixels.growth import PixelModel, settle_window
from weftex.methods.pixels.windowed import WindowedMethod
from weftex.methods.wei_levoy import growth_kernels as _wei_levoy_kernels
from weftex.random import draw
from weftex.raster.pyramids import gaussian_pyramid, mask_pyramid
from weftex.search.pyramid_windows import (
    parent_offsets,
    sample_pyramid,
    whole_windows,
    window_offsets,
    window_vectors,
)
from weftex.search.tsvq import TSVQ, build_tsvq
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.pixels.growth import Growth
    from weftex.progress import Progress

_WIDTH = 9
_LEVELS = 4
_MASKED = 8  # times the leaves where a window is known in part: it says less of where to look
_CLOSING = 2  # passes over the border of a wrapped picture; of one, at one resolution, much is left
_WHOLE = 4  # passes over a hole by whole windows; the paper has one, but more make stones whole
_LEAST = 64  # pixels in one call of the kernel, where lines are shorter


@dataclass(frozen=True)
class WeiLevoy(WindowedMethod):
    """Synthesis in scan order by L-shaped windows, at one resolution or over a pyramid.

    The picture starts as noise. Each pixel in turn is replaced by that of the sample whose window
    is nearest: the pixels above and to the left and, over a pyramid, all that surround its parent
    at the next coarser level. A tree of vectors makes the search fast.

    Raises
    ------
    InvalidInputError
        If `parent_width` is not below `window_width`, or is given for one level.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> sample = weftex.Exemplar(np.random.default_rng(0).integers(0, 255, (32, 32), np.uint8))
    >>> weftex.WeiLevoy(levels=2, window_width=5).fit(sample).sample((20, 30), seed=7).image.shape
    (20, 30)
    """

    slug: ClassVar[str] = "wei-levoy"
    title: ClassVar[str] = "Synthesis with tree-structured vector quantisation"
    paper: ClassVar[str] = (
        "L.-Y. Wei, M. Levoy: Fast texture synthesis using tree-structured vector quantization. "
        "Proceedings of SIGGRAPH 2000"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "many"})

    levels: int | None = parameter(
        None,
        "levels of the pyramid; 1 is a single resolution",
        low=1,
        high=16,
        default_text="4, or fewer so that the coarsest holds two windows side by side",
    )
    window_width: int | None = parameter(
        None,
        "side S of the window at a pixel's own level, odd",
        low=1,
        unit="px",
        default_text=f"{_WIDTH}, or what fits the sample",
    )
    parent_width: int | None = parameter(
        None,
        "side N of the window at the parent's level, odd and below S",
        low=1,
        unit="px",
        default_text="2 less than window_width",
    )
    search: str = parameter(
        "tsvq", "look into a part of the tree, or at all windows", choices=("tsvq", "full")
    )
    tree_size: int | None = parameter(
        None,
        "leaves of the tree of each level",
        low=1,
        default_text="as many as leave 32 windows or fewer in each",
        needs=("search", ("tsvq",)),
    )
    leaves: int = parameter(
        8,
        "leaves to look into; 1 goes down without backtracking",
        low=1,
        needs=("search", ("tsvq",)),
    )
    passes: int = parameter(
        0, "further passes over everything, with windows that look to all sides", low=0, high=1000
    )
    start: str = parameter(
        "parent",
        "what a finer level is before its pixels are chosen: copied like its parent, or the noise",
        choices=("parent", "noise"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.parent_width is not None and self.parent_width % 2 == 0:
            raise InvalidInputError(f"parent_width is {self.parent_width}; it must be odd")
        if self.parent_width is not None and self.levels == 1:
            raise InvalidInputError("parent_width has no effect unless levels is 2 or more")
        if self.parent_width and self.window_width and self.parent_width >= self.window_width:
            raise InvalidInputError(
                f"parent_width is {self.parent_width}; it must be below window_width, "
                f"which is {self.window_width}"
            )

    def fit(self, exemplar: Exemplar) -> WeiLevoyModel:
        """Build the pyramid and, for each level, the tree."""
        return WeiLevoyModel(self, exemplar)

    def settle(self, exemplar: Exemplar) -> WeiLevoy:
        """See `Method.settle`; the trees are what takes long."""
        return _settle(self, exemplar)[0]


class WeiLevoyModel(PixelModel):
    """A sample's pyramid with its trees; `sample` makes outputs from it."""

    method: WeiLevoy

    def __init__(self, method: WeiLevoy, exemplar: Exemplar) -> None:
        settled, self.samples = _settle(method, exemplar)
        super().__init__(settled, exemplar)
        self.windows = windows_of(exemplar, (0, 0, 0, 0))  # so its indices are the sample's own
        self._trees: dict[tuple[int, bool], TSVQ] = {}
        for level in range(len(self.samples)):
            if self._widths(level)[0] > 1:
                self._tree(level, causal=True)

    def _tree(self, level: int, causal: bool) -> TSVQ:
        """The tree of a level; one for windows that look to all sides is built when needed."""
        if (level, causal) not in self._trees:
            parent = self.samples[level + 1] if level + 1 < len(self.samples) else None
            width, parent_width = self._widths(level)
            vectors, places = window_vectors(
                self.samples[level], parent, width, parent_width, causal=causal
            )
            size = 1 if self.method.search == "full" else self.method.tree_size
            self._trees[level, causal] = build_tsvq(vectors, places, size)
        return self._trees[level, causal]

    def _widths(self, level: int) -> tuple[int, int]:
        """S, and N or 0 at the coarsest level."""
        method = self.method
        assert method.window_width is not None
        return method.window_width, (level + 1 < len(self.samples)) * (method.parent_width or 0)

    def grow(self, growth: Growth) -> None:
        """Make all levels, the coarsest first (section III.B)."""
        # Whatever has no border of its own is on a torus, as in the paper.
        wrap = (True, True) if growth.hole is None else growth.canvas.wrap
        unknown = growth.done == 0
        growth.source[unknown] = self._noise(growth.seed, 0, unknown.shape)[unknown]
        self._copy(0, growth.levels, growth.source, unknown)
        pictures = gaussian_pyramid(growth.levels, len(self.samples), wrap)
        masks = mask_pyramid(growth.done > 0, len(self.samples), wrap)
        plans = [self._plan(growth, ~known) for known in masks]
        total = sum(len(step.pixels) for plan in plans for step in plan)
        progress = growth.progress(total, "pixels")
        coarser: _Picture | None = None
        for level in reversed(range(len(self.samples))):
            source = np.full(masks[level].shape, -1, np.int32) if level else growth.source
            done = masks[level] if growth.hole is not None else np.ones_like(masks[level])
            picture = _Picture(level, pictures[level], source, done.astype(np.uint8), coarser)
            if self.method.start == "parent" and len(self.samples) > 1:
                self._start(picture, growth.seed, ~masks[level])
            for step in plans[level]:
                self._choose(picture, step, wrap, progress)
            coarser = picture

    def _noise(self, seed: int, level: int, shape: tuple[int, ...]) -> NDArray[np.int32]:
        """Every pixel of a level of the sample equally often, as far as possible, and shuffled."""
        mask = self.samples[level].mask
        assert mask is not None  # sample_pyramid always sets one
        usable = np.flatnonzero(mask)
        order = np.argsort(draw(seed, "wei-levoy share", level, usable), kind="stable")
        at = np.arange(int(np.prod(shape)))
        each = np.resize(usable[order], at.size)
        shuffled = each[np.argsort(draw(seed, "wei-levoy noise", level, at), kind="stable")]
        return shuffled.reshape(shape).astype(np.int32)

    def _copy(
        self,
        level: int,
        levels: NDArray[np.uint8],
        source: NDArray[np.int32],
        where: NDArray[np.bool_],
    ) -> None:
        levels[where] = self.samples[level].pixels.reshape(-1, levels.shape[2])[source[where]]

    def _start(self, picture: _Picture, seed: int, unknown: NDArray[np.bool_]) -> None:
        """Noise of the coarsest level's own pixels; at finer ones the children of the sources."""
        if picture.coarser is None:
            source = self._noise(seed, picture.level, unknown.shape)
        else:
            height, width = self.samples[picture.level].shape
            y, x = np.indices(unknown.shape)
            above = picture.coarser.source[y // 2, x // 2]
            above_y, above_x = np.divmod(above, self.samples[picture.level + 1].shape[1])
            child_y = np.minimum(2 * above_y + y % 2, height - 1)
            child_x = np.minimum(2 * above_x + x % 2, width - 1)
            source = (child_y * width + child_x).astype(np.int32)
        picture.source[unknown] = source[unknown]
        self._copy(picture.level, picture.levels, picture.source, unknown)

    def _plan(self, growth: Growth, unknown: NDArray[np.bool_]) -> list[_Pass]:
        """What to do at a level, pass after pass."""
        leaves, passes = self.method.leaves, self.method.passes
        if growth.hole is not None:
            # Two passes for constraints: by what is known so far, then, more than once, by whole
            # windows.
            inwards = _inwards(unknown, growth.canvas.wrap, growth.seed)
            first = _Pass(inwards, False, leaves * _MASKED)
            return [first] + [_Pass(inwards, False, leaves)] * (_WHOLE + passes)
        scan = np.arange(unknown.size, dtype=np.int32)
        plan = [_Pass(scan, True, leaves)] + [_Pass(scan, False, leaves)] * passes
        # A causal pass does not show the first rows to the last ones.
        reach = self._widths(0)[0] // 2
        border = np.zeros(unknown.shape, bool)
        for axis in (0, 1):
            if growth.canvas.wrap[axis]:
                lines = border.swapaxes(0, axis)
                lines[:reach] = lines[max(len(lines) - reach, 0) :] = True
        if border.any():
            around = np.flatnonzero(border).astype(np.int32)
            plan += [_Pass(around, False, leaves)] * _CLOSING
        return plan

    def _choose(
        self, picture: _Picture, step: _Pass, wrap: tuple[bool, bool], progress: Progress
    ) -> None:
        """Replace pixels one after the other by the sample's with the nearest window."""
        pixels = step.pixels
        width, parent_width = self._widths(picture.level)
        if width == 1:  # such a window sees nothing, and the noise stays
            progress.advance(len(pixels))
            return
        tree = self._tree(picture.level, step.causal)
        own, parents = window_offsets(width, step.causal), parent_offsets(parent_width)
        query = np.empty(tree.rows.shape[1], np.uint8)
        spans = np.empty((len(own) + len(parents), 2), np.int32)
        coarser = picture.coarser or picture
        line = max(picture.levels.shape[1], _LEAST)
        for start in range(0, len(pixels), line):
            stop = min(start + line, len(pixels))
            _wei_levoy_kernels.choose_pixels(
                picture.levels, picture.source, picture.done, wrap, coarser.levels, coarser.done,
                own, parents, pixels, start, stop, self.samples[picture.level].pixels,
                tree.rows, tree.places, tree.nodes, tree.centroids, step.leaves,
                query, spans, *tree.scratch(),
            )  # fmt: skip
            progress.advance(stop - start)


@dataclass(frozen=True, eq=False)
class _Pass:
    """Flat indices of pixels in their order, what their windows are, and how far to search."""

    pixels: NDArray[np.int32]
    causal: bool
    leaves: int


@dataclass
class _Picture:
    """A level of the output in the making: bytes, sources, what is done, and the coarser level."""

    level: int
    levels: NDArray[np.uint8]
    source: NDArray[np.int32]
    done: NDArray[np.uint8]
    coarser: _Picture | None


def _inwards(unknown: NDArray[np.bool_], wrap: tuple[bool, bool], seed: int) -> NDArray[np.int32]:
    """Unknown pixels in layers from the border inwards, each by lines from a random corner.

    Neighbours of a layer follow each other, as on a spiral, so that they go on coherently.
    """
    layers, left = [np.empty(0, np.int32)], unknown.copy()
    while left.any():
        known = np.pad(~left, 1)
        for axis in (0, 1):
            lines = known.swapaxes(0, axis)
            if wrap[axis]:
                lines[0], lines[-1] = lines[-2].copy(), lines[1].copy()
        beside = known[:-2, 1:-1] | known[2:, 1:-1] | known[1:-1, :-2] | known[1:-1, 2:]
        layer = left & beside if beside.any() else left.copy()
        pixels = np.flatnonzero(layer).astype(np.int32)
        bits = int(draw(seed, "wei-levoy order", len(layers)))
        y, x = np.divmod(pixels, unknown.shape[1])
        keys = [y * (1 - 2 * (bits & 1)), x * (1 - (bits & 2))]
        layers.append(pixels[np.lexsort(keys[:: 1 - 2 * (bits >> 2 & 1)])])
        left &= ~layer
    return np.concatenate(layers)


def _settle(method: WeiLevoy, exemplar: Exemplar) -> tuple[WeiLevoy, list[Exemplar]]:
    """Settle levels and widths; return the method and the sample's levels."""
    settled = settle_window(method, exemplar, _WIDTH)
    width: int = settled.window_width
    while True:
        parent_width = method.parent_width or max(1, width - 2)
        try:
            samples = _levels_with_windows(
                sample_pyramid(exemplar, method.levels or _LEVELS), width, parent_width
            )
            break
        except InvalidInputError:
            if method.window_width is not None or width == 1:
                raise
            width -= 2
    if method.levels is None:
        fits = [min(sample.shape) > 2 * width for sample in samples]
        samples = samples[: max(1, fits.index(False) if False in fits else len(fits))]
    elif len(samples) < method.levels:
        raise InvalidInputError(
            f"levels is {method.levels}; {exemplar.name} is {exemplar.shape[1]}x"
            f"{exemplar.shape[0]}, which has room for {len(samples)} with windows of {width} pixels"
        )
    if len(samples) == 1:
        if method.parent_width is not None:
            raise InvalidInputError(
                f"parent_width has no effect: {exemplar.name} has room for one level only"
            )
        return dataclasses.replace(settled, levels=1, window_width=width), samples
    if parent_width >= width:
        raise InvalidInputError(
            f"parent_width is {parent_width}; it must be below window_width, which is {width}"
        )
    found = {"levels": len(samples), "window_width": width, "parent_width": parent_width}
    return dataclasses.replace(settled, **found), samples


def _levels_with_windows(samples: list[Exemplar], width: int, parent_width: int) -> list[Exemplar]:
    """The levels, finest first, where windows that look to all sides are whole."""
    whole_windows(samples[0], None, width, 0, causal=False)
    count = 1
    while count < len(samples) and width > 1:
        try:
            whole_windows(samples[count], None, width, 0, causal=False)
            pair = samples[count - 1], samples[count]
            whole_windows(*pair, width, parent_width, causal=False)
        except InvalidInputError:
            break
        count += 1
    return samples[:count]
