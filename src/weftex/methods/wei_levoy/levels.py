"""The levels of the output's pyramid, and what they are before pixels are chosen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.random import draw
from weftex.raster.pyramids import children, gaussian_pyramid, mask_pyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar


@dataclass(frozen=True, eq=False)
class Level:
    """A level of the output's pyramid in the making.

    Attributes
    ----------
    number : int
        0 is the finest.
    sample : Exemplar
        The same level of the sample's pyramid.
    pixels : uint8 array (H, W, K)
        The bytes that windows are compared on.
    source : int32 array (H, W)
        Where pixels come from, flat indices into the sample's level; or -1.
    unknown : bool array (H, W)
        The pixels to make.
    done : uint8 array (H, W)
        1 where a window sees the pixel: known, made, or noise.
    coarser : Level or None
        The level of the parents.
    """

    number: int
    sample: Exemplar
    pixels: NDArray[np.uint8]
    source: NDArray[np.int32]
    unknown: NDArray[np.bool_]
    done: NDArray[np.uint8]
    coarser: Level | None

    def start_from(self, source: NDArray[np.int32]) -> None:
        """Copy the unknown pixels from the sample's level."""
        self.source[self.unknown] = source[self.unknown]
        flat = self.sample.pixels.reshape(-1, self.pixels.shape[2])
        self.pixels[self.unknown] = flat[source[self.unknown]]


def output_pyramid(
    pixels: NDArray[np.uint8],
    source: NDArray[np.int32],
    done: NDArray[np.uint8],
    samples: list[Exemplar],
    wrap: tuple[bool, bool],
) -> list[Level]:
    """Make the pyramid of an output, the coarsest level first.

    Parameters
    ----------
    pixels, source : arrays (H, W, K) and (H, W)
        The finest level's, which stay as they are; unknown pixels are noise.
    done : uint8 array (H, W)
        1 where a pixel is known. If any is, windows do not see the noise.
    samples : list of Exemplar
        The sample's pyramid, finest level first.
    wrap : (bool, bool)
        Axes that go around.
    """
    pictures = gaussian_pyramid(pixels, len(samples), wrap)
    masks = mask_pyramid(done > 0, len(samples), wrap)
    levels: list[Level] = []
    for number in reversed(range(len(samples))):
        known = masks[number]
        sources = np.full(known.shape, -1, np.int32) if number else source
        seen = (known if done.any() else np.ones_like(known)).astype(np.uint8)
        coarser = levels[-1] if levels else None
        levels.append(
            Level(number, samples[number], pictures[number], sources, ~known, seen, coarser)
        )
    return levels


def noise(sample: Exemplar, seed: int, number: int, shape: tuple[int, ...]) -> NDArray[np.int32]:
    """Shuffle the usable pixels of a level of the sample, each equally often as far as possible.

    So the noise has the histogram of the sample. Returned are flat indices into the level.
    """
    usable = np.flatnonzero(np.ones(sample.shape, bool) if sample.mask is None else sample.mask)
    order = np.argsort(draw(seed, "wei-levoy share", number, usable), kind="stable")
    at = np.arange(int(np.prod(shape)))
    each = np.resize(usable[order], at.size)
    shuffled = each[np.argsort(draw(seed, "wei-levoy noise", number, at), kind="stable")]
    return shuffled.reshape(shape).astype(np.int32)


def parents_or_noise(level: Level, seed: int) -> NDArray[np.int32]:
    """Give each pixel the child of its parent's source; at the coarsest level, noise.

    Returned are flat indices into the sample's level.
    """
    if level.coarser is None:
        return noise(level.sample, seed, level.number, level.source.shape)
    height, width = level.sample.shape
    y, x = np.indices(level.source.shape)
    coarser = level.coarser
    y, x = children(coarser.source[y // 2, x // 2], coarser.sample.shape[1], y, x)
    places = np.minimum(y, height - 1) * width + np.minimum(x, width - 1)
    source: NDArray[np.int32] = places.astype(np.int32)
    return source
