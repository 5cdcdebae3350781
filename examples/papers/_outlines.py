"""Whether outlines continue across seams, which `papers/patch_sampling.py edges` counts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import weftex


class Outlines:
    """Where outlines run across the columns of a picture: local maxima of the vertical gradient.

    They are clear where the gradient is larger than `limit`, by default the picture's own 90 %
    quantile, and steeper than along the row.
    """

    def __init__(self, pixels: np.ndarray, limit: float | None = None) -> None:
        gray = pixels.reshape(*pixels.shape[:2], -1).mean(axis=2)
        for _ in range(2):  # grain is no outline
            gray = np.pad(gray, 1, mode="edge")
            gray = (gray[:-2] + 2 * gray[1:-1] + gray[2:]) / 4
            gray = (gray[:, :-2] + 2 * gray[:, 1:-1] + gray[:, 2:]) / 4
        self.dy, self.dx = np.gradient(gray)
        self.limit = np.quantile(np.hypot(self.dy, self.dx), 0.9) if limit is None else limit
        strength = np.abs(self.dy)
        self.peak = np.zeros(gray.shape, bool)
        self.peak[1:-1] = (strength[1:-1] >= strength[:-2]) & (strength[1:-1] > strength[2:])
        self.clear = self.peak & (strength >= np.abs(self.dx)) & (strength > self.limit)

    def go_on(self, column: int, rows: range, gap: int) -> np.ndarray:
        """Count the clear outlines at a column, and those of them that arrive `gap` further.

        One arrives if within two pixels of where its direction leads there is one of the same sign
        and at least half the strength.
        """
        found = arrived = 0
        for v in (np.flatnonzero(self.clear[rows.start : rows.stop, column]) + rows.start).tolist():
            slope = self.dy[v, column]
            to = round(v - gap * self.dx[v, column] / slope)
            if to < 2 or to + 3 > len(self.dy):
                continue
            window = slice(to - 2, to + 3), column + gap
            found += 1
            arrived += bool((self.peak[window] & (self.dy[window] / slope > 0.5)).any())
        return np.array([found, arrived])


def turned(pixels: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(pixels.swapaxes(0, 1))


def continuity(result: weftex.Synthesis, zone: int, limits: Sequence[float]) -> tuple[float, float]:
    """Share of the outlines at one side of the seams that arrive at the other; how many a pixel."""
    total, length = np.zeros(2, int), 0
    size = result.weights.shape[1]
    for axis, pixels in ((1, result.image), (0, turned(result.image))):
        outlines = Outlines(pixels, limits[axis])
        for place in result.placements[:, :2].tolist():
            along, across = place[1 - axis], place[axis]
            if across > 0:
                rows = range(along + zone, along + size - zone)
                total += outlines.go_on(across - 3, rows, zone + 5)
                length += len(rows)
    return float(total[1] / max(total[0], 1)), float(total[0] / length)


def own_continuity(sample: np.ndarray, zone: int) -> tuple[float, float, list[float]]:
    """The same all over the sample, and what it calls clear along each axis."""
    total, length = np.zeros(2, int), 0
    limits = []
    for pixels in (turned(sample), sample):
        outlines = Outlines(pixels)
        limits.append(float(outlines.limit))
        rows = range(2, len(pixels) - 2)
        for column in range(3, pixels.shape[1] - zone - 8, 3):
            total += outlines.go_on(column, rows, zone + 5)
            length += len(rows)
    return float(total[1] / max(total[0], 1)), float(total[0] / length), limits
