"""Paving of blocks of whole units, bonds of bricks, and cobbles and ashlar, for drawn.py."""

from __future__ import annotations

import numpy as np
from shapes import MANY, Drawn, Floats, Whole, tones

Block = tuple[tuple[int, int], ...]  # cells (x, y) of a block
Period = tuple[int, int, int]  # W, S, H of the lattice (W, S), (0, H)


def box(x: int, y: int, wide: int, high: int) -> Block:
    return tuple((x + i, y + j) for j in range(high) for i in range(wide))


def _paved(
    x: Floats, y: Floats, rng: np.random.Generator, period: Period, blocks: list[Block],
    unit: tuple[float, float], zigzag: float = 0.0,
) -> Drawn:  # fmt: skip
    """Blocks that fill the plane by a lattice of units; `zigzag` bends all joints, by units."""
    across, slant, down = period
    x, y = x / unit[0], y / unit[1]
    x, y = x + zigzag * _triangle(y), y + zigzag * _triangle(x)
    owner = np.full((across, down, 3), -1)
    for k, block in enumerate(blocks):
        for i, j in block:
            at = i % across, (j - i // across * slant) % down
            assert owner[at][0] < 0
            owner[at] = k, i - block[0][0], j - block[0][1]
    assert (owner[..., 0] >= 0).all()

    def piece(i: Whole, j: Whole) -> Whole:
        k, a, b = np.moveaxis(owner[i % across, (j - i // across * slant) % down], -1, 0)
        return np.stack([k, i - a, j - b])

    levels, off = _filled(x, y, piece, unit, rng)
    joint = off < rng.uniform(0.8, max(1.0, 0.07 * min(unit))) * _ragged(x, y, rng)
    levels[joint] = rng.choice([-2, 2]) * rng.uniform(0.7, 1)
    return levels, ((across * unit[0], slant * unit[1]), (0.0, down * unit[1]))


def _filled(x, y, piece, unit, rng) -> tuple[Floats, Floats]:  # type: ignore[no-untyped-def]
    """Tones of the pieces of all cells, and distances to joints in pixels."""
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    own, off = piece(i, j), np.full(x.shape, np.inf)
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            right, low = (x - i - (a + 1) / 2) * a, (y - j - (b + 1) / 2) * b
            far = np.hypot(right * unit[0], low * unit[1])
            other = (piece(i + a, j + b) != own).any(axis=0)
            off = np.where(other, np.minimum(off, far), off)
    levels = tones(rng, own[1] + 7 * own[0], own[2] + 3 * own[0], spread=rng.uniform(0.1, 0.6))
    return levels, off


def _triangle(at: Floats) -> Floats:
    return abs(at % 1 - 0.5) * 4 - 1


def _ragged(x: Floats, y: Floats, rng: np.random.Generator) -> Floats:
    """Factors of the joints' widths, from about a half to one and a half."""
    waves = rng.uniform(-2, 2, (4, 2))
    phases = rng.uniform(0, 7, 4)
    total = sum(np.sin(a * x + b * y + c) for (a, b), c in zip(waves, phases, strict=True))
    return np.clip(1 + 0.25 * total, 0.5, 1.6)


def _square(rng: np.random.Generator, least: float = 16, most: float = 40) -> tuple[float, float]:
    unit = rng.uniform(least, most)
    return unit, unit


def _maybe(rng: np.random.Generator) -> float:
    return float(rng.choice([0, rng.uniform(0.05, 0.14)]))


def stepped(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Two lying and two standing blocks in turn, each column lower than the one before."""
    blocks = [box(0, 0, 2, 1), box(0, 1, 2, 1), box(0, 2, 1, 2), box(1, 2, 1, 2)]
    return _paved(x, y, rng, (2, -1, 4), blocks, _square(rng, 16, 64), _maybe(rng))


def interlocking(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Zigzag blocks in running bond."""
    unit = _square(rng, 16, 44)
    return _paved(x, y, rng, (1, 1, 2), [box(0, 0, 1, 2)], unit, rng.uniform(0.07, 0.16))


def zigzag_herringbone(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    c = 0.5**0.5 if rng.random() < 0.5 else 1.0
    s = (1 - c * c) ** 0.5
    blocks, unit = [box(0, 0, 2, 1), box(-1, 0, 1, 2)], _square(rng, 16, 44)
    levels, truth = _paved(
        c * x + s * y, c * y - s * x, rng, (1, 1, 4), blocks, unit, rng.uniform(0.05, 0.15)
    )
    return levels, tuple((c * p - s * q, s * p + c * q) for p, q in truth)


def corners(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Blocks of the shape of an L."""
    blocks = [((0, 0), (1, 0), (0, 1)), ((1, 1), (0, 2), (1, 2))]
    period = (2, int(rng.integers(0, 2)), 3)
    return _paved(x, y, rng, period, blocks, _square(rng, 16, 44), _maybe(rng))


def zigzags(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Blocks of the shape of a Z."""
    blocks = [((0, 0), (1, 0), (1, 1), (2, 1))]
    return _paved(x, y, rng, (1, 2, 4), blocks, _square(rng, 14, 40), _maybe(rng))


def pinwheel(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    return _paved(x, y, rng, (1, 3, 5), [box(0, 0, 2, 2), box(2, 0, 1, 1)], _square(rng, 14, 36))


def windmill(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    blocks = [box(0, 0, 2, 1), box(2, 0, 1, 2), box(1, 2, 2, 1), box(0, 1, 1, 2), box(1, 1, 1, 1)]
    return _paved(x, y, rng, (3, 0, 3), blocks, _square(rng, 14, 30))


def ladder(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Strips across, between strips along."""
    number = int(rng.integers(3, 6))
    blocks = [box(0, k, number, 1) for k in range(number)] + [box(number, 0, 1, number)]
    return _paved(x, y, rng, (number + 1, 0, number), blocks, _square(rng, 10, 20))


def versailles(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Slabs of four sizes in a large period."""
    side = int(rng.integers(5, 8))
    taken, blocks = np.zeros((side, side), bool), []
    for j, i in np.ndindex(side, side):
        for w, h in rng.permutation([[3, 2], [2, 3], [2, 2], [2, 1], [1, 2], [1, 1]])[:4].tolist():
            cells = box(i, j, w, h)
            at = [(a % side, b % side) for a, b in cells]
            if not any(taken[p] for p in at):
                for p in at:
                    taken[p] = True
                blocks.append(cells)
                break
        else:
            if not taken[i, j]:
                taken[i, j] = True
                blocks.append(box(i, j, 1, 1))
    return _paved(x, y, rng, (side, 0, side), blocks, _square(rng, 14, 34))


def flemish(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """A stretcher and a header in turn."""
    high = rng.uniform(14, 32)
    unit = high * rng.uniform(0.65, 0.85), high
    return _paved(x, y, rng, (3, 1, 2), [box(0, 0, 4, 1), box(4, 0, 2, 1)], unit)


def english(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """A course of stretchers and one of headers in turn."""
    high = rng.uniform(14, 32)
    blocks = [box(0, 0, 4, 1), box(1, 1, 2, 1), box(3, 1, 2, 1)]
    period = (4, 0, 2) if rng.random() < 0.5 else (2, 2, 4)
    return _paved(x, y, rng, period, blocks, (high * rng.uniform(0.65, 0.85), high))


def stacked(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    high = rng.uniform(14, 36)
    return _paved(x, y, rng, (1, 0, 1), [box(0, 0, 1, 1)], (high * rng.uniform(2, 3.5), high))


def cobbled_rows(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Rounded stones in rows of even height, about as wide as high."""
    high, spread = rng.uniform(28, 64), rng.uniform(0.15, 0.4)
    row = np.floor(y / high).astype(np.int64)
    ends = np.cumsum(high * rng.uniform(1 - spread, 1 + spread, (64, MANY)), axis=1) - 9 * high
    k, along, wide = np.zeros(x.shape, np.int64), np.zeros(x.shape), np.ones(x.shape)
    for r in np.unique(row):
        own, line = row == r, ends[r % 64]
        k[own] = np.clip(np.searchsorted(line, x[own]), 1, MANY - 1)
        wide[own] = line[k[own]] - line[k[own] - 1]
        along[own] = x[own] - line[k[own] - 1]
    power, gap = rng.uniform(3, 7), rng.uniform(0.03, 0.1)
    moved = 0.04 * rng.standard_normal((2, MANY, MANY))[:, k % MANY, row % MANY]
    far = abs(2 * along / wide - 1 + moved[0]) ** power
    far = (far + abs(2 * (y / high % 1) - 1 + moved[1]) ** power) ** (1 / power)
    levels = tones(rng, k, row, spread=rng.uniform(0.15, 0.6)) - (0.8 * far**4)[..., None]
    levels[far > 1 - gap] = -2
    return levels, ((0, high),)


def ashlar(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Rectangles of several heights and widths, without a period."""
    side, unit = 160, _square(rng, 10, 26)
    block, taken = np.zeros((3, side, side), np.int64), np.zeros((side, side), bool)
    sizes = np.array([[2, 1], [3, 1], [2, 2], [3, 2], [4, 2], [1, 1], [4, 1], [3, 3], [5, 2]])
    for j, i in np.ndindex(side, side):
        for w, h in rng.permutation(sizes).tolist() if not taken[i, j] else ():
            if i + w <= side and j + h <= side and not taken[i : i + w, j : j + h].any():
                taken[i : i + w, j : j + h] = True
                block[1, i : i + w, j : j + h], block[2, i : i + w, j : j + h] = i, j
                break
    lines = np.arange(side + 1) + rng.uniform(-0.12, 0.12, (2, side + 1))
    start = [float(c.min()) for c in (x, y)]
    x, y = (
        np.interp((c - low) / unit[0] + 2, line, np.arange(side + 1.0))
        for c, low, line in zip((x, y), start, lines, strict=True)
    )

    def piece(i: Whole, j: Whole) -> Whole:
        found: Whole = block[:, np.clip(i, 0, side - 1), np.clip(j, 0, side - 1)]
        return found

    levels, off = _filled(x, y, piece, unit, rng)
    levels[off < rng.uniform(0.8, 0.1 * unit[0]) * _ragged(x, y, rng)] = rng.choice([-2, 2])
    return levels, ()


def planks(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Boards of two or three widths in random order, or of any width."""
    some = rng.uniform(18, 60, int(rng.integers(2, 4)))
    wide = rng.choice(some, MANY) if rng.random() < 0.5 else rng.uniform(18, 70, MANY)
    ends = np.cumsum(wide) + float(y.min()) - 100
    row = np.searchsorted(ends, y)
    above = np.minimum(ends[row] - y, y - ends[row - 1])
    long = rng.uniform(150, 500)
    place = (x + 997 * (row * 17 % 31)) / long
    k, at = np.divmod(place, 1)
    levels = tones(rng, k.astype(np.int64), row, spread=rng.uniform(0.1, 0.6))
    levels[np.minimum(above, at * long) < rng.uniform(0.8, 2.5)] -= rng.uniform(1, 3)
    return levels, ()


def slates(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Slates of even width in half bond, with a shadow below each and uneven lower ends."""
    high = rng.uniform(24, 60)
    wide = high * rng.uniform(0.7, 1.3)
    row = np.floor(y / high).astype(np.int64)
    k = np.floor(x / wide - row / 2).astype(np.int64)
    off = rng.normal(0, rng.uniform(0.01, 0.04) * high, (2, MANY, MANY))
    low = y % high + off[0, k % MANY, row % MANY]
    side = (x / wide - row / 2) % 1 * wide + 0.5 * off[1, k % MANY, row % MANY]
    levels = tones(rng, k, row, spread=rng.uniform(0.15, 0.6))
    levels += rng.uniform(0.2, 1) * (low / high - 0.5)[..., None]
    dark = (abs(low - 1) < rng.uniform(1.5, 4)) | (abs(side - 1) < rng.uniform(0.8, 1.6))
    levels[dark] -= rng.uniform(1, 2.5)
    return levels, ((wide, 0), (wide / 2, high))


BLOCKS = (
    stepped, interlocking, zigzag_herringbone, corners, zigzags, pinwheel, windmill, ladder,
    versailles, flemish, english, stacked, cobbled_rows, ashlar, planks, slates,
)  # fmt: skip
