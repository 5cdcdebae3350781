"""Repeating a tile over a canvas (eq. 4.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.progress import Progress

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.canvas_lattice import CanvasLattice
    from weftex.canvas import Canvas
    from weftex.exemplar import Exemplar
    from weftex.progress import ProgressCallback

_BAND = 16  # rows that are made at a time


def repeated(
    exemplar: Exemplar,
    anchor: tuple[int, int],
    rows: NDArray[np.int64],
    lattice: CanvasLattice,
    canvas: Canvas,
    origin: tuple[int, int],
    callback: ProgressCallback | None,
    period: tuple[int, int] | None = None,
) -> NDArray[np.int32]:
    """Paste copies of a tile beside each other; return flat indices (H, W) into the sample.

    Parameters
    ----------
    anchor : (int, int)
        First corner of the tile in the sample.
    rows : int64 array (m, 3)
        Of a tile, see `tiles.runs_of`.
    lattice : CanvasLattice
        The vectors, stretched to wrap around the canvas or the plane's `period`.
    origin : (int, int)
        Where the canvas's corner lies in the plane of the lattice.
    """
    index = np.full(canvas.shape, -1, np.int32)
    pixels = exemplar.pixels.reshape(-1, *exemplar.pixels.shape[2:])

    def preview() -> NDArray[Any]:
        made: NDArray[Any] = pixels[index]
        made[index < 0] = 0
        return made

    # Coordinates up to 2**40 are exact to 2**-13 pixel in a float. On a canvas that wraps they
    # count from its corner.
    lines = [np.arange(n) + at for n, at in zip(canvas.shape, origin, strict=True)]
    if period is not None:
        lines = [line % n for line, n in zip(lines, period, strict=True)]
    down, across = (line - at for line, at in zip(lines, anchor, strict=True))
    progress = Progress(callback, canvas.height, "rows", preview)
    for top in range(0, canvas.height, _BAND):
        y, x = down[top : top + _BAND, None], across[None, :]
        number = [np.floor(along + 2.0**-20) for along in lattice.multiples(y, x)]
        away = [number[0] * lattice.canvas[0, k] + number[1] * lattice.canvas[1, k] for k in (0, 1)]
        v, u = y - np.rint(away[0]), x - np.rint(away[1])
        # Vectors with fractions, or a stretched lattice, lead a little past the tile: there the
        # tile's border is repeated.
        row = np.clip(v - rows[0, 0], 0, len(rows) - 1).astype(np.int64)
        u = np.clip(u, rows[row, 1], rows[row, 2] - 1).astype(np.int64)
        y, x = rows[row, 0] + anchor[0], u + anchor[1]
        index[top : top + _BAND] = y * exemplar.shape[1] + x
        progress.advance(len(number[0]))
    return index
