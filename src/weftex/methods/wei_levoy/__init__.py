"""Texture synthesis with tree-structured vector quantization (Wei and Levoy, 2000).

Sections III and IV are those of the survey in docs/background/fidelity/
non-parametric-sampling-and-tsvq.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.methods.pixels import Growth, PixelModel, WindowedMethod
from weftex.methods.wei_levoy import scan_kernels
from weftex.methods.wei_levoy.levels import (
    PROPOSED_WIDTH,
    OutputLevel,
    levels_and_widths,
    noise,
    output_pyramid,
    parents_or_noise,
    too_wide,
    window_width,
)
from weftex.methods.wei_levoy.tsvq import Trees
from weftex.parameters import length_parameter, levels_parameter, parameter, window_parameter
from weftex.progress import Progress
from weftex.random import draw
from weftex.raster.masks import peeled
from weftex.search.picture_kernels import Picture
from weftex.search.pyramid_windows import parent_offsets, sample_pyramid, window_offsets
from weftex.search.windows import Windows, windows_of

_TREES_WINDOWS = 2**17  # at most, of each level
_MASKED_FACTOR = 8  # times the leaves: a window known in part says less of where to look
_CLOSING_PASSES = 2  # over the border of a wrapped picture; after one, at one level, much is left
_WHOLE_PASSES = 4  # over a hole by whole windows; the paper has one, but more make stones whole
_LEAST_PIXELS = 64  # in one call of the kernel, where lines are shorter


@dataclass(frozen=True)
class WeiLevoy(WindowedMethod):
    """Synthesis in scan order by L-shaped windows, at one resolution or over a pyramid.

    The picture starts as noise. Each pixel is replaced by the sample pixel with the nearest window.
    A window holds the pixels above and to the left and, over a pyramid, all pixels around the
    parent at the next coarser level. A tree of vectors makes the search fast.

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
    title: ClassVar[str] = "Tree-structured vector quantization"
    paper: ClassVar[str] = (
        "L.-Y. Wei, M. Levoy: Fast texture synthesis using tree-structured vector quantization. "
        "Proceedings of SIGGRAPH 2000"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "many"})

    levels: int | None = levels_parameter(
        "4, fewer where the coarsest level would not hold two windows", high=16
    )
    window_width: int | None = window_parameter(
        "side S of the square window at a pixel's own level, odd; wider keeps larger shapes",
        f"{PROPOSED_WIDTH}, less for a very small sample",
    )
    parent_width: int | None = length_parameter(
        "side N of the square window at the next coarser level, odd and less than S; 0 is none",
        "2 less than the window width; 0 for one level",
        low=0,
        parity="odd",
    )
    search: str = parameter(
        "tsvq",
        "search of a part of a tree of windows (tsvq), or of all windows (full), which is slower",
        choices=("tsvq", "full"),
    )
    tree_size: int = parameter(
        0,
        "number of leaves of each level's tree; 0 chooses it for at most 32 windows per leaf",
        low=0,
        needs=("search", ("tsvq",)),
    )
    leaves: int = parameter(
        8,
        "number of leaves searched; more matches better and is slower; 1 does not backtrack",
        low=1,
        needs=("search", ("tsvq",)),
    )
    passes: int = parameter(
        0,
        "number of further passes over all pixels, which compare windows on all sides",
        low=0,
        high=1000,
    )
    start: str = parameter(
        "parent",
        "start of a finer level: the sources of the next coarser level (parent), or noise",
        choices=("parent", "noise"),
        idle_canvas="known",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.levels == 1 and self.start != type(self).start:
            raise InvalidInputError("start has no effect unless levels is 2 or more")
        width = self.parent_width
        if not width:
            return
        if self.levels == 1:
            raise InvalidInputError("parent_width has no effect unless levels is 2 or more")
        if self.window_width and width >= self.window_width:
            raise InvalidInputError(too_wide(width, self.window_width))

    def fit_exemplar(self, exemplar: Exemplar) -> PixelModel:
        """Build the pyramid and, for each level, the tree."""
        method = self.resolved(exemplar)
        assert method.levels and method.window_width
        assert method.parent_width is not None
        samples = sample_pyramid(exemplar, method.levels)
        # A tree of one leaf is an exhaustive search, of all windows; another tree takes long, and
        # hundreds of megabytes, over many, so it has a part of them drawn at random.
        full = method.search == "full"
        tree_size, most = (1, 0) if full else (method.tree_size, _TREES_WINDOWS)
        trees = Trees(samples, method.window_width, method.parent_width, tree_size, most)
        windows = windows_of(exemplar, (0, 0, 0, 0))
        return PixelModel(method, exemplar, Prepared(method, windows, samples, trees), synthesize)

    def window_of(self, exemplar: Exemplar) -> int:
        """See `Method.window_of`."""
        return window_width(exemplar, self.window_width)

    def resolved(self, exemplar: Exemplar) -> Self:
        """See `Method.resolved`; the trees are what takes long."""
        levels, width, parent_width = levels_and_widths(
            exemplar, self.levels, self.window_width, self.parent_width
        )
        return replace(self, levels=levels, window_width=width, parent_width=parent_width)


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for Wei and Levoy's method."""

    method: WeiLevoy  # resolved
    windows: Windows  # of a single pixel, so that indices are the sample's own
    samples: list[Exemplar]  # the levels of the sample's pyramid, finest first
    trees: Trees  # of the windows of each level


def synthesize(prepared: Prepared, growth: Growth) -> None:
    """Make the levels of the output, the coarsest first (sections III.B.1 and III.B.2)."""
    method, samples, seed = prepared.method, prepared.samples, growth.seed
    leaves, reach = method.leaves, method.window_for(0) // 2
    filling = growth.hole is not None
    # "For the random image, the edges are treated toroidally"; those around a hole are not.
    wrap = growth.canvas.wrap if filling else (True, True)
    # Steps 1 and 2 of III.B.1: white noise that has the histogram of the sample.
    unknown = growth.done == 0
    growth.source[unknown] = noise(samples[0], seed, 0, unknown.shape)[unknown]
    sample = samples[0].pixels.reshape(-1, growth.pixels.shape[2])
    growth.pixels[unknown] = sample[growth.source[unknown]]
    # Step 2 of III.B.2: the Gaussian pyramid of the noise; the sample's is in the model.
    pyramid = output_pyramid(growth.pixels, growth.source, growth.done, samples, wrap)
    # Step 3 goes over a level in raster scan order; over a hole inwards, as on a spiral.
    passes = [
        hole_passes(level.unknown, growth.canvas.wrap, seed, leaves, method.passes)
        if filling
        else scan_passes(level.unknown.shape, growth.canvas.wrap, reach, leaves, method.passes)
        for level in pyramid
    ]
    total = sum(len(step.places) for steps in passes for step in steps)
    progress = growth.progress(total, "pixels")
    # Step 3 of III.B.2: "starting at the lowest resolution level of the pyramids", ...
    for level, steps in zip(pyramid, passes, strict=True):
        # (Beyond the paper, a level starts as a copy of its parents and not as noise.)
        if method.start == "parent" and len(pyramid) > 1:
            level.start_from(parents_or_noise(level, seed))
        for step in steps:
            # ... "replace each pixel in the random image [...] with a pixel from the input image
            # that best matches it": by the SSD of its S x S window, causal in raster scan, and of
            # the N x N window around its parent. The tree makes the search fast.
            replace_by_nearest(level, step, prepared.trees, wrap, progress)


@dataclass(frozen=True, eq=False)
class Pass:
    """One pass over pixels of a level."""

    places: NDArray[np.int32]  # flat indices of the pixels in their order
    causal: bool  # L-shaped windows, or such that look to all sides
    leaves: int  # to look into


def scan_passes(
    shape: tuple[int, ...], wrap: tuple[bool, bool], reach: int, leaves: int, further: int
) -> list[Pass]:
    """Return the passes over a level without known pixels; `wrap` is the canvas's.

    The first is the paper's, in scan order with causal windows. Where the canvas wraps, a second
    one replaces the border, as the first rows did not depend on the last.
    """
    every = np.arange(shape[0] * shape[1], dtype=np.int32)
    found = [Pass(every, True, leaves)] + [Pass(every, False, leaves)] * further
    border = np.zeros(shape, bool)
    for axis in (0, 1):
        if wrap[axis]:
            lines = border.swapaxes(0, axis)
            lines[:reach] = lines[max(len(lines) - reach, 0) :] = True
    if border.any():
        around = np.flatnonzero(border).astype(np.int32)
        found += [Pass(around, False, leaves)] * _CLOSING_PASSES
    return found


def hole_passes(
    unknown: NDArray[np.bool_], wrap: tuple[bool, bool], seed: int, leaves: int, further: int
) -> list[Pass]:
    """Return the passes of constrained synthesis: by known pixels, then by whole windows."""
    places = inwards(unknown, wrap, seed)
    first = Pass(places, False, leaves * _MASKED_FACTOR)
    return [first] + [Pass(places, False, leaves)] * (_WHOLE_PASSES + further)


def inwards(unknown: NDArray[np.bool_], wrap: tuple[bool, bool], seed: int) -> NDArray[np.int32]:
    """Return flat indices of unknown pixels in layers from the border inward.

    Neighbors of a layer follow each other in lines from a random corner, so that they continue
    coherently.
    """
    layers = [np.empty(0, np.int32)]
    for number, places in enumerate(peeled(unknown, wrap), 1):
        bits = int(draw(seed, "wei-levoy order", number))
        y, x = np.divmod(places, unknown.shape[1])
        keys = [y * (1 - 2 * (bits & 1)), x * (1 - (bits & 2))]
        layers.append(places[np.lexsort(keys[:: 1 - 2 * (bits >> 2 & 1)])])
    return np.concatenate(layers)


def replace_by_nearest(
    level: OutputLevel, step: Pass, trees: Trees, wrap: tuple[bool, bool], progress: Progress
) -> None:
    """Replace the pixels of a pass in turn, each by the sample's pixel with the nearest window."""
    if trees.window_width == 1:  # such a window sees nothing, and the noise stays
        progress.advance(len(step.places))
        return
    tree = trees.of(level.number, causal=step.causal)
    own = window_offsets(trees.window_width, step.causal)
    parents = parent_offsets(trees.parent_widths[level.number])
    spans = np.empty((len(own) + len(parents), 2), np.int32)
    leaves = min(step.leaves, len(tree.places))
    both = (level, level.coarser or level)
    here, above = (Picture(part.pixels, part.done, part.source, wrap) for part in both)
    sample, bundle = level.sample.pixels, tree.bundle(spans)
    line = max(level.pixels.shape[1], _LEAST_PIXELS)
    for start in range(0, len(step.places), line):
        places = step.places[start : start + line]
        scan_kernels.replace_pixels(here, above, sample, own, parents, places, bundle, leaves)
        progress.advance(len(places))
