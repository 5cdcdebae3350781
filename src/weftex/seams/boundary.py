"""Boundaries between two pictures, as minimum cuts: of two materials, and of a hole's filling."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.raster.arrays import Bytes, Ints, Mask
from weftex.seams import LARGEST_CAPACITY, minimum_cut

#: What a small step costs, which one in four is below; the unit of `leaning`.
UNIT = 256
#: So much leaning decides a pixel.
HELD = LARGEST_CAPACITY
_SMALLEST = 16  # of the mean, so many make the least that a small step is taken for
_DEAREST = 256 * UNIT  # of a step; four of them and a leaning must not overflow


def cheapest_boundary(
    first: Bytes,
    second: Bytes,
    leaning: NDArray[np.int32],
    free: Mask | None = None,
    wrap: tuple[bool, bool] = (False, False),
) -> Mask:
    """Mask (H, W), True where `second` is taken instead of `first`, by a minimum cut.

    A step costs its square, down to half of it on an edge. `leaning` is each pixel's bias to
    `second` in 1 / UNIT of a small step, +-`HELD` decides it; pixels outside `free` take no part.
    """
    if free is None:
        free = np.ones(leaning.shape, bool)
    if not any(wrap):
        return _cut(first, second, leaning, free)
    # Cut where the picture's border is its middle, hold what lies at the border, and cut again.
    middle = [n // 2 * wraps for n, wraps in zip(leaning.shape, wrap, strict=True)]

    def moved(each: NDArray[Any]) -> NDArray[Any]:
        return np.roll(each, middle, (0, 1))

    def repeated(each: NDArray[Any]) -> NDArray[Any]:
        around = [(0, int(wraps)) for wraps in wrap]
        return np.pad(each, around + [(0, 0)] * (each.ndim - 2), mode="wrap")

    side = np.roll(
        _cut(moved(first), moved(second), moved(leaning), moved(free)), [-m for m in middle], (0, 1)
    )
    at_border = np.zeros(leaning.shape, bool)
    at_border[0] = wrap[0]
    at_border[:, 0] |= wrap[1]
    held = np.where(at_border, np.where(side, HELD, -HELD), leaning).astype(np.int32)
    again = _cut(repeated(first), repeated(second), repeated(held), repeated(free))
    return again[: side.shape[0], : side.shape[1]]


def _cut(first: Bytes, second: Bytes, leaning: NDArray[np.int32], free: Mask) -> Mask:
    arcs = _costs(first.astype(np.int32), second.astype(np.int32), free)
    return minimum_cut(arcs, np.maximum(leaning, 0), np.maximum(-leaning, 0))[0]


def _costs(first: NDArray[np.int32], second: NDArray[np.int32], free: Mask) -> NDArray[np.int32]:
    """Costs of the arcs to the right, lower, left and upper neighbor; integers, so exact."""
    height, width = free.shape
    steps, edges = np.zeros((2, height, width, 4), np.int64)
    both = np.zeros((height, width, 4), bool)
    for axis, ahead in ((1, 0), (0, 1)):
        here, there = (
            tuple(s if axis == a else slice(None) for a in (0, 1))
            for s in (slice(None, -1), slice(1, None))
        )
        steps[(*here, ahead)] = _step(second[here], first[there])
        steps[(*there, ahead + 2)] = _step(first[here], second[there])
        edge = _step(first[here], first[there]) + _step(second[here], second[there])
        taking_part = free[here] & free[there]
        for place, direction in ((here, ahead), (there, ahead + 2)):
            edges[(*place, direction)] = edge
            both[(*place, direction)] = taking_part
    count = max(1, int(both.sum()))
    strong = 2 * (int(edges[both].sum()) // count) + 1
    # The full step without an edge, half of it at a strong one, in 1/256.
    seen = steps * (2 * strong - np.minimum(edges, strong)) * 128 // strong
    squares = (seen // 16) ** 2
    there = squares[both]
    mean = int(there.sum()) // count + 1
    small = int(np.partition(there, len(there) // 4)[len(there) // 4]) if len(there) else 0
    costs = np.minimum(squares * UNIT // max(1, small, mean // _SMALLEST), _DEAREST) + 1
    return np.where(both, costs, 0).astype(np.int32)


def _step(a: NDArray[np.int32], b: NDArray[np.int32]) -> Ints:
    result: Ints = np.abs(a - b).sum(axis=2, dtype=np.int64)
    return result


def cut_around(old: Bytes, new: Bytes, wide: Mask, hole: Mask) -> Mask:
    """Mask (H, W) of the pixels to take from `new`: within `wide`, covering `hole`.

    Its border is a minimum cut; a seam costs the differences of the two pixels (H, W, K) beside it.
    """
    difference = np.abs(old.astype(np.int32) - new).sum(axis=2, dtype=np.int32)
    difference[~wide] = 0
    arcs = np.zeros((*hole.shape, 4), np.int32)
    arcs[:, :-1, 0] = arcs[:, 1:, 2] = _seam_costs(difference, wide)
    arcs[:-1, :, 1] = arcs[1:, :, 3] = _seam_costs(difference.T, wide.T).T
    must, never = (np.where(mask, LARGEST_CAPACITY, 0).astype(np.int32) for mask in (hole, ~wide))
    return minimum_cut(arcs, must, never)[0]


def _seam_costs(difference: NDArray[np.int32], wide: Mask) -> NDArray[np.int32]:
    """Costs of seams between the pixels of each row: (H, W - 1)."""
    costs: NDArray[np.int32] = difference[:, :-1] + difference[:, 1:]
    # At the outer border only one of the two pixels has a filling to differ, so it counts twice.
    costs[wide[:, :-1] ^ wide[:, 1:]] *= 2
    return costs
