"""The sample as iterative refinement prepares it: the modeling stage of section 3."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from weftex.methods.refinement.levels import sample_levels
from weftex.registry import METHODS
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.method import Model
    from weftex.methods.refinement.levels import Level
    from weftex.methods.refinement.settings import Settings
    from weftex.search.windows import Windows


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for iterative refinement.

    Attributes
    ----------
    settings : Settings
    windows : Windows
        The sample with windows of one pixel.
    levels : list of Level
        From the finest to the coarsest; one where search is "nearest", or only belts are refined.
    start : Model or None
        Makes the pictures to refine; None plants seed points.
    """

    settings: Settings
    windows: Windows
    levels: list[Level]
    start: Model | None

    def start_for(self, guided: bool) -> Model | None:
        """The model to start from on a canvas with or without a guide; None plants seed points."""
        return None if guided and self.settings.seeds_for_guides else self.start


def prepare(exemplar: Exemplar, settings: Settings) -> Prepared:
    """Build the levels of a sample, and the model of the method to start from."""
    start = None if settings.init == "seeds" else METHODS[settings.init]().fit(exemplar)
    levels = sample_levels(exemplar, settings)
    return Prepared(settings, windows_of(exemplar, (0,) * 4), levels, start)
