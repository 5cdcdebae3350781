"""Seed points, the start of iterative refinement (section 3, Fig. 5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.methods.refinement.levels import ONE, Prepared
from weftex.methods.refinement.output import NO_GUIDE, Guide, Output
from weftex.random import draw
from weftex.search.windows import Windows


def seed_sources(prepared: Prepared, output: Output, guide: Guide, seed: int) -> NDArray[np.int32]:
    """Return sources for a grid of seed points of an output, -1 elsewhere."""
    level, step = prepared.levels[output.number], 2**output.number
    pyramid, matches = level.pyramid, prepared.method.matches
    spacing = max(1, round(prepared.seed_spacing / step))
    places, y, x = plant_seeds(
        pyramid, output.known.shape, output.wrap, spacing, matches, seed, guide
    )
    source = np.full(output.known.shape, -1, np.int32)
    v, u = np.divmod(pyramid.to_sample(places), pyramid.shape[1])
    source[np.ix_(y, x)] = level.at(v * step, u * step)
    return source


def plant_seeds(
    pyramid: Windows,
    shape: tuple[int, ...],
    wrap: tuple[bool, bool],
    spacing: int,
    matches: int,
    seed: int,
    guide: Guide = NO_GUIDE,
) -> tuple[NDArray[np.int32], NDArray[np.intp], NDArray[np.intp]]:
    """Sample seed points by stochastic tiling with unit tiles (section 3, Fig. 5).

    Returns places (rows, columns), flat indices into `pyramid.pixels`, and the y and x of points
    `spacing` pixels apart. Each slot takes one of the `matches` tiles with the best corners.
    """
    y, x = (_grid(*axis, spacing) for axis in zip(shape, wrap, strict=True))
    bits = draw(seed, "seed point", *np.indices((len(y), len(x))))
    tiles = _unit_tiles(pyramid, spacing)
    if not len(tiles):
        return pyramid.centers[bits % np.uint64(len(pyramid.centers))], y, x
    flat = pyramid.pixels.reshape(-1, pyramid.pixels.shape[2])
    colors = flat[tiles].astype(np.int64)
    # Beyond the end of an axis lies one more row of points, or the first one again.
    rows, columns = (len(n) + (not wraps) for n, wraps in zip((y, x), wrap, strict=True))
    points = np.full((rows, columns), -1, np.int32)
    if guide.weight:
        own = guide.pyramid.reshape(-1, guide.pyramid.shape[2])[tiles].astype(np.int64)
        ends = [np.append(n, length - 1) for n, length in zip((y, x), shape, strict=True)]
        shown = guide.output[np.ix_(ends[0][:rows], ends[1][:columns])]
    for i, j in np.ndindex(bits.shape):
        corners = [(v % rows, u % columns) for v in (i, i + 1) for u in (j, j + 1)]
        slot = np.array([points[corner] for corner in corners])
        there = slot >= 0
        distance = ((colors - flat[slot]) ** 2).sum(axis=2) @ there
        if guide.weight:
            wanted = np.array([shown[corner] for corner in corners], np.int64)
            apart = ((own - wanted) ** 2).sum(axis=(1, 2))
            distance = ONE * distance + guide.weight * apart
        # At the first slot nothing tells tiles apart but the guide; many may be equally good.
        equal = int((distance == distance.min()).sum())
        best = np.argsort(distance, kind="stable")[: matches if there.any() else equal]
        tile = tiles[best[int(bits[i, j] % np.uint64(len(best)))]]
        for corner, place in zip(corners, tile, strict=True):
            if points[corner] < 0:
                points[corner] = place
    return points[: len(y), : len(x)], y, x


def _grid(length: int, wraps: bool, spacing: int) -> NDArray[np.intp]:
    """Places of the points along an axis."""
    if not wraps:
        return np.arange(0, length, spacing)
    count = max(1, round(length / spacing))
    return np.arange(count) * length // count


def _unit_tiles(pyramid: Windows, spacing: int) -> NDArray[np.int32]:
    """Corners (n, 4) of the sample's unit tiles: upper left and right, lower left and right."""
    width = pyramid.usable.shape[1]
    if spacing >= min(pyramid.usable.shape):  # padding by it may not fit in memory
        return np.empty((0, 4), np.int32)
    usable = np.pad(pyramid.usable, (0, spacing))
    y, x = np.divmod(pyramid.centers, width)
    on_grid = ((y - y.min()) % spacing == 0) & ((x - x.min()) % spacing == 0)
    y, x = y[on_grid], x[on_grid]
    whole = usable[y + spacing, x] & usable[y, x + spacing] & usable[y + spacing, x + spacing]
    corner = (y * width + x)[whole > 0]
    steps = np.array([0, spacing, spacing * width, spacing * width + spacing], np.int32)
    tiles: NDArray[np.int32] = (corner[:, None] + steps).astype(np.int32)
    return tiles
