"""Joining blocks: seams of least error, or blending (section 4.2.3)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.methods.near_regular import edge_kernels as kernels
from weftex.methods.near_regular.blocks import Plan
from weftex.methods.near_regular.layout import Axis
from weftex.results.patches import PatchSynthesis

_AT_A_TIME = 32  # edges that a thread cuts


class Joints(NamedTuple):
    """How the visible blocks are pasted over each other, see `PatchSynthesis`."""

    cuts: NDArray[np.uint16]  # (rows, columns, n) or (0, 0)
    zones: NDArray[np.int64]  # (rows, columns): the weights of each block
    weights: NDArray[np.uint16]  # (zones, lines, columns), in 1/256


class _Cutter:
    """Cuts the blocks of one output: runs the kernels over corners and edges, in threads."""

    def __init__(self, plan: Plan, sources: NDArray[np.int32]) -> None:
        self.plan, self.sources, layout = plan, sources, plan.layout
        self.reach, self.side = layout.reach, layout.rows.side
        self.inset = layout.rows.margin - self.reach  # of the outermost seam, in a window
        least = min(int(axis.sizes.min()) for axis in (layout.rows, layout.columns))
        self.slack = min(self.reach // 2, (least - 1) // 4)  # that corners move, at most

    def _band(self) -> kernels.Band:
        lines, depth = self.side, 2 * self.reach
        return kernels.Band(
            np.empty((lines, depth), np.int64),
            np.empty((lines, depth + 1), np.int64),
            np.empty((lines, depth + 1), np.int32),
            np.empty(lines, np.int32),
        )

    def _each(self, work: Any, table: NDArray[np.void], found: NDArray[np.int32]) -> None:
        """Run a kernel over portions of a table, into the same rows of `found`."""
        parts = [slice(k, k + _AT_A_TIME) for k in range(0, len(table), _AT_A_TIME)]
        list(self.plan.each(lambda part: work(table[part], self._band(), found[part]), parts))

    def corners(self) -> NDArray[np.int32]:
        """How far from their vertex four blocks meet: (dy, dx) for (rows + 1, columns + 1)."""
        sample, layout = self.plan.sample, self.plan.layout
        up, down, above = _before_and_after(layout.rows)
        left, right, beside = _before_and_after(layout.columns)
        corners = np.zeros((len(up), len(left), 2), np.int32)
        if self.slack == 0:
            return corners
        # The blocks above to the left and below to the right are drawn, or the two others are.
        falls = (layout.rows.numbers[down][:, None] + layout.columns.numbers[right]) % 2 == 0
        one = np.where(falls, self.sources[np.ix_(up, left)], self.sources[np.ix_(up, right)])
        other = np.where(falls, self.sources[np.ix_(down, right)], self.sources[np.ix_(down, left)])
        there = (one >= 0) & (other >= 0)
        width, inset = sample.pixels.shape[1], self.inset
        one = one + (inset + above[:, None]) * width + inset + beside * falls
        other = other + inset * width + inset + beside * ~falls
        table = _table(there, one=one, other=other)
        found = np.zeros((len(table), 2), np.int32)
        still = sample.pixels, sample.visibility, self.slack
        self._each(lambda *work: kernels.find_corners(*still, *work), table, found)
        corners[there] = found
        return corners

    def paths(self, upright: bool, corners: NDArray[np.int32]) -> NDArray[np.int32]:
        """For each line of a window where its block begins, along the left or the upper edges.

        (rows, columns + 1, lines) for `upright` edges, else (columns, rows + 1, lines).
        """
        sample, layout, sources = self.plan.sample, self.plan.layout, self.sources
        along, across, step = layout.rows, layout.columns, (sample.pixels.shape[1], 1)
        if not upright:
            along, across, step = across, along, step[::-1]
            sources, corners = sources.T, corners.transpose(1, 0, 2)[..., ::-1]
        i = np.arange(along.visible.start, along.visible.stop)
        before, after, size = _before_and_after(across)
        one, other = sources[np.ix_(i, before)], sources[np.ix_(i, after)]
        start = corners[:-1, :, 0] + self.reach + self.inset
        stop = corners[1:, :, 0] + self.reach + self.inset + along.sizes[i][:, None]
        there = (one >= 0) & (other >= 0) & (stop > start)
        one = one + start * step[0] + (self.inset + size) * step[1]
        other = other + start * step[0] + self.inset * step[1]
        begin, end = corners[:-1, :, 1] + self.reach, corners[1:, :, 1] + self.reach
        table = _table(
            there, one=one, other=other, start=start, length=stop - start, begin=begin, end=end
        )
        found = np.empty((len(table), self.side), np.int32)
        still = sample.pixels, sample.visibility, upright
        self._each(lambda *work: kernels.cut_edges(*still, *work), table, found)
        paths = np.full((*there.shape, self.side), self.inset + self.reach, np.int32)
        paths[there] = found + self.inset
        return paths


def _before_and_after(axis: Axis) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """The blocks before and after each edge of visible blocks, and the sizes of those before."""
    edges = np.arange(axis.visible.start, axis.visible.stop + 1)
    before, after = ((edges + by) % len(axis.sizes) for by in (-1, 0))
    return before, after, axis.sizes[before]


def _table(there: NDArray[np.bool_], **columns: NDArray[Any]) -> NDArray[np.void]:
    """A table of vertices or edges as `edge_kernels` has them, of the places that are there."""
    table = np.empty(np.count_nonzero(there), [(name, np.int64) for name in columns])
    for name, column in columns.items():
        table[name] = np.broadcast_to(column, there.shape)[there]
    return table


def cut_seams(plan: Plan, sources: NDArray[np.int32]) -> Joints:
    """Cut blocks along the paths of least error through their overlaps (chapter 6)."""
    layout = plan.layout
    rows, columns = layout.rows.sizes[layout.visible[0]], layout.columns.sizes[layout.visible[1]]
    if layout.reach:
        cutter = _Cutter(plan, sources)
        corners = cutter.corners()
        upright, lying = cutter.paths(True, corners), cutter.paths(False, corners)
    else:
        upright = np.full((len(rows), len(columns) + 1, layout.rows.side), layout.rows.margin)
        lying = np.full((len(columns), len(rows) + 1, layout.rows.side), layout.rows.margin)
    left, right = upright[:, :-1], upright[:, 1:] + columns[:, None]
    top, bottom = lying[:, :-1], lying[:, 1:] + rows[:, None]
    left, right = _own(layout.rows, layout.columns, layout.reach, left, right)
    top, bottom = _own(layout.columns, layout.rows, layout.reach, top, bottom)
    cuts = [left, right, top.swapaxes(0, 1), bottom.swapaxes(0, 1)]
    shape = layout.rows.pasted(layout.reach)[0], layout.columns.pasted(layout.reach)[0]
    return Joints(
        np.concatenate(cuts, axis=2).astype(np.uint16),
        np.zeros((len(rows), len(columns)), np.int64),
        np.full((1, *shape), 128, np.uint16),
    )


def _own(
    along: Axis, across: Axis, reach: int, first: NDArray[Any], last: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """First and last own pixels of pasted lines, (along, across, lines); none off the canvas."""
    lines, begin = along.pasted(reach)
    most, before = across.pasted(reach)
    at = begin[:, None, None] + np.arange(lines)
    every = np.broadcast_to(at, (*first.shape[:2], lines))
    first, last = (
        np.clip(np.take_along_axis(cut, every, 2) - before[None, :, None], 0, most)
        for cut in (first, last)
    )
    if not along.period:
        line = along.edges[:-1][along.visible][:, None, None] - along.margin + at
        off = (line < 0) | (line >= along.length)
        first, last = np.where(off, most, first), np.where(off, 0, last)
    return first, last


def blend_linearly(plan: Plan) -> Joints:
    """Feather blocks over the blending area (section 4.2.3); one of no width pastes them."""
    method, layout = plan.method, plan.layout
    width = min(method.blend_width if method.blend == "feather" else 0, 2 * layout.reach)
    # Rows, and columns, of the same shares and parity blend alike.
    kinds, number = [], []
    for axis in (layout.rows, layout.columns):
        odd = axis.numbers[axis.visible] % 2
        profiles = np.column_stack([odd, _shares(width, layout.reach, axis)])
        found, which = np.unique(profiles, axis=0, return_inverse=True)
        kinds.append([(int(kind[0]), kind[1:]) for kind in found])
        number.append(which.ravel())
    weights = [_weights(row, column) for row in kinds[0] for column in kinds[1]]
    zones = number[0][:, None] * len(kinds[1]) + number[1]
    return Joints(np.zeros((0, 0), np.uint16), zones, np.stack(weights))


def _shares(width: int, reach: int, axis: Axis) -> NDArray[np.float64]:
    """Alpha of eqs. (4.9) and (4.10) from both sides of each visible block: (blocks, lines)."""
    sizes, edges = axis.sizes[axis.visible], axis.edges[:-1][axis.visible]
    lines, first = axis.pasted(reach)
    at = first[:, None] + np.arange(lines) - axis.margin
    x = at + width // 2 + 1  # of eq. (4.9), 1 at the first line that is blended
    share: NDArray[np.float64] = np.clip(x, 0, width + 1) / (width + 1)
    share -= np.clip(x - sizes[:, None], 0, width + 1) / (width + 1)
    line = edges[:, None] + at
    if not axis.period:
        share[(line < 0) | (line >= axis.length)] = 0
    return share


def _weights(
    row: tuple[int, NDArray[np.float64]], column: tuple[int, NDArray[np.float64]]
) -> NDArray[np.uint16]:
    """Weights in 1/256 that blend four kinds of blocks, one after the other (eqs. 4.6 to 4.8).

    Every corner of a block meets one block of each kind. A block's weight is its share over the sum
    of its own share and the shares of the blocks pasted before it.
    """
    before, kind = np.zeros((len(row[1]), len(column[1]))), 2 * (row[0] != column[0]) + row[0]
    for other in range(kind + 1):
        # Drawn ones of even rows, drawn ones of odd rows, gaps of even rows, of odd rows.
        odd_y, odd_x = other % 2, (other % 2 + other // 2) % 2
        y = row[1] if odd_y == row[0] else 1 - row[1]
        x = column[1] if odd_x == column[0] else 1 - column[1]
        own = np.outer(y, x)
        before = before + own
    result = np.rint(256 * own / np.where(own > 0, before, 1))
    return result.astype(np.uint16)


def paste_blocks(
    plan: Plan, sources: NDArray[np.int32], joints: Joints, provenance: dict[str, Any]
) -> PatchSynthesis:
    """Paste blocks by kind: drawn ones of even rows, of odd rows, then the gaps."""
    method, sample, layout, _ = plan
    rows, columns = layout.visible
    margin, (height, width) = layout.rows.margin, sample.exemplar.shape
    flat = sample.windows.to_sample(sources[layout.visible].ravel())
    y, x = np.divmod(flat.reshape(joints.zones.shape), width)
    v, u = layout.rows.pasted(layout.reach)[1][:, None], layout.columns.pasted(layout.reach)[1]
    placements = [
        (layout.rows.edges[:-1][rows][:, None] - margin + v) % layout.canvas.height,
        (layout.columns.edges[:-1][columns] - margin + u) % layout.canvas.width,
        (y + v) % height,
        (x + u) % width,
        joints.zones,
    ]
    table = np.stack([np.broadcast_to(p, y.shape) for p in placements], axis=-1).reshape(-1, 5)
    kind = 2 * layout.gap[layout.visible] + layout.rows.numbers[rows][:, None] % 2
    order = np.argsort(kind.ravel(), kind="stable")
    cuts = joints.cuts
    if cuts.ndim == 3:
        cuts = np.ascontiguousarray(cuts.reshape(kind.size, -1)[order])
    facts: dict[str, Any] = {"seed": layout.seed}
    if any(layout.origin):
        facts["origin"] = list(layout.origin)
    if any(layout.canvas.wrap):
        facts["strain"] = round(layout.lattice.strain, 6)
    if 2 * layout.half_border < method.border_width:  # blocks of a small canvas that wraps
        facts["border_narrowed_to"] = 2 * layout.half_border
    about: dict[str, Any] = {
        "sample_shape": sample.exemplar.shape,
        "exemplar": sample.exemplar,
        "provenance": provenance | facts,
    }
    pasted = layout.canvas, table[order].astype(np.int32), joints.weights, cuts
    return PatchSynthesis(*pasted, **about)
