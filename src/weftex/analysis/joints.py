"""The edges of a sample by their direction, and what they add up to along lines.

Rows lie between joints. A joint is thin, and often faint beside the tones of what it parts, but it
runs on: edges added up along its direction stand far above those of other lines. No edge counts
for more than three times the middling one, so that strong spots make no lines.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.relief import Relief, averaged, mixed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_STRONGEST = 3.0  # times the median edge; more counts as that
_ENOUGH = 0.5  # of the longest line, that a line must have to count
_LEAST = 8  # places that must overlap
_ALIKE = 0.3  # correlation below which places have nothing in common


class Joints:
    """The edges of a sample, to be added up along lines of any direction.

    Parameters
    ----------
    flat : Relief
        The sample without slow lighting.
    """

    def __init__(self, flat: Relief) -> None:
        self.inner = flat.usable >= 0.5
        if not self.inner.all():  # the border of a mask is no edge
            framed = np.pad(self.inner, 1, mode="edge")
            self.inner = self.inner & framed[:-2, 1:-1] & framed[2:, 1:-1]
            self.inner &= framed[1:-1, :-2] & framed[1:-1, 2:]
        self.levels = mixed(flat.levels)
        down, along = np.zeros((2, *flat.levels.shape))
        if flat.levels.shape[1] > 1:
            down = np.gradient(flat.levels, axis=1)
        if flat.levels.shape[2] > 1:
            along = np.gradient(flat.levels, axis=2)
        parts = np.stack([(one * other).sum(axis=0) for one, other in
                          ((along, along), (along, down), (down, down))])  # fmt: skip
        square = parts[0] + parts[2]
        strength = np.sqrt(square)
        edges = strength[self.inner & (strength > 0)]
        most = _STRONGEST * float(np.median(edges)) if len(edges) else 0.0
        self.parts: Floats = parts * (
            self.inner * np.minimum(strength, most) / np.maximum(square, 1e-12)
        )
        self._place()

    def relief(self) -> Relief:
        """Edges down and along as levels, in which pieces of any tone are alike."""
        levels: Floats = np.stack([part - float(part.mean()) for part in self.parts[[0, 2]]])
        return Relief(levels, self.inner.astype(np.float64), 1)

    def coarser(self, largest: int) -> tuple[Joints, int]:
        """The same in squares of some pixels, at most so many a side; and the side of these."""
        step = -(-max(self.inner.shape) // largest)
        if step == 1:
            return self, 1
        smaller = object.__new__(Joints)
        smaller.parts = np.stack([averaged(part, step) for part in self.parts])
        smaller.inner = averaged(self.inner, step) >= 0.5
        smaller.levels = averaged(self.levels, step)
        smaller._place()
        return smaller, step

    def _place(self) -> None:
        self.y, self.x = (np.arange(side) - (side - 1) / 2 for side in self.inner.shape)

    def along(self, angle: float) -> Floats:
        """How strong the edges are that a line of this direction runs along."""
        c, s = np.cos(angle), np.sin(angle)
        found: Floats = (s * s) * self.parts[0]
        found -= (2 * s * c) * self.parts[1]
        found += (c * c) * self.parts[2]
        return found

    def lines(self, angle: float, values: Floats | None = None) -> Floats:
        """Mean edge, or mean of other values, of each line of a direction, a pixel apart.

        Lines at the corners, which are less than half as long as the longest, are left out.
        """
        values = self.along(angle) if values is None else values
        place = np.add.outer(np.cos(angle) * self.y, -np.sin(angle) * self.x)
        place += 0.5 - place.min()
        number = place.astype(np.int64).ravel()
        count = np.bincount(number, self.inner.ravel())
        total = np.bincount(number, values.ravel())
        kept = np.flatnonzero(count >= _ENOUGH * max(float(count.max()), 1))
        if not len(kept):
            return np.zeros(1)
        part = slice(kept[0], kept[-1] + 1)
        found: Floats = total[part] / np.maximum(count[part], 1)
        known = count[part] > 0
        found[~known] = found[known].mean()
        return found

    def turned(self, angle: float) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Edges along and across lines of a direction, turned so that these lie; what is known."""
        c, s = np.cos(angle), np.sin(angle)
        height, width = self.inner.shape
        high, wide = (int(abs(c) * a + abs(s) * b) for a, b in ((height, width), (width, height)))
        down, along = (np.arange(side) - (side - 1) / 2 for side in (high, wide))
        x = np.rint(np.add.outer(-s * down, c * along) + (width - 1) / 2).astype(np.int64)
        y = np.rint(np.add.outer(c * down, s * along) + (height - 1) / 2).astype(np.int64)
        known = (x >= 0) & (y >= 0) & (x < width) & (y < height)
        x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
        known &= self.inner[y, x]
        return self.along(angle)[y, x] * known, self.along(angle + np.pi / 2)[y, x] * known, known


def alike(values: Floats, reach: int) -> Floats:
    """The correlation of values with themselves at distances 0 to reach - 1, of what overlaps.

    >>> alike(np.tile([0.0, 1.0, 0.0, -1.0], 9), 5).round(2).tolist()
    [1.0, 0.0, -1.0, 0.0, 1.0]
    """
    size = len(values)
    known = max(min(reach, size - _LEAST), 1)
    values = values - values.mean()
    products = np.fft.irfft(abs(np.fft.rfft(values, 2 * size)) ** 2, 2 * size)[:known]
    sums, squares = (np.concatenate([[0.0], np.cumsum(part)]) for part in (values, values**2))
    count = size - np.arange(known)
    before, after = sums[count], sums[size] - sums[:known]
    spread = squares[count] - before**2 / count
    spread *= squares[size] - squares[:known] - after**2 / count
    real = spread > 1e-18 * float(squares[-1]) ** 2
    result = np.zeros(reach)
    above = products - before * after / count
    result[:known] = np.where(real, above / np.sqrt(np.where(real, spread, 1)), 0)[:reach]
    return result


def width_of(correlation: Floats) -> int:
    """How many places are alike to their neighbors, both ways: as many as one that is not."""
    return 1 + 2 * int(np.argmax(np.append(correlation, 0.0) < _ALIKE))
