"""Paving, roofs and sheets for drawn.py, whose pieces turn, alternate, or have fixtures."""

from __future__ import annotations

import numpy as np
from shapes import MANY, Drawn, Floats, cells, fibers, smooth, tones


def _laid(x: Floats, y: Floats, rng: np.random.Generator, long: int, split: int = 1) -> Drawn:
    """Blocks `long` times as long as wide, each set against the side of the next."""
    wide = rng.uniform(14, 30) * split**0.5
    i, j = (np.floor(c / wide).astype(np.int64) for c in (x, y))
    part = (i - j) % (2 * long)  # those below `long` lie, the others stand
    lying = part < long
    first = np.where(lying, i - part, j + part - 2 * long + 1)  # cell that the block begins in
    along = np.where(lying, x, y) - first * wide
    across = np.where(lying, y, x) % wide
    piece, across = np.floor(across / wide * split).astype(np.int64), across % (wide / split)
    ends = np.minimum(along, long * wide - along)
    off = np.minimum(ends, np.minimum(across, wide / split - across))
    column = np.where(lying, j, i + MANY // 2)
    levels = tones(rng, 2 * first + piece, column, spread=rng.uniform(0.1, 0.6))
    levels[off < rng.uniform(0.8, 0.1 * wide)] = rng.choice([-2, 2])
    return levels, ((wide, wide), (2 * long * wide, 0))


def herringbone(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    return _laid(x, y, rng, 2)


def long_herringbone(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    return _laid(x, y, rng, 3)


def slanted_herringbone(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    c = 0.5**0.5
    levels, truth = _laid(c * x + c * y, c * y - c * x, rng, int(rng.choice([2, 3])))
    return levels, tuple((c * p - c * q, c * p + c * q) for p, q in truth)


def double_herringbone(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    return _laid(x, y, rng, 2, 2)


def _turned(
    x: Floats, y: Floats, rng: np.random.Generator, least: float, numbers: list[int]
) -> tuple[Floats, Floats, float, float]:
    """Square blocks of strips, each turned against the next: levels, distances to joints, sides."""
    side, number = rng.uniform(least, 64), int(rng.choice(numbers))
    i, j = np.floor(x / side).astype(np.int64), np.floor(y / side).astype(np.int64)
    lying, size = (i + j) % 2 == 0, side / number
    part = np.floor(np.where(lying, y, x) / side % 1 * number).astype(np.int64)
    along, across = np.where(lying, x, y) % side, np.where(lying, y, x) % size
    off = np.minimum(np.minimum(along, side - along), np.minimum(across, size - across))
    return tones(rng, number * i + part, j, spread=rng.uniform(0.1, 0.5)), off, side, size


def basket(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Pavers in blocks of two or three, each block turned against the next."""
    levels, off, side, _ = _turned(x, y, rng, 26, [2, 3])
    levels[off < rng.uniform(0.8, 0.06 * side)] = rng.choice([-2, 2])
    return levels, ((side, side), (side, -side))


def parquet(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Blocks of three to five strips, each turned against the next."""
    levels, off, side, size = _turned(x, y, rng, 30, [3, 4, 5])
    levels[off < rng.uniform(0.6, 0.15 * size)] = rng.choice([-2, 2])
    return levels, ((side, side), (side, -side))


def octagons(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Octagons with a square dot at each corner."""
    side = rng.uniform(26, 64)
    cut = rng.uniform(0.2, 0.3) * side
    i, j = np.rint(x / side).astype(np.int64), np.rint(y / side).astype(np.int64)
    right, down = abs(x / side - i) * side, abs(y / side - j) * side
    left = side - right - down
    dot, edge = left < cut, np.minimum(side / 2 - right, side / 2 - down)
    levels = tones(rng, i, j, spread=rng.uniform(0.1, 0.5))
    k, m = np.floor(x / side).astype(np.int64), np.floor(y / side).astype(np.int64)
    dots = tones(rng, k, m, spread=0.2) + rng.choice([-1.5, 0, 1.5])
    levels = np.where(dot[..., None], dots, levels)
    off = np.where(dot, cut - left, np.minimum(edge, left - cut))
    levels[off < rng.uniform(0.8, 2.5)] = rng.choice([-2, 2])
    return levels, ((side, 0), (0, side))


def long_and_short(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Bricks of two lengths in turn."""
    high = rng.uniform(14, 32)
    long = high * rng.uniform(2.2, 3.2)
    both = long * (1 + rng.uniform(0.45, 0.8))
    shift = rng.choice([0.5, 0.25, 1 / 3]) * both
    row = np.floor(y / high).astype(np.int64)
    k, at = np.divmod(x - row * shift, both)
    second = at > long
    aside = np.minimum(np.where(second, at - long, at), np.where(second, both - at, long - at))
    above = np.minimum(y % high, high - y % high)
    levels = tones(rng, 2 * k.astype(np.int64) + second, row, spread=rng.uniform(0.1, 0.6))
    levels[np.minimum(aside, above) < rng.uniform(0.8, 0.1 * high)] = rng.choice([-2, 2])
    return levels, ((both, 0), (shift, high))


def checkers(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Two colors in turn, from two to four tiles each."""
    side, number = rng.uniform(24, 64), int(rng.choice([2, 3, 4]))
    i, j, off = cells(x, y, side, side, 0, 0, rng)
    made = [smooth(rng.standard_normal((64, 64)), 2) for _ in range(2 * number)]
    which = rng.integers(0, number, (MANY, MANY))[i % MANY, j % MANY] + number * ((i + j) % 2)
    a, b = (np.floor(c / side % 1 * 64).astype(np.int64) for c in (y, x))
    levels = (np.stack(made)[which, a, b] * rng.uniform(0.1, 0.6))[..., None]
    levels = levels + rng.uniform(-1.5, 1.5, (2, 3))[(i + j) % 2]
    if rng.random() < 0.5:
        levels[off < rng.uniform(0.5, 1.5)] = rng.choice([-2, 2])
    return levels, ((side, side), (side, -side))


def roof_tiles(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Waves of clay with a shadow below each row."""
    wide = rng.uniform(18, 44)
    high, shift = wide * rng.uniform(1.1, 1.8), rng.choice([0, 0, 0.5])
    row = np.floor(y / high).astype(np.int64)
    place = x / wide - shift * row
    wave = np.sin(2 * np.pi * place) + 0.4 * np.cos(4 * np.pi * place) + 1.2 * (y / high % 1)
    piece = np.floor(place).astype(np.int64)
    levels = wave[..., None] + tones(rng, piece, row, spread=rng.uniform(0.1, 0.6))
    levels[y % high < rng.uniform(1, 0.12 * high)] -= 2
    return levels, ((wide, 0), (shift * wide, high))


def corrugated(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Sheet with streaks along it; screws at any distance would be a lattice."""
    wide = rng.uniform(24, 70)
    levels = np.tanh(rng.uniform(1, 6) * (np.sin(2 * np.pi * x / wide) - rng.uniform(0, 0.6)))
    streaks = smooth(rng.standard_normal((1024, 1024)), (rng.uniform(20, 80), rng.uniform(1, 4)))
    i, j = (np.rint(2 * c).astype(np.int64) % 1024 for c in (y, x))
    levels += 0.3 * np.cos(2 * np.pi * x / wide) + rng.uniform(0.2, 0.7) * streaks[i, j]
    return levels[..., None] * np.ones(3), ((wide, 0),)


def bolted(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Boards with a pair of bolts each, all at one place."""
    high = rng.uniform(24, 60)
    row = np.floor(y / high).astype(np.int64)
    levels = tones(rng, row, spread=rng.uniform(0.05, 0.4)) + 0.5 * fibers(x, y, rng, row)
    levels[y % high < rng.uniform(1, 2.5)] -= rng.uniform(1, 2)
    first, apart = 1000 + rng.uniform(150, 240), rng.uniform(25, 64)
    for place in (first, first + apart):
        near = np.hypot(x - place, y % high - high / 2) < rng.uniform(2, 4)
        levels[near] += rng.choice([-2, 2])
    return levels, ((0, high),)


PAVING = (
    herringbone, long_herringbone, slanted_herringbone, double_herringbone, parquet, octagons,
    long_and_short, checkers, roof_tiles, corrugated, bolted,
)  # fmt: skip
