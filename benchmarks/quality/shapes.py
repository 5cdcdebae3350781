"""What drawn surfaces are made of: noise, pieces with uneven joints, tones, moved points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
Vectors = tuple[tuple[float, float], ...]
Drawn = tuple[Floats, Vectors]  # levels of a spread of about 1, and the truth

MANY = 512  # cells a side whose jitters and tones are drawn; more wrap around


def smooth(values: Floats, radius: float | tuple[float, float]) -> Floats:
    """A Gaussian of this radius down and along, around the borders; spread 1."""
    down, along = radius if isinstance(radius, tuple) else (radius, radius)
    v, u = np.fft.fftfreq(values.shape[0])[:, None], np.fft.rfftfreq(values.shape[1])
    kernel = np.exp(-2 * np.pi**2 * ((down * v) ** 2 + (along * u) ** 2))
    made = np.fft.irfft2(np.fft.rfft2(values, axes=(0, 1)) * kernel, values.shape[:2], axes=(0, 1))
    spread: Floats = made / max(float(made.std()), 1e-12)
    return spread


def grain(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    """Noise whose power falls with frequency, as that of stone and plaster does; spread 1."""
    v, u = np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1])
    fall = np.maximum(np.hypot(v, u), 1 / 64) ** -rng.uniform(0.5, 1.5)
    made = np.fft.irfft2(np.fft.rfft2(rng.standard_normal(shape)) * fall, shape)
    spread: Floats = made / made.std()
    return spread


def cells(
    x: Floats, y: Floats, wide: float, high: float, shift: float, uneven: float,
    rng: np.random.Generator,
) -> tuple[Whole, Whole, Floats]:  # fmt: skip
    """Column and row of the piece at each place, and how far off its nearest joint is.

    Each course is moved on by a share of a piece; joints are off by `uneven` of its height.
    """
    course, above = between(y, high, np.zeros(1, np.int64), uneven / 2 * high, rng)
    piece, aside = between(x - shift * wide * course, wide, course, uneven * high, rng)
    return piece, course, np.minimum(above, aside)


def between(
    place: Floats, period: float, line: Whole, off: float, rng: np.random.Generator
) -> tuple[Whole, Floats]:
    """The number of the piece of a line that a place is in, and the distance to its ends."""
    moved = np.clip(rng.normal(0, off, (MANY, MANY)), -0.3 * period, 0.3 * period)

    def end(k: Whole) -> Floats:
        found: Floats = k * period + moved[line % MANY, k % MANY]
        return found

    k = np.floor(place / period).astype(np.int64)
    k = k - (place < end(k)) + (place >= end(k + 1))
    return k, np.minimum(place - end(k), end(k + 1) - place)


def tones(rng: np.random.Generator, *which: Whole, spread: float) -> Floats:
    """A color for each cell, gray for the most part."""
    table = rng.standard_normal((MANY, MANY, 1)) + 0.4 * rng.standard_normal((MANY, MANY, 3))
    column, row = which if len(which) == 2 else (which[0], 0 * which[0])
    found: Floats = spread * table[column % MANY, row % MANY]
    return found


def nearest(
    x: Floats, y: Floats, vectors: Vectors, uneven: float, rng: np.random.Generator
) -> tuple[Whole, Whole, Floats, Floats]:
    """Number (a, b) of the nearest of the lattice's points, each moved; distances to it, the next.

    `uneven` of 0.5 moves points anywhere in their tile, which leaves no lattice.
    """
    a, b = np.tensordot(np.linalg.inv(np.array(vectors)).T, np.stack([x, y]), 1)
    moved = rng.uniform(-uneven, uneven, (MANY, MANY, 2))
    first = second = np.full(x.shape, np.inf)
    i, j = np.zeros(x.shape, np.int64), np.zeros(x.shape, np.int64)
    reach = 1 if uneven < 0.2 else 2
    base = np.floor(a).astype(np.int64), np.floor(b).astype(np.int64)
    for da in range(-reach, reach + 2):
        for db in range(-reach, reach + 2):
            p, q = base[0] + da, base[1] + db
            off = moved[p % MANY, q % MANY]
            place = np.stack([p + off[..., 0] - a, q + off[..., 1] - b], axis=-1)
            far = np.hypot(*np.moveaxis(place @ np.array(vectors), -1, 0))
            closer = far < first
            second = np.where(closer, first, np.minimum(second, far))
            first = np.where(closer, far, first)
            i, j = np.where(closer, p, i), np.where(closer, q, j)
    return i, j, first, second


def fibers(x: Floats, y: Floats, rng: np.random.Generator, row: Whole | int = 0) -> Floats:
    """Fine lines along x, each board with its own."""
    made = smooth(rng.standard_normal((1024, 1024)), (1, rng.uniform(20, 80)))
    i, j = (np.rint(2 * c).astype(np.int64) for c in (y, x))
    found: Floats = made[(i + 97 * row) % 1024, (j + 389 * row) % 1024][..., None] * np.ones(3)
    return found
