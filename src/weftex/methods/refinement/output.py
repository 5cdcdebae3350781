"""The output of iterative refinement at its resolutions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.raster.pyramids import gaussian_pyramid, mask_pyramid

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from weftex.methods.pixels.growth import Growth
    from weftex.methods.refinement.levels import Level
    from weftex.search.windows import Windows


class Output:
    """The output at one level while it is refined.

    Attributes
    ----------
    number : int
        Of the level; 0 is the finest.
    pixels : uint8 array (H, W, K)
    source : int32 array (H, W)
        Flat indices into `Level.pixels`, -1 for none.
    done : uint8 array (H, W)
        1 where a pixel is known or made.
    known : bool array (H, W)
        Pixels that stay as they are.
    wrap : (bool, bool)
        Whether the vertical and the horizontal axis go around.
    """

    def __init__(
        self,
        number: int,
        pixels: NDArray[np.uint8],
        source: NDArray[np.int32],
        known: NDArray[np.bool_],
        wrap: tuple[bool, bool],
    ) -> None:
        self.number, self.pixels, self.source = number, pixels, source
        self.done, self.known, self.wrap = known.astype(np.uint8), known, wrap
        self.wanted = ~known
        self.count = int(self.wanted.sum())

    def begin(self, level: Level, source: NDArray[np.int32]) -> None:
        """Show the sources of the pixels that are to be made; -1 leaves one to be made later."""
        made = self.wanted & (source >= 0)
        self.pixels[made] = level.pixels.reshape(-1, self.pixels.shape[2])[source[made]]
        self.source[self.wanted] = source[self.wanted]
        self.done[made] = 1


def output_pyramid(windows: Windows, levels: Sequence[Level], growth: Growth) -> list[Output]:
    """Return the known pixels at each level, the finest first."""
    known = mask_pyramid(growth.done.astype(bool), len(levels), growth.canvas.wrap)
    pictures = gaussian_pyramid(growth.pixels, len(levels), growth.canvas.wrap)
    y, x = np.divmod(windows.to_sample(growth.source), growth.exemplar.shape[1])
    outputs = []
    for number, level in enumerate(levels):
        # Known pixels may be in the sample too: then their sources go on in their neighbors.
        own = _every(y, number), _every(x, number)
        source = np.where(known[number] & (own[0] >= 0), level.at(*own), np.int32(-1))
        outputs.append(Output(number, pictures[number], source, known[number], growth.canvas.wrap))
    return outputs


def sources_shown(sources: NDArray[np.int32], number: int, level: Level) -> NDArray[np.int32]:
    """Return the sources (H, W, 2) of a picture as far as a level shows it; -1 stays."""
    y, x = np.moveaxis(sources, -1, 0)
    y, x = _every(y, number), _every(x, number)
    return np.where(y < 0, np.int32(-1), level.at(y, x))


def sources_of_children(
    coarser: Output, coarser_level: Level, output: Output, level: Level
) -> NDArray[np.int32]:
    """Return a source for each pixel of a level: where its parent's goes on."""
    step = 2**output.number
    y, x = np.indices(output.known.shape)
    parents = coarser_level.places.ravel()[coarser.source[y // 2, x // 2]]
    v, u = np.divmod(parents, level.nearest.shape[1])
    return level.at(v + y % 2 * step, u + x % 2 * step)


def show_coarse(output: Output, growth: Growth) -> None:
    """Let the preview show a coarse level; it shows the finest by itself."""
    if output.number:
        step, (height, width) = 2**output.number, growth.done.shape
        large = output.pixels.repeat(step, 0).repeat(step, 1)[:height, :width]
        unknown = growth.done == 0
        growth.pixels[unknown] = large[unknown]


def finish(output: Output, level: Level, windows: Windows, growth: Growth) -> None:
    """Hand the sources of the finest level over."""
    places = level.places.ravel()[output.source[output.wanted]]
    growth.source[output.wanted] = windows.from_sample(places)


def _every(rows: NDArray[np.int32], number: int) -> NDArray[np.int32]:
    """The pixels of a picture that those of a level lie on."""
    return rows[:: 2**number, :: 2**number]
