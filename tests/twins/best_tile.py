"""Best tile repetition (section 4.1 of the thesis)."""

from __future__ import annotations

import math

import numpy as np


def tile_errors(pixels, vectors, border):
    """Accumulated squared differences of opposite borders of each tile (section 4.1.1)."""
    x1, y1, x2, y2 = vectors
    sides = ((y1, x1), (y2, x2))
    height, width = pixels.shape[:2]
    levels = pixels.astype(int)
    total = np.zeros((height, width), int)
    for y in range(height):
        for x in range(width):
            for k in (0, 1):
                step = [round(part) for part in sides[k]]
                for v, u in segment_pixels(sides[1 - k], (border + 1) // 2):
                    a, b = (y + v, x + u), (y + v + step[0], x + u + step[1])
                    if all(0 <= p < height and 0 <= q < width for p, q in (a, b)):
                        total[y, x] += ((levels[a] - levels[b]) ** 2).sum()
    return total


def segment_pixels(side, reach):
    """Pixels around the segment from (0, 0) to `side`, row by row.

    A row has those within `reach` columns of the part of the segment within `reach` rows of it.
    """
    steps = 1024  # such fine ones that vectors of quarters are met exactly
    rows = {}
    low, high = math.ceil(min(0, side[0])) - reach, math.ceil(max(0, side[0])) + reach
    for row in range(low, max(high, low + 1)):
        on = [
            side[1] * t / steps
            for t in range(steps + 1)
            if row - reach <= side[0] * t / steps <= row + reach
        ]
        if not on:
            near = min((0, steps), key=lambda t: abs(side[0] * t / steps - row))
            on = [side[1] * near / steps]
        rows[row] = (math.ceil(min(on)) - reach, math.ceil(max(on)) + reach)
    return [(row, u) for row, (a, b) in rows.items() for u in range(a, max(b, a + 1))]
