"""A sample prepared for coherent candidates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from weftex.search.windows import windows_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.ashikhmin.settings import Settings
    from weftex.search.windows import Windows


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


def prepare(settings: Settings, exemplar: Exemplar) -> Prepared:
    """Find the whole windows of a sample and of its guide."""
    reach = (settings.half,) * 4
    windows = windows_of(exemplar, reach)
    guide = windows.pixels  # the picture's channels come first, those of its maps after
    if exemplar.guide is not None:
        guide = windows_of(exemplar, reach, exemplar.as_guide(exemplar.guide)).pixels
    return Prepared(settings, windows, guide)
