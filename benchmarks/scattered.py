"""Drawn surfaces that do not repeat: stones, noise, leaves, grain, scratches."""

from __future__ import annotations

import numpy as np
from shapes import MANY, Drawn, Floats, between, fibers, grain, nearest, smooth, tones


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


def disks(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Round stones that lie no nearer to each other than their size, as if packed."""
    size = rng.uniform(14, 60)
    low, side = np.array([x.min(), y.min()]), np.array([np.ptp(x), np.ptp(y)])
    places: list[Floats] = []
    known: dict[tuple[int, int], list[Floats]] = {}
    for place in rng.uniform(0, 1, (int(12 * side.prod() / size**2), 2)) * side:
        a, b = (int(c) for c in place // size)
        near = [p for i in (-1, 0, 1) for j in (-1, 0, 1) for p in known.get((a + i, b + j), [])]
        if all(np.hypot(*(place - other)) >= size for other in near):
            places.append(place)
            known.setdefault((a, b), []).append(place)
    levels = np.full((*x.shape, 3), rng.uniform(-2, 0))
    tall = rng.uniform(0.5, 1.5)
    center = low[:, None, None]
    for place in places:
        far = np.hypot(*(np.stack([x, y]) - center - place[:, None, None])) / (
            size * rng.uniform(0.45, 0.6)
        )
        own = far < 1
        shade = 0.5 * rng.standard_normal() + 0.2 * rng.standard_normal(3)
        levels[own] = shade + tall * (1 - far[own] ** 2)[:, None] ** 0.5
    return levels, ()


def scratches(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Straight lines of any length, most of them in about one direction: brushed or worn metal."""
    levels = 0.5 * smooth(rng.standard_normal(x.shape), rng.uniform(2, 20))
    main, spread = rng.uniform(0, np.pi), rng.choice([0.03, 0.3, 3])
    low, side = np.array([x.min(), y.min()]), np.array([np.ptp(x), np.ptp(y)])
    for _ in range(int(rng.uniform(40, 200))):
        (a, b), angle = low + rng.uniform(0, 1, 2) * side, main + spread * rng.standard_normal()
        along = np.cos(angle) * (x - a) + np.sin(angle) * (y - b)
        off = abs(np.cos(angle) * (y - b) - np.sin(angle) * (x - a))
        own = (off < rng.uniform(0.5, 1.5)) & (abs(along) < rng.uniform(20, 300))
        levels[own] += rng.choice([-1, 1]) * rng.uniform(0.5, 2)
    return levels[..., None] * np.ones(3), ()


def blobs(x: Floats, y: Floats, rng: np.random.Generator) -> Drawn:
    """Spots or a maze of about one width, at no fixed distance: coats, corrosion, foam."""
    v, u = np.fft.fftfreq(x.shape[0])[:, None], np.fft.rfftfreq(x.shape[1])
    period, breadth = rng.uniform(16, 120), rng.uniform(0.2, 0.6)  # in halves of a pixel
    ring = np.exp(-0.5 * (np.log(np.hypot(v, u) * period + 1e-9) / breadth) ** 2)
    made = np.fft.irfft2(np.fft.rfft2(rng.standard_normal(x.shape)) * ring, x.shape)
    made = made / made.std() - rng.uniform(-0.8, 0.8)
    return np.tanh(rng.uniform(0.5, 5) * made)[..., None] * rng.uniform(0.5, 1.5, 3), ()
