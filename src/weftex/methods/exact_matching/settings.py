"""The settings of exact neighborhood matching, with everything proposed that was left open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.regularity import regularity
from weftex.analysis.scale import dominant_scale
from weftex.methods.pixels.growth import narrowed, width_for
from weftex.search.color_index import ColorIndex
from weftex.search.pyramid_windows import sample_pyramid
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.search.windows import Reach

_NEAR_REGULAR = 0.4  # regularity from which on a sample is near-regular
_SMALLEST_PROPOSED = 31  # width of a window at a single resolution, unless there is no room
_SMALLEST_WITH_ROOM = 11
_WIDTH_WITH_LEVELS = 17
_LEVELS = 3  # docs/exact-matching.md says why
_SIDE_FOR_LEVELS = 128  # shorter side from which on a sample is seen at several levels
_COLORS_IN_REACH = 5  # of a color that occurs once, itself among them
#: How far windows between known pixels reach at most: a layer is decided by what is near to it.
_REACH_TO_ALL_SIDES = 7
#: How far the window over the next coarser level reaches, in pixels of the finer one.
_REACH_OVER_COARSER = 4


@dataclass(frozen=True)
class Settings:
    """Every parameter of `ExactMatching`, settled for a sample."""

    window_width: int  # odd
    tolerance: float  # of the sample's largest color distance
    nearest_colors: int  # 0 if the tolerance decides
    init: str  # "random" or "structured"
    candidates: int
    grouping: float
    repeat_distance: int
    copying: str
    levels: int
    passes: int


def settle(method: Any, exemplar: Exemplar) -> Settings:
    """Propose what was left open (section 7), from the sample's scale, regularity and colors.

    Parameters
    ----------
    method : ExactMatching
        As it was given.
    exemplar : Exemplar
        The sample.

    Raises
    ------
    InvalidInputError
        If the sample has no room for `window_width`.
    """
    init, repeat_distance = _init(method, exemplar), method.repeat_distance
    width, levels = _width_and_levels(method, exemplar, init)
    if repeat_distance is None:
        repeat_distance = 0 if init == "structured" else width // 2
    tolerance = method.tolerance
    if tolerance is None:
        tolerance = 0.0 if method.nearest_colors else _proposed_tolerance(exemplar)
    return Settings(
        window_width=width,
        tolerance=tolerance,
        nearest_colors=method.nearest_colors or 0,
        init=init,
        candidates=method.candidates,
        grouping=method.grouping,
        repeat_distance=repeat_distance,
        copying=method.copying,
        levels=levels,
        passes=method.passes,
    )


def window_width(method: Any, exemplar: Exemplar) -> int:
    """Return the width of `settle`; colors, which take longest, are not looked at."""
    return _width_and_levels(method, exemplar, _init(method, exemplar))[0]


def reach_of(width: int, sample: Exemplar, *, causal: bool, guided: bool) -> tuple[Reach, int]:
    """Return how far windows of a level reach, and how far over the next coarser level, or 0.

    Parameters
    ----------
    width : int
        Of the settings. The coarser levels of a pyramid have room for smaller windows only.
    sample : Exemplar
        The level of the sample.
    causal : bool
        L-shaped windows, as in figure 2; otherwise they look to all sides, not as far.
    guided : bool
        There is a coarser level.
    """
    reach = (min(width, *sample.shape) - 1) // 2
    if not causal:
        reach = min(reach, _REACH_TO_ALL_SIDES)
    coarse = min(reach, _REACH_OVER_COARSER) if guided else 0
    return (reach, coarse if causal else reach, reach, reach), coarse


def _init(method: Any, exemplar: Exemplar) -> str:
    """Start from the sample's own order if that is near-regular."""
    if method.init != "auto":
        init: str = method.init
        return init
    return "structured" if regularity(exemplar) >= _NEAR_REGULAR else "random"


def _width_and_levels(method: Any, exemplar: Exemplar, init: str) -> tuple[int, int]:
    """Several levels where the sample is large; fewer, then smaller windows where none is whole."""
    given, levels = method.window_width, method.levels
    if levels is None:
        large = given is None and min(exemplar.shape) >= _SIDE_FOR_LEVELS
        levels = _LEVELS if large else 1
    samples = sample_pyramid(exemplar, levels)
    levels = method.levels or len(samples)

    def find(width: int) -> None:
        """Look for whole windows at each level, for any canvas."""
        for number, sample in enumerate(samples[:levels]):
            for causal in (False, True):
                guided = number + 1 < levels
                reach, _ = reach_of(width, sample, causal=causal, guided=guided)
                windows_of(sample, reach)
            if init == "structured" and not guided:  # L-shaped windows of the turned sample
                windows_of(sample, (reach[0], reach[0], reach[0], 0))

    while True:
        proposed = _WIDTH_WITH_LEVELS
        if levels == 1 and given is None:
            proposed = max(_SMALLEST_PROPOSED, dominant_scale(exemplar).window_width)
            proposed = min(proposed, max(min(exemplar.shape) // 3, _SMALLEST_WITH_ROOM))
        width = width_for(given, exemplar, proposed)
        if given is not None:
            return width, levels
        fitting = narrowed(width, find)
        if fitting == width or levels == 1 or method.levels is not None:
            return fitting, levels
        levels -= 1


def _proposed_tolerance(exemplar: Exemplar) -> float:
    """The distance of the few nearest colors, if most pixels have a color of their own.

    Each of the four lists then has some places, and a pixel 10 to 30 candidates. Where colors
    occur twice or more, a tolerance costs time and mends nothing.
    """
    windows = windows_of(exemplar, (0, 0, 0, 0))
    index = ColorIndex(windows.pixels, windows.usable)
    number = index.number[windows.usable > 0]
    often = np.bincount(number, minlength=len(index.colors))
    once = often[number] == 1
    if 2 * once.sum() < len(once):
        return 0.0
    reach = np.where(once, index.reach(_COLORS_IN_REACH)[number], 0)
    middle = int(np.sort(reach)[len(once) // 2])
    return float(np.ceil(np.sqrt(middle / max(index.span, 1)) * 1e4) / 1e4)
