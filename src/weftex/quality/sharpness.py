"""Sharpness: whether fine detail is as strong as in the sample, everywhere."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.quality.view import View

    Floats = NDArray[np.float64]

_CELL = 8  # pixels
_SOFTEST = 0.05  # of the sample
_ROUNDING = 1 / 12  # the variance of an error of up to half


def sharpness(sample: View, result: View) -> tuple[float | None, float | None]:
    """Compare the finest detail.

    *Definition.* Detail is the difference from a 3x3 blur. The first figure is the ratio of its
    root mean squares, the second the share of the result's cells of 8x8 pixels that have less of
    it than the softest 5 % of the sample's.

    *Unit.* Ratio, and share. *Good.* The first near 1: below it is blurred, above it has noise or
    hard edges. The second near 0.05 or below; more is blurred in places. *Blind to* what the
    detail is.

    Returns
    -------
    (float or None, float or None)
        None for pictures with a side below 3, and masks that leave no detail; the second also for
        a side below 16.
    """
    first, second = _detail(sample), _detail(result)
    if first is None or second is None:
        return None, None
    (own, usable), (made, all_of_it) = first, second
    strength = [float(own[usable].mean()), float(made[all_of_it].mean())]
    ratio = float(np.sqrt((strength[1] + _ROUNDING) / (strength[0] + _ROUNDING)))
    if min(*sample.shape, *result.shape) < 2 * _CELL:
        return ratio, None
    cells = [_cells(np.where(place, square, np.nan)) for square, place in (first, second)]
    known = cells[0][~np.isnan(cells[0])]
    if len(known) < 4:
        return ratio, None
    softest = np.quantile(known, _SOFTEST)
    # A cell that rounding alone makes flatter than the sample's softest is not softer.
    return ratio, float((cells[1] < softest - _ROUNDING / 4).mean())


def _detail(view: View) -> tuple[Floats, NDArray[np.bool_]] | None:
    """Squared detail, and where all pixels of the blur are usable; the outermost are left out."""
    if min(view.shape) < 3:
        return None
    smooth, usable = view.gray.astype(np.float64), view.usable
    for axis in (0, 1):
        before, middle, after = (
            tuple(
                slice(k, smooth.shape[axis] - 2 + k) if a == axis else slice(None) for a in (0, 1)
            )
            for k in range(3)
        )
        smooth = (smooth[before] + 2 * smooth[middle] + smooth[after]) / 4
        usable = usable[before] & usable[middle] & usable[after]
    if not usable.any():
        return None
    return (view.gray[1:-1, 1:-1] - smooth) ** 2, usable


def _cells(squares: Floats) -> Floats:
    """Means over cells; NaN where one holds a pixel that may not be used."""
    rows, columns = (side // _CELL for side in squares.shape)
    cut = squares[: rows * _CELL, : columns * _CELL].reshape(rows, _CELL, columns, _CELL)
    means: Floats = cut.mean(axis=(1, 3))
    return means
