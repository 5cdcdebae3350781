"""What the references share: their result, whole windows, and random picks."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError, shown
from weftex.random import draw, seed_number


class Made(NamedTuple):
    """What every reference returns.

    Attributes
    ----------
    image : uint8 array (H, W) or (H, W, channels)
        The picture, with the channels of the sample.
    sources : int array (H, W, 2)
        Row and column in the sample of each pixel's source. Where patches are blended, the source
        with the largest share; -1 for a pixel without a single source.
    """

    image: NDArray[np.uint8]
    sources: NDArray[np.int64]


def checked(sample: Any, size: Any, seed: int = 0) -> tuple[NDArray[np.int64], tuple[int, int]]:
    """The sample as (h, w, channels) whole numbers, and the output's height and width."""
    seed_number(seed)
    pixels = np.asarray(sample)
    if pixels.dtype != np.uint8 or pixels.ndim not in (2, 3) or not pixels.size:
        raise InvalidInputError(
            f"sample is {pixels.dtype} {pixels.shape}; it must be uint8 (h, w) or (h, w, channels)"
        )
    height, width = (size, size) if isinstance(size, int) else map(int, size)
    if min(height, width) < 1:
        raise InvalidInputError(f"size is {shown(size)}; both sides must be 1 or more")
    return pixels.reshape(*pixels.shape[:2], -1).astype(np.int64), (height, width)


def fits(name: str, value: int, sample: NDArray[Any], odd: bool = False, least: int = 1) -> int:
    """The value, if a square of that side fits into the sample."""
    most = min(sample.shape[:2])
    if not least <= value <= most or (odd and value % 2 == 0):
        kind = "odd and " if odd else ""
        raise InvalidInputError(f"{name} is {value}; it must be {kind}from {least} to {most}")
    return int(value)


def made(sample: Any, pixels: NDArray[Any], sources: NDArray[Any]) -> Made:
    """The result, in the layout of the sample."""
    shape = (*pixels.shape[:2], *np.shape(sample)[2:])
    return Made(pixels.reshape(shape).astype(np.uint8), sources)


def windows(pixels: NDArray[Any], height: int, width: int) -> NDArray[Any]:
    """All whole windows of a picture, by their upper left corners: (rows, columns, H, W, ...)."""
    found = np.lib.stride_tricks.sliding_window_view(pixels, (height, width), (0, 1))
    return np.moveaxis(found, (-2, -1), (2, 3))


def places(height: int, width: int) -> NDArray[np.int64]:
    """Row and column of each pixel of a rectangle: (height, width, 2)."""
    return np.moveaxis(np.indices((height, width)), 0, 2)


def window_steps(half: int) -> NDArray[np.int64]:
    """Steps (n, 2) to the pixels of a square window, in scan order; the middle is the middle."""
    return (places(2 * half + 1, 2 * half + 1) - half).reshape(-1, 2)


def at(picture: NDArray[Any], where: NDArray[Any]) -> Any:
    """The pixels of a picture at some places (..., 2)."""
    return picture[where[..., 0], where[..., 1]]


def pick(count: int, seed: int, purpose: str, *place: int) -> int:
    """A random number from 0 to count - 1, the same for the same seed, purpose and place."""
    return (int(draw(seed, purpose, *place)) >> 32) * count >> 32
