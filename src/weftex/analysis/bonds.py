"""The bond of rows: how long their pieces are, and how far each row is moved against the next.

The courses of a wall have most of what its picture correlates with, and hide the joints within
them. Where rows are known, each is one line of numbers: the mean of the edges across it, without
its own joints. These lines are correlated with each other along the rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.joints import width_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.joints import Joints
    from weftex.analysis.rows import Rows

    Floats = NDArray[np.float64]

_HEIGHT = 0.6  # of a row, around its middle, that is looked at
_PHASES = 24  # of the first row, that are tried
_ROWS = 3  # rows away that are compared
_ALONG = 4  # pieces away that are compared
_REACH = 0.8  # of a row: the farthest that is compared
_LONGEST = 0.4  # of a row: the longest piece
_SHORTEST = 0.4  # of a row's height, and
_FEWEST = 6  # pixels: the shortest
_SHIFTS = 48  # shifts of a row against the next that are tried
_SUMS, _OFF = 4, 0.1  # of vectors, that are tried; of a row, that one may be off it
_SLANT = 0.02  # of a vector, that it may be off rows
_LEAST = 0.03  # of all, that must overlap
_BETWEEN = (1 / 2, 1 / 3, 2 / 3)  # of a piece


@dataclass(frozen=True, eq=False)
class Bond:
    """Pieces of a length in rows that are moved by a shift.

    Attributes
    ----------
    vectors : float64 array (2, 2)
        Along a row, and to the next; as (x, y).
    contrast : float
        How far the correlation at multiples is above that half and a third of a piece beside them.
    chance : float
        The standard error of that.
    """

    vectors: Floats
    contrast: float
    chance: float

    @property
    def sure(self) -> float:
        """Standard errors that the contrast is."""
        return self.contrast / max(self.chance, 1e-9)


def find_bond(joints: Joints, rows: Rows) -> Bond | None:
    """Find the bond that the joints within rows tell best, right or not.

    Parameters
    ----------
    joints : Joints
        The sample's edges.
    rows : Rows
        Its rows.

    Returns
    -------
    Bond or None
        None where rows are too short.

    Examples
    --------
    >>> from weftex.analysis.joints import Joints
    >>> from weftex.analysis.relief import Relief
    >>> from weftex.analysis.rows import rated_rows
    >>> y, x = np.mgrid[:120, :200]
    >>> bricks = ((y % 12 < 2) | ((x + y // 12 % 2 * 15) % 30 < 2))[None] * 1.0
    >>> joints = Joints(Relief(bricks, np.ones((120, 200)), 1))
    >>> bond = find_bond(joints, rated_rows(joints, np.array([0.0, 12.0])))
    >>> (bond.vectors.round() + 0).tolist(), bond.sure > 9
    ([[30.0, 0.0], [15.0, 12.0]], True)
    """
    seen = _Lines(joints, rows)
    longest, shortest = _LONGEST * seen.length, max(_FEWEST, _SHORTEST * rows.distance)
    best = None
    for length in np.arange(shortest, longest):
        found = seen.best(length, np.arange(0, length, max(1.0, length / _SHIFTS)))
        if found is not None and (best is None or found.sure > best.sure):
            best = found
    return best


def rated_bond(joints: Joints, rows: Rows, vectors: Floats) -> Bond | None:
    """What tells a bond that is given by vectors, if it is one of these rows."""
    along, across = _axes(rows)
    # The shortest sum of the vectors that leads along the rows, and one to the next row.
    times = np.stack(np.meshgrid(*[np.arange(-_SUMS, _SUMS + 1)] * 2), axis=-1).reshape(-1, 2)
    sums = times[times.any(axis=1)] @ vectors
    steps, places = sums @ across / rows.distance, sums @ along
    off = _OFF + _SLANT * abs(places) / rows.distance
    same = (abs(steps) < off) & (places > 0)
    next_one = abs(steps - 1) < off
    if not same.any() or not next_one.any():
        return None
    length = float(places[same].min())
    shift = places[next_one] % length
    return _Lines(joints, rows).best(length, shift[:1])


class _Lines:
    """Rows as lines of numbers, correlated with those that are 0, 1, ... away."""

    def __init__(self, joints: Joints, rows: Rows) -> None:
        self.rows = rows
        beds, edges, known = joints.turned(rows.angle)
        high, self.length = edges.shape
        distance, box = rows.distance, max(1, int(_HEIGHT * rows.distance))
        # Lines begin where a box leaves out most of the joints between rows.
        line = beds.sum(axis=1) / np.maximum(known.sum(axis=1), 1)
        bins = (np.arange(high) / distance % 1 * _PHASES).astype(np.int64)
        folded = np.bincount(bins, line, _PHASES) / np.maximum(np.bincount(bins, None, _PHASES), 1)
        folded += (np.roll(folded, 1) + np.roll(folded, -1)) / 2
        joint = (int(np.argmax(folded)) + 0.5) / _PHASES * distance
        tops = joint + (1 - _HEIGHT) / 2 * distance + np.arange(-1, high // distance + 1) * distance
        tops = np.rint(tops[(tops >= 0) & (tops + box < high)]).astype(np.int64)
        sums, counts = (
            np.concatenate([np.zeros((1, self.length)), np.cumsum(part, axis=0)])
            for part in (edges, known)
        )
        count = counts[tops + box] - counts[tops]
        good = count >= 0.5 * box
        lines = np.where(good, (sums[tops + box] - sums[tops]) / np.maximum(count, 1), 0)
        mean = lines.sum(axis=1) / np.maximum(good.sum(axis=1), 1)
        lines = np.where(good, lines - mean[:, None], 0)
        self._compare(lines, good)

    def _compare(self, lines: Floats, good: NDArray[np.bool_]) -> None:
        size, reach = 2 * self.length, int(_REACH * self.length)
        waves, masks, squares = (np.fft.rfft(part, size) for part in (lines, good * 1.0, lines**2))
        order, number = np.arange(-reach, reach + 1), min(_ROWS + 1, len(lines))
        table, self.overlap = np.zeros((2, number, len(order)))
        for away in range(number):
            pairs = [(away + k, k) for k in range(len(lines) - away)]
            lower, upper = np.array(pairs).T
            products, count, first, second = (
                np.fft.irfft((one[lower] * other[upper].conj()).sum(axis=0), size)[order]
                for one, other in (
                    (waves, waves), (masks, masks), (squares, masks), (masks, squares)
                )
            )  # fmt: skip
            spread = first * second
            enough = (count > _LEAST * max(float(count.max()), 1)) & (spread > 1e-12)
            table[away] = enough * products / np.sqrt(np.where(enough, spread, 1))
            self.overlap[away] = enough * count
        self.middle = reach
        self.wide = width_of(table[0, reach:]) if number else 1
        # A joint is some pixels wide, and pieces are not laid to the pixel.
        self.table = np.maximum(table, np.roll(table, 1, axis=1))
        self.table = np.maximum(self.table, np.roll(table, -1, axis=1))
        pairs = [(k, m) for k in range(number) for m in range(-_ALONG, _ALONG + 1)]
        right = [pair for pair in pairs if pair > (0, 0)]
        self.times = np.array(right).reshape(-1, 2).T[:, :, None]

    def best(self, length: float, shift: Floats) -> Bond | None:
        """The surest of some shifts of a row against the next, of pieces of a length."""
        away, times = self.times
        means = []
        chance = np.ones(len(shift))
        for phase in (0.0, *_BETWEEN):
            place = np.rint((times + phase) * length + away * shift).astype(np.int64)
            inside = abs(place) < self.middle
            place = np.where(inside, place, 0) + self.middle
            weights = self.overlap[away, place] * inside
            total = np.maximum(weights.sum(axis=0), 1e-9)
            means.append((self.table[away, place] * weights).sum(axis=0) / total)
            if phase == 0:
                errors = weights**2 * self.wide / np.maximum(weights, self.wide)
                chance = np.sqrt(errors.sum(axis=0)) / total
        contrast = means[0] - np.max(means[1:], axis=0)
        sure = contrast / np.maximum(chance, 1e-9)
        if not len(sure):
            return None
        k = int(sure.argmax())
        along, _ = _axes(self.rows)
        vectors = np.stack([length * along, self.rows.vector + float(shift[k]) * along])
        return Bond(vectors, float(contrast[k]), float(chance[k]))


def _axes(rows: Rows) -> tuple[Floats, Floats]:
    """Along the rows, and across."""
    along = np.array([np.cos(rows.angle), np.sin(rows.angle)])
    return along, np.array([-along[1], along[0]])
