"""Warps of gaps: their pieces bent so that they meet the blocks around them (chapter 6)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.near_regular import warp_kernels as kernels
from weftex.raster.boxes import extended_sums
from weftex.results import warp_kernels as result_kernels
from weftex.results.paste_kernels import View

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.near_regular.layout import Layout
    from weftex.methods.near_regular.sample import BlockSample
    from weftex.methods.near_regular.settings import Settings

_SPACING = 10  # px between the places of a side that are shifted, about
_MOST_PLACES = 8  # of them, and 1
_HALF = 8  # px around such a place that count
_AROUND = 4  # px that a pixel's surroundings reach
_GAPS_AT_A_TIME = 16  # that a thread looks at


@dataclass(frozen=True, eq=False)
class Warps:
    """How the gaps of one output are warped.

    Attributes
    ----------
    nodes : int16 array (rows, columns, n, n, 2)
        Shifts of each block, see `weftex.results.warp_kernels`.
    warped : bool array (rows, columns)
        The gaps that are.
    """

    nodes: NDArray[np.int16]
    warped: NDArray[np.bool_]

    def shown(
        self, sample: BlockSample, layout: Layout, place: NDArray[np.int32], rows: list[int]
    ) -> tuple[NDArray[np.uint8], NDArray[np.uint16], NDArray[np.int32]]:
        """The sample with the warped pieces of these rows of blocks below it, for seams.

        Returns
        -------
        pixels : uint8 array (rows, columns, K)
        visibility : uint16 array (rows, columns)
            Of warped pieces as if they were not.
        place : int32 array
            Places of all blocks, in these pixels.
        """
        place, side = place.copy(), layout.rows.side
        height, width, channels = sample.pixels.shape
        cells = [(i, int(j)) for i in rows for j in np.flatnonzero(self.warped[i])]
        pixels = np.empty((height + side * len(cells), width, channels), np.uint8)
        pixels[:height] = sample.pixels
        visibility = np.ones(pixels.shape[:2], np.uint16)
        visibility[:height] = sample.visibility
        for k, (i, j) in enumerate(cells):
            top = height + side * k
            y, x = divmod(int(place[i, j]), width)
            about = (0, 0, layout.rows.sizes[i], layout.columns.sizes[j], layout.rows.margin)
            warps = result_kernels.Warps(self.nodes[i, j][None], np.array([about], np.int32))
            piece = pixels[top : top + side]
            result_kernels.warp_into(piece, sample.pixels, y, x, side, warps, 0, View(0, 0, 1, 0))
            visibility[top : top + side, :side] = sample.visibility[y : y + side, x : x + side]
            place[i, j] = top * width
        return pixels, visibility, place

    def of(
        self, layout: Layout, order: NDArray[np.int64], row: NDArray[Any], column: NDArray[Any]
    ) -> tuple[NDArray[np.int16], NDArray[np.int32]]:
        """Warps of the gaps among these patches, and where in their windows those begin.

        Parameters
        ----------
        order : int array (n,)
            Flat indices of blocks among those that show.
        row, column : int array
            For each of those, the first line and column of its window that is laid.
        """
        rows, columns = layout.rows.shown, layout.columns.shown
        order = order[layout.gap[rows, columns].ravel()[order]]
        at = np.unravel_index(order, row.shape)
        i, j = at[0] + rows.start, at[1] + columns.start
        sizes = layout.rows.sizes[i], layout.columns.sizes[j]
        margin = np.full(len(order), layout.rows.margin)
        within = np.stack([row[at], column[at], *sizes, margin], axis=1)
        return self.nodes[i, j], np.ascontiguousarray(within, np.int32)


def warp_gaps(
    settings: Settings,
    sample: BlockSample,
    layout: Layout,
    place: NDArray[np.int32],
    gaps: NDArray[np.bool_],
    each: Callable[..., Iterable[Any]],
) -> Warps:
    """Find shifts of these gaps along their sides that bring them together with their neighbors."""
    limit = settings.warp
    last = min(max(settings.block_size // _SPACING, 1), _MOST_PLACES)
    nodes = np.zeros((*place.shape, last + 1, last + 1, 2), np.int16)
    warped = gaps & (place >= 0)
    half = min(_HALF, layout.reach)
    if half == 0:
        return Warps(nodes, warped)
    steps = range(-limit, limit + 1)
    shifts = sorted(
        ((a, b) for a in steps for b in steps), key=lambda s: (s[0] ** 2 + s[1] ** 2, s)
    )
    bundle = kernels.Warps(settings.margin, half, limit, np.array(shifts, np.int32), nodes)
    edges, grid = without_tone(sample.pixels), layout.grid(place)
    cells = np.ascontiguousarray(np.argwhere(warped), np.int32)

    def estimate(k: int) -> None:
        scratch = kernels.Scratch(
            np.empty(settings.side, np.int64),
            np.empty((last + 1, len(steps), len(steps)), np.int64),
            np.empty((4, last + 1, 2), np.int64),
            np.empty((4, last + 1, 2), np.int64),
        )
        kernels.estimate(edges, grid, cells[k : k + _GAPS_AT_A_TIME], bundle, scratch)

    list(each(estimate, range(0, len(cells), _GAPS_AT_A_TIME)))
    return Warps(nodes, warped)


def without_tone(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """How pixels differ from their surroundings: of two tiles of any colors, the joint.

    Parameters
    ----------
    pixels : uint8 array (H, W, K)

    Returns
    -------
    uint8 array (H, W, K)
        128 where a pixel is the mean of those around it.

    Examples
    --------
    >>> without_tone(np.full((2, 3, 1), 200, np.uint8)).ravel()
    array([128, 128, 128, 128, 128, 128], dtype=uint8)
    """
    mean = extended_sums(pixels, _AROUND) // (2 * _AROUND + 1) ** 2
    result: NDArray[np.uint8] = np.clip(128 + pixels.astype(np.int64) - mean, 0, 255).astype(
        np.uint8
    )
    return result
