"""A sample prepared for non-parametric sampling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from weftex.methods.efros_leung.settings import Settings
from weftex.search.exhaustive import ExhaustiveSearch
from weftex.search.half_known import HalfKnownSearch
from weftex.search.weighted_windows import gaussian_weights
from weftex.search.windows import square_windows

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.search.weighted_windows import WindowSearch
    from weftex.search.windows import Windows

_SIGMAS = 6.4  # standard deviations of the Gaussian in a window's width


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for non-parametric sampling.

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
    windows: Windows
    search: WindowSearch


def prepare(settings: Settings, exemplar: Exemplar) -> Prepared:
    """Find the sample's windows, and build the structure that is searched."""
    windows = square_windows(exemplar, settings.window_width)
    weights = gaussian_weights(settings.window_width, settings.window_width / _SIGMAS)
    search: WindowSearch = (
        ExhaustiveSearch(windows, weights)
        if settings.search == "full"
        else HalfKnownSearch(windows, weights, settings.candidates, settings.variance)
    )
    return Prepared(settings, windows, search)
