"""Arrays of users, checked and kept apart from what the users do with them; the median."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError, wrong_value

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Indices = NDArray[np.int32]
Bytes = NDArray[np.uint8]
Mask = NDArray[np.bool_]

_DTYPES = ("uint8", "uint16", "float32", "float64")
_MOST_CHANNELS = 32  # of a picture of four rows or fewer


def as_array(values: Any, name: str) -> NDArray[Any]:
    """Return `np.asarray(values)`, or raise `InvalidInputError`, also for a masked array."""
    if is_masked(values):
        raise InvalidInputError(f"{name} is a masked array; use its filled(value), or give a mask")
    try:
        return np.asarray(values)
    except (TypeError, ValueError, OverflowError):
        raise wrong_value(name, values, "an array") from None


def is_masked(values: Any) -> bool:
    """Return whether something is a masked array, without importing that part of NumPy."""
    masked = sys.modules.get("numpy.ma")
    return masked is not None and isinstance(values, masked.MaskedArray)


def without_mask(pixels: Any) -> tuple[Any, NDArray[np.bool_] | None]:
    """Return pixels, and which of them are usable: not masked in any channel."""
    if not is_masked(pixels) or pixels.ndim not in (2, 3):
        return pixels, None
    masked: NDArray[np.bool_] = np.atleast_3d(np.ma.getmaskarray(pixels))
    usable: NDArray[np.bool_] = np.logical_not(masked.any(axis=2))
    first = pixels.data[usable]
    return pixels.filled(first.flat[0] if first.size else 0), usable


def check_layout(pixels: NDArray[Any], name: str) -> None:
    """Refuse (channels, height, width), which is how other programs stack them.

    A picture of four rows or fewer may well have three or five channels, but hardly more than
    `_MOST_CHANNELS`; as a picture of so few columns a stack would be no sample.
    """
    shape = as_array(pixels, name).shape
    if len(shape) == 3 and 0 < shape[0] <= 4 and shape[2] > _MOST_CHANNELS:
        raise InvalidInputError(
            f"{name} has the shape {shape}, which looks like (channels, height, width); use "
            "np.moveaxis(pixels, 0, -1), or give alpha=False if it has "
            f"{shape[2]} channels"
        )


def as_mask(values: Any, name: str) -> NDArray[np.bool_]:
    """Return a contiguous mask (H, W), of booleans or numbers; refuse anything else."""
    mask = as_array(values, name)
    if mask.dtype.kind not in "biuf":
        raise InvalidInputError(f"{name} has dtype {mask.dtype}; it must be boolean")
    if mask.ndim != 2:
        raise InvalidInputError(f"{name} has shape {mask.shape}; it must be (H, W)")
    return np.ascontiguousarray(mask, bool)


def check_guide(pixels: NDArray[Any], name: str) -> NDArray[Any]:
    """`check_pixels`, but for labels in whole numbers of any type too."""
    pixels = as_array(pixels, name)
    if pixels.dtype.kind in "biu" and pixels.dtype.name not in _DTYPES and pixels.size:
        if pixels.min() < 0 or pixels.max() > 65535:
            raise InvalidInputError(
                f"{name} has labels from {pixels.min()} to {pixels.max()}; they must be from 0 to "
                "65535"
            )
        pixels = pixels.astype(np.uint16)
    return check_pixels(pixels, name)


def check_pixels(pixels: NDArray[Any], name: str) -> NDArray[Any]:
    """Return `pixels` contiguous, or raise `InvalidInputError` saying what is wrong with them."""
    pixels = as_array(pixels, name)
    if pixels.dtype.name not in _DTYPES:
        if pixels.dtype == bool:
            raise InvalidInputError(f"{name} is boolean; multiply by 255 and make it uint8")
        able = f"supported: {', '.join(_DTYPES)}; convert it, as with astype(np.float32)"
        raise InvalidInputError(f"{name} has dtype {pixels.dtype}; {able}")
    if pixels.ndim not in (2, 3):
        raise InvalidInputError(
            f"{name} has {pixels.ndim} dimensions; an image has (height, width[, channels])"
        )
    if 0 in pixels.shape:
        raise InvalidInputError(f"{name} is empty: its shape is {pixels.shape}")
    if pixels.dtype.kind == "f" and not np.isfinite(pixels).all():
        raise InvalidInputError(
            f"{name} contains NaN or infinity; replace or mask them, as with np.ma.masked_invalid"
        )
    return np.ascontiguousarray(pixels, pixels.dtype.newbyteorder("="))


def owned(values: NDArray[Any]) -> NDArray[Any]:
    """Return a read-only array that no other array can write to, copied if it must be."""
    whole: Any = values
    while isinstance(whole, np.ndarray) and not whole.flags.writeable and whole.base is not None:
        whole = whole.base
    writeable = isinstance(whole, np.ndarray) and whole.flags.writeable
    if writeable or not isinstance(whole, (np.ndarray, bytes)):
        values = values.copy()
        values.setflags(write=False)
    return values


def median(values: NDArray[Any]) -> float:
    """The median of all values of a non-empty array without NaN, without loading numpy.ma."""
    last = values.size // 2
    first = last - 1 + values.size % 2
    ordered = np.partition(values, (first, last), axis=None)
    return (float(ordered[first]) + float(ordered[last])) / 2


def fast_size(length: int) -> int:
    """Return the smallest length from `length` on with no prime factors but 2, 3 and 5."""
    while True:
        rest = length
        for factor in (2, 3, 5):
            while rest % factor == 0:
                rest //= factor
        if rest == 1:
            return length
        length += 1


def stacked(parts: list[NDArray[Any]], fill: Any) -> NDArray[Any]:
    """Arrays one under the other; `fill` beside narrow ones."""
    whole = np.full((sum(map(len, parts)), max(part.shape[1] for part in parts)), fill)
    top = 0
    for part in parts:
        whole[top : top + len(part), : part.shape[1]] = part
        top += len(part)
    return whole
