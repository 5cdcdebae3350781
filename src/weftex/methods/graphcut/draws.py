"""Drawing places by how well they match (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.graphcut.match_kernels import best_places
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
    several, near = draw(seed, "patch", number, np.arange(count)), [n // _APART for n in size]
    if spread <= 0:
        left = np.ascontiguousarray(np.where(allowed, costs, np.inf))
        places = np.empty((count, 2), np.int32)
        many = best_places(left, several, tuple(near), places) if left.size else 0
        return [(y, x) for y, x in places[:many].tolist()]
    chances = np.where(allowed, chances_of(costs, allowed, spread), 0)
    found: list[tuple[int, int]] = []
    for bits in several:
        at = _by_chance(chances, int(bits))
        if at is None:
            break
        y, x = divmod(at, chances.shape[1])
        found.append((y, x))
        rows, columns = (
            slice(max(middle - reach, 0), middle + reach + 1)
            for middle, reach in zip((y, x), near, strict=True)
        )
        chances[rows, columns] = 0
    return found


def _by_chance(chances: NDArray[np.int64], bits: int) -> int | None:
    """A place, flat, in proportion to the chances; None where there is none."""
    sums = chances.ravel().cumsum()
    if not sums[-1]:
        return None
    return int(sums.searchsorted(bits % int(sums[-1]), side="right"))


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
