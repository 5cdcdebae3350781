"""The best self-similar tiles of a sample (section 4.1.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.methods.best_tile.parallelogram import integrated, runs_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar


def tile_rows(vectors: tuple[float, ...], border: int) -> NDArray[np.int64]:
    """The rows of a tile with half its borders, see `parallelogram.runs_of`."""
    x1, y1, x2, y2 = vectors
    return runs_of(np.array([y1, x1]), np.array([y2, x2]), border // 2)


def tile_fits(shape: tuple[int, int], rows: NDArray[np.int64]) -> bool:
    """Whether a tile of these rows and its corner fit into a picture.

    >>> rows = tile_rows((4, 0, 0, 3), 0)
    >>> tile_fits((3, 4), rows), tile_fits((2, 4), rows)
    (True, False)
    """
    lowest, ends = -rows[:, :2].min(axis=0), rows[:, [0, 2]].max(axis=0) + (1, 0)
    places = np.minimum(np.array(shape) - 1, shape - ends) - np.maximum(lowest, 0)
    return bool((places >= 0).all())


def tile_errors(exemplar: Exemplar, vectors: tuple[float, ...], border: int) -> NDArray[np.int64]:
    """Accumulated squared differences of opposite borders of every tile (eq. 4.2, Fig. 4.4, 4.5).

    int64 (H, W), by the tile's first corner; -1 where a tile with its borders is not on usable
    pixels. Borders of no width make all tiles equal.

    >>> from weftex.exemplar import Exemplar
    >>> stripes = np.tile(np.uint8([10, 90]), (8, 4))
    >>> errors = tile_errors(Exemplar(stripes), (2, 0, 0, 2), 1)
    >>> int(errors.max()), int((errors == 0).sum())
    (0, 49)
    """
    height, width = shape = exemplar.shape
    mask = np.ones(shape, bool) if exemplar.mask is None else exemplar.mask
    fits = integrated((~mask).astype(np.int64), tile_rows(vectors, border), outside=1) == 0
    total = np.zeros(shape, np.int64)
    if not fits.any():
        return total - 1
    x1, y1, x2, y2 = vectors
    sides = np.array([[y1, x1], [y2, x2]])
    pixels = exemplar.matching().astype(np.int64)
    for k in (0, 1) if border else ():
        step = np.rint(sides[k]).astype(int)
        other = runs_of(np.zeros(2), sides[1 - k], (border + 1) // 2)
        y, x = np.indices(shape) + step[:, None, None]
        inside = (y >= 0) & (y < height) & (x >= 0) & (x < width)
        there = pixels[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
        error = np.where(inside, ((pixels - there) ** 2).sum(axis=2), 0)
        total += integrated(error, other, outside=0)
    return np.where(fits, total, -1)


def best_tiles(
    errors: NDArray[np.int64], vectors: tuple[float, ...], wanted: int
) -> NDArray[np.int64]:
    """First corners (n, 2) of the tile of least error and of up to `wanted` - 1 of the next best.

    Those contain the same part of the lattice.
    """
    order = np.argsort(
        np.where(errors < 0, np.iinfo(np.int64).max, errors), axis=None, kind="stable"
    )
    order = order[: int((errors >= 0).sum())]
    y, x = np.divmod(order, errors.shape[1])
    first = y[0], x[0]
    if wanted == 1:
        return np.array([first], np.int64)
    # The others are a sum of multiples away from it, to a pixel, and do not overlap.
    lattice = CanvasLattice(vectors)
    near = np.rint(np.stack(lattice.multiples(y - first[0], x - first[1]), axis=1))
    away = np.stack([y - first[0], x - first[1]], axis=1) - near @ lattice.sample
    found: dict[tuple[float, ...], tuple[int, int]] = {}
    for k in np.flatnonzero((np.abs(away) <= 1).all(axis=1)):
        found.setdefault(tuple(near[k]), (int(y[k]), int(x[k])))
        if len(found) == wanted:
            break
    return np.array(list(found.values()), np.int64)
