"""How much a picture is like itself some pixels on, in whole numbers so that all machines agree."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.raster.boxes import box_sums

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.int64]


def like_itself(
    values: NDArray[np.integer],
    vector: tuple[float, float],
    usable: NDArray[np.bool_] | None = None,
) -> float:
    """The correlation of a picture with itself, moved by a vector.

    Parameters
    ----------
    values : integer array (H, W, K)
        The picture, of values up to 2^17.
    vector : (float, float)
        x, y; the nearest whole pixels count.
    usable : bool array (H, W), optional
        Pixels that count; all by default.

    Returns
    -------
    float
        Up to 1; 0 where nothing is left to compare, or all is one color.

    Examples
    --------
    >>> stripes = np.tile(np.uint8([10, 10, 30, 30]), (8, 8))[..., None]
    >>> like_itself(stripes, (4, 0)), like_itself(stripes, (2.2, 0)), like_itself(stripes, (40, 0))
    (1.0, -1.0, 0.0)
    """
    x, y = (round(part) for part in vector)
    height, width = values.shape[:2]
    if abs(y) >= height or abs(x) >= width:
        return 0.0
    first = (slice(max(0, -y), height - max(0, y)), slice(max(0, -x), width - max(0, x)))
    second = (slice(max(0, y), height - max(0, -y)), slice(max(0, x), width - max(0, -x)))
    here, there = values[first].astype(np.int64), values[second].astype(np.int64)
    if usable is None:
        here, there = (part.reshape(-1, values.shape[2]) for part in (here, there))
    else:
        both = usable[first] & usable[second]
        here, there = here[both], there[both]
    if not len(here):
        return 0.0
    together = _variance(here, here) + _variance(there, there)
    return 2 * _variance(here, there) / together if together else 0.0


def detail(pixels: NDArray[np.integer]) -> Values:
    """49 times what differs from the mean of 7x7 pixels (H - 6, W - 6, 1), all channels summed."""
    values = pixels.sum(axis=2, dtype=np.int64)
    fine: Values = 49 * values[3:-3, 3:-3] - box_sums(values, 7, 7)
    return fine[..., None]


def _variance(first: Values, second: Values) -> int:
    """The covariance of (N, K), summed over K, times N squared; it may pass 64 bits."""
    sums = [int(a) * int(b) for a, b in zip(first.sum(axis=0), second.sum(axis=0), strict=True)]
    return len(first) * int((first * second).sum()) - sum(sums)
