"""The settings of exact neighborhood matching, with everything proposed that was left open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.regularity import regularity
from weftex.analysis.scale import dominant_scale
from weftex.methods.pixels.growth import settled_width
from weftex.search.color_index import ColorIndex
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

_NEAR_REGULAR = 0.4  # regularity from which on a sample is near-regular
_SMALLEST_PROPOSED = 31  # width of a window at a single resolution, unless there is no room
_SMALLEST_WITH_ROOM = 11
_WIDTH_WITH_LEVELS = 17
_LEVELS = 3  # docs/exact-matching.md says why
_SIDE_FOR_LEVELS = 128  # shorter side from which on a sample is seen at several levels
_COLORS_IN_REACH = 5  # of a color that occurs once, itself among them


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
    hole_levels: int  # that are asked for where a hole is filled, which takes 1 only
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
        If `window_width` is even or the sample has no room for it.
    """
    levels = level_count(method, exemplar)
    width = window_width(method, exemplar)
    init, repeat_distance = method.init, method.repeat_distance
    if init == "auto":
        init = "structured" if regularity(exemplar) >= _NEAR_REGULAR else "random"
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
        hole_levels=method.levels or 1,
        passes=method.passes,
    )


def level_count(method: Any, exemplar: Exemplar) -> int:
    """Return the number of levels: the one given, or several for a large sample."""
    several = method.window_width is None and min(exemplar.shape) >= _SIDE_FOR_LEVELS
    return method.levels or (_LEVELS if several else 1)


def window_width(method: Any, exemplar: Exemplar) -> int:
    """Return the width of the windows: the one given, or by the scale of the sample."""
    levels, width = level_count(method, exemplar), method.window_width
    proposed = _WIDTH_WITH_LEVELS if levels > 1 else _SMALLEST_WITH_ROOM
    if levels == 1 and width is None:
        proposed = max(_SMALLEST_PROPOSED, dominant_scale(exemplar).window_width)
        proposed = min(proposed, max(min(exemplar.shape) // 3, _SMALLEST_WITH_ROOM))
    return settled_width(width, exemplar, proposed)


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
