"""What a picture to follow is compared with while it is refined."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.raster.pyramids import gaussian_pyramid
from weftex.search.stack import gaussian_stack

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.pixels.growth import Growth
    from weftex.methods.refinement import RefinementModel

ONE = 256  # a weight of 1
_KIND = 6  # bits that are dropped to count how often a guide shows the same


@dataclass(frozen=True, eq=False)
class Guide:
    """The canvas's guide and the sample's at one level.

    Attributes
    ----------
    canvas : uint8 array (H, W, G)
    sample : uint8 array (H', W', G)
        Laid as the level's pixels are.
    plain : uint8 array (H'', W'', G)
        The sample's as a pyramid has it.
    weight : int
        Of a squared difference, in 1/256; 0 without a guide.
    """

    canvas: NDArray[np.uint8]
    sample: NDArray[np.uint8]
    plain: NDArray[np.uint8]
    weight: int

    def demand(
        self, wanted: NDArray[np.bool_], centres: NDArray[np.int32], least: int
    ) -> NDArray[np.int64]:
        """How often each centre is to be used, in 1/256: `least` or, as the guide asks, more.

        What the canvas's guide shows twice as often as the sample's has to be used twice as often.
        """
        own = self.sample.reshape(-1, self.sample.shape[2])[centres]
        both = np.concatenate([own, self.canvas[wanted]]) >> _KIND
        kinds = np.unique(both, axis=0, return_inverse=True)[1].ravel()
        count = kinds.max() + 1
        there, asked = (
            np.bincount(k, minlength=count) for k in (kinds[: len(own)], kinds[len(own) :])
        )
        share = np.maximum(ONE * asked // np.maximum(there, 1), least)
        result: NDArray[np.int64] = share[kinds[: len(own)]]
        return result


def guides_of(model: RefinementModel, growth: Growth) -> list[Guide]:
    """One for each level; all of its channels together weigh as much as all of the picture's."""
    exemplar, canvas, depth = model.exemplar, growth.canvas, len(model.levels)
    if canvas.guide is None:
        nothing = np.zeros((1, 1, 1), np.uint8)
        return [Guide(nothing, nothing, nothing, 0)] * depth
    given = exemplar.as_guide(canvas.guide)
    own = exemplar.as_guide(exemplar.pixels if exemplar.guide is None else exemplar.guide)
    pictures = gaussian_pyramid(given, depth, canvas.wrap)
    samples = gaussian_stack(own, depth, (exemplar.tileable,) * 2)
    share = growth.levels.shape[2] / given.shape[2]
    weight = max(1, round(ONE * model.method.guide_weight * share))
    guides = []
    for picture, phases, level in zip(pictures, samples, model.levels, strict=True):
        assert level.layout is not None
        guides.append(Guide(picture, level.layout.lay(phases), phases[0], weight))
    return guides
