"""Texture synthesis using exact neighborhood matching (Sabha, Peers and Dutré, 2007).

The method `exact-matching` makes the same bytes of a sample that tiles with `levels=1,
candidates=0, repeat_distance=0`, unless two neighborhoods match equally well: it draws one of them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from weftex.random import draw
from weftex.reference.common import Made, at, checked, fits, made, pick, places, window_steps

#: Steps to the four direct neighbors of Fig. 2.
DIRECT_NEIGHBORS = ((0, -1), (-1, -1), (-1, 0), (-1, 1))


def exact_matching(
    sample: Any,
    size: Any,
    window: int,
    tolerance: float = 0.0,
    structured: bool = False,
    seed: int = 0,
) -> Made:
    """Copy each pixel from the best neighborhood that has the color of a direct neighbor.

    M. Sabha, P. Peers, P. Dutré: Texture synthesis using exact neighborhood matching, Computer
    Graphics Forum 26(2), 2007, section 4.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The sample texture.
    size : int or (int, int)
        Height and width of the output in pixels.
    window : int
        Width of the L-shaped causal neighborhood of Fig. 2 in pixels, odd.
    tolerance : float
        Largest distance of a direct neighbor's color from the color that it should have, as a share
        of the largest in the sample (section 5): 0 is exact, 1 takes any color.
    structured : bool
        Whether the upper band is structured, or of randomly selected pixels (section 4.3).
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Notes
    -----
    The upper band lies above the output. Below a random band, as many rows as it has are made and
    discarded. Of equal distances the first place in scan order wins. Where the reduced search
    space is empty, a random pixel is taken.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import exact_matching
    >>> sample = np.indices((16, 16)).sum(0).astype(np.uint8) % 5 * 50
    >>> exact_matching(sample, (10, 12), window=5, seed=1).image.shape
    (10, 12)
    """
    pixels, (height, width) = checked(sample, size, seed)
    half = fits("window", window, pixels, odd=True, least=3) // 2
    # Synthesis initialization (section 4.3): the upper band, as high as the causal neighborhood.
    if structured:  # a structured band begins as a block at the left of the rotated sample
        rotated = pixels.swapaxes(0, 1)
        sources = np.zeros((width, half, 2), np.int64)
        centers = centers_of(rotated, half)
        center = centers[int(draw(seed, "exact block", 0)) % len(centers)]
        block = min(half, width)
        sources[:block] = places(block, half) + center - half
        synthesize(rotated, sources, block, half, tolerance, seed, "exact structure")
        band, top = sources.swapaxes(0, 1)[:, :, ::-1], half
    else:
        centers, cells = centers_of(pixels, half), np.indices((half, width))
        band = centers[draw(seed, "exact band", *cells) % np.uint64(len(centers))]
        top = 2 * half
    sources = np.zeros((top + height, width, 2), np.int64)
    sources[:half] = band
    synthesize(pixels, sources, half, half, tolerance, seed, "exact 0")
    sources = sources[top:]
    return made(sample, at(pixels, sources), sources)


def synthesize(
    pixels: Any, sources: Any, first: int, half: int, tolerance: float, seed: int, purpose: str
) -> None:
    """Texture synthesis (section 4.2): sources of the rows from `first` on, in scanline order."""
    height, width = sources.shape[:2]
    image = at(pixels, sources)
    causal = window_steps(half)[: (2 * half + 1) ** 2 // 2]
    centers = centers_of(pixels, half)
    search_space = texture_analysis(pixels, centers, tolerance)

    def causal_neighborhood(y: int, x: int) -> Any:
        """Steps to the neighbors that are already made."""
        inside = (causal + (y, x) >= 0).all(axis=1) & (causal[:, 1] + x < width)
        return causal[inside]

    def reduced_search_space(y: int, x: int) -> Any:
        """The union of the direct neighbors' lists, each adjusted to represent the centers."""
        lists = [
            search_space(image[y + dy, x + dx], (dy, dx))
            for dy, dx in DIRECT_NEIGHBORS
            if y + dy >= 0 and 0 <= x + dx < width
        ]
        return centers[np.unique(np.concatenate(lists))]

    for y, x in np.ndindex(height, width):
        if y < first:
            continue
        space = reduced_search_space(y, x)
        if len(space):
            steps = causal_neighborhood(y, x)
            here = at(image, steps + (y, x))
            there = at(pixels, space[:, None] + steps)
            best = space[((there - here) ** 2).sum(axis=(1, 2)).argmin()]  # the L2 difference
        else:
            best = centers[pick(len(centers), seed, purpose, y * width + x)]
        sources[y, x], image[y, x] = best, pixels[tuple(best)]


def texture_analysis(pixels: Any, centers: Any, tolerance: float) -> Any:
    """Texture analysis (section 4.1): for each color and neighbor, the centers that have it there.

    A plain search stands in for the paper's kd-tree. Returns the function of section 4.2.
    """
    colors, number = np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0, return_inverse=True)
    number = number.reshape(pixels.shape[:2])
    radius = int(tolerance * tolerance * ((colors.max(axis=0) - colors.min(axis=0)) ** 2).sum())
    beside = {step: at(number, centers + step) for step in DIRECT_NEIGHBORS}

    def search_space(key: Any, step: Any) -> Any:
        """Centers whose neighbor has the key's color, or one within the range of it (section 5)."""
        near = ((colors - key) ** 2).sum(axis=1) <= radius
        return np.flatnonzero(near[beside[step]])

    return search_space


def centers_of(pixels: Any, half: int) -> Any:
    """The centers that are considered: those half a window or more from every edge."""
    return np.argwhere(np.ones([n - 2 * half for n in pixels.shape[:2]])) + half
