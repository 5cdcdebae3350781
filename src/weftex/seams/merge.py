"""Merging two samples into one: islands of one in the other (the paper on fusion, section 4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.random import draw
from weftex.raster.arrays import Bytes, Mask
from weftex.seams.boundary import HELD, cheapest_boundary

_TRIES = 64  # places of the other sample that are compared for an island
_CUT = 4  # the best of them, of which the one with the least boundary is taken
_SPACING = 4.5  # between islands, in scales
_CORE = 1.0  # mean radius of what is always inside, in scales
_RIM = 2.2  # and of what may be


def islands(sea: Bytes, land: Bytes, usable: Mask, scale: int, seed: int) -> NDArray[np.int32]:
    """Flat index (H, W) into `land` of islands placed in `sea`, -1 elsewhere.

    Each island has a random core and a free belt; of many random offsets the best match is taken.
    `scale` is the feature size in pixels, `usable` (H', W') what may be shown of `land`.
    """
    height, width = sea.shape[:2]
    shown = np.full((height, width), -1, np.int32)
    # Half of the smaller sample at most: the boundary needs sea on all sides.
    scale = max(1, min(scale, int(min(height, width, *usable.shape) / (4 * _RIM))))
    apart = round(_SPACING * scale)
    rows, columns = max(1, height // apart), max(1, width // apart)
    for i, j in np.ndindex(rows, columns):
        number = i * columns + j
        core, limit = _shape(scale, seed, number)
        size = core.shape
        corner = [
            min(k * n // of + _below(max(0, n // of - s) + 1, seed, number, axis), max(0, n - s))
            for axis, (k, n, of, s) in enumerate(
                zip((i, j), (height, width), (rows, columns), size, strict=True)
            )
        ]
        area = tuple(slice(c, c + s) for c, s in zip(corner, size, strict=True))
        around = sea[area]
        if around.shape[:2] != size:
            continue
        found = _fitting(around, land, usable, core, limit, (seed, number))
        if found is not None:
            inside, place = found
            y, x = np.indices(size)
            source = (y + place[0]) * land.shape[1] + x + place[1]
            shown[area] = np.where(inside, source, shown[area])
    return shown


def _shape(scale: int, seed: int, number: int) -> tuple[Mask, Mask]:
    """Return the core of an island, and how far it may reach: rings of corners of their own."""
    reach = int(np.ceil(_RIM * scale)) + 1
    y, x = np.indices((2 * reach + 1, 2 * reach + 1)) - reach
    corners = 7
    # From 0.55 to 1.45 of the mean radius, straight from corner to corner around the center.
    bits = draw(seed, "island corner", number, np.arange(corners)) >> np.uint64(54)
    stretch = 0.55 + 0.9 * bits.astype(np.float64) / 1024
    angle = (np.arctan2(y, x) / (2 * np.pi) % 1.0) * corners
    at = angle.astype(np.intp) % corners
    part = angle - np.floor(angle)
    radius = stretch[at] * (1 - part) + stretch[(at + 1) % corners] * part
    away = np.sqrt(y**2 + x**2)
    core = away <= _CORE * scale * radius
    core[reach, reach] = True
    limit = (away <= np.minimum(_RIM, 1.5 * _CORE * radius + 0.5) * scale) | core
    border = np.maximum(np.abs(y), np.abs(x)) == reach
    return core & ~border, limit & ~border


def _fitting(
    around: Bytes, land: Bytes, usable: Mask, core: Mask, limit: Mask, draws: tuple[int, int]
) -> tuple[Mask, tuple[int, int]] | None:
    """Return an island and the corner of what it shows of the land; None if nothing fits."""
    (seed, number), size = draws, core.shape
    room = [n - s + 1 for n, s in zip(usable.shape, size, strict=True)]
    if min(room) < 1:
        return None
    belt = limit & ~core
    tried = []
    for k in range(_TRIES):
        y, x = (_below(n, seed, number, 2 + 2 * k + axis) for axis, n in enumerate(room))
        area = slice(y, y + size[0]), slice(x, x + size[1])
        if usable[area].all():
            differ = np.abs(around[belt].astype(np.int64) - land[area][belt]).sum()
            tried.append((int(differ), k, (y, x)))
    best: tuple[int, Mask, tuple[int, int]] | None = None
    leaning = np.where(core, HELD, np.where(limit, 0, -HELD)).astype(np.int32)
    for _, _, (y, x) in sorted(tried)[:_CUT]:
        shown = land[y : y + size[0], x : x + size[1]]
        inside = cheapest_boundary(around, shown, leaning)
        seen = _mean_step(np.where(inside[..., None], shown, around), inside)
        if best is None or seen < best[0]:
            best = seen, inside, (y, x)
    return None if best is None else best[1:]


def _mean_step(picture: Bytes, inside: Mask) -> int:
    """The mean step across the boundary, in 1/256."""
    total, count = 0, 0
    for axis in (0, 1):
        crossed = np.diff(inside, axis=axis)
        steps = np.abs(np.diff(picture.astype(np.int64), axis=axis)).sum(axis=2)
        total, count = total + int(steps[crossed].sum()), count + int(crossed.sum())
    return 256 * total // max(1, count)


def _below(count: int, seed: int, *place: int) -> int:
    return int(draw(seed, "island", *place) % np.uint64(count))
