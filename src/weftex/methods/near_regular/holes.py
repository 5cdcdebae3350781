"""Holes: the blocks that fill one, and the known pixels around it.

Blocks that see known pixels continue them, drawn blocks too: they get the window that fits best.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.methods.near_regular.sample import runs_of
from weftex.raster.masks import grown

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.near_regular.layout import Layout
    from weftex.methods.near_regular.sample import BlockSample

_KNOWN = 5  # the wedge of known pixels, beside those of the four neighbors
_HOLE, _BESIDE, _OFF = 0, 1, 2  # states of a pixel: beside are known pixels next to the hole


@dataclass(frozen=True, eq=False)
class Hole:
    """The blocks that fill a hole, and the known pixels around it; without a hole, all blocks."""

    missing: NDArray[np.bool_]  # (H, W), empty without a hole
    near: NDArray[np.bool_]  # known pixels within the width of a border around the hole
    known: NDArray[np.uint8]  # (H, W, K), the canvas's pixels
    filling: NDArray[np.bool_]  # (rows, columns): blocks with some of the hole in their windows
    bound: NDArray[np.bool_]  # of these that are not gaps, those that see known pixels
    drawn: NDArray[np.bool_]  # and the others

    @property
    def exists(self) -> bool:
        """Whether there is a hole."""
        return self.missing.size > 0

    def border_of(
        self, method: Any, sample: BlockSample, layout: Layout, i: int, j: int
    ) -> tuple[NDArray[np.uint8], NDArray[np.int32], NDArray[np.uint8]]:
        """A block's border: wedges, runs (see `Border`) and pixels, as far as they are known.

        It is that of a gap, inside the hole, and all known pixels around: wedge 5.
        """
        height, width = int(layout.rows.sizes[i]), int(layout.columns.sizes[j])
        wedges, runs = sample.border(height, width, method.margin, layout.reach)
        if not self.exists:
            return wedges, runs, np.zeros((*wedges.shape, sample.pixels.shape[2]), np.uint8)
        wedges = wedges.copy() if layout.gap[i, j] else np.zeros_like(wedges)
        y, inside = layout.rows.lines(i, wedges.shape[0])
        x, within = layout.columns.lines(j, wedges.shape[1])
        there, at = inside[:, None] & within, np.ix_(y, x)
        wedges[~there | ~self.missing[at]] = 0
        wedges[there & self.near[at]] = _KNOWN
        return wedges, runs_of(wedges > 0), np.ascontiguousarray(self.known[at])

    def around(self, layout: Layout, pad: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Known pixels and the states of pixels, padded for `seam_kernels` beyond the canvas."""
        known, wrap = self.known, layout.canvas.wrap
        state = np.where(self.missing, _HOLE, _OFF).astype(np.uint8)
        if not self.exists:
            return known, state
        state[grown(self.missing, 1, wrap) & ~self.missing] = _BESIDE
        for axis, wraps in enumerate(wrap):
            mode: Any = "wrap" if wraps else "edge"
            widths = [(pad * (axis == k), pad * (axis == k)) for k in range(3)]
            known = np.pad(known, widths, mode=mode)
            state = np.pad(state, widths[:2], mode=mode)
            if not wraps:
                lines = np.moveaxis(state, axis, 0)
                lines[:pad] = lines[-pad:] = _OFF
        return known, state


def find_hole(method: Any, sample: BlockSample, layout: Layout) -> Hole:
    """Find the blocks that fill the canvas's hole, and the known pixels around it.

    Raises `InvalidInputError` if the sample has no whole window for one of them.
    """
    canvas = layout.canvas
    filling = np.zeros_like(layout.gap)
    if canvas.known is None or canvas.hole is None:
        filling[layout.visible] = True
        none, nowhere = np.zeros((0, 0), bool), np.zeros_like(filling)
        return Hole(none, none, np.zeros((0, 0, 0), np.uint8), filling, nowhere, ~layout.gap)
    missing = canvas.hole
    near = grown(missing, 2 * method.margin or 1, canvas.wrap) & ~missing
    known = np.ascontiguousarray(sample.exemplar.as_known(canvas.known))
    filling = _seeing(layout, missing)
    if not method.unconstrained:
        _check(method, sample, layout, filling)
    bound = filling & ~layout.gap & _seeing(layout, near)
    return Hole(missing, near, known, filling, bound, filling & ~layout.gap & ~bound)


def _seeing(layout: Layout, mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which visible blocks have some of these pixels in their windows."""
    result = np.zeros(layout.bits.shape, bool)
    for i in range(layout.rows.visible.start, layout.rows.visible.stop):
        y, inside = layout.rows.lines(i)
        row: NDArray[np.bool_] = np.any(mask[y[inside]], axis=0)
        for j in range(layout.columns.visible.start, layout.columns.visible.stop):
            x, within = layout.columns.lines(j)
            result[i, j] = row[x[within]].any()
    return result


def _check(method: Any, sample: BlockSample, layout: Layout, filling: NDArray[np.bool_]) -> None:
    """Refuse a hole for a block of which the sample has no whole window."""
    for i, j in np.argwhere(filling).tolist():
        similar = (layout.phase[i, j] + sample.offsets + 2**15) >> 16
        if not sample.has_window(*similar.T).any():
            y, x = max(int(layout.rows.edges[i]), 0), max(int(layout.columns.edges[j]), 0)
            side, name = method.window_side, sample.exemplar.name
            raise InvalidInputError(
                f"no whole piece of {side}x{side} pixels that the lattice leads to from x {x}, "
                f"y {y} lies on usable pixels of {name}; make block_size and border_width "
                "smaller, cover less with the mask, or give a sample to fill it from"
            )


def known_sources(sample: BlockSample, layout: Layout, hole: Hole) -> NDArray[np.int32]:
    """Return sources (rows, columns) of known blocks beside a hole, if it is one of the sample.

    So blocks in the hole do not repeat what is beside it. All others are -1.
    """
    result = np.full(layout.bits.shape, -1, np.int32)
    if not hole.exists or layout.canvas.known_from is None:
        return result
    wrap = (layout.rows.period > 0, layout.columns.period > 0)
    i, j = np.nonzero(grown(hole.filling, 1, wrap) & ~hole.filling)
    y, x = (
        axis.edges[at] - axis.margin + known_from
        for axis, at, known_from in zip(
            (layout.rows, layout.columns), (i, j), layout.canvas.known_from, strict=True
        )
    )
    there, period = sample.has_window(y, x), sample.windows.period
    if period[2]:
        y, x = y % period[2], x % period[3]
    result[i[there], j[there]] = (y * sample.windows.pixels.shape[1] + x)[there]
    return result
