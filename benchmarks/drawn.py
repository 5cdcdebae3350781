"""Surfaces that are drawn with a lattice that is known, as somebody might photograph them.

Every number of a surface (periods, shifts, unevenness, tones, dirt, light, turn, noise) is drawn
from a range that was written down before the detector saw any of them; `KINDS` lists what is drawn.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scattered import any_courses, blobs, clouds, cracks, disks, leaves, scratches, stones, wood
from shapes import (
    MANY,
    Drawn,
    Floats,
    Vectors,
    between,
    cells,
    fibers,
    grain,
    nearest,
    smooth,
    tones,
)

# What repeats along two directions.


def bricks(x: Floats, y: Floats, rng: np.random.Generator, uneven: float = 0.0) -> Drawn:
    high = rng.uniform(14, 45)
    wide = high * rng.uniform(1.6, 3.6)
    shift = rng.choice([1 / 2, 1 / 2, 1 / 2, 1 / 3, 1 / 4])
    k, row, off = cells(x, y, wide, high, shift, uneven, rng)
    levels = tones(rng, k, row, spread=rng.uniform(0.1, 0.8))
    joint = off < rng.uniform(1.0, 0.1 * high)
    levels[joint] = rng.choice([-1.5, 1.5, 2.5])
    return levels, ((wide, 0), (shift * wide, high))


def uneven_bricks(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    return bricks(x, y, rng, rng.uniform(0.04, 0.12))


def tiles(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    high, wide = rng.uniform(16, 70, 2)
    k, row, off = cells(x, y, wide, high, 0, rng.uniform(0, 0.04), rng)
    levels = tones(rng, k, row, spread=rng.uniform(0.05, 0.6))
    levels[off < rng.uniform(0.8, 2.5)] = rng.choice([-2, 2])
    return levels, ((wide, 0), (0, high))


def panels(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Few of them: two to three along a side of 256 pixels."""
    high, wide = rng.uniform(80, 128, 2)
    shift = rng.choice([0, 0, 0.5])
    k, row, off = cells(x, y, wide, high, shift, 0, rng)
    levels = tones(rng, k, row, spread=rng.uniform(0.05, 0.4))
    levels[off < rng.uniform(1.0, 3)] = -2
    return levels, ((wide, 0), (shift * wide, high))


