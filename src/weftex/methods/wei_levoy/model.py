"""A sample prepared for Wei and Levoy's method."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from weftex.methods.pixels.growth import PixelModel
from weftex.methods.wei_levoy.search import Trees
from weftex.methods.wei_levoy.settings import Settings, settle
from weftex.search.pyramid_windows import sample_pyramid
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.methods.pixels.growth import Growth


class WeiLevoyModel(PixelModel):
    """A sample's pyramid with its trees; `sample` makes outputs from it.

    Attributes
    ----------
    settings : Settings
        Every parameter, settled.
    samples : list of Exemplar
        The levels of the sample's pyramid, finest first.
    trees : Trees
        Of the windows of each level.
    """

    settings: Settings

    def __init__(
        self,
        method: Any,
        exemplar: Exemplar,
        algorithm: Callable[[WeiLevoyModel, Growth], None],
    ) -> None:
        self.settings = settings = settle(method, exemplar)
        super().__init__(dataclasses.replace(method, **dataclasses.asdict(settings)), exemplar)
        self.windows = windows_of(exemplar, (0, 0, 0, 0))  # so its indices are the sample's own
        self.samples = sample_pyramid(exemplar, settings.levels)
        self.trees = Trees(self.samples, settings)
        self._algorithm = algorithm

    def grow(self, growth: Growth) -> None:
        """Make every pixel that is not known."""
        self._algorithm(self, growth)
