"""Planting seed points: stochastic tiling with unit tiles (section 3, Fig. 5)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weft.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weft.search.windows import Windows


def plant_seeds(
    windows: Windows, shape: tuple[int, int], spacing: int, matches: int, seed: int
) -> NDArray[np.int32]:
    """Sample a grid of seed points for an output.

    The sample is divided into unit tiles, squares between grid points. Slots of the output are
    tiled in scan order: each takes, among the tiles whose corners best match the colours of the
    corners that are there, one at random, and from it the corners that are not. (Corners mean
    the points of Fig. 5, so the first row of slots gives two rows of points.)

    Parameters
    ----------
    windows : Windows
        The sample.
    shape : (int, int)
        Of the output.
    spacing : int
        Distance of the grid points in pixels: the dominant scale.
    matches : int
        k: one of so many best tiles is taken.
    seed : int
        For `weft.random.draw`.

    Returns
    -------
    int32 array (rows, columns)
        Flat indices into `windows.pixels`, of the seed points at multiples of `spacing`. Where
        the sample has no whole tile, seed points are drawn from all its places.
    """
    rows, columns = (-(-length // spacing) for length in shape)
    bits = draw(seed, "seed point", *np.indices((rows + 1, columns + 1)))
    corners = _unit_tiles(windows, spacing)
    centres = windows.centres
    if not len(corners):
        return centres[bits[:rows, :columns] % np.uint64(len(centres))]
    colours = windows.pixels.reshape(-1, windows.pixels.shape[2])[corners].astype(np.int64)
    points = np.full((rows + 1, columns + 1), -1, np.int32)
    flat = windows.pixels.reshape(-1, windows.pixels.shape[2])
    for i in range(rows):
        for j in range(columns):
            slot = points[i : i + 2, j : j + 2].ravel()
            there = slot >= 0
            wanted = flat[slot].astype(np.int64)
            distance = ((colours - wanted) ** 2).sum(axis=2) @ there
            best = np.argsort(distance, kind="stable")[: matches if there.any() else None]
            tile = corners[best[int(bits[i, j] % np.uint64(len(best)))]]
            points[i : i + 2, j : j + 2] = np.where(there, slot, tile).reshape(2, 2)
    return np.ascontiguousarray(points[:rows, :columns])


def _unit_tiles(windows: Windows, spacing: int) -> NDArray[np.int32]:
    """Corners (n, 4) of the sample's unit tiles: upper left, upper right, lower left, lower right."""
    width = windows.pixels.shape[1]
    y, x = np.divmod(windows.centres, width)
    top, left = int(y.min()), int(x.min())
    on_grid = ((y - top) % spacing == 0) & ((x - left) % spacing == 0)
    corner = windows.centres[on_grid]
    steps = np.array([0, spacing, spacing * width, spacing * width + spacing], np.int32)
    usable = np.pad(windows.usable, (0, spacing))
    v, u = np.divmod(corner, width)
    whole = usable[v + spacing, u] & usable[v, u + spacing] & usable[v + spacing, u + spacing]
    return corner[whole > 0][:, None] + steps
