"""The settings of coherent candidates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from weftex.methods.pixels.growth import narrowed, width_for
from weftex.search.windows import square_windows

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

_PROPOSED_WIDTH = 5


@dataclass(frozen=True)
class Settings:
    """Every parameter of `Ashikhmin`, settled for a sample."""

    window_width: int  # odd
    passes: int
    jumps: int
    jumps_with_guide: int
    guide_weight: float

    @property
    def half(self) -> int:
        """How far a window reaches from its center, in pixels."""
        return self.window_width // 2


def settle(method: Any, exemplar: Exemplar) -> Settings:
    """Settle the parameters of an `Ashikhmin` for a sample.

    Raises
    ------
    InvalidInputError
        If the sample has no room for `window_width`.
    """
    width = width_for(method.window_width, exemplar, _PROPOSED_WIDTH)
    if method.window_width is None:
        width = narrowed(width, partial(square_windows, exemplar))
    return Settings(
        window_width=width,
        passes=method.passes,
        jumps=0 if method.jumps is None else method.jumps,
        jumps_with_guide=1 if method.jumps is None else method.jumps,
        guide_weight=method.guide_weight,
    )
