"""Pixels of any type as bytes, which distances are taken on, and as light; at other sizes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from fractions import Fraction

    from numpy.typing import NDArray

    from weftex.raster.arrays import Floats

_KNEE = 0.04045  # below which the curve of sRGB is a line
_ORDINARY = 100  # powers of two: float32, too, subtracts and divides such numbers


def scale_to_bytes(pixels: NDArray[Any]) -> tuple[float, float]:
    """Return the values that become 0 and 255."""
    if pixels.dtype == np.uint8:
        return 0.0, 255.0
    if pixels.dtype == np.uint16:
        low, high = float(pixels.min()), float(pixels.max())
        full = 65535.0
    else:
        # A few specular pixels of an HDR picture must not turn the rest black.
        numbers, exponent = tamed(pixels)
        low, high = (math.ldexp(float(q), exponent) for q in np.quantile(numbers, (0.001, 0.999)))
        full = 1.0
    if low >= 0 and high <= full and high - low >= full / 8:
        return 0.0, full  # the same bytes as the 8-bit version of the picture
    if 0 <= low < 0.75 * high:
        low = 0.0
    return low, high if high > low else low + max(1.0, abs(low))


def to_bytes(pixels: NDArray[Any], scale: tuple[float, float]) -> NDArray[np.float64]:
    """Return (H, W, C) scaled from 0 to 255, not rounded; the ends of `scale` become 0 and 255."""
    low, high = scale
    pixels = np.clip(pixels.reshape(*pixels.shape[:2], -1).astype(np.float64), low, high)
    exponent = _exponent(max(abs(low), abs(high)))
    if exponent:
        pixels = np.ldexp(pixels, -exponent)
        low, high = math.ldexp(low, -exponent), math.ldexp(high, -exponent)
    return np.clip((pixels - low) * (255 / (high - low)), 0, 255)


def tamed(pixels: NDArray[Any]) -> tuple[NDArray[Any], int]:
    """Divide numbers so large or small that arithmetic fails by a power of two, and return it."""
    exponent = _exponent(float(np.abs(pixels).max()))
    return (np.ldexp(pixels.astype(np.float64), -exponent) if exponent else pixels), exponent


def _exponent(largest: float) -> int:
    """0 for ordinary numbers, whose differences and quotients are numbers too."""
    exponent = math.frexp(largest)[1]
    return 0 if abs(exponent) < _ORDINARY or largest == math.inf else exponent


def scale_between(shape: tuple[int, ...], other: tuple[int, ...]) -> Fraction | int | None:
    """Pixels of one picture per pixel of another: an integer or 1 / integer, else None."""
    height, width, times = *shape[:2], shape[0] // other[0]
    if times and (height, width) == (times * other[0], times * other[1]):
        return times
    from fractions import Fraction  # takes its time

    scale, same = (Fraction(a, b) for a, b in zip(shape[:2], other[:2], strict=True))
    return scale if scale == same and scale.numerator == 1 else None


def resized(pixels: NDArray[Any], scale: Fraction | float) -> NDArray[Any]:
    """Pixels repeated to an integer multiple of their size, or averaged to a fraction of it."""
    if scale >= 1:
        return pixels if scale == 1 else pixels.repeat(int(scale), 0).repeat(int(scale), 1)
    side = round(1 / scale)
    numbers, exponent = tamed(pixels) if pixels.dtype.kind == "f" else (pixels, 0)
    blocks = numbers.reshape(len(pixels) // side, side, -1, side, *pixels.shape[2:])
    means = np.ldexp(blocks.mean(axis=(1, 3), dtype=np.float64), exponent)
    return np.asarray(means if pixels.dtype.kind == "f" else np.rint(means), pixels.dtype)


def to_light(stored: Floats) -> Floats:
    """Return the linear light, 0 to 1, of stored sRGB values, 0 to 1 (IEC 61966-2-1)."""
    return np.where(stored <= _KNEE, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4)


def to_stored(light: Floats) -> Floats:
    """Return the values that are stored for amounts of light: the inverse of `to_light`."""
    return np.where(light <= _KNEE / 12.92, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
