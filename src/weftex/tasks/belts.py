"""Belts along the boundaries of a label map, in which materials may meet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.random import draw
from weftex.raster.masks import squared_distance_to

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

_DEPTH = 1.5  # a belt reaches into a region of so many times its own depth; others get less


class Meetings:
    """Where regions of a label map are near each other, and how far their belts reach."""

    def __init__(
        self,
        labels: NDArray[np.int32],
        present: Sequence[int],
        reaches: NDArray[np.int64],
        wrap: tuple[bool, bool],
    ) -> None:
        self.labels, self.reaches = labels, reaches
        self.farthest = int(reaches[np.ix_(present, present)].max()) if len(present) > 1 else 0
        far = int(np.ceil(_DEPTH * self.farthest))
        away = {k: squared_distance_to(labels == k, far, wrap) for k in present}
        self._away = {k: np.sqrt(squares) for k, squares in away.items()}
        # To the nearest other region: the second of all, for the own one is at 0.
        depth = np.sqrt(np.sort(np.stack([*away.values()]), axis=0)[min(1, len(present) - 1)])
        self._room = self._rooms(depth, wrap)

    def _rooms(self, depth: NDArray[np.float64], wrap: tuple[bool, bool]) -> NDArray[np.float64]:
        """Return how far belts may reach into each pixel of a region, leaving some of it."""
        room = np.zeros(depth.shape)
        reach = float(self.farthest)
        while True:
            steps = int(np.ceil(_DEPTH * reach))
            for k in self._away:
                left = (self.labels == k) & (room == 0)
                if not left.any():
                    continue
                area = _around(left, steps, wrap)
                inside = (self.labels[area] == k) & (depth[area] >= steps)
                deep = squared_distance_to(inside, steps, wrap) <= steps**2
                room[area] = np.where(left[area] & deep, reach, room[area])
            if reach < 1 or (room > 0).all():
                return np.maximum(room, 0.5)
            reach /= 2

    def have_met(self, a: int, b: int) -> bool:
        """Return whether two regions touch, corners included."""
        return bool((self._away[a] + self._away[b] < 2).any())

    def span(self, a: int, b: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the rows and columns of the belt between two regions and one pixel around it."""
        near = np.maximum(self._away[a], self._away[b]) <= self.reaches[a, b] + 1
        lines = []
        for axis in (0, 1):
            taken = np.flatnonzero(near.any(axis=1 - axis))
            lines.append(np.arange(taken[0], taken[-1] + 1))
        return lines[0], lines[1]

    def place(
        self, a: int, b: int, rows: NDArray[np.intp], columns: NDArray[np.intp]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return where pixels lie in the belt: -1 at its edge in the first region, 1 in the second.

        Also half the width of the belt there, in pixels; it takes few values.
        """
        area = np.ix_(rows, columns)
        apart = self._away[a][area] - self._away[b][area]
        room = np.minimum(self._room[area], self.reaches[a, b])
        return apart / room, room


def _around(mask: NDArray[np.bool_], far: int, wrap: tuple[bool, bool]) -> tuple[slice, slice]:
    """Return the box of a mask and `far` pixels around it; all of an axis that wraps."""
    spans = []
    for axis, (side, wraps) in enumerate(zip(mask.shape, wrap, strict=True)):
        taken = np.flatnonzero(mask.any(axis=1 - axis))
        low, high = int(taken[0]) - far, int(taken[-1]) + far + 1
        spans.append(slice(0, side) if wraps else slice(max(0, low), min(side, high)))
    return spans[0], spans[1]


def hills(
    place: NDArray[np.float64],
    room: NDArray[np.float64],
    wrap: tuple[bool, ...],
    seed: int,
) -> NDArray[np.float64]:
    """Return the noise that bends a boundary: hills as wide as its belt, of either sign.

    Narrow belts have hills of their own, or they would be led aside as a whole. What all have in
    common is taken off: around a small region lie few, which would make it larger or smaller.
    """
    astray = np.zeros(place.shape)
    for wide in np.unique(room):
        here = room == wide
        astray[here] = wander(place.shape, max(1, round(wide)), wrap, seed)[here]
    # A sum of integers is the same on every machine.
    heights = np.rint(astray[np.abs(place) < 1] * 2**20).astype(np.int64)
    result: NDArray[np.float64] = astray - int(heights.sum()) / (max(1, len(heights)) * 2**20)
    return result


def wander(
    shape: tuple[int, ...], cell: int, wrap: tuple[bool, ...], seed: int
) -> NDArray[np.float64]:
    """Return smooth noise from -1 to 1 with periods of about `cell` pixels and half of that."""
    result = np.zeros(shape)
    for octave, weight in enumerate((2 / 3, 1 / 3)):
        size = max(2, cell >> octave)
        whole, part = [], []
        for n, wraps in zip(shape, wrap, strict=True):
            count = max(1, round(n / size))
            at = np.arange(n) * (count / n if wraps else 1 / size)
            low = at.astype(np.int64)
            whole.append([low % count, (low + 1) % count] if wraps else [low, low + 1])
            smooth = at - low
            part.append(smooth * smooth * (3 - 2 * smooth))
        total = np.zeros(shape)
        for i, j in np.ndindex(2, 2):
            bits = draw(seed, "hill", octave, whole[0][i][:, None], whole[1][j][None])
            height = (bits >> np.uint64(40)).astype(np.float64) / 2**23 - 1
            v = part[0] if i else 1 - part[0]
            u = part[1] if j else 1 - part[1]
            total += height * v[:, None] * u
        result += weight * total
    return result
