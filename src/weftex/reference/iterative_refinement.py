"""Iterative texture refinement (the paper on refinement and texture fusion, section 3).

The method `refinement` makes the same bytes with `search="nearest"`, `init="seeds"`, the scale as
`seed_scale`, and twice the scale and 1 as `window_width`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from weftex.random import draw
from weftex.reference.common import Made, at, checked, fits, made, places, windows


def iterative_refinement(
    sample: Any,
    size: Any,
    scale: int | None = None,
    matches: int = 5,
    iterations: int = 10,
    threshold: float = 0.01,
    seed: int = 0,
) -> Made:
    """Plant a grid of seed points, and refine the texture until it no longer changes.

    S. Shin, T. Nishita, S. Y. Shin: On pixel-based texture synthesis by non-parametric sampling,
    2006, section 3, with an exhaustive search in place of step 2, BuildSearchTree.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The texture sample.
    size : int or (int, int)
        Height and width of the output in pixels.
    scale : int, optional
        Scale of the dominant structure in pixels; by default estimated from the power spectrum, but
        at most so large that a window fits into the sample.
    matches : int
        k: a unit tile is drawn from the k best matching ones.
    iterations : int
        The most iterations.
    threshold : float
        epsilon: refinement stops when an iteration changes the texture by less, eq. (1).
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Notes
    -----
    The difference of two textures, eq. (1), is taken as a mean over pixels: as a sum it would only
    be small where nothing changes. Of equal distances the first in scan order wins. Seed points are
    drawn from pixels with whole windows, as all others are.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import iterative_refinement
    >>> sample = np.indices((20, 20)).sum(0).astype(np.uint8) % 4 * 60
    >>> iterative_refinement(sample, (12, 14), scale=4, iterations=2, seed=1).image.shape
    (12, 14)
    """
    pixels, shape = checked(sample, size, seed)
    # Steps 1 and 3: the window is twice as wide as the scale; seed points lie one scale apart.
    if scale is None:
        scale = max(1, min(round(dominant_scale(sample)), (min(pixels.shape[:2]) - 1) // 2))
    fits("window", 2 * scale + 1, pixels, odd=True, least=3)
    planted = plant_seeds(pixels, scale, shape, scale, matches, seed)
    image, sources = np.zeros((*shape, pixels.shape[2]), np.int64), np.full((*shape, 2), -1)
    for p, place in planted.items():
        image[p], sources[p] = pixels[place], place
    # Steps 4 to 9: RefineTexture until little changes.
    everywhere = np.ones(shape, bool)
    for iteration in range(iterations):
        before = image.copy()
        known = sources[..., 0] >= 0
        refine(pixels, scale, image, sources, known, everywhere, torus=iteration > 0)
        if iteration and difference(before, image) < threshold:
            break
    return made(sample, image, sources)


def dominant_scale(sample: Any) -> float:
    """ComputeDominantScale: s = N / r of the ring of the power spectrum with the most power.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The texture sample; of other than square ones N is the longer side.

    Returns
    -------
    float
        In pixels; that of the sample if it is constant.

    Examples
    --------
    >>> x = np.arange(64)
    >>> stripes = np.tile(127 + 100 * np.sin(x * 2 * np.pi / 8), (64, 1)).astype(np.uint8)
    >>> round(dominant_scale(stripes))
    8
    """
    pixels, _ = checked(sample, 1)
    side, thickness = max(pixels.shape[:2]), 0.1  # N and d
    f = pixels - pixels.mean(axis=(0, 1))
    power = (abs(np.fft.fft2(f, axes=(0, 1))) ** 2).sum(axis=2)  # P(u, v), of all channels
    v, u = np.fft.fftfreq(f.shape[0]), np.fft.fftfreq(f.shape[1])
    r = side * np.hypot(v[:, None], u)
    rings = np.bincount(np.rint(r / thickness).astype(int).ravel(), power.ravel())  # P(r)
    return float(side / (rings.argmax() * thickness)) if rings.any() else float(side)


def plant_seeds(
    pixels: Any, reach: int, shape: tuple[int, int], spacing: int, matches: int, seed: int
) -> dict[tuple[int, int], tuple[int, int]]:
    """PlantSeed, seed point planting (Fig. 5): {pixel of the output: pixel of the sample}.

    Seed points are `spacing` pixels apart. If the sample's part with whole windows, which `reach`
    so far, is smaller than a unit tile, each is any pixel of it.
    """
    corner, whole = places(2, 2).reshape(4, 2) * spacing, pixels[reach:-reach, reach:-reach]
    rows, columns = (range(0, n - spacing, spacing) for n in whole.shape[:2])
    tiles = np.array([corner + (y, x) + reach for y in rows for x in columns])
    points: dict[tuple[int, int], tuple[int, int]] = {}
    for i, j in np.ndindex(-(-shape[0] // spacing), -(-shape[1] // spacing)):  # Fig. 5 (b) to (e)
        slot = [(i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1)]
        bits = int(draw(seed, "seed point", i, j))
        if not len(tiles):
            y, x = divmod(bits % (whole.shape[0] * whole.shape[1]), whole.shape[1])
            points[i, j] = y + reach, x + reach
            continue
        there = [k for k in range(4) if slot[k] in points]
        unlike = np.zeros(len(tiles), np.int64)
        for k in there:
            unlike += ((at(pixels, tiles[:, k]) - pixels[points[slot[k]]]) ** 2).sum(axis=1)
        best = np.argsort(unlike, kind="stable")[: matches if there else None]
        tile = tiles[best[bits % len(best)]].tolist()
        for k in range(4):  # only points that are not there are sampled from the new tile
            points.setdefault(slot[k], (tile[k][0], tile[k][1]))
    return {
        (i * spacing, j * spacing): place
        for (i, j), place in points.items()
        if i * spacing < shape[0] and j * spacing < shape[1]
    }


def refine(
    pixels: Any, reach: int, image: Any, sources: Any, known: Any, where: Any, torus: bool
) -> None:
    """RefineTexture: each pixel in scan-line order becomes that of the nearest window.

    Pixels that are not `known` are masked out in neighborhood comparison; `where` says which pixels
    to choose. On a torus windows wrap around the border.
    """
    shape, side = image.shape[:2], 2 * reach + 1
    neighbors = windows(pixels, side, side).reshape(-1, side, side, pixels.shape[2])
    known = known.copy()

    def window(axis: int, p: int) -> Any:
        """Rows or columns in the window, and those in the image; no pixel is there twice."""
        length = shape[axis]
        before, after = min(reach, p), min(reach, length - 1 - p)
        if torus:
            before, after = min(reach, (length - 1) // 2), min(reach, length // 2)
        steps = np.arange(-before, after + 1)
        return steps + reach, (p + steps) % length

    for y, x in np.argwhere(where).tolist():
        (v, rows), (u, columns) = window(0, y), window(1, x)
        there = known[np.ix_(rows, columns)]
        there[rows == y, columns == x] = False
        i, j = np.nonzero(there)
        query = image[rows[i], columns[j]]
        distance = ((neighbors[:, v[i], u[j]] - query) ** 2).sum(axis=(1, 2))
        best = np.divmod(int(distance.argmin()), pixels.shape[1] - 2 * reach)
        sources[y, x] = best[0] + reach, best[1] + reach
        image[y, x], known[y, x] = pixels[tuple(sources[y, x])], True


def difference(before: Any, after: Any) -> float:
    """Eq. (1), as a mean over pixels."""
    length = np.sqrt((before**2).sum(axis=2))
    return float((np.sqrt(((after - before) ** 2).sum(axis=2)) / np.maximum(length, 1)).mean())
