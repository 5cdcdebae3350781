"""Texture synthesis using exact neighborhood matching (Sabha, Peers and Dutré, 2007)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.methods.exact_matching.defaults import resolved_values, window_width
from weftex.methods.exact_matching.lists import Prepared, prepare
from weftex.methods.exact_matching.matching import (
    Matching,
    Parents,
    Sheet,
    random_band,
    structured_band,
)
from weftex.methods.pixels import Growth, PixelModel, WindowedMethod
from weftex.parameters import length_parameter, levels_parameter, parameter, window_parameter


@dataclass(frozen=True)
class ExactMatching(WindowedMethod):
    """Exact neighborhood matching.

    Pixels are made in scanline order. For each, weftex compares only windows that have exactly the
    color of one of the four direct neighbors, at that neighbor's place, and copies the best one.

    Raises
    ------
    InvalidInputError
        If `tolerance` and `nearest_colors` are both given.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> sample = weftex.Exemplar(np.random.default_rng(0).integers(0, 255, (32, 32), np.uint8))
    >>> weftex.ExactMatching(window_width=7).fit(sample).sample((20, 30), seed=7).image.shape
    (20, 30)
    """

    slug: ClassVar[str] = "exact-matching"
    title: ClassVar[str] = "Exact neighborhood matching"
    paper: ClassVar[str] = (
        "M. Sabha, P. Peers, P. Dutré: Texture synthesis using exact neighborhood matching. "
        "Computer Graphics Forum 26(2), 2007"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "many"})

    window_width: int | None = window_parameter(
        "side of the square window that is compared, odd; at least the size of features "
        "to keep whole",
        "17 with several levels, else from the sample's scale",
        high=1001,
    )
    tolerance: float | None = parameter(
        None,
        "largest color difference of a match, as a share of the sample's largest; higher "
        "is more random",
        low=0.0,
        high=1.0,
        default_text="0 if colors repeat, else the least at which each color matches four others",
        control="variety",
    )
    nearest_colors: int | None = parameter(
        None,
        "number of nearest colors that match, in place of a tolerance; higher is more random",
        low=1,
        default_text="the tolerance decides",
    )
    init: str = parameter(
        "auto",
        "start of the output: a band of random pixels, a structured band of the sample, or auto",
        choices=("auto", "random", "structured"),
    )
    candidates: int = parameter(
        250,
        "number of windows compared for each pixel; higher is slower, 0 compares all",
        low=0,
        high=2**31 - 1,
    )
    grouping: float = parameter(
        0.0, "windows that differ by less (RMS) are compared only once; higher is faster",
        low=0.0, high=1.0,
    )  # fmt: skip
    repeat_distance: int | None = length_parameter(
        "minimum distance between copies of the same sample pixel (0 in the paper)",
        "half the window width for a random band, 0 for a structured one",
        low=0,
    )
    levels: int | None = levels_parameter(
        "1 for a given window width, holes or a small sample, else 3", high=12
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tolerance is not None and self.nearest_colors is not None:
            raise InvalidInputError("give tolerance or nearest_colors, not both")

    def fit_exemplar(self, exemplar: Exemplar) -> PixelModel:
        """Propose what was left open; make the lists of colors (section 4.1)."""
        method = self.resolved(exemplar)
        return PixelModel(method, exemplar, prepare(method, exemplar), grow)

    def takes(self, name: str, canvas: Canvas | None = None) -> bool:
        """See `Method.takes`."""
        if name == "init" and canvas is not None and "known" in canvas.kinds:
            return self.repeat_distance is None  # which is all that it decides in a hole
        return super().takes(name, canvas)

    def for_belt(self, width: int, **parameters: Any) -> Self:
        """See `Method.for_belt`: a belt is a hole, which is filled at a single resolution."""
        if self.repeat_distance is not None:
            parameters |= {"init": "auto"}
        return super().for_belt(width, levels=None, **parameters)

    def require(self, canvas: Canvas) -> None:
        """See `Method.require`."""
        super().require(canvas)
        if self.init != type(self).init and not self.takes("init", canvas):
            raise InvalidInputError(
                "init has no effect with known pixels beside repeat_distance; leave one out"
            )
        if "known" in canvas.kinds and (self.levels or 1) > 1:
            raise InvalidInputError(f"levels is {self.levels}; holes are filled with 1")

    def window_of(self, exemplar: Exemplar) -> int:
        """See `Method.window_of`."""
        return window_width(self, exemplar)

    def resolved(self, exemplar: Exemplar) -> Self:
        """See `Method.resolved`; scale, regularity and colors are looked at, no list is made."""
        return replace(self, **resolved_values(self, exemplar))


def grow(prepared: Prepared, growth: Growth) -> None:
    """Synthesize a canvas, or fill its hole."""
    if growth.hole is not None:
        fill_hole(prepared, growth)
    else:
        finest = synthesize(prepared, growth, level=0)
        growth.source[:] = finest.places[finest.top :]


def synthesize(prepared: Prepared, growth: Growth, level: int) -> Sheet:
    """Synthesize one level of the canvas; the coarser ones before it (section 7)."""
    method, sample, parents = prepared.method, prepared.levels[level], None
    height, width = (-(-n >> level) for n in growth.canvas.shape)
    # Sections 4 and 4.1: the kd-tree over the sample's colors, and the windows of each color:
    # `methods.exact_matching.color_index.ColorIndex`, `lists.color_lists`.
    lists = sample.causal
    top = lists.reach
    # Section 4.3: a band as high as a window reaches. It is cropped at the end, and so are as
    # many rows that see random pixels.
    if sample.coarser:
        coarser = synthesize(prepared, growth, level + 1)
        band, parents = coarser.parents(top, (height, width), sample.sample.shape)
    elif method.init == "structured":
        band = structured_band(sample.turned, width, method, growth)
    else:
        band = random_band(lists, width, growth.seed)
        top += lists.reach
    sheet = Sheet(lists, (top + height, width), (False, growth.canvas.wrap[1]), top)
    sheet.put(band)
    matching = Matching(sheet, method, growth, parents)
    matching.scan(range(len(band), top), f"exact {level}", "beginning")
    # Section 4.2: in scanline order, each pixel is copied from the center of the best matching
    # window of the union of its direct neighbors' lists: see `match_kernels.match_pixels`. No
    # neighborhood is compared twice (section 4.4): `match_kernels.PixelSearch.seen`. Nor is a color
    # looked up twice in a row: `list_kernels.slot_of`.
    shown = growth.pixels if level == 0 else None
    matching.scan(range(top, top + height), f"exact {level}", "rows", shown)
    if growth.canvas.wrap[0] and height > 1:
        close(prepared, growth, level, sheet, parents)
    y, x = (np.arange(n) >> level for n in growth.canvas.shape)
    growth.pixels[:] = sheet.pixels[top:][np.ix_(y, x)]
    return sheet


def close(
    prepared: Prepared, growth: Growth, level: int, sheet: Sheet, parents: Parents | None
) -> None:
    """Beyond the paper: make the last rows again, between those above and the first ones."""
    lists, (height, width) = prepared.levels[level].around, sheet.done[sheet.top :].shape
    again = min(2 * lists.reach + 1, height // 2)
    closed = Sheet(lists, (height, width), growth.canvas.wrap)
    closed.put(sheet.places[sheet.top : sheet.top + height - again])
    below = parents and parents.below(sheet.top)
    Matching(closed, prepared.method, growth, below).fill(f"exact seam {level}")
    sheet.put(closed.places, sheet.top)


def fill_hole(prepared: Prepared, growth: Growth) -> None:
    """Beyond the paper: make a hole from its border inwards, at a single resolution."""
    lists = prepared.levels[0].around
    growth.about["levels"] = 1
    sheet = Sheet(lists, growth.canvas.shape, growth.canvas.wrap)
    sheet.pixels, sheet.done = growth.pixels, growth.done
    sheet.source = lists.windows.from_sample(growth.source)
    sheet.name_colors()
    Matching(sheet, prepared.method, growth).fill("exact hole")
    growth.source[:] = sheet.places
