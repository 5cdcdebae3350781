"""The settings of coherent candidates, and a sample prepared for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.pixels.growth import settled_width
from weftex.random import draw
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.search.windows import Windows

_PROPOSED_WIDTH = 5


@dataclass(frozen=True)
class Settings:
    """Every parameter of `Ashikhmin`, settled for a sample.

    Attributes
    ----------
    window_width : int
        Odd, in pixels.
    passes : int
        Times that all pixels are chosen.
    jumps, jumps_with_guide : int
        Random places tried for every pixel too.
    guide_weight : float
        Of the guide beside the picture.
    """

    window_width: int
    passes: int
    jumps: int
    jumps_with_guide: int
    guide_weight: float

    @property
    def half(self) -> int:
        """How far a window reaches from its center, in pixels."""
        return self.window_width // 2


def settle(
    exemplar: Exemplar,
    *,
    window_width: int | None,
    passes: int,
    jumps: int | None,
    guide_weight: float,
) -> Settings:
    """Settle the parameters of `Ashikhmin`.

    Raises
    ------
    InvalidInputError
        If `window_width` is even or the sample has no room for it.
    """
    return Settings(
        window_width=settled_width(window_width, exemplar, _PROPOSED_WIDTH),
        passes=passes,
        jumps=0 if jumps is None else jumps,
        jumps_with_guide=1 if jumps is None else jumps,
        guide_weight=guide_weight,
    )


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for coherent candidates.

    Attributes
    ----------
    settings : Settings
        See there.
    windows : Windows
        The sample's whole windows.
    guide : uint8 array (H, W, K)
        The sample's own guide for the pixels of the windows: these themselves if it has none.
    """

    settings: Settings
    windows: Windows
    guide: NDArray[np.uint8]

    def random_places(
        self, seed: int, purpose: str, *place: NDArray[np.integer] | int
    ) -> NDArray[np.int32]:
        """Draw centers of windows evenly, one for each place; see `weftex.random.draw`."""
        centers = self.windows.centres
        share = (draw(seed, purpose, *place) >> np.uint64(32)) * np.uint64(len(centers))
        places: NDArray[np.int32] = centers[share >> np.uint64(32)]
        return places


def prepare(settings: Settings, exemplar: Exemplar) -> Prepared:
    """Find the whole windows of a sample and of its guide."""
    reach = (settings.half,) * 4
    windows = windows_of(exemplar, reach)
    guide = windows.pixels  # the picture's channels come first, those of its maps after
    if exemplar.guide is not None:
        guide = windows_of(exemplar, reach, exemplar.as_guide(exemplar.guide)).pixels
    return Prepared(settings, windows, guide)
