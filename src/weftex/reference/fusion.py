"""Texture fusion (the paper on refinement and texture fusion, section 4).

`weftex.fuse` follows the same section, but moves boundaries to where they show least.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.random import draw
from weftex.reference.common import Made, at, checked, fits, made, places, windows
from weftex.reference.graphcut import NEW, OLD, Graph
from weftex.reference.iterative_refinement import plant_seeds, refine


def fusion(
    samples: Sequence[Any], fusion_map: Any, scales: Sequence[int], matches: int = 5, seed: int = 0
) -> Made:
    """Merge textures where a map says, with belts of a merged texture between them.

    S. Shin, T. Nishita, S. Y. Shin: On pixel-based texture synthesis by non-parametric sampling,
    2006, section 4.

    Parameters
    ----------
    samples : sequence of uint8 array (h, w) or (h, w, channels)
        The texture samples, with the same channels.
    fusion_map : int array (H, W)
        Number of the sample of each pixel of the output, from 0.
    scales : sequence of int
        Scale of the dominant structure of each sample in pixels.
    matches : int
        k: a unit tile is drawn from the k best matching ones.
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from, in the samples one below the other.

    Notes
    -----
    The paper leaves open how two textures are merged: here the second lies in the middle third of
    the first, and a minimum cut is the boundary.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import fusion
    >>> stripes = np.indices((15, 15)).astype(np.uint8) % 3 * 80
    >>> fusion_map = np.repeat([[0] * 8 + [1] * 8], 10, axis=0)
    >>> fusion([stripes[0], stripes[1]], fusion_map, [3, 3], seed=1).image.shape
    (10, 16)
    """
    labels = np.asarray(fusion_map)
    inputs = [checked(sample, labels.shape, seed)[0] for sample in samples]
    if len(samples) != len(scales) or labels.min() < 0 or labels.max() >= len(samples):
        raise InvalidInputError(
            f"fusion_map has numbers from {labels.min()} to {labels.max()} for {len(samples)} "
            f"samples and {len(scales)} scales"
        )
    tops = np.cumsum([0, *(len(pixels) for pixels in inputs)])
    origins = [places(*f.shape[:2]) + (top, 0) for f, top in zip(inputs, tops[:-1], strict=True)]
    image = np.zeros((*labels.shape, inputs[0].shape[2]), np.int64)
    sources = np.full((*labels.shape, 2), -1)

    def near(k: int, reach: int) -> Any:
        """Pixels within `reach` of the region of a sample."""
        return windows(np.pad(labels == k, reach), 2 * reach + 1, 2 * reach + 1).any(axis=(2, 3))

    def fill(pixels: Any, origin: Any, where: Any, scale: int, spacing: int, number: int) -> None:
        """Synthesize a region in scan-line order with no iterative refinement."""
        fits("window", 2 * scale + 1, pixels, odd=True, least=3)
        own_seed = int(draw(seed, "fill", number))
        planted = plant_seeds(pixels, scale, labels.shape, spacing, matches, own_seed)
        own, known = np.full_like(sources, -1), sources[..., 0] >= 0
        for p, place in planted.items():
            if where[p]:
                image[p], known[p] = pixels[place], True
        refine(pixels, scale, image, own, known, where, torus=False)
        sources[where] = at(origin, own[where])

    # A belt along each boundary, as wide as half of the larger window, Fig. 6 (b).
    pairs = list(combinations(range(len(samples)), 2))
    belt_of = np.full(labels.shape, -1)
    for number, (a, b) in enumerate(pairs):
        reach = max(1, max(scales[a], scales[b]) // 2)
        belt = near(a, reach) & near(b, reach) & ((labels == a) | (labels == b))
        belt_of[belt & (belt_of < 0)] = number
    # First each non-belt region with its texture sample ...
    for k, (pixels, origin) in enumerate(zip(inputs, origins, strict=True)):
        fill(pixels, origin, (labels == k) & (belt_of < 0), scales[k], scales[k], k)
    # ... then each belt from a merged sample: the window has the larger scale, the seed points the
    # smaller.
    for number, (a, b) in enumerate(pairs):
        belt = belt_of == number
        if belt.any():
            inside, shape = merged(inputs[a], inputs[b])
            crop = np.s_[: shape[0], : shape[1]]
            pixels, origin = (
                np.where(inside[..., None], of[b][crop], of[a][crop]) for of in (inputs, origins)
            )
            scale, spacing = max(scales[a], scales[b]), min(scales[a], scales[b])
            fill(pixels, origin, belt, scale, spacing, len(samples) + number)
    return made(samples[0], image, sources)


def merged(a: Any, b: Any) -> tuple[Any, tuple[int, int]]:
    """Where the second texture is in the first, by a minimum cut of their differences."""
    height, width = shape = min(len(a), len(b)), min(a.shape[1], b.shape[1])
    middle = np.s_[height // 3 : height - height // 3, width // 3 : width - width // 3]
    apart = abs(a[:height, :width] - b[:height, :width]).sum(axis=2)
    core, frame = np.zeros(shape, bool), np.ones(shape, bool)
    core[middle], frame[1:-1, 1:-1] = True, False
    graph = Graph()
    for y, x in np.ndindex(shape):
        if core[y, x] or frame[y, x]:
            graph.join((y, x), NEW if core[y, x] else OLD, 2**20)
        for t in ((y + 1, x), (y, x + 1)):
            if t[0] < height and t[1] < width:
                graph.join((y, x), t, int(apart[y, x] + apart[t]))
    taken = graph.new_side()
    return np.array([[(y, x) in taken for x in range(width)] for y in range(height)]), shape
