"""The best self-similar tile of a sample (section 4.1.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar

_BORDER = 10  # px (section 4.1.1)


def runs_of(
    first: NDArray[np.float64], second: NDArray[np.float64], reach: int
) -> NDArray[np.int64]:
    """Runs of pixels within `reach` of a parallelogram or, with a zero side, of a segment.

    Rows of (n, 3): row, first column and the column after the last, counted from its corner.
    """
    corners = np.stack([0 * first, first, first + second, second])
    low = np.ceil(corners[:, 0].min()).astype(int) - reach
    high = max(np.ceil(corners[:, 0].max()).astype(int) + reach, low + 1)
    runs = []
    for row in range(low, high):
        # The parallelogram's part within reach of this row lies between its sides there.
        near = np.clip([row - reach, row + reach], corners[:, 0].min(), corners[:, 0].max())
        crossed = []
        for k in range(4):
            (y, x), (v, u) = corners[k], corners[(k + 1) % 4]
            crossed += [x] if near[0] <= y <= near[1] else []
            for at in near:
                if min(y, v) <= at <= max(y, v) and y != v:
                    crossed.append(x + (at - y) / (v - y) * (u - x))
        # The nudge decides where a side leads through pixels, whatever was rounded.
        first_column, end = np.ceil(np.array([min(crossed), max(crossed)]) - 2.0**-20).astype(int)
        left = int(first_column) - reach
        runs.append((row, left, max(int(end) + reach, left + 1)))
    return np.array(runs, np.int64).reshape(-1, 3)


def integrated(
    values: NDArray[np.int64], runs: NDArray[np.int64], outside: int
) -> NDArray[np.int64]:
    """Sum over the runs at every place; `outside` is the value of pixels that are not there."""
    height, width = values.shape
    low = min(0, int(runs[:, 0].min())), min(0, int(runs[:, 1].min()))
    high = max(0, int(runs[:, 0].max())), max(0, int(runs[:, 2].max()))
    pads = ((-low[0], high[0]), (-low[1], high[1]))
    wide = np.pad(values, pads, constant_values=outside)
    sums = np.zeros((wide.shape[0], wide.shape[1] + 1), np.int64)
    np.cumsum(wide, axis=1, out=sums[:, 1:])
    total = np.zeros((height, width), np.int64)
    for row, left, right in runs.tolist():
        lines = sums[row - low[0] : row - low[0] + height]
        total += lines[:, right - low[1] : right - low[1] + width]
        total -= lines[:, left - low[1] : left - low[1] + width]
    return total


def tile_rows(vectors: tuple[float, ...], border: int) -> NDArray[np.int64]:
    """The rows of a tile with half its borders, see `runs_of`."""
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


def least_corner(errors: NDArray[np.int64]) -> tuple[int, int]:
    """First corner of the tile of least error, the first of several."""
    usable = np.where(errors < 0, np.iinfo(np.int64).max, errors)
    y, x = divmod(int(usable.argmin()), errors.shape[1])
    return y, x


def border_for(given: int | None, vectors: tuple[float, ...], exemplar: Exemplar) -> int:
    """The width of borders: the given one, or at most 10 if the sample is large enough.

    Raises `InvalidInputError` if the sample has no room for the given one.
    """

    def fits(width: int) -> bool:
        return width == 0 or tile_fits(exemplar.shape, tile_rows(vectors, width))

    border = _BORDER if given is None else given
    if exemplar.mask is not None or fits(border):
        return border
    if given is not None:
        better = next(width for width in range(min(given, *exemplar.shape), -1, -1) if fits(width))
        raise InvalidInputError(
            f"border_width is {given}; for {exemplar.name} it must be at most {better}"
        )
    while not fits(border):
        border //= 2
    return border
