"""Sums over boxes of pixels, all places at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def box_sums(values: NDArray[Any], height: int, width: int) -> NDArray[np.int64]:
    """Sums over the boxes of a size that lie in `values`, by their upper left corner.

    Parameters
    ----------
    values : bool or int array (H, W)
    height, width : int
        Of the box.

    Returns
    -------
    int64 array (H - height + 1, W - width + 1)

    Examples
    --------
    >>> box_sums(np.arange(6).reshape(2, 3), 2, 2).tolist()
    [[8, 12]]
    """
    total = np.zeros((values.shape[0] + 1, values.shape[1] + 1), np.int64)
    np.cumsum(values, axis=0, out=total[1:, 1:])
    np.cumsum(total[1:, 1:], axis=1, out=total[1:, 1:])
    result: NDArray[np.int64] = total[height:, width:] - total[:-height, width:]
    result -= total[height:, :-width]
    result += total[:-height, :-width]
    return result


def centered_sums(values: NDArray[Any], radius: int, axes: tuple[int, ...] = (0, 1)) -> Floats:
    """Sums over squares of 2 * radius + 1 pixels a side, of what of them is in the picture.

    Parameters
    ----------
    values : array (H, W)
    radius : int
        0 or more.
    axes : tuple of int
        Sum along these only.

    Returns
    -------
    float64 array (H, W)

    Examples
    --------
    >>> centered_sums(np.ones((3, 4)), 1)[1].tolist()
    [6.0, 9.0, 9.0, 6.0]
    """
    result = np.asarray(values, np.float64)
    for axis in axes:
        at = np.arange(result.shape[axis])
        result = sums_along(result, axis, at - radius, at + radius + 1)
    return result


def extended_sums(values: NDArray[Any], radius: int) -> NDArray[np.int64]:
    """Sums over squares of 2 * radius + 1 pixels a side; the border's pixels go on beyond it.

    Parameters
    ----------
    values : int array (H, W) or (H, W, K)
    radius : int
        0 or more.

    Returns
    -------
    int64 array of the shape of `values`

    Examples
    --------
    >>> extended_sums(np.arange(6).reshape(2, 3), 1)[0].tolist()
    [12, 18, 24]
    """
    result: NDArray[np.int64] = np.asarray(values, np.int64)
    for axis in (0, 1):
        pads = [(radius, radius) if a == axis else (0, 0) for a in range(result.ndim)]
        at = np.arange(result.shape[axis])
        result = sums_along(np.pad(result, pads, mode="edge"), axis, at, at + 2 * radius + 1)
    return result


def touching_sums(
    values: Floats, box: tuple[int, ...], reach: tuple[int, int] | None = None
) -> Floats:
    """Sums over every position of a box that touches the picture, of what of it lies inside.

    Parameters
    ----------
    values : float64 array (H, W)
    box : (int, int)
        Height and width, h and w.
    reach : (int, int), optional
        Its corner lies at most so many rows and columns from the picture's.

    Returns
    -------
    float64 array (H + h - 1, W + w - 1), or what of it is within reach

    Examples
    --------
    >>> touching_sums(np.ones((1, 2)), (1, 2)).tolist()
    [[1.0, 2.0, 1.0]]
    """
    for axis in (0, 1):
        at = np.arange(1 - box[axis], values.shape[axis])  # the first row or column in the box
        at = at if reach is None else at[abs(at) <= reach[axis]]
        values = sums_along(values, axis, at, at + box[axis])
    return values


def sums_along(
    values: NDArray[Any], axis: int, first: NDArray[Any], last: NDArray[Any]
) -> NDArray[Any]:
    """Sums of values[first:last] along an axis, as far as that lies inside.

    Parameters
    ----------
    values : array
        Of integers or floats.
    axis : int
    first, last : int arrays (n,)
        Each sum's first place and the one after its last.

    Returns
    -------
    array
        Of the shape and dtype of `values`, but n along the axis. The running sum of integers may
        wrap around; a sum that fits the dtype is right nevertheless.

    Examples
    --------
    >>> sums_along(np.array([200, 100, 50], np.uint8), 0, np.array([1]), np.array([9])).tolist()
    [150]
    """
    shape = list(values.shape)
    shape[axis] += 1
    running = np.zeros(shape, values.dtype)
    later = tuple(slice(int(a == axis), None) for a in range(values.ndim))
    np.cumsum(values, axis=axis, dtype=values.dtype, out=running[later])
    ends, starts = np.minimum(last, values.shape[axis]), np.maximum(first, 0)
    result: NDArray[Any] = _taken(running, ends, axis) - _taken(running, starts, axis)
    return result


def _taken(values: NDArray[Any], places: NDArray[Any], axis: int) -> NDArray[Any]:
    """`values.take`, whose columns are slow, for places that rise by one between equal ones."""
    if len(places) < 2 or axis == 0:
        return values.take(places, axis)
    low, high = int(places[0]), int(places[-1])
    start, end = int((places == low).sum()) - 1, len(places) - int((places == high).sum())
    if high <= low or end - start != high - low:
        return values.take(places, axis)
    rest = (slice(None),) * axis
    result = np.empty((*values.shape[:axis], len(places), *values.shape[axis + 1 :]), values.dtype)
    result[(*rest, slice(start))] = values[(*rest, slice(low, low + 1))]
    result[(*rest, slice(start, end + 1))] = values[(*rest, slice(low, high + 1))]
    result[(*rest, slice(end + 1, None))] = values[(*rest, slice(high, high + 1))]
    return result


def cell_sums(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Sum over square cells side by side; the last ones of each axis may be smaller.

    Parameters
    ----------
    values : array (H, W)
        True counts 1.
    side : int
        Of a cell, in pixels.

    Returns
    -------
    array (ceil(H / side), ceil(W / side))
        int64, or float64 of floats.

    Examples
    --------
    >>> cell_sums(np.ones((3, 5), bool), 2).tolist()
    [[4, 4, 2], [2, 2, 1]]
    """
    kind = np.float64 if values.dtype.kind == "f" else np.int64
    for axis in (0, 1):
        starts = np.arange(0, values.shape[axis], side)
        values = np.add.reduceat(values, starts, axis=axis, dtype=kind)
    return values
