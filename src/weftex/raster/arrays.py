"""Arrays of users, checked and kept apart from what the users do with them; the median."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError, shown


def as_array(values: Any, name: str) -> NDArray[Any]:
    """Return `np.asarray(values)`, or raise `InvalidInputError`, also for a masked array."""
    if is_masked(values):
        raise InvalidInputError(f"{name} is a masked array; use its filled(value), or give a mask")
    try:
        return np.asarray(values)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError(f"{name} is {shown(values)}; it must be an array") from None


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
