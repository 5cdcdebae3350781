"""The pictures that an output is to follow, at the levels of the sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.refinement.levels import CoherentLevel
from weftex.methods.refinement.settings import ONE
from weftex.raster.pyramids import gaussian_pyramid, gaussian_stack

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from weftex.methods.pixels.growth import Growth
    from weftex.methods.refinement.levels import Level
    from weftex.methods.refinement.settings import Settings

_KIND_BITS = 6  # lower bits of a guide's bytes that do not make another kind of place


@dataclass(frozen=True, eq=False)
class Guide:
    """The output's guide and the sample's at one level.

    Attributes
    ----------
    output : uint8 array (H, W, G)
    sample : uint8 array (H', W', G)
        Laid out as `Level.pixels`.
    pyramid : uint8 array (H'', W'', G)
        The sample's as a pyramid has it.
    weight : int
        Of a squared difference, in 1/256; 0 without a guide.
    """

    output: NDArray[np.uint8]
    sample: NDArray[np.uint8]
    pyramid: NDArray[np.uint8]
    weight: int

    def demand(
        self, wanted: NDArray[np.bool_], centers: NDArray[np.int32], least: int
    ) -> NDArray[np.int64]:
        """How often each center is to be used, in 1/256: `least`, or more as the guide asks.

        A kind of place that the output's guide shows twice as often as the sample's has to be used
        twice as often.
        """
        own = self.sample.reshape(-1, self.sample.shape[2])[centers]
        both = np.concatenate([own, self.output[wanted]]) >> _KIND_BITS
        kinds = np.unique(both, axis=0, return_inverse=True)[1].ravel()
        count = kinds.max() + 1
        there = np.bincount(kinds[: len(own)], minlength=count)
        asked = np.bincount(kinds[len(own) :], minlength=count)
        share = np.maximum(ONE * asked // np.maximum(there, 1), least)
        result: NDArray[np.int64] = share[kinds[: len(own)]]
        return result


_NOTHING = np.zeros((1, 1, 1), np.uint8)
#: For canvases without a guide.
NO_GUIDE = Guide(_NOTHING, _NOTHING, _NOTHING, 0)


def guides_of(settings: Settings, levels: Sequence[Level], growth: Growth) -> list[Guide]:
    """One for each level; all of its channels together weigh as much as all of the picture's."""
    exemplar, canvas = growth.exemplar, growth.canvas
    if canvas.guide is None:
        return [NO_GUIDE] * len(levels)
    coherent = [level for level in levels if isinstance(level, CoherentLevel)]
    given = exemplar.as_guide(canvas.guide)
    own = exemplar.as_guide(exemplar.pixels if exemplar.guide is None else exemplar.guide)
    pictures = gaussian_pyramid(given, len(coherent), canvas.wrap)
    samples = gaussian_stack(own, len(coherent), (exemplar.tileable,) * 2)
    share = growth.pixels.shape[2] / given.shape[2]
    weight = max(1, round(ONE * settings.guide_weight * share))
    return [
        Guide(picture, level.layout.lay(phases), phases[0], weight)
        for picture, phases, level in zip(pictures, samples, coherent, strict=True)
    ]
