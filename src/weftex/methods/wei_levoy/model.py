"""A sample prepared for Wei and Levoy's method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from weftex.methods.wei_levoy.search import Trees
from weftex.methods.wei_levoy.settings import Settings
from weftex.search.pyramid_windows import sample_pyramid
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.search.windows import Windows


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample's pyramid with its trees.

    Attributes
    ----------
    settings : Settings
        Every parameter, settled.
    windows : Windows
        Of a single pixel, so that its indices are the sample's own.
    samples : list of Exemplar
        The levels of the sample's pyramid, finest first.
    trees : Trees
        Of the windows of each level.
    """

    settings: Settings
    windows: Windows
    samples: list[Exemplar]
    trees: Trees


def prepare(settings: Settings, exemplar: Exemplar) -> Prepared:
    """Build the pyramid of a sample, and for each of its levels the tree."""
    samples = sample_pyramid(exemplar, settings.levels)
    windows = windows_of(exemplar, (0, 0, 0, 0))
    return Prepared(settings, windows, samples, Trees(samples, settings))
