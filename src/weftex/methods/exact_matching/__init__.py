"""Texture synthesis using exact neighborhood matching (Sabha, Peers and Dutré, 2005)."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weftex.analysis.regularity import regularity
from weftex.analysis.scale import dominant_scale
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import parameter
from weftex.methods.exact_matching.candidates import Candidates
from weftex.methods.exact_matching.growth import ExactGrowth, Statistics
from weftex.methods.pixels.growth import PixelModel, settle_window
from weftex.methods.pixels.windowed import WindowedMethod
from weftex.search.color_index import ColorIndex
from weftex.search.pyramid_windows import sample_pyramid
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.pixels.growth import Growth
    from weftex.results.pixels import PixelSynthesis

_REGULAR = 0.4  # regularity from which on a sample is near-regular
_WIDTH = 31  # of a window, unless the structure is larger
_LEVELS = 3  # see docs/exact-matching.md for what they gain
_WITH_LEVELS = 17  # width of a window where there are levels
_ENOUGH = 128  # shorter side from which on a sample is seen at several levels
_NARROW = 11  # the smallest window that is proposed where there is room
_LEAST = 5  # pixels to a side of the coarsest level
_NEAR = 5  # colours, itself among them, in reach of one that occurs once


@dataclass(frozen=True)
class ExactMatching(WindowedMethod):
    """Exact neighborhood matching.

    Pixels are made in scan order. Each is copied from the window that matches best among those
    that have, at the place of one of the four direct neighbours, exactly that neighbour's colour.

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

    window_width: int | None = parameter(
        None,
        "side of the window around a pixel, odd; at least the size of what is to stay whole",
        low=1,
        high=1001,
        unit="px",
        default_text="17 with levels, else from the sample's scale",
    )
    tolerance: float | None = parameter(
        None,
        "how far a colour may be off, of the sample's largest colour distance; 1 takes any",
        low=0.0,
        high=1.0,
        default_text="0 where colours occur more than once, else as far as the nearest four",
    )
    nearest_colors: int | None = parameter(
        None,
        "take so many of the nearest colours, instead of a tolerance",
        low=1,
        default_text="the tolerance decides",
    )
    init: str = parameter(
        "auto",
        "what lies above the first row: random pixels, a structured band, or as the sample asks",
        choices=("auto", "random", "structured"),
    )
    candidates: int = parameter(
        250,
        "of longer lists about so many windows are compared, drawn anew for each pixel",
        low=1,
        high=2**31 - 1,
    )
    grouping: float = parameter(
        0.0, "root mean square difference up to which windows are one entry of a list",
        low=0.0, high=1.0,
    )  # fmt: skip
    repeat_distance: int | None = parameter(
        None,
        "a pixel of the sample is not taken again nearer than this; 0 is the paper's way",
        low=0,
        unit="px",
        default_text="half a window for random beginnings, 0 for structured ones",
    )
    copying: str = parameter(
        "pixels",
        "search for each pixel, or go on without where all four neighbours come from one block",
        choices=("pixels", "blocks"),
    )
    levels: int | None = parameter(
        None,
        "levels of the pyramid; 1 is a single resolution",
        low=1,
        high=12,
        default_text="1 if window_width is given, for holes, and for small samples; else 3",
    )
    passes: int = parameter(
        2, "further passes over what was made between known pixels", low=0, high=100
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tolerance is not None and self.nearest_colors is not None:
            raise InvalidInputError("tolerance and nearest_colors are two ways; give one of them")

    def fit(self, exemplar: Exemplar) -> ExactMatchingModel:
        """Make the index of colours (section 4.1); propose what was left open."""
        return ExactMatchingModel(self, exemplar)

    def settle(self, exemplar: Exemplar) -> ExactMatching:
        """See `Method.settle`; scale, regularity and colours are looked at, no list is made."""
        return _settled(self, exemplar)

    def radius(self, index: ColorIndex) -> NDArray[np.int64]:
        """The squared distance up to which colours count as each colour."""
        if self.nearest_colors is not None:
            return index.reach(self.nearest_colors)
        assert self.tolerance is not None
        limit = int(self.tolerance * self.tolerance * index.span)
        return np.full(len(index.colors), limit, np.int64)


class ExactMatchingModel(PixelModel):
    """A sample prepared for exact neighborhood matching; `sample` makes outputs from it.

    Attributes
    ----------
    samples : list of Exemplar
        The sample's bytes, level by level, finest first.
    structured : bool
        Whether the band above the canvas is made of the sample or of random pixels.
    """

    method: ExactMatching

    def __init__(self, method: ExactMatching, exemplar: Exemplar) -> None:
        self.windows = windows_of(exemplar, (0, 0, 0, 0))  # so that indices are the sample's own
        super().__init__(_settled(method, exemplar), exemplar)
        count: int = self.method.levels  # type: ignore[assignment]
        self.samples = sample_pyramid(exemplar, count)
        most = len(self.samples)
        while most > 1 and min(self.samples[most - 1].shape) < _LEAST:
            most -= 1
        if most < count:
            raise InvalidInputError(
                f"levels is {count}; {exemplar.name} is {exemplar.shape[1]}x"
                f"{exemplar.shape[0]}, which is enough for {most}"
            )
        self._fills = count == 1 or method.levels is None
        self._statistics: Statistics | None = None
        self._ready: dict[tuple[int, str], Candidates] = {}
        for level in range(count):
            self.candidates(level, "causal")
        if self.method.init == "structured":
            self.candidates(count - 1, "turned")

    def candidates(self, level: int, kind: str) -> Candidates:
        """Windows of a level: "causal", "full", or causal ones of the "turned" sample."""
        if (level, kind) not in self._ready:
            sample, guide = self.samples[level], None
            if kind == "turned":
                sample = _turned(sample)
            elif level + 1 < len(self.samples):
                y, x = (np.arange(n) // 2 for n in sample.shape)
                guide = np.ascontiguousarray(self.samples[level + 1].pixels[np.ix_(y, x)])
            made = Candidates(self.method, sample, kind != "full", guide)
            self._ready[level, kind] = made
        return self._ready[level, kind]

    def grow(self, growth: Growth) -> None:
        """Scan the canvas (section 4.2), or fill its hole from the border inwards."""
        making = ExactGrowth(self, growth, self._statistics or Statistics())
        if growth.hole is None:
            making.scan()
        elif self._fills:
            growth.about["levels"] = 1
            making.fill()
        else:
            raise InvalidInputError(f"levels is {self.method.levels}; holes are filled with 1")

    def measure(self, *args: Any, **options: Any) -> tuple[PixelSynthesis, Statistics]:
        """Do what `sample` does; return the result and what it cost."""
        model, statistics = copy.copy(self), Statistics()
        model._statistics = statistics
        return model.sample(*args, **options), statistics


def _turned(sample: Exemplar) -> Exemplar:
    """The sample with its axes exchanged."""
    mask = None if sample.mask is None else sample.mask.T
    turned = np.ascontiguousarray(sample.pixels.swapaxes(0, 1))
    return Exemplar(turned, mask=mask, tileable=sample.tileable, alpha=False, name=sample.name)


def _settled(method: ExactMatching, exemplar: Exemplar) -> ExactMatching:
    """Propose what was left open."""
    proposed = _NARROW
    if method.levels is None:
        several = method.window_width is None and min(exemplar.shape) >= _ENOUGH
        method = replace(method, levels=_LEVELS if several else 1)
    if method.levels != 1:
        proposed = _WITH_LEVELS
    elif method.window_width is None:
        proposed = max(_WIDTH, dominant_scale(exemplar).window_width)
        proposed = min(proposed, max(min(exemplar.shape) // 3, _NARROW))
    method = settle_window(method, exemplar, proposed)
    half = (method.window_width or 1) // 2
    if method.init == "auto":
        regular = regularity(exemplar) >= _REGULAR
        method = replace(method, init="structured" if regular else "random")
    if method.repeat_distance is None:
        method = replace(method, repeat_distance=0 if method.init == "structured" else half)
    if method.tolerance is None and method.nearest_colors is None:
        method = replace(method, tolerance=_proposed_tolerance(exemplar))
    return method


def _proposed_tolerance(exemplar: Exemplar) -> float:
    """Where most pixels have a colour of their own, as far as the few colours nearest to it.

    Each of the four lists then has some places, and a pixel 10 to 30 candidates. Where colours
    occur twice or more, a tolerance costs time and mends nothing.
    """
    windows = windows_of(exemplar, (0, 0, 0, 0))
    index = ColorIndex(windows.pixels, windows.usable)
    number = index.number[windows.usable > 0]
    often = np.bincount(number, minlength=len(index.colors))
    once = often[number] == 1
    if 2 * once.sum() < len(once):
        return 0.0
    middle = int(np.sort(np.where(once, index.reach(_NEAR)[number], 0))[len(once) // 2])
    return float(np.ceil(np.sqrt(middle / max(index.span, 1)) * 1e4) / 1e4)
