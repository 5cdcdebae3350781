"""The values of the parameters of exact neighborhood matching that are left open."""

from __future__ import annotations

from typing import Any

import numpy as np

from weftex.analysis.properties import regularity
from weftex.analysis.scale import structure_scale
from weftex.exemplar import Exemplar
from weftex.methods.exact_matching.color_index import ColorIndex
from weftex.methods.pixels import narrowed, width_for
from weftex.search.pyramid_windows import sample_pyramid
from weftex.search.windows import Reach, windows_of

_NEAR_REGULAR = 0.4  # regularity from which on a sample is near-regular
_SMALLEST_PROPOSED = 31  # width of a window at a single resolution, unless there is no room
_SMALLEST_WITH_ROOM = 11
_WIDTH_WITH_LEVELS = 17
_LEVELS = 3  # docs/lab/exact-matching-windows.md says why
_SIDE_FOR_LEVELS = 128  # shorter side from which on a sample is seen at several levels
_COLORS_IN_REACH = 5  # of a color that occurs once, itself among them
#: How far windows between known pixels reach at most: a layer is decided by what is near to it.
_REACH_TO_ALL_SIDES = 7
#: How far the window over the next coarser level reaches, in pixels of the finer one.
_REACH_OVER_COARSER = 4


def resolved_values(method: Any, exemplar: Exemplar) -> dict[str, Any]:
    """Return values of open parameters by the sample's scale, regularity, colors (section 7)."""
    init, repeat_distance, tolerance = _init(method, exemplar), method.repeat_distance, None
    width, levels = _width_and_levels(method, exemplar, init)
    if repeat_distance is None:
        repeat_distance = 0 if init == "structured" else width // 2
    if not method.nearest_colors:
        tolerance = method.tolerance
        tolerance = _proposed_tolerance(exemplar) if tolerance is None else tolerance
    return {
        "window_width": width,
        "levels": levels,
        "init": init,
        "repeat_distance": repeat_distance,
        "tolerance": tolerance,
    }


def window_width(method: Any, exemplar: Exemplar) -> int:
    """Return the width of the windows; colors, which take longest, are not looked at."""
    return _width_and_levels(method, exemplar, _init(method, exemplar))[0]


def reach_of(width: int, sample: Exemplar, *, causal: bool, guided: bool) -> tuple[Reach, int]:
    """Return the reach of a level's windows, and in pixels that on the next coarser level, or 0.

    Coarser levels have room for smaller windows only. Windows that are not `causal` (figure 2)
    reach to all sides, but not as far.
    """
    reach = (min(width, *sample.shape) - 1) // 2
    if not causal:
        reach = min(reach, _REACH_TO_ALL_SIDES)
    coarse = min(reach, _REACH_OVER_COARSER) if guided else 0
    return (reach, coarse if causal else reach, reach, reach), coarse


def _init(method: Any, exemplar: Exemplar) -> str:
    """Start from the sample's own order if that is near-regular."""
    if method.init != "auto":
        return str(method.init)
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
            proposed = max(_SMALLEST_PROPOSED, structure_scale(exemplar).window_width)
            proposed = min(proposed, max(min(exemplar.shape) // 3, _SMALLEST_WITH_ROOM))
        width = width_for(given, exemplar, proposed)
        if given is not None:
            return width, levels
        fitting = narrowed(width, find)
        if fitting == width or levels == 1 or method.levels is not None:
            return fitting, levels
        levels -= 1


def _proposed_tolerance(exemplar: Exemplar) -> float:
    """Return the distance of the few nearest colors if most colors are unique, else 0.

    Each of the four lists then has some entries, and a pixel has 10 to 30 candidates.
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
