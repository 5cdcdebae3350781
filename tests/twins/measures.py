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
