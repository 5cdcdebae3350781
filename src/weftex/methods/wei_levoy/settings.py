"""The parameters of Wei and Levoy's method, settled for a sample."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError
from weftex.methods.pixels.growth import width_for
from weftex.search.pyramid_windows import interior_windows, sample_pyramid

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

PROPOSED_WIDTH = 9
_PROPOSED_LEVELS = 4
TREES_WINDOWS = 2**17  # a tree over more takes long and hundreds of megabytes


@dataclass(frozen=True)
class Settings:
    """Every parameter of `WeiLevoy`, settled; each is described there."""

    levels: int
    window_width: int
    parent_width: int
    search: str
    tree_size: int
    leaves: int
    most_windows: int
    passes: int
    start: str

    def parent_width_at(self, level: int) -> int:
        """Return N, or 0 at the coarsest level, where pixels have no parents."""
        return self.parent_width if level + 1 < self.levels else 0

    @property
    def most_leaves(self) -> int:
        """The most leaves of a tree; with 0, as many as leave a few windows in each."""
        return 1 if self.search == "full" else self.tree_size


def settle(method: Any, exemplar: Exemplar) -> Settings:
    """Settle the parameters of a method for a sample.

    Raises
    ------
    InvalidInputError
        If the sample has no room for the given levels and windows, or N is not below S.
    """
    width = window_width(method, exemplar)
    parent_width = max(1, width - 2) if method.parent_width is None else method.parent_width
    if parent_width >= max(width, 2):
        raise InvalidInputError(_too_wide(parent_width, width))
    samples = sample_pyramid(exemplar, method.levels or _PROPOSED_LEVELS)
    levels = _levels_with_windows(samples, width, parent_width)
    if method.levels is None:
        # The coarsest level holds two windows side by side.
        small = [min(sample.shape) <= 2 * width for sample in samples[:levels]]
        levels = max(1, small.index(True) if True in small else levels)
    elif levels < method.levels:
        raise InvalidInputError(
            f"levels is {method.levels}; {exemplar.name} is {exemplar.shape[1]}x"
            f"{exemplar.shape[0]}, which has room for {levels} with windows of {width} pixels"
        )
    if levels == 1:
        if method.parent_width:
            raise InvalidInputError(
                f"parent_width has no effect: {exemplar.name} has room for one level only"
            )
        parent_width = 0
    elif parent_width >= width:
        raise InvalidInputError(_too_wide(parent_width, width))
    most = method.most_windows
    if most is None:
        most = 0 if method.search == "full" else TREES_WINDOWS
    found = {"levels": levels, "window_width": width, "parent_width": parent_width}
    found["most_windows"] = most
    return Settings(**dataclasses.asdict(method) | found)


def window_width(method: Any, exemplar: Exemplar) -> int:
    """Return the width of the windows: the one given, or the widest proposed that has room."""
    width: int = width_for(method.window_width, exemplar, PROPOSED_WIDTH)
    while True:
        try:
            interior_windows(exemplar, None, width, 0, causal=False)
            return width
        except InvalidInputError:
            if method.window_width is not None or width == 1:
                raise
            width -= 2


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
