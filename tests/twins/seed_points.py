"""Seed points by stochastic tiling (Fig. 5 of the paper on texture refinement and fusion)."""

import numpy as np

from twins.randomness import random_bits


def grid_points(length, wraps, spacing):
    """Where seed points lie along an axis; on one that goes around they are spread evenly."""
    if not wraps:
        return list(range(0, length, spacing))
    count = max(1, round(length / spacing))
    return [i * length // count for i in range(count)]


def seed_points(pixels, mask, shape, wrap, spacing, matches, seed):
    """Stochastic tiling with unit tiles (Fig. 5): {(y, x) of the output: (y, x) of the sample}."""
    usable = [tuple(at) for at in np.argwhere(mask).tolist()]
    top, left = min(y for y, _ in usable), min(x for _, x in usable)
    tiles = []
    for y, x in usable:
        corners = [(y + dy, x + dx) for dy in (0, spacing) for dx in (0, spacing)]
        if (y - top) % spacing == 0 and (x - left) % spacing == 0 and set(corners) <= set(usable):
            tiles.append(corners)
    rows, columns = (grid_points(*axis, spacing) for axis in zip(shape, wrap, strict=True))
    points = {}
    for i, j in np.ndindex(len(rows), len(columns)):
        bits = random_bits(seed, "seed point", i, j)
        if not tiles:
            points[i, j] = usable[bits % len(usable)]
            continue
        slot = [(i + di, j + dj) for di in (0, 1) for dj in (0, 1)]
        slot = [(v % len(rows) if wrap[0] else v, u) for v, u in slot]
        slot = [(v, u % len(columns) if wrap[1] else u) for v, u in slot]
        there = [k for k in range(4) if slot[k] in points]
        unlike = [
            sum(((pixels[tile[k]].astype(int) - pixels[points[slot[k]]]) ** 2).sum() for k in there)
            for tile in tiles
        ]
        ranked = sorted(range(len(tiles)), key=lambda n: unlike[n])
        ranked = ranked[:matches] if there else [n for n in ranked if unlike[n] == min(unlike)]
        tile = tiles[ranked[bits % len(ranked)]]
        for k in range(4):
            points.setdefault(slot[k], tile[k])
    return {
        (rows[i], columns[j]): place
        for (i, j), place in points.items()
        if i < len(rows) and j < len(columns)
    }
