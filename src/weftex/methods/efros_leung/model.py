"""A sample prepared for non-parametric sampling."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from weftex.methods.efros_leung.settings import Settings, settle, square_windows
from weftex.methods.pixels.growth import PixelModel
from weftex.search.exhaustive import ExhaustiveSearch
from weftex.search.half_known import HalfKnownSearch
from weftex.search.weighted_windows import gaussian_weights

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.methods.pixels.growth import Growth
    from weftex.search.weighted_windows import WindowSearch

_SIGMAS = 6.4  # standard deviations of the Gaussian in a window's width


class EfrosLeungModel(PixelModel):
    """A sample prepared for non-parametric sampling; `sample` makes outputs from it.

    Attributes
    ----------
    settings : Settings
        Every parameter, settled.
    windows : Windows
        The sample's whole windows.
    search : WindowSearch
        Finds those that match what is known around a pixel.
    """

    settings: Settings

    def __init__(
        self,
        method: Any,
        exemplar: Exemplar,
        algorithm: Callable[[EfrosLeungModel, Growth], None],
    ) -> None:
        self.settings = settings = settle(method, exemplar)
        super().__init__(dataclasses.replace(method, **dataclasses.asdict(settings)), exemplar)
        self.windows = square_windows(exemplar, settings.window_width)
        weights = gaussian_weights(settings.window_width, settings.window_width / _SIGMAS)
        self.search: WindowSearch = (
            ExhaustiveSearch(self.windows, weights)
            if settings.search == "full"
            else HalfKnownSearch(self.windows, weights, settings.candidates, settings.variance)
        )
        self._algorithm = algorithm

    def grow(self, growth: Growth) -> None:
        """Make every pixel that is not known."""
        self._algorithm(self, growth)
