"""Candidate patches, and how they are drawn (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from weftex.canvas import MOST_WRAPPED, Canvas
from weftex.guides import Guiding
from weftex.methods.graphcut.sample import Level
from weftex.random import draw
from weftex.raster.arrays import Floats, Ints, Mask
from weftex.repeats.salience import SaliencePenalty

_LARGEST_EXPONENT = 64.0  # e**-64 is no chance at all
_BEST_CHANCE = 2.0**32  # the chance of the best match, as a whole number
_APART = 32  # candidates lie more than 1/32 of a patch from each other


class Patch(NamedTuple):
    """A box on the canvas, and the pixel of the sample at its upper left corner."""

    top: int
    left: int
    height: int
    width: int
    source_top: int
    source_left: int
    factor: float = 1.0  # for the cost of its seam, by what it repeats


class Matches(NamedTuple):
    """How well each offset matches on one level of the sample's pyramid."""

    costs: Floats  # C(t): mean squared differences
    factors: Floats  # of the repetition penalty
    allowed: Mask
    level: int  # 0: full size; each further one is half as large
    #: The patches of offsets that were drawn, found in full size; see `Placement.matches`.
    patches: Callable[[list[tuple[int, int]], Callable[..., Any]], list[Patch]]


class Placement(Protocol):
    """A way to find candidate patches."""

    size: tuple[int, int]  # height and width of a patch on this canvas, in pixels
    reduction: int  # how many times smaller the smallest level is
    levels: list[Level]  # of the sample
    penalty: SaliencePenalty | None
    guiding: Guiding | None

    def matches(
        self, pixel: tuple[int, int], number: int, centered: bool, map_: Callable[..., Any] = map
    ) -> Matches:
        """Match all offsets of the `number`-th patch, which is to cover a pixel of the canvas.

        The pixel is in the middle of the patch if `centered`, else near its upper left corner.
        `map_` may use threads.
        """


def draw_offsets(
    matches: Matches, placement: Placement, tolerance: float, draws: tuple[int, int, int]
) -> list[tuple[int, int]]:
    """Draw offsets by P(t), proportional to exp(-C(t) / (k sigma**2)), not next to each other.

    k is the tolerance; at 0 the best offset is taken, then the best one that is left. `draws`: the
    seed, the number of the patch, and how many offsets to draw. There may be fewer.
    """
    variances = (level.variance for level in reversed(placement.levels[: matches.level + 1])
                 if level.mask.any())  # fmt: skip
    near = [(n >> matches.level) // _APART for n in placement.size]
    costs = matches.costs * matches.factors
    return drawn_places(costs, matches.allowed, tolerance * next(variances), draws, near)


def drawn_places(
    costs: Floats, allowed: Mask, spread: float, draws: tuple[int, int, int], near: list[int]
) -> list[tuple[int, int]]:
    """Draw places by their costs over `spread`, k sigma**2; no two as near as that, in pixels."""
    seed, number, count = draws
    left = np.where(allowed, costs, np.inf)
    chances = chances_of(costs, left < np.inf, spread) if spread > 0 else None
    found: list[tuple[int, int]] = []
    for each in draw(seed, "patch", number, np.arange(count)):
        best = left.min(initial=np.inf)
        if best == np.inf:
            break
        likely = left == best if chances is None else chances * (left < np.inf)
        sums = likely.ravel().cumsum()
        if not sums[-1]:
            break
        at = int(sums.searchsorted(int(each) % int(sums[-1]), side="right"))
        found.append(divmod(at, left.shape[1]))
        rows, columns = (
            slice(max(middle - reach, 0), middle + reach + 1)
            for middle, reach in zip(found[-1], near, strict=True)
        )
        left[rows, columns] = np.inf
    return found


def chances_of(costs: Floats, allowed: Mask, spread: float) -> Ints:
    """Whole numbers in proportion to exp(-cost / spread), of a spread above 0.

    exp(x) is taken as (1 + x / 1024)**1024, which every machine rounds alike.
    """
    above: Floats = np.maximum(costs - costs[allowed].min(), 0)
    with np.errstate(over="ignore"):  # a spread may be the least number that there is
        power = 1 + np.minimum(above / spread, _LARGEST_EXPONENT) / 1024
    for _ in range(10):
        power *= power
    return np.asarray(_BEST_CHANCE / power, np.int64)


def size_on(canvas: Canvas, patch_shape: tuple[int, int]) -> tuple[int, int]:
    """The size of patches on a canvas; along a wrapped axis they leave something to join."""
    height, width = (
        min(side, max(1, int(MOST_WRAPPED * n)) if wraps else n)
        for side, n, wraps in zip(patch_shape, canvas.shape, canvas.wrap, strict=True)
    )
    return height, width
