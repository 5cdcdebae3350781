"""What kernels of the measures do, pixel by pixel."""

import numpy as np


def prediction_error(steps, weights, knots, usual):
    """Of each step by the 30 beside it, over the usual one at their mean square."""
    height, width = steps.shape
    found = np.zeros((height - 4, width - 6))
    for y in range(height - 4):
        for x in range(width - 6):
            beside = np.delete(steps[y : y + 5, x : x + 7].astype(float), 3, axis=1).ravel()
            left = float(steps[y + 2, x + 3]) - weights @ beside
            expected = np.interp((beside**2).mean(), knots, usual)
            found[y, x] = abs(left) / np.sqrt(expected)
    return found


def differ_at_joints(own, made, source):
    """The sum of the lesser squared differences where two pieces meet, and their number."""
    total = count = 0
    places = {(y, x): tuple(at) for (y, x), at in zip(
        np.ndindex(source.shape[:2]), source.reshape(-1, 2).tolist(), strict=True)}  # fmt: skip
    for (y, x), at in places.items():
        for step in ((1, 0), (0, 1)):
            other = y + step[0], x + step[1]
            there = places.get(other, (-1, -1))
            goes_on = at[0] + step[0], at[1] + step[1]
            before = there[0] - step[0], there[1] - step[1]
            if at[0] < 0 or there[0] < 0 or there == goes_on:
                continue
            differ = [
                ((made[pixel].astype(int) - own[place]) ** 2).sum()
                for pixel, place in ((other, goes_on), ((y, x), before))
                if 0 <= place[0] < own.shape[0] and 0 <= place[1] < own.shape[1]
            ]
            if differ:
                total, count = total + int(min(differ)), count + 1
    return total, count
