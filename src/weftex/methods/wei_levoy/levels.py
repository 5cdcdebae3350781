"""The levels: how many fit a sample with windows of what width, and the output's pyramid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError, size_words
from weftex.exemplar import Exemplar
from weftex.methods.pixels import square_width
from weftex.random import draw
from weftex.raster.pyramids import children, gaussian_pyramid, mask_pyramid
from weftex.search.pyramid_windows import interior_windows, sample_pyramid
from weftex.search.windows import square_windows

PROPOSED_WIDTH = 9
_PROPOSED_LEVELS = 4


def levels_and_widths(
    exemplar: Exemplar, given: int | None, given_width: int | None, given_parent_width: int | None
) -> tuple[int, int, int]:
    """Return the number of levels, S and N for a sample, from the given ones."""
    width = window_width(exemplar, given_width)
    parent_width = max(1, width - 2) if given_parent_width is None else given_parent_width
    if parent_width >= max(width, 2):
        raise InvalidInputError(too_wide(parent_width, width))
    samples = sample_pyramid(exemplar, given or _PROPOSED_LEVELS)
    levels = _levels_with_windows(samples, width, parent_width)
    if given is None:
        # The coarsest level holds two windows side by side.
        small = [min(sample.shape) <= 2 * width for sample in samples[:levels]]
        levels = max(1, small.index(True) if True in small else levels)
    elif levels < given:
        raise InvalidInputError(
            f"levels is {given}; {exemplar.name} is {size_words(exemplar.shape)}, "
            f"so it must be at most {levels} with windows of {width} pixels"
        )
    if levels == 1:
        if given_parent_width:
            raise InvalidInputError(
                f"parent_width has no effect: {exemplar.name} is too small for two levels"
            )
        parent_width = 0
    elif parent_width >= width:
        raise InvalidInputError(too_wide(parent_width, width))
    return levels, width, parent_width


def window_width(exemplar: Exemplar, given: int | None) -> int:
    """Return the width of the windows: the given one, or the widest default that fits."""
    width = square_width(given, exemplar, PROPOSED_WIDTH)
    square_windows(exemplar, width)  # refuses a sample without whole windows
    return width


def too_wide(parent_width: int, width: int) -> str:
    """Return what is wrong with windows at the parents that are as wide as the others."""
    return f"parent_width is {parent_width}; it must be below window_width, which is {width}"


def _levels_with_windows(samples: list[Exemplar], width: int, parent_width: int) -> int:
    """Count the levels, from the finest on, where windows that look to all sides are whole."""
    count = 1
    while count < len(samples) and width > 1:
        try:
            interior_windows(samples[count], None, width, 0, causal=False)
            if parent_width:
                pair = samples[count - 1], samples[count]
                interior_windows(*pair, width, parent_width, causal=False)
        except InvalidInputError:
            break
        count += 1
    return count


@dataclass(frozen=True, eq=False)
class OutputLevel:
    """A level of the output's pyramid; level 0 is the finest."""

    number: int
    sample: Exemplar  # the same level of the sample's pyramid
    pixels: NDArray[np.uint8]  # (H, W, K): the bytes that windows are compared on
    source: NDArray[np.int32]  # (H, W): flat indices into the sample's level, or -1
    unknown: NDArray[np.bool_]  # (H, W): the pixels to make
    done: NDArray[np.uint8]  # (H, W): 1 where windows include the pixel: known, made, or noise
    coarser: OutputLevel | None  # the level of the parents

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
) -> list[OutputLevel]:
    """Return the pyramid of an output, coarsest level first.

    `pixels` (H, W, K), `source` and `done` (H, W) are the finest level's; unknown pixels are noise,
    which windows include only if no pixel is known.
    """
    pictures = gaussian_pyramid(pixels, len(samples), wrap)
    masks = mask_pyramid(done > 0, len(samples), wrap)
    levels: list[OutputLevel] = []
    for number in reversed(range(len(samples))):
        known = masks[number]
        sources = np.full(known.shape, -1, np.int32) if number else source
        seen = (known if done.any() else np.ones_like(known)).astype(np.uint8)
        coarser = levels[-1] if levels else None
        levels.append(
            OutputLevel(number, samples[number], pictures[number], sources, ~known, seen, coarser)
        )
    return levels


def noise(sample: Exemplar, seed: int, number: int, shape: tuple[int, ...]) -> NDArray[np.int32]:
    """Return flat indices of shuffled usable pixels of a level of the sample, each equally often.

    The noise has the histogram of the sample.
    """
    usable = np.flatnonzero(sample.usable)
    order = np.argsort(draw(seed, "wei-levoy share", number, usable), kind="stable")
    at = np.arange(int(np.prod(shape)))
    each = np.resize(usable[order], at.size)
    shuffled = each[np.argsort(draw(seed, "wei-levoy noise", number, at), kind="stable")]
    return shuffled.reshape(shape).astype(np.int32)


def parents_or_noise(level: OutputLevel, seed: int) -> NDArray[np.int32]:
    """Return flat indices into the sample's level: the child of each parent's source, or noise.

    The coarsest level has noise.
    """
    if level.coarser is None:
        return noise(level.sample, seed, level.number, level.source.shape)
    height, width = level.sample.shape
    coarser = level.coarser
    rows, columns = np.arange(level.source.shape[0])[:, None], np.arange(level.source.shape[1])
    parents = coarser.source[rows // 2, columns // 2]
    y, x = children(parents, coarser.sample.shape[1], rows, columns)
    places = np.minimum(y, height - 1) * width + np.minimum(x, width - 1)
    return places.astype(np.int32)
