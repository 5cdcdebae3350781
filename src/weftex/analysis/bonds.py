"""The bond of rows: how long their pieces are, and how far each row is moved against the next.

The courses of a wall hide the joints within them. So where rows are known, the correlation along
them is taken less its mean, at each number of rows away: what is left repeats piece by piece.
"""

from __future__ import annotations

import numpy as np

from weftex.analysis.autocorrelations import all_times
from weftex.analysis.pairs import PHASES
from weftex.raster.arrays import Floats

_ROWS = 3  # rows away that are compared
_ACROSS = 0.08  # of the distance of rows, that courses may be off
_ALONG = 0.05  # the same of joints, along them
_REACH = 0.7  # of the sample: the farthest that is compared
_LEAST = 0.1  # of the sample, that must overlap
_SHORTEST = 0.5  # of the distance of rows, and
_FINEST = 6.0  # pixels: the shortest piece
_LONGEST = 0.85  # of what is compared, and
_BRICK = 1.5  # of the distance of rows: the shortest brick
_FLATTEST = 4.0  # of the distance of rows: the longest; slanted lines have longer stairs
_SHIFTS = 48  # shifts of a row against the next that are tried
_SUMS = 6  # of vectors, that may lead along a row, or to the next
_OFF, _SLANT = 0.1, 0.02  # of the distance, and of their length, that these may be off
_FAINTEST = 0.01  # of all edges: the least that joints are
_CHANCE = 0.7  # of chance: the least spread, about, of a photograph along its rows


class Bonds:
    """What joints within rows say of the bonds that rows may have.

    `correlation` is that of the whitened sample, `rows` the vector (x, y) from one row to the next.
    """

    def __init__(self, correlation: Floats, rows: Floats) -> None:
        self.rows, self.distance = rows, float(np.hypot(*rows))
        along = np.array([rows[1], -rows[0]]) / self.distance
        self.along = along * (1 if along[0] + along[1] / 8 > 0 else -1)
        self.table, self.weights = _along(correlation, rows, self.along, self.distance)
        self.far = self.table.shape[1] // 2
        power = (self.table**2 * self.weights).sum() / max(float(self.weights.sum()), 1e-12)
        self.spread = max(float(np.sqrt(power)), 1e-12)

    def best(self, chance: float = 0.0, half: bool = False) -> tuple[Floats, float, float] | None:
        """The most likely bond, its confidence and its share; None where rows are too short.

        Vectors lead along a row and to the next. How far multiples are above what is between them,
        times the root of their number, is in units of the spread of all, or of `chance` if that is
        more: stairs of a drawing come back, far below it. The share is that of the correlation at
        no shift. With `half` each row is moved by half a brick: chance makes few of these.
        """
        best, share, found = 0.0, 0.0, None
        shortest = max(_FINEST, (_BRICK if half else _SHORTEST) * self.distance)
        longest = min(_LONGEST * self.far, _FLATTEST * self.distance)
        for length in np.arange(shortest, longest):
            first, step = (length / 2, length) if half else (0, max(1.0, length / _SHIFTS))
            shifts = np.arange(first, length, step)
            sure, shares = self._rated(float(length), shifts)
            k = int(sure.argmax())
            if sure[k] > best:
                best, share, found = float(sure[k]), float(shares[k]), (length, shifts[k])
        if found is None or (half and found[0] >= longest - 1):  # of longer bricks, perhaps
            return None
        best *= min(1.0, self.spread / max(_CHANCE * chance, 1e-12))
        return np.stack([found[0] * self.along, self.rows + found[1] * self.along]), best, share

    def of(self, vectors: Floats) -> float | None:
        """The confidence of the bond that a lattice has; None if it is no bond of these rows."""
        sums = all_times(_SUMS, 2) @ vectors
        steps, places = sums @ self.rows / self.distance**2, sums @ self.along
        off = _OFF + _SLANT * abs(places) / self.distance
        same, next_one = (abs(steps) < off) & (places > 0), abs(steps - 1) < off
        if not same.any():
            return None
        length = float(places[same].min())
        if not next_one.any():  # two rows of pieces longer than any are chance
            return 0.0 if length > _FLATTEST * self.distance else None
        return float(self._rated(length, places[next_one][:1] % length)[0][0])

    def _rated(self, length: float, shifts: Floats) -> tuple[Floats, Floats]:
        """The evidence for multiples of a piece, for each shift, and their share."""
        most = int(self.far / length) + 2
        away, times = np.mgrid[: _ROWS + 1, -most - _ROWS : most + 1].reshape(2, -1)
        ahead = (away > 0) | (times > 0)
        away, times = away[ahead][:, None], times[ahead][:, None]
        means, total = [], np.zeros(len(shifts))
        for phase in PHASES:
            place = np.rint((times + phase) * length + away * shifts).astype(np.int64)
            inside = abs(place) <= self.far
            place = np.where(inside, place, 0) + self.far
            share = self.weights[away, place] * inside
            weight = share.sum(axis=0)
            means.append((self.table[away, place] * share).sum(axis=0) / np.maximum(weight, 1e-9))
            total = weight if phase == 0 else total
        higher: Floats = means[0] - np.max(means[1:], axis=0)
        own = max(float(self.table[0, self.far]), _FAINTEST)
        return higher * np.sqrt(total) / self.spread, higher / own


def _along(
    correlation: Floats, rows: Floats, along: Floats, distance: float
) -> tuple[Floats, Floats]:
    """The correlation at shifts of whole rows and of pixels along them, minus its mean along them.

    And the share of the sample that overlaps there, 0 where that is too little.
    """
    height, width = (side // 2 + 1 for side in correlation.shape)
    far = int(_REACH * min(width / max(abs(along[0]), 1e-9), height / max(abs(along[1]), 1e-9)))
    side = max(1, round(_ACROSS * distance))
    across = np.arange(-side, side + 1)[:, None, None] / distance
    away = np.arange(_ROWS + 1)[:, None] + across
    place = np.arange(-far, far + 1)
    x, y = (away * rows[axis] + place * along[axis] for axis in (0, 1))
    share = np.maximum(1 - abs(x[side]) / width, 0) * np.maximum(1 - abs(y[side]) / height, 0)
    share *= share > _LEAST
    # Between pixels: rounded places of slanted rows go up and down like stairs.
    table = _between(correlation, x + width - 1, y + height - 1).mean(axis=0)
    level = (table * share).sum(axis=1) / np.maximum(share.sum(axis=1), 1e-9)
    table -= level[:, None]
    by = max(1.0, _ALONG * distance)
    window = np.exp(-0.5 * (np.arange(-int(3 * by) - 1, int(3 * by) + 2) / by) ** 2)
    soft, known = (
        np.stack([np.convolve(row, window, "same") for row in part])
        for part in (table * share, share)
    )
    return np.where(share > 0, soft / np.maximum(known, 1e-9), 0), share


def _between(values: Floats, x: Floats, y: Floats) -> Floats:
    """Values at places between pixels, which at the border are those of the border."""
    x, y = (np.clip(at, 0, side - 1.001) for at, side in ((x, values.shape[1]), (y, len(values))))
    i, j = y.astype(np.int64), x.astype(np.int64)
    down, along = y - i, x - j
    upper = values[i, j] * (1 - along) + values[i, j + 1] * along
    lower = values[i + 1, j] * (1 - along) + values[i + 1, j + 1] * along
    return upper * (1 - down) + lower * down