def hexagons(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    wide = rng.uniform(18, 64)
    vectors = ((wide, 0.0), (wide / 2, wide * 0.75**0.5))
    i, j, first, second = nearest(x, y, vectors, rng.uniform(0, 0.04), rng)
    levels = tones(rng, i, j, spread=rng.uniform(0.1, 0.7))
    levels[second - first < rng.uniform(1.5, 4)] = rng.choice([-2, 2])
    return levels, vectors


def dots(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Holes, studs or printed dots on a lattice of any shape."""
    length, turn = rng.uniform(10, 48), rng.uniform(0.45, 0.55) * np.pi
    other = length * rng.uniform(0.8, 1.6)
    vectors = ((length, 0.0), (other * np.cos(turn), other * np.sin(turn)))
    i, j, first, _ = nearest(x, y, vectors, rng.uniform(0, 0.06), rng)
    levels = tones(rng, i, j, spread=rng.uniform(0, 0.5)) + 2
    levels[first > rng.uniform(0.2, 0.4) * length] = 0
    return levels, vectors


def scales(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Fish-scale tiles: each course covers the upper part of the next."""
    wide = rng.uniform(24, 80)
    high = wide * rng.uniform(0.4, 0.6)
    levels = np.zeros((*x.shape, 3))
    tone = rng.uniform(0.1, 0.6)
    table = tone * rng.standard_normal((MANY, MANY, 3))
    row = np.floor(y / high).astype(np.int64)
    for r in (2, 1, 0):  # the upper ones cover the lower ones
        course = row - r
        k = np.floor((x - course % 2 * wide / 2) / wide).astype(np.int64)
        center = (k + 0.5) * wide + course % 2 * wide / 2
        far = np.hypot(x - center, np.maximum(y - (course + 0.4) * high, 0)) / (0.55 * wide)
        own = far < 1
        shade = table[k % MANY, course % MANY] + (0.8 - 2.0 * far**6)[..., None]
        levels[own] = shade[own]
    return levels, ((wide, 0), (wide / 2, high))


def weave(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Over and under: plain (every second), or twill (two over, two under)."""
    p, q = rng.uniform(7, 22) * np.array([1, rng.uniform(0.8, 1.25)])
    i, j = np.floor(x / p).astype(np.int64), np.floor(y / q).astype(np.int64)
    times = 2 if rng.random() < 0.7 else 4
    over = (i + j) % times < times // 2
    across, down = (np.sin(np.pi * (c % 1)) ** 0.5 for c in (x / p, y / q))
    levels = np.where(over, across, down) + rng.uniform(0.2, 0.6) * np.where(over, 1, -1)
    thread = np.where(over, *(rng.normal(0, 0.25, (2, MANY))[n][k % MANY]
                              for n, k in ((0, i), (1, j))))  # fmt: skip
    return (levels + thread)[..., None] * np.ones(3), ((p, -q), (times * p, 0))


def checks(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Gingham: stripes that cross."""
    wide, high = rng.uniform(16, 90, 2)
    part = rng.uniform(0.3, 0.7)
    levels = (x / wide % 1 < part) * 1.0 + (y / high % 1 < part) * 1.0
    return levels[..., None] * rng.uniform(-2, 2, 3) + levels[..., None], ((wide, 0), (0, high))


def pattern(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Any picture, again and again: wallpaper, print, relief."""
    length = rng.uniform(14, 70)
    slant = rng.uniform(-0.5, 0.5) * length
    vectors = ((length, rng.uniform(-0.2, 0.2) * length), (slant, length * rng.uniform(0.7, 1.4)))
    a, b = np.tensordot(np.linalg.inv(np.array(vectors)).T, np.stack([x, y]), 1)
    tile = np.stack([smooth(rng.standard_normal((32, 32)), rng.uniform(1, 3)) for _ in range(3)])
    i, j = (np.floor(c % 1 * 32).astype(np.int64) for c in (b, a))
    return np.moveaxis(tile, 0, 2)[i, j], vectors


def in_turn(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """A pattern whose cells are of two kinds, like a checkerboard, that differ a little."""
    wide, high = rng.uniform(10, 34, 2)
    i, j = np.floor(x / wide).astype(np.int64), np.floor(y / high).astype(np.int64)
    picture = [smooth(rng.standard_normal((16, 16)), 1.5) for _ in range(3)]
    a, b = (np.floor(c % 1 * 16).astype(np.int64) for c in (y / high, x / wide))
    amount = rng.uniform(0.2, 1.0)
    levels = picture[0][a, b] + amount * np.where((i + j) % 2, picture[1][a, b], picture[2][a, b])
    return levels[..., None] * np.ones(3), ((wide, high), (wide, -high))


def basket(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Pavers in blocks of two or three, each block turned against the next."""
    side, number = rng.uniform(26, 64), rng.choice([2, 3])
    i, j = np.floor(x / side).astype(np.int64), np.floor(y / side).astype(np.int64)
    lying = (i + j) % 2 == 0
    part = np.floor(np.where(lying, y, x) / side % 1 * number).astype(np.int64)
    size = side / number
    along, across = np.where(lying, x, y) % side, np.where(lying, y, x) % size
    off = np.minimum(np.minimum(along, side - along), np.minimum(across, size - across))
    levels = tones(rng, number * i + part, j, spread=rng.uniform(0.1, 0.5))
    levels[off < rng.uniform(0.8, 0.06 * side)] = rng.choice([-2, 2])
    return levels, ((side, side), (side, -side))


def mesh(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Wires before stones."""
    wide, high = rng.uniform(24, 70) * np.array([1, rng.uniform(0.8, 1.25)])
    if rng.random() < 0.4:
        vectors: Vectors = ((wide, high), (wide, -high))
    else:
        vectors = ((wide, 0.0), (0.0, high))
    levels = stones(x, y, rng)[0]
    thick, tone = rng.uniform(1.2, 3.5), rng.choice([-2.0, 2.5])
    for across in np.linalg.inv(np.array(vectors)).T:
        place = (x * across[0] + y * across[1]) % 1
        wire = np.minimum(place, 1 - place) / np.hypot(*across) < thick / 2
        levels[wire] = tone
    return levels, vectors


def thirds(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Bricks or planks, each course a third of a piece on."""
    high = rng.uniform(12, 36)
    wide, shift = high * rng.uniform(2, 4), rng.choice([-1, 1]) / 3
    k, row, off = cells(x, y, wide, high, shift, rng.uniform(0, 0.05), rng)
    levels = tones(rng, k, row, spread=rng.uniform(0.1, 0.7))
    levels[off < rng.uniform(0.8, 0.1 * high)] = rng.choice([-2, 2])
    return levels, ((wide, 0), (shift * wide, high))


def herringbone(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Blocks two or three times as long as wide, each set against the side of the next."""
    wide, long = rng.uniform(12, 26), int(rng.choice([2, 2, 3]))
    c = s = 0.5**0.5
    if rng.random() < 0.5:
        c, s = 1.0, 0.0
    x, y = c * x + s * y, c * y - s * x
    i, j = np.floor(x / wide).astype(np.int64), np.floor(y / wide).astype(np.int64)
    part = (i - j) % (2 * long)  # those below `long` lie, the others stand
    lying = part < long
    first = np.where(lying, i - part, j + part - 2 * long + 1)  # cell that the block begins in
    along = np.where(lying, x, y) - first * wide
    across = np.where(lying, y, x) % wide
    off = np.minimum(np.minimum(along, long * wide - along), np.minimum(across, wide - across))
    levels = tones(rng, first, np.where(lying, j, i + MANY // 2), spread=rng.uniform(0.1, 0.6))
    levels[off < rng.uniform(0.8, 0.1 * wide)] = rng.choice([-2, 2])
    return levels, tuple(
        (c * a - s * b, s * a + c * b) for a, b in ((wide, wide), (2 * long * wide, 0))
    )


def checker(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Two colors in turn, as of a floor or a board."""
    wide, high = rng.uniform(14, 60) * np.array([1, rng.choice([1, 1, rng.uniform(0.7, 1.4)])])
    k, row, off = cells(x, y, wide, high, 0, rng.uniform(0, 0.04), rng)
    levels = tones(rng, k, row, spread=rng.uniform(0.05, 0.6))
    colors = rng.uniform(-1.5, 1.5, (2, 3))
    levels = levels + colors[(k + row) % 2]
    if rng.random() < 0.5:
        levels[off < rng.uniform(0.8, 2)] = rng.choice([-2, 2])
    return levels, ((wide, high), (wide, -high))


def faint_turns(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """A pattern of which every second or third column has a little of another."""
    wide, high, times = rng.uniform(12, 34), rng.uniform(12, 34), int(rng.choice([2, 2, 3]))
    i = np.floor(x / wide).astype(np.int64)
    picture = [smooth(rng.standard_normal((16, 16)), 1.5) for _ in range(times + 1)]
    a, b = (np.floor(c % 1 * 16).astype(np.int64) for c in (y / high, x / wide))
    levels, amount = picture[0][a, b], rng.uniform(0.15, 0.5)
    for k in range(times):
        levels = levels + amount * (i % times == k) * picture[k + 1][a, b]
    return levels[..., None] * np.ones(3), ((times * wide, 0), (0, high))


def few(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """A picture, or pieces of any tone, three to five times along a side of 256 pixels."""
    length = 256 / rng.uniform(3, 5)
    vectors = ((length, 0.0), (rng.choice([0, 0.5]) * length, length * rng.uniform(0.8, 1.0)))
    if rng.random() < 0.5:
        i, j, first, second = nearest(x, y, vectors, rng.uniform(0, 0.03), rng)
        levels = tones(rng, i, j, spread=rng.uniform(0.1, 0.6))
        levels[second - first < rng.uniform(2, 6)] = rng.choice([-2, 2])
        return levels, vectors
    a, b = np.tensordot(np.linalg.inv(np.array(vectors)).T, np.stack([x, y]), 1)
    tile = smooth(rng.standard_normal((96, 96)), rng.uniform(3, 12))
    i, j = (np.floor(c % 1 * 96).astype(np.int64) for c in (b, a))
    return tile[i, j][..., None] * rng.uniform(0.5, 1.5, 3), vectors


# What repeats along one.


def boards(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Planks of one width, with grain; their ends lie anywhere."""
    high = rng.uniform(20, 100)
    row, above = between(y, high, np.zeros(1, np.int64), rng.uniform(0, 0.015) * high, rng)
    start = rng.uniform(0, 1, MANY)[row % MANY]
    length = rng.uniform(180, 500)
    k, aside = between(x + 9 * length * start, length, row, 0.15 * length, rng)
    levels = tones(rng, k, row, spread=rng.uniform(0.2, 0.7)) + 0.5 * fibers(x, y, rng, row)
    levels[np.minimum(above, aside) < rng.uniform(0.7, 2)] -= rng.uniform(1, 3)
    return levels, ((0, high),)


def courses(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Stones of one height and any length."""
    high = rng.uniform(16, 60)
    row, above = between(y, high, np.zeros(1, np.int64), rng.uniform(0, 0.03) * high, rng)
    ends = np.cumsum(rng.uniform(0.6, 2.4, (64, MANY)) * high, axis=1) - 9 * high
    k = np.zeros(x.shape, np.int64)
    aside = np.full(x.shape, np.inf)
    for r in np.unique(row):
        own, line = row == r, ends[r % 64]
        k[own] = np.searchsorted(line, x[own])
        n = np.clip(k[own], 1, MANY - 1)
        aside[own] = np.minimum(line[n] - x[own], x[own] - line[n - 1])
    levels = tones(rng, k, row, spread=rng.uniform(0.2, 0.8))
    levels[np.minimum(above, aside) < rng.uniform(0.8, 0.08 * high)] = rng.choice([-2, 2])
    return levels, ((0, high),)


def ribs(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Corrugated metal, corduroy, ribbed plastic."""
    high, sharp = rng.uniform(8, 50), rng.uniform(0.5, 4)
    levels = np.tanh(sharp * np.sin(2 * np.pi * y / high)) + 0.5 * np.cos(4 * np.pi * y / high)
    return levels[..., None] * np.ones(3), ((0, high),)


def shingles(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Rows of slates of any width, whose lower ends are not in line."""
    high = rng.uniform(16, 50)
    k, _ = between(x, 1.3 * high, np.floor(y / high).astype(np.int64), 0.3 * high, rng)
    down = y + rng.uniform(0, 0.1) * high * rng.standard_normal(MANY)[k * 7 % MANY]
    row = np.floor(down / high).astype(np.int64)
    k, aside = between(x, 1.3 * high, row, 0.4 * high, rng)
    levels = tones(rng, k, row, spread=rng.uniform(0.2, 0.6))
    levels += rng.uniform(0.5, 1.5) * ((down / high % 1)[..., None] - 0.5)
    levels[(down % high < rng.uniform(1, 3)) | (aside < 1)] -= 1.5
    return levels, ((0, high),)


KINDS: dict[str, Callable[[Floats, Floats, np.random.Generator], Drawn]] = {
    one.__name__.replace("_", " "): one
    for one in (
        bricks, uneven_bricks, tiles, panels, hexagons, dots, scales, weave, checks, pattern,
        in_turn, basket, mesh, boards, courses, ribs, shingles,
        stones, clouds, leaves, wood, any_courses, cracks,
        thirds, herringbone, checker, faint_turns, few, disks, scratches, blobs,
    )
}  # fmt: skip


def draw(kind: str, seed: int, side: int = 512) -> tuple[NDArray[np.uint8], Vectors]:
    """A photograph of a drawn surface, and its lattice: two vectors, one, or none.

    Four in five are turned by a degree or so, as a camera is, the others by any angle. They are
    dirty, lit unevenly, bent by about a pixel, out of focus and noisy, more or less.
    """
    rng = np.random.default_rng([list(KINDS).index(kind), seed])
    v, u = np.mgrid[: 2 * side, : 2 * side] / 2
    angle = np.deg2rad(rng.choice([rng.normal(0, 0.7), rng.uniform(-90, 90)], p=[0.8, 0.2]))
    c, s = np.cos(angle), np.sin(angle)
    bend = rng.uniform(0, 1.2) * np.stack([smooth(rng.standard_normal(v.shape), 90) for _ in "xy"])
    x, y = c * u + s * v + bend[0] + 1000, c * v - s * u + bend[1] + 1000
    levels, truth = KINDS[kind](x, y, rng)
    levels = levels + rng.uniform(0.05, 0.6) * grain(rng, v.shape)[..., None]
    levels += rng.uniform(0, 0.4) * smooth(rng.standard_normal(v.shape), 40)[..., None]
    light = rng.normal(0, 0.4, 2)
    levels += (light[0] * (u / side - 0.5) + light[1] * (v / side - 0.5))[..., None]
    focus = rng.uniform(0.6, 2.0)
    levels = np.stack([_blurred(levels[..., k], focus) for k in range(3)], axis=2)
    levels = levels.reshape(side, 2, side, 2, 3).mean(axis=(1, 3))
    if rng.random() < 0.15:
        levels = levels.mean(axis=2, keepdims=True) * np.ones(3)
    levels = rng.uniform(90, 150) + rng.uniform(15, 40) * levels
    levels += rng.uniform(1, 10) * rng.standard_normal(levels.shape)
    turned = tuple((c * a - s * b, s * a + c * b) for a, b in truth)
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8), turned


def _blurred(values: Floats, radius: float) -> Floats:
    spread, mean = float(values.std()), float(values.mean())
    return smooth(values - mean, radius) * spread + mean
