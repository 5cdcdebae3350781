"""Repeating tiles over a canvas (eq. 4.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.progress import Progress
from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.canvas_lattice import CanvasLattice
    from weftex.canvas import Canvas
    from weftex.exemplar import Exemplar
    from weftex.progress import ProgressCallback

_BAND = 16  # rows that are made at a time


def repeated(
    exemplar: Exemplar,
    anchors: NDArray[np.int64],
    rows: NDArray[np.int64],
    lattice: CanvasLattice,
    canvas: Canvas,
    origin: tuple[int, int],
    seed: int,
    callback: ProgressCallback | None,
    period: tuple[int, int] | None = None,
) -> NDArray[np.int32]:
    """Paste copies of tiles beside each other; return flat indices (H, W) into the sample.

    Parameters
    ----------
    anchors : int64 array (n, 2)
        First corners of the tiles in the sample; each copy is of one of them, drawn at random.
    rows : int64 array (m, 3)
        Of a tile, see `parallelogram.runs_of`.
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
    wrap = canvas.wrap
    if period is not None:
        lines, wrap = [line % n for line, n in zip(lines, period, strict=True)], (True, True)
    down, across = (line - at for line, at in zip(lines, anchors[0], strict=True))
    progress = Progress(callback, canvas.height, "rows", preview)
    size = period or canvas.shape
    repeats = [np.rint(n @ lattice.inverse).astype(np.int64) for n in np.diag(size)]
    for top in range(0, canvas.height, _BAND):
        y, x = down[top : top + _BAND, None], across[None, :]
        number = [np.floor(along + 2.0**-20) for along in lattice.multiples(y, x)]
        away = [number[0] * lattice.canvas[0, k] + number[1] * lattice.canvas[1, k] for k in (0, 1)]
        v, u = y - np.rint(away[0]), x - np.rint(away[1])
        place = anchors[0]
        if len(anchors) > 1:
            which = draw(seed, "tile", *_first(number, repeats, wrap))
            place = anchors[(which % np.uint64(len(anchors))).astype(np.int64)]
        # Vectors with fractions, or a stretched lattice, lead a little past the tile: there the
        # tile's border is repeated.
        row = np.clip(v - rows[0, 0], 0, len(rows) - 1).astype(np.int64)
        u = np.clip(u, rows[row, 1], rows[row, 2] - 1).astype(np.int64)
        y, x = rows[row, 0] + place[..., 0], u + place[..., 1]
        index[top : top + _BAND] = y * exemplar.shape[1] + x
        progress.advance(len(number[0]))
    return index


def _first(
    number: list[NDArray[np.float64]], repeats: list[NDArray[np.int64]], wrap: tuple[bool, bool]
) -> list[NDArray[np.int64]]:
    """Numbers of tiles, the same for copies of a tile that the canvas wraps around."""
    found = np.stack(number, axis=-1).astype(np.int64)
    around = np.array([r for r, wraps in zip(repeats, wrap, strict=True) if wraps], np.int64)
    if len(around):
        # Reduced by the lattice of repeats.
        if len(around) == 1:
            axis = int(np.abs(around[0]).argmax())
            times = np.floor_divide(found[..., axis], around[0, axis])
            found = found - times[..., None] * around[0]
        else:
            (a, b), (c, d) = around.tolist()
            det = a * d - b * c
            i, j = found[..., 0], found[..., 1]
            times = np.floor_divide(i * d - j * c, det), np.floor_divide(j * a - i * b, det)
            found = found - times[0][..., None] * around[0] - times[1][..., None] * around[1]
    return [found[..., 0], found[..., 1]]
