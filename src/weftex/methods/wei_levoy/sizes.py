"""The number of levels that fit a sample, and the width of the windows."""

from __future__ import annotations

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.methods.pixels import square_width
from weftex.search.pyramid_windows import interior_windows, sample_pyramid
from weftex.search.windows import square_windows

PROPOSED_WIDTH = 9
_PROPOSED_LEVELS = 4


def levels_and_widths(
    exemplar: Exemplar, given: int | None, given_width: int | None, given_parent_width: int | None
) -> tuple[int, int, int]:
    """Return the number of levels, S and N for a sample, from the given ones."""
    width = window_width(exemplar, given_width)
    parent_width = max(1, width - 2) if given_parent_width is None else given_parent_width
    if parent_width >= max(width, 2):
        raise InvalidInputError(_too_wide(parent_width, width))
    samples = sample_pyramid(exemplar, given or _PROPOSED_LEVELS)
    levels = _levels_with_windows(samples, width, parent_width)
    if given is None:
        # The coarsest level holds two windows side by side.
        small = [min(sample.shape) <= 2 * width for sample in samples[:levels]]
        levels = max(1, small.index(True) if True in small else levels)
    elif levels < given:
        raise InvalidInputError(
            f"levels is {given}; {exemplar.name} is {exemplar.shape[1]}x"
            f"{exemplar.shape[0]}, which has room for {levels} with windows of {width} pixels"
        )
    if levels == 1:
        if given_parent_width:
            raise InvalidInputError(
                f"parent_width has no effect: {exemplar.name} has room for one level only"
            )
        parent_width = 0
    elif parent_width >= width:
        raise InvalidInputError(_too_wide(parent_width, width))
    return levels, width, parent_width


def window_width(exemplar: Exemplar, given: int | None) -> int:
    """Return the width of the windows: the given one, or the widest default that fits."""
    width = square_width(given, exemplar, PROPOSED_WIDTH)
    square_windows(exemplar, width)  # refuses a sample without whole windows
    return width


def _too_wide(parent_width: int, width: int) -> str:
    return f"parent_width is {parent_width}; it must be below window_width, which is {width}"


def _levels_with_windows(samples: list[Exemplar], width: int, parent_width: int) -> int:
    """Count the levels, from the finest on, where windows that look to all sides are whole."""
    count = 1
    while count < len(samples) and width > 1:
        try:
            interior_windows(samples[count], None, width, 0, causal=False)
            if parent_width:
                pair = samples[count - 1], samples[count]
                interior_windows(*pair, width, parent_width, causal=False)
        except InvalidInputError:
            break
        count += 1
    return count
