"""The settings of exact neighborhood matching, with everything proposed that was left open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

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
    """Every parameter of `ExactMatching`, settled for a sample.

    Attributes
    ----------
    window_width : int
        Odd, in pixels.
    tolerance : float
        How far a color may be off, of the sample's largest color distance.
    nearest_colors : int
        Number of colors that are near enough; 0 if the tolerance decides.
    init : {"random", "structured"}
        The band above the first row.
    candidates : int
        About so many windows of longer lists are compared.
    grouping : float
        Root mean square difference, of 1, up to which windows are one entry of a list.
    repeat_distance : int
        A pixel of the sample is not taken again nearer than this, in pixels.
    copying : {"pixels", "blocks"}
        Whether a pixel whose four neighbors come from one block is searched for.
    levels : int
        Of the pyramid.
    hole_levels : int
        Levels that holes are asked to be filled with; there they are filled at 1 only.
    passes : int
        Further passes over pixels that were made between known ones.
    """

    window_width: int
    tolerance: float
    nearest_colors: int
    init: str
    candidates: int
    grouping: float
    repeat_distance: int
    copying: str
    levels: int
    hole_levels: int
    passes: int


def settle(
    exemplar: Exemplar,
    *,
    window_width: int | None,
    tolerance: float | None,
    nearest_colors: int | None,
    init: str,
    candidates: int,
    grouping: float,
    repeat_distance: int | None,
    copying: str,
    levels: int | None,
    passes: int,
) -> Settings:
    """Propose what was left open (section 7), from the sample's scale, regularity and colors.

    Parameters
    ----------
    exemplar : Exemplar
        The sample.
    window_width, tolerance, nearest_colors, init, candidates, grouping, repeat_distance, copying,
    levels, passes
        Parameters of `ExactMatching`.

    Raises
    ------
    InvalidInputError
        If `window_width` is even or the sample has no room for it.
    """
    several = window_width is None and min(exemplar.shape) >= _SIDE_FOR_LEVELS
    settled_levels = levels or (_LEVELS if several else 1)
    proposed = _WIDTH_WITH_LEVELS if settled_levels > 1 else _SMALLEST_WITH_ROOM
    if settled_levels == 1 and window_width is None:
        proposed = max(_SMALLEST_PROPOSED, dominant_scale(exemplar).window_width)
        proposed = min(proposed, max(min(exemplar.shape) // 3, _SMALLEST_WITH_ROOM))
    width = settled_width(window_width, exemplar, proposed)
    if init == "auto":
        init = "structured" if regularity(exemplar) >= _NEAR_REGULAR else "random"
    if repeat_distance is None:
        repeat_distance = 0 if init == "structured" else width // 2
    if tolerance is None:
        tolerance = 0.0 if nearest_colors else _proposed_tolerance(exemplar)
    return Settings(
        window_width=width,
        tolerance=tolerance,
        nearest_colors=nearest_colors or 0,
        init=init,
        candidates=candidates,
        grouping=grouping,
        repeat_distance=repeat_distance,
        copying=copying,
        levels=settled_levels,
        hole_levels=levels or 1,
        passes=passes,
    )


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
