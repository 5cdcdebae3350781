"""Drawing places by how well they match (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LARGEST_EXPONENT = 64.0  # e**-64 is no chance at all
_BEST_CHANCE = 2.0**32  # the chance of the best match, as a whole number
_APART = 32  # candidates lie more than 1/32 of a patch from each other


def drawn_places(
    costs: NDArray[np.float64],
    allowed: NDArray[np.bool_],
    spread: float,
    draws: tuple[int, int, int],
    size: tuple[int, ...],
) -> list[tuple[int, int]]:
    """Draw places by P(t), proportional to exp(-C(t) / (k * sigma**2)), not next to each other.

    Parameters
    ----------
    costs : float64 array (H, W)
        C(t); infinite where a place is none.
    allowed : bool array (H, W)
        The places to draw from.
    spread : float
        k * sigma**2; at 0 the best place is taken, then the best one that is left.
    draws : (int, int, int)
        Seed, the number of the patch, and how many places to draw.
    size : (int, int)
        Height and width of the patch; no two places are within 1/32 of it.

    Returns
    -------
    list of (row, column)
        Fewer where there are not so many.
    """
    seed, number, count = draws
    allowed = allowed & (costs < np.inf)
    if spread > 0:
        left = np.where(allowed, chances_of(costs, allowed, spread), 0)
    else:
        left = np.where(allowed, costs, np.inf)
    found: list[tuple[int, int]] = []
    for bits in draw(seed, "patch", number, np.arange(count)):
        at = _by_chance(left, int(bits)) if spread > 0 else _of_the_best(left, int(bits))
        if at is None:
            break
        y, x = divmod(at, left.shape[1])
        found.append((y, x))
        near_y, near_x = (length // _APART for length in size)
        around = np.s_[max(y - near_y, 0) : y + near_y + 1, max(x - near_x, 0) : x + near_x + 1]
        left[around] = 0 if spread > 0 else np.inf
    return found


def _by_chance(chances: NDArray[np.int64], bits: int) -> int | None:
    """A place, flat, in proportion to the chances; None where there is none."""
    sums = chances.ravel().cumsum()
    if not sums[-1]:
        return None
    return int(sums.searchsorted(bits % int(sums[-1]), side="right"))


def _of_the_best(costs: NDArray[np.float64], bits: int) -> int | None:
    """One of the places that cost least, flat; None where all costs are infinite."""
    least = costs.min()
    if least == np.inf:
        return None
    best = np.flatnonzero(costs == least)
    return int(best[bits % len(best)])


def chances_of(
    costs: NDArray[np.float64], allowed: NDArray[np.bool_], spread: float
) -> NDArray[np.int64]:
    """Whole numbers in proportion to exp(-cost / spread), of a spread above 0.

    exp(x) is taken as (1 + x / 1024)**1024, which every machine rounds alike.
    """
    above: NDArray[np.float64] = np.maximum(costs - costs[allowed].min(), 0)
    with np.errstate(over="ignore"):  # a spread may be the least number that there is
        power = 1 + np.minimum(above / spread, _LARGEST_EXPONENT) / 1024
    for _ in range(10):
        power *= power
    return np.asarray(_BEST_CHANCE / power, np.int64)


def variance(pixels: NDArray[np.uint8]) -> float:
    """Variance of pixels (N, K), all channels together, from exact sums."""
    total = [int(k) for k in pixels.sum(axis=0, dtype=np.int64)]
    squares = sum(int(np.square(k, dtype=np.int64).sum()) for k in pixels.T)
    count = len(pixels)
    return (count * squares - sum(t * t for t in total)) / (count * count)
