"""Surfaces that are drawn with a lattice that is known, as somebody might photograph them.

Every number of a surface (periods, shifts, unevenness, tones, dirt, light, turn, noise) is drawn
from a range that was written down before the detector saw any of them; `KINDS` lists what is drawn.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from blocks import BLOCKS
from numpy.typing import NDArray
from paving import PAVING, basket
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


# What does not repeat.


def stones(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    size = rng.uniform(10, 70)
    i, j, first, second = nearest(x, y, ((size, 0), (0, size)), 0.5, rng)
    levels = tones(rng, i, j, spread=rng.uniform(0.3, 0.9))
    gap = second - first < rng.uniform(0.03, 0.2) * size
    levels[gap] -= rng.uniform(0.5, 2)
    return levels - 0.5 * (first / size)[..., None], ()


def clouds(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Noise of any grain: sand, plaster, rust, stains."""
    made = smooth(rng.standard_normal(x.shape), rng.choice([0.3, 1, 3, 8, 20]))
    return (made + rng.uniform(0, 1) * grain(rng, x.shape))[..., None] * np.ones(3), ()


def leaves(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Ellipses over one another in any direction; blades of grass if they are thin."""
    levels = np.zeros((*x.shape, 3))
    size, thin = rng.uniform(10, 45), rng.uniform(0.1, 0.8)
    number = int(2 * x.size / 4 / (np.pi / 4 * thin * size**2))
    side = np.array(x.shape)  # places are of the picture here, two to a pixel
    for _ in range(min(number, 6000)):
        center, angle = rng.uniform(0, 1, 2) * side, rng.uniform(0, np.pi)
        low = np.maximum(center - size, 0).astype(int)
        part = tuple(slice(k, int(c + size) + 1) for k, c in zip(low, center, strict=True))
        dy, dx = np.mgrid[part] - center[:, None, None]
        dy, dx = (d[: levels[part].shape[0], : levels[part].shape[1]] for d in (dy, dx))
        along, off = (
            np.cos(angle) * dx + np.sin(angle) * dy,
            np.cos(angle) * dy - np.sin(angle) * dx,
        )
        far = (along / size) ** 2 + (off / (thin * size)) ** 2
        levels[part][far < 1] = rng.standard_normal() + 0.3 * rng.standard_normal(3)
    return levels, ()


def wood(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Figured grain: rings of any width."""
    bent = smooth(rng.standard_normal(x.shape), (30, 120))
    phase = y / rng.uniform(6, 30) + rng.uniform(0.3, 3) * bent
    rings = np.interp(phase, np.arange(-50, 250), rng.standard_normal(300))
    return rings[..., None] + 0.6 * fibers(x, y, rng), ()


def any_courses(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Rubble or boards of any height."""
    size = rng.uniform(16, 60)
    ends = np.cumsum(rng.uniform(0.4, 2.0, MANY) * size) - 20 * size
    row = np.searchsorted(ends, y)
    above = np.minimum(ends[row] - y, y - ends[row - 1])
    k, aside = between(x, 1.8 * size, row, 0.5 * size, rng)
    levels = tones(rng, k, row, spread=rng.uniform(0.2, 0.8))
    levels[np.minimum(above, aside) < rng.uniform(1, 0.08 * size)] = -2
    return levels, ()


def cracks(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Bark, cracked mud and rock: level lines of noise, longer in one direction."""
    made = smooth(rng.standard_normal(x.shape), (rng.uniform(4, 20), rng.uniform(4, 60)))
    return np.minimum(abs(made), 0.8)[..., None] * 3 * np.ones(3), ()


KINDS: dict[str, Callable[[Floats, Floats, np.random.Generator], Drawn]] = {
    one.__name__.replace("_", " "): one
    for one in (
        bricks, uneven_bricks, tiles, panels, hexagons, dots, scales, weave, checks, pattern,
        in_turn, basket, mesh, boards, courses, ribs, shingles,
        stones, clouds, leaves, wood, any_courses, cracks, *PAVING, *BLOCKS,
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
