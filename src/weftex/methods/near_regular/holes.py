"""Holes: which blocks fill one, and what is known around it.

All blocks beside a hole go on with the known pixels, drawn ones too: they take the piece that fits
those best, and only blocks in the midst of a hole are random.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.errors import InvalidInputError
from weftex.methods.near_regular.sample import shuffled
from weftex.raster.masks import grown
from weftex.search.boundary_zone import runs_over

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.near_regular.layout import Layout
    from weftex.methods.near_regular.sample import BlockSample
    from weftex.methods.near_regular.settings import Settings

_HOLE, _BESIDE, _OFF = 0, 1, 2  # the seam kernels' states of a pixel
_KNOWN = 5  # the gap kernels' wedge of pixels that are known


@dataclass(frozen=True, eq=False)
class Hole:
    """The blocks that fill a hole, and what is known around it; without a hole, all blocks.

    Attributes
    ----------
    missing : bool array (H, W) or (0, 0)
        True in the hole.
    near : bool array (H, W) or (0, 0)
        Known pixels that count: as near to the hole as a border is wide.
    known : uint8 array (H, W, K) or (0, 0, 0)
        The canvas's pixels.
    state : uint8 array (H, W) or (0, 0)
        0 in the hole, 1 beside it, 2 off it.
    laid : bool array (rows, columns)
        Blocks that have some of the hole in their windows.
    bound : bool array (rows, columns)
        Those of them that would be drawn but see known pixels, so that they are not random.
    drawn : bool array (rows, columns)
        Those that are random.
    """

    missing: NDArray[np.bool_]
    near: NDArray[np.bool_]
    known: NDArray[np.uint8]
    state: NDArray[np.uint8]
    laid: NDArray[np.bool_]
    bound: NDArray[np.bool_]
    drawn: NDArray[np.bool_]

    @property
    def is_there(self) -> bool:
        """Whether there is a hole."""
        return self.missing.size > 0

    def border_of(
        self, settings: Settings, sample: BlockSample, layout: Layout, i: int, j: int
    ) -> tuple[NDArray[np.uint8], NDArray[np.int32], NDArray[np.uint8]]:
        """The border of a block: that of a gap, in the hole, and all known pixels around.

        Returns
        -------
        wedges, runs
            See `BlockSample.border`; the wedge of known pixels is 5.
        known : uint8 array (rows, columns, K)
            The border's pixels, as far as they are known.
        """
        height, width = int(layout.rows.sizes[i]), int(layout.columns.sizes[j])
        wedges, runs = sample.border(height, width, settings.margin, layout.reach)
        if not self.is_there:
            return wedges, runs, np.zeros((*wedges.shape, sample.pixels.shape[2]), np.uint8)
        wedges = wedges.copy() if layout.gap[i, j] else np.zeros_like(wedges)
        y, inside = layout.rows.lines(i, wedges.shape[0])
        x, within = layout.columns.lines(j, wedges.shape[1])
        there, at = inside[:, None] & within, np.ix_(y, x)
        wedges[~there | ~self.missing[at]] = 0
        wedges[there & self.near[at]] = _KNOWN
        return wedges, shuffled(runs_over(wedges > 0)), np.ascontiguousarray(self.known[at])


def find_hole(settings: Settings, sample: BlockSample, layout: Layout) -> Hole:
    """Say which blocks fill the canvas's hole, and what is known around it.

    Raises
    ------
    InvalidInputError
        If the sample has no whole piece for a block that fills a hole.
    """
    canvas = layout.canvas
    if canvas.known is None or canvas.hole is None:
        none = np.zeros((0, 0), np.uint8)
        missing, nowhere = none.astype(bool), np.zeros_like(layout.gap)
        return Hole(
            missing, missing, none[..., None], none, layout.shown, nowhere, drawn=~layout.gap
        )
    missing = canvas.hole
    near = grown(missing, 2 * settings.margin or 1, canvas.wrap) & ~missing
    state = np.where(missing, _HOLE, _OFF).astype(np.uint8)
    state[grown(missing, 1, canvas.wrap) & ~missing] = _BESIDE
    known = np.ascontiguousarray(sample.exemplar.as_known(canvas.known))
    laid = _seen(layout, missing)
    if not settings.unconstrained:
        _check(settings, sample, layout, laid)
    bound = laid & ~layout.gap & _seen(layout, near)
    return Hole(missing, near, known, state, laid, bound, laid & ~layout.gap & ~bound)


def _seen(layout: Layout, mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which blocks have some of these pixels in their windows."""
    result = np.zeros(layout.bits.shape, bool)
    for i in range(layout.rows.shown.start, layout.rows.shown.stop):
        y, inside = layout.rows.lines(i)
        row: NDArray[np.bool_] = np.any(mask[y[inside]], axis=0)
        for j in range(layout.columns.shown.start, layout.columns.shown.stop):
            x, within = layout.columns.lines(j)
            result[i, j] = row[x[within]].any()
    return result


def _check(
    settings: Settings, sample: BlockSample, layout: Layout, laid: NDArray[np.bool_]
) -> None:
    """Refuse a hole for a block of which the sample has no whole piece."""
    for i, j in np.argwhere(laid).tolist():
        if not _whole(sample, (layout.phase[i, j] + sample.steps + 2**15) >> 16).any():
            y, x = max(int(layout.rows.edges[i]), 0), max(int(layout.columns.edges[j]), 0)
            side, name = settings.side, sample.exemplar.name
            raise InvalidInputError(
                f"no whole piece of {side}x{side} pixels that the lattice leads to from x {x}, "
                f"y {y} lies on usable pixels of {name}; make block_size and border_width "
                "smaller, cover less with the mask, or give a sample to fill it from"
            )


def _whole(sample: BlockSample, places: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether whole windows lie at these places."""
    windows = sample.windows
    if windows.period[2]:
        places = places % windows.period[2:]
    inside: NDArray[np.bool_] = np.all((places >= 0) & (places < windows.usable.shape), axis=-1)
    inside[inside] = windows.usable[places[inside, 0], places[inside, 1]] > 0
    return inside


def known_places(sample: BlockSample, layout: Layout, hole: Hole) -> NDArray[np.int32]:
    """Places of blocks beside a hole that are part of the sample: they are not shown again.

    Returns
    -------
    int32 array (rows, columns)
        -1 everywhere else.
    """
    result = np.full(layout.bits.shape, -1, np.int32)
    if not hole.is_there or layout.canvas.known_from is None:
        return result
    beside = grown(hole.laid, 1, (layout.rows.period > 0, layout.columns.period > 0)) & ~hole.laid
    cells = np.argwhere(beside)
    place = np.stack([layout.rows.edges[cells[:, 0]], layout.columns.edges[cells[:, 1]]], axis=1)
    place += np.array(layout.canvas.known_from) - layout.rows.margin
    windows = sample.windows
    there = _whole(sample, place)
    if windows.period[2]:
        place = place % windows.period[2:]
    flat = place[:, 0] * windows.pixels.shape[1] + place[:, 1]
    result[cells[there, 0], cells[there, 1]] = flat[there]
    return result
