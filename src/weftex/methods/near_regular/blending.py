"""Joining blocks by blending (section 4.2.3)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.methods.near_regular.blocks import Plan
from weftex.methods.near_regular.layout import Axis
from weftex.raster.arrays import Floats
from weftex.results.patches import PatchSynthesis


class Joints(NamedTuple):
    """How the visible blocks are pasted over each other, see `PatchSynthesis`."""

    zones: NDArray[np.int64]  # (rows, columns): the weights of each block
    weights: NDArray[np.uint16]  # (zones, lines, columns), in 1/256


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
    return Joints(zones, np.stack(weights))


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


def _weights(row: tuple[int, Floats], column: tuple[int, Floats]) -> NDArray[np.uint16]:
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
    return np.rint(256 * own / np.where(own > 0, before, 1)).astype(np.uint16)


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
    facts: dict[str, Any] = {"seed": layout.seed}
    if any(layout.origin):
        facts["origin"] = list(layout.origin)
    if any(layout.canvas.wrap):
        facts["strain"] = round(layout.lattice.strain, 6)
    if 2 * layout.half_border < method.border_width:  # blocks of a small canvas that wraps
        facts["border_narrowed_to"] = 2 * layout.half_border
    return PatchSynthesis(
        layout.canvas,
        table[order].astype(np.int32),
        joints.weights,
        np.zeros((0, 0), np.uint16),
        exemplar=sample.exemplar,
        provenance=provenance | facts,
    )
