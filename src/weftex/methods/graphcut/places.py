"""Places of patches, and what the ways to find them share (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from weftex.methods.graphcut.copies import Copy, copies_of
from weftex.methods.graphcut.draws import drawn_places
from weftex.notes import note

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from numpy.typing import NDArray

    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth


class Place(NamedTuple):
    """A box on the canvas, and the place in the sample of its upper left pixel."""

    top: int
    left: int
    height: int
    width: int
    source_top: int
    source_left: int
    price: float = 1.0  # by which the cost of its seam is multiplied for what it shows again


class Matches(NamedTuple):
    """How well each place of a copy of the sample matches."""

    costs: NDArray[np.float64]  # C(t): mean squared differences
    prices: NDArray[np.float64]  # by which they are multiplied for what is shown again
    allowed: NDArray[np.bool_]
    halvings: int  # of the copy


class Placement(Protocol):
    """A way to find places for patches."""

    size: tuple[int, int]  # height and width of a patch on this canvas, in pixels
    reduction: int  # how many times smaller the copies are that matches and cuts begin on

    def candidates(
        self, pixel: tuple[int, int], number: int, centered: bool, map_: Callable[..., Any] = map
    ) -> list[Place]:
        """Draw places for a patch, the `number`-th one, that covers a pixel (row, column).

        The pixel is in the middle of the patch if `centered`, else near its upper left corner.
        What does not need each other is looked at by `map_`, perhaps in threads.
        """


def sample_copies(settings: Settings, reduction: int) -> list[Copy]:
    """The sample and smaller copies."""
    return copies_of(Copy(settings.windows.pixels, settings.windows.usable), reduction)


def variance_of(copies: list[Copy]) -> float:
    """Variance of the sample, sigma**2, on the smallest of some copies that has a usable pixel."""
    return next(copy.variance for copy in reversed(copies) if copy.mask.any())


def draw_matches(
    settings: Settings,
    seed: int,
    number: int,
    matches: Matches,
    copies: list[Copy],
    size: tuple[int, int],
) -> list[tuple[int, int]]:
    """Draw places on a copy for the `number`-th patch, of a size in full pixels.

    They are drawn by P(t) = exp(-C(t) / (k sigma**2)), with the variance of the sample's copies.
    """
    costs, prices, allowed, k = matches
    spread = settings.tolerance * variance_of(copies[: k + 1])
    draws, on_copy = (seed, number, settings.candidates), tuple(n >> k for n in size)
    drawn = drawn_places(costs * prices, allowed, spread, draws, on_copy)
    note("matches", **matches._asdict(), drawn=drawn)
    return drawn


def on_copies(places: NDArray[np.uint8], copies: list[Copy]) -> list[NDArray[np.uint8]]:
    """Those of the places that a smaller copy has, for each."""
    result = []
    for k, copy in enumerate(copies):
        height, width = copy.mask.shape
        result.append(np.ascontiguousarray(places[:: 1 << k, :: 1 << k][:height, :width]))
    return result


def smallest(boxes: list[Copy], places: list[NDArray[np.uint8]]) -> int:
    """The smallest copy that has a place, and of the box whatever there is."""
    there = boxes[0].mask.any()
    return next(
        k
        for k in range(len(boxes) - 1, -1, -1)
        if places[k].any() and (boxes[k].mask.any() or not there)
    )


def size_on_canvas(patch_shape: tuple[int, int], growth: Growth) -> tuple[int, int]:
    """The patch's size; around a wrapped axis it leaves something that it can be joined to."""
    canvas = growth.canvas
    height, width = (
        min(side, max(1, 2 * n // 3) if wraps else n)
        for side, n, wraps in zip(patch_shape, canvas.shape, canvas.wrap, strict=True)
    )
    return height, width
