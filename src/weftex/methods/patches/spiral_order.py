"""Where the patches of a hole go: in spirals from its border inwards (section 2.3)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.patches.scan_order import Frame, Order, Run, Step, patch_starts
from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.patches.analysis import Zones

_MOST_AROUND = 11  # earlier patches that a patch should not repeat


def spiral_patches(frame: Frame, zones: Zones, seed: int) -> Order:
    """Patches, or single pixels, that fill the canvas's hole."""
    unknown = np.zeros(frame.shape, bool)
    unknown[frame.inside] = frame.canvas.hole
    total = int(unknown.sum())
    outside = np.ones(frame.shape, bool)
    outside[frame.inside] = False
    frozen = ~unknown
    reach = frame.boundary_width
    if frame.method.pixelwise:
        found = [(y - reach, x - reach) for y, x in spiral(unknown)]
        corners = np.array(found, np.int32).reshape(-1, 2) % np.array(frame.shape, np.int32)
    else:
        corners = _useful(_corners(frame, unknown), frame, unknown)
    around = np.zeros((len(corners), 0), np.int32)
    if frame.method.repeat_distance > 0 and not frame.method.pixelwise:
        around = pasted_nearby(corners, 2 * np.array(frame.window))

    def steps() -> Iterator[Step]:
        for k, (y, x) in enumerate(corners.tolist()):
            at = _window_at(frame, y, x)
            missing = unknown[at]
            zone = zones.number(~missing & ~outside[at], frozen[at])
            done = missing
            if frame.method.pixelwise:
                done = np.zeros_like(missing)
                done[reach, reach] = True
            yield Step([[Run(zone, k, k + 1)]], int(done.sum()))
            unknown[at] = missing & ~done

    return Order(
        corners=corners,
        bits=draw(seed, "patch", np.arange(len(corners))),
        around=around,
        steps=steps(),
        total=total,
        stage="pixels",
    )


def pasted_nearby(corners: NDArray[np.int32], reach: NDArray[np.int64]) -> NDArray[np.int32]:
    """Return the latest earlier patches nearer than `reach` to each; -1 for none."""
    around = np.full((len(corners), _MOST_AROUND), -1, np.int32)
    for k in range(1, len(corners)):
        near = np.flatnonzero((np.abs(corners[:k] - corners[k]) < reach).all(axis=1))[
            -_MOST_AROUND:
        ]
        around[k, : len(near)] = near
    return around


def _window_at(frame: Frame, y: int, x: int) -> tuple[NDArray[np.intp], ...]:
    """Index of the window at a corner; it goes around the frame."""
    (height, width), (rows, columns) = frame.shape, frame.window
    return np.ix_((y + np.arange(rows)) % height, (x + np.arange(columns)) % width)


def _corners(frame: Frame, unknown: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Corners of windows that cover the holes, each group of holes spirally inwards."""
    if not unknown.any():
        return []
    overlap = frame.method.boundary_width
    assert overlap
    grids = []
    for axis in (0, 1):
        there = np.flatnonzero(unknown.any(axis=1 - axis))
        start, stop = int(there[0]) - overlap, int(there[-1]) + 1 + overlap
        length, window = unknown.shape[axis], frame.window[axis]
        if not frame.canvas.wrap[axis]:
            start, stop = max(start, 0), min(stop, length)
        slack = max(window - (stop - start), 0)
        start -= slack // 2
        if not frame.canvas.wrap[axis]:
            start = min(max(start, 0), max(length - window, 0))
        shared = min(overlap, window - 1)
        offsets = patch_starts(max(stop - start, window), window, shared, wrap=False)
        grids.append([(start + k) % length for k in offsets])
    cells = np.array([[unknown[_window_at(frame, y, x)].any() for x in grids[1]] for y in grids[0]])
    return [(grids[0][i], grids[1][j]) for i, j in spiral(cells)]


def _useful(
    corners: list[tuple[int, int]], frame: Frame, unknown: NDArray[np.bool_]
) -> NDArray[np.int32]:
    """Leave out windows that earlier ones cover whole."""
    left, useful = unknown.copy(), []
    for y, x in corners:
        at = _window_at(frame, y, x)
        if left[at].any():
            useful.append((y, x))
            left[at] = False
    return np.array(useful, np.int32).reshape(-1, 2)


def spiral(cells: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Yield (row, column) of each connected group of cells, from its border inward, clockwise."""
    for group in _groups(cells):
        rows, columns = np.nonzero(group)
        top, bottom, left, right = rows.min(), rows.max(), columns.min(), columns.max()
        while top <= bottom and left <= right:
            ring = [(top, x) for x in range(left, right + 1)]
            ring += [(y, right) for y in range(top + 1, bottom + 1)]
            if top < bottom:
                ring += [(bottom, x) for x in range(right - 1, left - 1, -1)]
            if left < right:
                ring += [(y, left) for y in range(bottom - 1, top, -1)]
            yield from ((int(y), int(x)) for y, x in ring if group[y, x])
            top, bottom, left, right = top + 1, bottom - 1, left + 1, right - 1


def _groups(cells: NDArray[np.bool_]) -> Iterator[NDArray[np.bool_]]:
    left = cells.copy()
    while left.any():
        group = np.zeros_like(left)
        stack = [tuple(int(k) for k in np.argwhere(left)[0])]
        while stack:
            y, x = stack.pop()
            if not (0 <= y < left.shape[0] and 0 <= x < left.shape[1] and left[y, x]):
                continue
            left[y, x], group[y, x] = False, True
            stack += [(y + dy, x + dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
        yield group
