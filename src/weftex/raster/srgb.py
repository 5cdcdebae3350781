"""The curve of sRGB (IEC 61966-2-1), between values as they are stored and amounts of light."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_KNEE = 0.04045  # below which the curve is a line


def to_light(stored: Floats) -> Floats:
    """Linear light, 0 to 1, of stored sRGB values, 0 to 1."""
    return np.where(stored <= _KNEE, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4)


def to_stored(light: Floats) -> Floats:
    """Return the values that are stored for amounts of light: the inverse of `to_light`."""
    return np.where(light <= _KNEE / 12.92, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
