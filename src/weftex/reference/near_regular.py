"""Constrained random sampling and gap filling (López Recas, 2011, section 4.2).

The method `near-regular` makes the same bytes with `defaults="paper"` and no blending (with it, the
same but for rounding), if its drawn blocks repeat nothing, which it avoids.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.random import draw
from weftex.reference.common import Made, checked, fits, made, places, windows


def near_regular(
    sample: Any,
    size: Any,
    vectors: Any,
    block: int,
    border: int = 10,
    blend: int = 4,
    tolerance: int = 3,
    match: str = "difference",
    seed: int = 0,
) -> Made:
    """Draw every second block at multiples of the vectors, and fill the gaps by their borders.

    D. López Recas: Constrained random sampling and gap filling technique for near-regular texture
    synthesis, diploma thesis, TU Berlin 2011, section 4.2.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The input texture sample.
    size : int or (int, int)
        Height and width of the output in pixels.
    vectors : ((x, y), (x, y))
        The translation vectors v1 and v2 in pixels, x to the right and y downwards.
    block : int
        Side b of the square blocks in pixels.
    border : int
        Width of the borders in pixels, even: half of it lies on either side of a block's edge.
    blend : int
        w, the width of the blending area in pixels, even, less than `block`; 0 does not blend.
    tolerance : int
        How many pixels from a multiple of the vectors the patch of a gap may lie.
    match : {"difference", "gncc"}
        How a border matches: by squared color differences, eq. (4.4), or correlation, eq. (3.13).
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Notes
    -----
    Blocks beyond the output are made too, so that all gaps have four neighbors. The
    multiples of the vectors are shuffled once; each block starts at a random place in that order.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import near_regular
    >>> tile = np.random.default_rng(0).integers(0, 255, (6, 8), np.uint8)
    >>> image = near_regular(np.tile(tile, (5, 5)), (24, 24), ((8, 0), (0, 6)), 8, 4).image
    >>> bool((image == np.tile(tile, (4, 3))).all())
    True
    """
    pixels, (height, width) = checked(sample, size, seed)
    v = np.array(vectors, float)[:, ::-1]  # rows first
    inverse, margin = np.linalg.inv(v), max(border, blend) // 2
    side = fits("block with its border", block + 2 * margin, pixels)
    if border % 2 or blend % 2 or not 0 <= blend < block:
        raise InvalidInputError(f"border is {border} and blend {blend}; even, less than the block")
    patches = windows(pixels, side, side)  # only patches whose borders lie in the input
    steps = multiples_of(v, pixels.shape[:2])

    def similar(i: int, j: int) -> Any:
        """Fig. 4.7 (b): patches whose distance from the block is a multiple of v1, v2."""
        along = (np.array([i, j]) * block - margin) @ inverse
        first = (along - np.floor(along)) @ v  # in the tile at the origin
        start = int(draw(seed, "block", i, j)) % len(steps)
        found = np.floor(np.roll(steps, -start, axis=0) + first + 0.5).astype(int)
        return found[((found >= 0) & (found < patches.shape[:2])).all(axis=1)]

    @functools.cache
    def drawn(i: int, j: int) -> tuple[int, int]:
        """Constrained random sampling (4.2.1): every second block is a similar patch at random."""
        y, x = similar(i, j)[0]
        return int(y), int(x)

    @functools.cache
    def fitting(i: int, j: int) -> tuple[int, int]:
        """Constrained gap filling (4.2.2): near similar patches, the one that fits the border."""
        neighbors = [drawn(i - 1, j), drawn(i, j - 1), drawn(i + 1, j), drawn(i, j + 1)]
        g, wedges = full_border(pixels, neighbors, block, border, margin)
        near = np.zeros(patches.shape[:2], bool)
        for y, x in similar(i, j):
            near[max(0, y - tolerance) : y + tolerance + 1,
                 max(0, x - tolerance) : x + tolerance + 1] = True  # fmt: skip
        candidates = np.argwhere(near)
        f, g = patches[near][:, wedges], g[wedges]
        if match == "gncc":
            best = correlation(f, g).argmax()
        else:
            best = ((f - g) ** 2).sum(axis=(1, 2)).argmin()  # chi of eq. (4.4)
        return int(candidates[best][0]), int(candidates[best][1])

    # Final composition and blending (4.2.3), eqs. (4.6) to (4.8): all blocks by their shares.
    alpha = share_along_axis(block, blend, margin)
    share = np.outer(alpha, alpha)
    rows, columns = (-(-n // block) for n in (height, width))
    shape = np.array([rows + 2, columns + 2]) * block + 2 * margin
    total, most = np.zeros((*shape, pixels.shape[2])), np.zeros(shape)
    sources = np.zeros((*shape, 2), np.int64)
    for i, j in np.ndindex(rows + 2, columns + 2):  # from the block (-1, -1) on
        kind = drawn if (i + j) % 2 == 0 else fitting  # chess-like
        place = kind(i - 1, j - 1)
        here = np.s_[i * block : i * block + side, j * block : j * block + side]
        total[here] += share[..., None] * patches[place]
        larger = share > most[here]
        sources[here] = np.where(larger[..., None], places(side, side) + place, sources[here])
        most[here] = np.maximum(most[here], share)
    crop = np.s_[block + margin :, block + margin :]
    image = np.floor(total[crop][:height, :width] + 0.5)
    return made(sample, image, sources[crop][:height, :width])


def multiples_of(v: Any, shape: Any) -> Any:
    """All a v1 + b v2 that lead from the tile at the origin into the sample, in random order."""
    corners = np.array([[0, 0], [0, shape[1]], [shape[0], 0], shape]) @ np.linalg.inv(v)
    low, high = np.floor(corners.min(axis=0)) - 1, np.ceil(corners.max(axis=0))
    a, b = (np.arange(low[k], high[k] + 1) for k in (0, 1))
    steps = (a[:, None, None] * v[0] + b[None, :, None] * v[1]).reshape(-1, 2)
    tile = np.array([0 * v[0], v[0], v[1], v[0] + v[1]])
    inside = (steps + tile.max(axis=0) > -1) & (steps + tile.min(axis=0) < shape)
    steps = steps[inside.all(axis=1)]
    return steps[np.argsort(draw(0, "steps", np.arange(len(steps))), kind="stable")]


def full_border(pixels: Any, neighbors: Any, block: int, border: int, margin: int) -> Any:
    """Fig. 4.9 (b): the wedges of a gap's border, from its neighbors above, left, below and right.

    `neighbors` are the corners of their patches in the sample.
    """
    side = block + 2 * margin
    to_sides = np.stack([*np.indices((side, side)), *np.indices((side, side))[:, ::-1, ::-1]])
    depth = to_sides.min(axis=0) - (margin - border // 2)
    wedges = (depth >= 0) & (depth < border)
    nearest, colors = to_sides.argmin(axis=0), np.zeros((side, side, pixels.shape[2]), int)
    for k, (a, b) in enumerate([(-1, 0), (0, -1), (1, 0), (0, 1)]):
        y, x = np.array(neighbors[k]) - (a * block, b * block)
        v, u = np.nonzero((nearest == k) & wedges)
        colors[v, u] = pixels[y + v, x + u]
    return colors, wedges


def share_along_axis(block: int, blend: int, margin: int) -> Any:
    """Eqs. (4.9) and (4.10), alpha: the share of a block along one axis, from both of its edges."""
    x = np.arange(block + 2 * margin) - margin + blend // 2 + 1
    rising, falling = np.clip(x, 0, blend + 1), np.clip(x - block, 0, blend + 1)
    return (rising - falling) / (blend + 1)


def correlation(f: Any, g: Any) -> Any:
    """Eq. (3.13) of n patches f (n, pixels, channels) with one border g (pixels, channels)."""
    count = len(g)
    above = count * (f * g).sum(axis=1) - f.sum(axis=1) * g.sum(axis=0)
    f_energy = count * (f**2).sum(axis=1) - f.sum(axis=1) ** 2
    g_energy = count * (g**2).sum(axis=0) - g.sum(axis=0) ** 2
    below = (np.sqrt(f_energy) * np.sqrt(g_energy)).sum(axis=1)
    return above.sum(axis=1) / np.maximum(below, 1e-9)
