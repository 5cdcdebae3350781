"""The source window of each block: drawn (section 4.2.1), or fitted into a gap (section 4.2.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.methods.near_regular import block_kernels as kernels
from weftex.methods.near_regular.layout import ANY, Layout
from weftex.methods.near_regular.sample import BlockSample
from weftex.progress import Progress, ProgressCallback
from weftex.raster.arrays import Indices, Ints

_GAPS_AT_A_TIME = 32  # that a thread fills, at most
_SIMILAR = 6  # windows around which a gap searches; the paper searches around all
_DRAWN_NEAR = [(-2, 0), (-1, -1), (-1, 1), (0, -2), (0, 2), (1, -1), (1, 1), (2, 0)]
#: As `block_kernels` has them.
_BLOCK_FIELDS = ("index", "phase_y", "phase_x", "height", "width", "first", "fallback")
_BLOCK = np.dtype([(name, np.int64) for name in _BLOCK_FIELDS])
_NEAR = np.dtype([(name, np.int64) for name in ("index", "dy", "dx")])
_NEIGHBORS = [(-1, 0), (0, -1), (1, 0), (0, 1)]


class Plan(NamedTuple):
    """What every step of one output needs: the resolved method, the sample and the blocks.

    `each` maps a function over items, in threads.
    """

    method: Any
    sample: BlockSample
    layout: Layout
    each: Callable[..., Iterable[Any]]


def draw_constrained_blocks(plan: Plan) -> Indices:
    """Return sources (rows, columns): similar windows drawn for every second block, else -1.

    Of four colors, one after the other, no block is near another of its own color.
    """
    layout, sample = plan.layout, plan.sample.windows.kernel
    sources = np.full(layout.bits.shape, -1, np.int32)
    i, j = layout.rows.numbers[:, None], layout.columns.numbers[None, :]
    color = (i + j) // 2 % 2 * 2 + (i - j) // 2 % 2
    for k in range(4):
        for offsets, cells in _with_offsets(plan, np.argwhere(~layout.gap & (color == k))):
            tables = _tables(plan, cells, len(offsets), _DRAWN_NEAR)
            kernels.draw_blocks(sample, offsets, *tables, sources.reshape(-1))
    return sources


def fill_gaps(plan: Plan, sources: Indices, callback: ProgressCallback | None) -> Indices:
    """Return `sources` with the windows that best fit the borders of the gaps (section 4.2.2)."""
    method, sample, layout, each = plan
    sources, kernel = sources.copy(), sample.windows.kernel
    rule = method.tolerance, method.match == "gncc"
    count = kernels.ALL_SIMILAR if method.defaults == "paper" else _SIMILAR
    gaps = len(layout.visible_gaps)
    progress = Progress(callback, gaps, "gaps", lambda: layout.preview(sample, sources))

    def fill(portion: tuple[NDArray[Any], ...]) -> int:
        offsets, blocks, near = portion
        height, width = blocks["height"][0], blocks["width"][0]
        size, pieces, runs = sample.border(height, width, method.margin, layout.half_border)
        border = np.empty((size, sample.pixels.shape[2]), np.uint8)
        best = np.empty(count, np.int64), np.empty(count, np.int32)
        same = kernels.Gaps(kernel, pieces, runs, *rule, (border, *best))
        kernels.fill_gaps(same, offsets, blocks, near, sources.reshape(-1))
        return len(blocks)

    for done in each(fill, list(_portions(plan, layout.visible_gaps))):
        progress.advance(done)
    return sources


def _portions(plan: Plan, cells: Ints) -> Iterator[tuple[NDArray[Any], ...]]:
    """Gaps of one size, for a thread: offsets, and tables of blocks."""
    most = min(_GAPS_AT_A_TIME, len(cells) // 8 + 1)
    for offsets, found in _with_offsets(plan, cells):
        blocks, near = _tables(plan, found, len(offsets), _NEIGHBORS)
        height, width = blocks["height"], blocks["width"]
        order = np.lexsort((width, height))
        changes = np.flatnonzero(np.diff(height[order]) | np.diff(width[order])) + 1
        for own in np.split(order, changes):
            for part in (own[k : k + most] for k in range(0, len(own), most)):
                yield offsets, blocks[part], near[part]


def _with_offsets(plan: Plan, cells: Ints) -> Iterator[tuple[Ints, Ints]]:
    """Offsets to the rows of the sample that blocks are to contain, and these blocks."""
    sample, row = plan.sample, plan.layout.row
    if row is None:
        yield sample.offsets, cells
        return
    row = row[cells[:, 0], cells[:, 1]]
    for number in np.unique(row).tolist():
        own = sample.multiples == number
        if number == ANY or not own.any():
            own[:] = True
        yield np.ascontiguousarray(sample.offsets[own]), cells[row == number]


def _tables(
    plan: Plan, cells: Ints, offsets: int, near: list[tuple[int, int]]
) -> tuple[NDArray[np.void], NDArray[np.void]]:
    """Blocks, and the blocks `near` each of them, as `block_kernels` takes them."""
    layout, centers = plan.layout, plan.sample.windows.centers
    i, j = cells.T
    bits, columns = layout.bits[i, j], layout.bits.shape[1]
    blocks, around = np.empty(len(cells), _BLOCK), np.empty((len(cells), len(near)), _NEAR)
    blocks["index"] = i * columns + j
    blocks["phase_y"], blocks["phase_x"] = layout.phase[i, j].T
    blocks["height"], blocks["width"] = layout.rows.sizes[i], layout.columns.sizes[j]
    blocks["first"] = bits % np.uint64(offsets)
    blocks["fallback"] = centers[(bits % np.uint64(len(centers))).astype(int)]
    i, j, (down, right) = i[:, None], j[:, None], np.array(near).T
    p, q = layout.rows.beside[down, i], layout.columns.beside[right, j]
    there = (p >= 0) & (q >= 0) & ((p != i) | (q != j))
    around["index"] = np.where(there, p * columns + q, -1)
    around["dy"] = layout.rows.apart[down, i]
    around["dx"] = layout.columns.apart[right, j]
    return blocks, around
