"""The output of iterative refinement at its resolutions, and the guides that it follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from weftex.methods.pixels import Growth
from weftex.methods.refinement.levels import ONE, CoherentLevel, Prepared, SampleLevel
from weftex.raster.pyramids import gaussian_pyramid, gaussian_stack, mask_pyramid
from weftex.search.picture_kernels import Picture
from weftex.search.windows import Windows

_KIND_BITS = 6  # lower bits of a guide's bytes that do not make another kind of place
_MOST_MOVED = 0.15  # of a start; more would break patterns that it continues


class OutputLevel:
    """The output at one level while it is refined; level 0 is the finest."""

    def __init__(
        self,
        number: int,
        pixels: NDArray[np.uint8],
        source: NDArray[np.int32],
        known: NDArray[np.bool_],
        wrap: tuple[bool, bool],
    ) -> None:
        # pixels (H, W, K); source (H, W): flat indices into `SampleLevel.pixels`, -1 for none
        self.number, self.pixels, self.source = number, pixels, source
        # done (H, W): 1 where a pixel is known or made; known (H, W): pixels that do not change;
        # wrap: whether the vertical and the horizontal axis wrap
        self.done, self.known, self.wrap = known.astype(np.uint8), known, wrap
        self.wanted = ~known
        self.count = int(self.wanted.sum())

    def begin(self, level: SampleLevel, source: NDArray[np.int32]) -> None:
        """Show the sources of the pixels that are to be made; -1 leaves one to be made later."""
        shown = self.wanted & (source >= 0)
        self.pixels[shown] = level.pixels.reshape(-1, self.pixels.shape[2])[source[shown]]
        self.source[self.wanted] = source[self.wanted]
        self.done[shown] = 1

    def picture(self, wrap: tuple[bool, bool]) -> Picture:
        """Return the output as kernels take it."""
        return Picture(self.pixels, self.done, self.source, wrap)


@dataclass(frozen=True, eq=False)
class Guide:
    """The guides of the output and the sample at one level."""

    output: NDArray[np.uint8]  # (H, W, G)
    sample: NDArray[np.uint8]  # (H', W', G), laid out as `SampleLevel.pixels`
    pyramid: NDArray[np.uint8]  # (H'', W'', G): the sample's guide at this level of its pyramid
    weight: int  # of a squared difference, in 1/256; 0 without a guide

    def demand(
        self, wanted: NDArray[np.bool_], centers: NDArray[np.int32], least: int
    ) -> NDArray[np.int64]:
        """Return how often to use each center, in 1/256: `least`, or more if the guide asks for it.

        A label twice as frequent in the output's guide as in the sample's is used twice as often.
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


def output_pyramid(
    windows: Windows, levels: Sequence[SampleLevel], growth: Growth
) -> list[OutputLevel]:
    """Return the known pixels at each level, the finest first."""
    wrap = growth.canvas.wrap
    masks = mask_pyramid(growth.done.astype(bool), len(levels), wrap)
    pictures = gaussian_pyramid(growth.pixels, len(levels), wrap)
    y, x = np.divmod(windows.to_sample(growth.source), growth.exemplar.shape[1])
    outputs = []
    for number, (level, known) in enumerate(zip(levels, masks, strict=True)):
        # Known pixels may be in the sample too: then their sources go on in their neighbors.
        own = _every(y, number), _every(x, number)
        source = np.where(known & (own[0] >= 0), level.at(*own), np.int32(-1))
        outputs.append(OutputLevel(number, pictures[number], source, known, wrap))
    return outputs


def guides_of(prepared: Prepared, growth: Growth) -> list[Guide]:
    """Return the guide of each level; its weight does not depend on its number of channels."""
    levels, exemplar, canvas = prepared.levels, growth.exemplar, growth.canvas
    if canvas.guide is None:
        return [NO_GUIDE] * len(levels)
    coherent = [level for level in levels if isinstance(level, CoherentLevel)]
    given = exemplar.as_guide(canvas.guide)
    own = exemplar.as_guide(exemplar.pixels if exemplar.guide is None else exemplar.guide)
    pictures = gaussian_pyramid(given, len(coherent), canvas.wrap)
    samples = gaussian_stack(own, len(coherent), (exemplar.tileable,) * 2)
    share = growth.pixels.shape[2] / given.shape[2]
    weight = max(1, round(ONE * prepared.method.guide_weight * share))
    return [
        Guide(picture, level.layout.arranged(phases), phases[0], weight)
        for picture, phases, level in zip(pictures, samples, coherent, strict=True)
    ]


def levels_that_show(
    sources: NDArray[np.int32], levels: Sequence[SampleLevel], growth: Growth
) -> int:
    """Return the number of levels on which few pixels of a source map (H, W, 2) are moved.

    Windows are wide on coarse levels, and none is centered near a hole of the sample.
    """
    known = mask_pyramid(growth.done.astype(bool), len(levels), growth.canvas.wrap)
    for number in range(len(levels) - 1, 0, -1):
        y, x = (_every(axis, number) for axis in np.moveaxis(sources, -1, 0))
        wanted = ~known[number] & (y >= 0)
        whole = levels[number].may_center(y[wanted], x[wanted])
        if np.count_nonzero(~whole) <= _MOST_MOVED * whole.size:
            return number + 1
    return 1


def sources_shown(sources: NDArray[np.int32], number: int, level: SampleLevel) -> NDArray[np.int32]:
    """Return the sources (H, W, 2) of a picture as far as a level shows it; -1 stays."""
    y, x = (_every(axis, number) for axis in np.moveaxis(sources, -1, 0))
    return np.where(y < 0, np.int32(-1), level.at(y, x))


def sources_of_children(
    coarser: OutputLevel, coarser_level: SampleLevel, shape: tuple[int, ...], level: SampleLevel
) -> NDArray[np.int32]:
    """Return (H, W) source of each pixel of a level: the one that continues its parent's."""
    step = 2 ** (coarser.number - 1)
    y, x = np.ogrid[: shape[0], : shape[1]]
    parents = coarser_level.sample_index.ravel()[coarser.source[y // 2, x // 2]]
    v, u = np.divmod(parents, level.padded_index.shape[1])
    return level.at(v + y % 2 * step, u + x % 2 * step)


def finish(output: OutputLevel, level: SampleLevel, windows: Windows, growth: Growth) -> None:
    """Hand the sources of the finest level over."""
    index = level.sample_index.ravel()[output.source[output.wanted]]
    growth.source[output.wanted] = windows.from_sample(index)


def _every(rows: NDArray[np.int32], number: int) -> NDArray[np.int32]:
    """The pixels of a picture that those of a level lie on."""
    return rows[:: 2**number, :: 2**number]
