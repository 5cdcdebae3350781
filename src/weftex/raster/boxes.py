"""Sums over boxes of pixels, all places at once."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from weftex.raster.arrays import Floats, Mask

Kind = TypeVar("Kind", bound=np.generic)
AROUND = 32  #: pixels around a hole that are matched with it, or half as many as it is wide
Hole = list[tuple[int, int]]  #: Its rows and columns: the first, and one after the last.


def box_sums(values: NDArray[Any], height: int, width: int) -> NDArray[np.int64]:
    """Sums (H - height + 1, W - width + 1) over all boxes inside `values`, by top left corner."""
    total = np.zeros((values.shape[0] + 1, values.shape[1] + 1), np.int64)
    np.cumsum(values, axis=0, out=total[1:, 1:])
    np.cumsum(total[1:, 1:], axis=1, out=total[1:, 1:])
    result: NDArray[np.int64] = total[height:, width:] - total[:-height, width:]
    result -= total[height:, :-width]
    result += total[:-height, :-width]
    return result


def whole_windows(mask: NDArray[np.bool_], reach: tuple[int, int, int, int]) -> NDArray[np.uint8]:
    """Return 1 where the window of a pixel lies on the mask: `reach` up, down, left and right."""
    up, down, left, right = reach
    height, width = mask.shape
    usable = np.zeros((height, width), np.uint8)
    inside = (max(height - up - down, 0), max(width - left - right, 0))
    if 0 not in inside:
        v, u = up + down + 1, left + right + 1
        whole = mask if v * u == 1 else mask.all() or box_sums(mask, v, u) == v * u
        usable[up : up + inside[0], left : left + inside[1]] = whole
    return usable


def centered_sums(values: NDArray[Any], radius: int, axes: tuple[int, ...] = (0, 1)) -> Floats:
    """Sums (H, W) over (2 * radius + 1)^2 squares, clipped to the picture, or along some axes."""
    result = np.asarray(values, np.float64)
    for axis in axes:
        at = np.arange(result.shape[axis])
        result = sums_along(result, axis, at - radius, at + radius + 1)
    return result


def extended_sums(values: NDArray[Any], radius: int) -> NDArray[np.int64]:
    """Sums over (2 * radius + 1)^2 squares of `values` (H, W[, K]); border pixels are repeated."""
    result: NDArray[np.int64] = np.asarray(values, np.int64)
    for axis in (0, 1):
        pads = [(radius, radius) if a == axis else (0, 0) for a in range(result.ndim)]
        at = np.arange(result.shape[axis])
        result = sums_along(np.pad(result, pads, mode="edge"), axis, at, at + 2 * radius + 1)
    return result


def sums_along(
    values: NDArray[Any], axis: int, first: NDArray[Any], last: NDArray[Any]
) -> NDArray[Any]:
    """Sums of values[first:last] along an axis, in the dtype of `values`, clipped to the array.

    The running sum of integers may overflow; sums that fit the dtype are right nevertheless.
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


def cells_as_pixels(cells: NDArray[Kind], side: int, shape: tuple[int, int]) -> NDArray[Kind]:
    """Return values (H, W) of square cells for each pixel; the last ones reach to the border."""
    rows, columns = (
        np.minimum(np.arange(long) // side, few - 1)
        for long, few in zip(shape, cells.shape, strict=True)
    )
    return cells[np.ix_(rows, columns)]


def cell_sums(values: NDArray[Any], side: int) -> NDArray[Any]:
    """Sums (ceil(H / side), ceil(W / side)) over adjacent square cells; the last may be smaller."""
    kind = np.float64 if values.dtype.kind == "f" else np.int64
    for axis in (0, 1):
        starts = np.arange(0, values.shape[axis], side)
        values = np.add.reduceat(values, starts, axis=axis, dtype=kind)
    return values


def smaller_masks(places: NDArray[np.bool_], count: int) -> list[NDArray[np.uint8]]:
    """Levels of a mask, each half as large: 1 where one of four pixels is; whole squares only."""
    copies = [places.view(np.uint8)]
    while len(copies) < count:
        rows, columns = (n // 2 * 2 for n in copies[-1].shape)
        either = copies[-1][:rows:2, :columns] | copies[-1][1:rows:2, :columns]
        copies.append(either[:, ::2] | either[:, 1::2])
    return copies


def holes_in(mask: Mask, wrap: tuple[bool, bool], apart: int = AROUND) -> list[Hole]:
    """Return boxes around all that is marked, more than `apart` pixels from each other.

    Along an axis that wraps around a box has the entire side.
    """
    left, holes, before, first = mask.copy(), [], Hole(), 0
    flat = left.ravel()
    while flat[first := first + int(flat[first:].argmax())]:  # no pixel is searched twice
        y, x = divmod(first, left.shape[1])
        runs = (y, left[y:, x]), (x, left[y, x:])  # which begin with marked pixels
        hole = [(at, at + (int(line.argmin()) or len(line))) for at, line in runs]
        while hole != before:
            before = hole
            near = tuple(slice(max(a - apart, 0), b + apart) for a, b in hole)
            lines = [np.flatnonzero(left[near].any(axis=axis)) for axis in (1, 0)]
            hole = [
                (0, n) if wraps else (int(line[0]) + part.start, int(line[-1]) + part.start + 1)
                for line, part, n, wraps in zip(lines, near, left.shape, wrap, strict=True)
            ]
        left[near] = False
        holes.append(hole)
    return holes


def nearest_hole(holes: NDArray[np.int_], pixel: tuple[int, int]) -> Hole:
    """Return the box, of boxes (n, 2, 2), that a pixel is in, or the nearest one."""
    outside = np.maximum(holes[..., 0] - pixel, pixel - holes[..., 1] + 1).clip(0)
    nearest: Hole = holes[outside.sum(axis=1).argmin()].tolist()
    return nearest
