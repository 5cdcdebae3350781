"""The source window of each block: drawn (section 4.2.1), or fitted into a gap (section 4.2.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weftex.methods.near_regular import block_kernels as kernels
from weftex.methods.near_regular.rows import ANY
from weftex.progress import Progress, ProgressCallback

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.near_regular.holes import Hole
    from weftex.methods.near_regular.layout import Layout
    from weftex.methods.near_regular.sample import BlockSample

_GAPS_AT_A_TIME = 32  # that a thread fills, at most
_MOST_COMPARED = 512  # similar windows that a gap is compared with
_MOST_DRAWN = 2048  # windows that it is compared with in the unconstrained mode
_PART, _ALL = 1024, 2**62  # pixels of the border that similar windows are compared by
_DRAWN_NEAR = [(-2, 0), (-1, -1), (-1, 1), (0, -2), (0, 2), (1, -1), (1, 1), (2, 0)]
_NEIGHBORS = [(-1, 0), (0, -1), (1, 0), (0, 1)]


class Plan(NamedTuple):
    """What every step of one output needs: the resolved method, the sample, the blocks, the hole.

    `each` maps a function over items, in threads.
    """

    method: Any
    sample: BlockSample
    layout: Layout
    hole: Hole
    each: Callable[..., Iterable[Any]]


def draw_constrained_blocks(plan: Plan, sources: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return `sources` with a similar window drawn for every second block (section 4.2.1).

    Of four colors, one after the other, no block is near another of its own color.
    """
    sources, sample = sources.copy(), plan.sample.kernel
    flat = sources.reshape(-1)
    i, j = plan.layout.rows.numbers[:, None], plan.layout.columns.numbers[None, :]
    color = (i + j) // 2 % 2 * 2 + (i - j) // 2 % 2
    for k in range(4):
        for offsets, cells in _with_offsets(plan, np.argwhere(plan.hole.drawn & (color == k))):
            kernels.draw_blocks(
                sample, offsets, *_tables(plan, cells, len(offsets), _DRAWN_NEAR), flat
            )
    return sources


def fill_gaps(
    plan: Plan,
    sources: NDArray[np.int32],
    gaps: NDArray[np.bool_],
    stage: str,
    callback: ProgressCallback | None,
) -> NDArray[np.int32]:
    """Return `sources` with the windows that best fit the borders of these gaps (section 4.2.2)."""
    method, sample, layout, hole, each = plan
    sources, kernel = sources.copy(), sample.kernel
    most, pixels = (_MOST_DRAWN, _PART) if method.unconstrained else (_MOST_COMPARED, _ALL)
    rule = method.tolerance, most, round(256 * method.variety), method.match == "gncc"
    count = int(np.count_nonzero(gaps))
    progress = Progress(callback, count, stage, lambda: layout.preview(sample, sources))

    def fill(portion: tuple[NDArray[np.int64], ...]) -> int:
        cells, offsets, blocks, near = portion
        border = hole.border_of(method, sample, layout, *cells[0].tolist())
        if method.unconstrained and not len(border[1]):
            sources.reshape(-1)[blocks[:, 0]] = blocks[:, 6]
            return len(cells)
        query = np.empty(np.count_nonzero(border[0]) * border[2].shape[2], np.uint8)
        best = np.empty(method.candidates, np.int64), np.empty(method.candidates, np.int32)
        few = int(np.searchsorted(border[1][:, 2].cumsum(), pixels)) + 1
        same = kernels.Gaps(kernel, border, few, rule, query, *best)
        kernels.fill_gaps(same, offsets, blocks, near, sources.reshape(-1))
        return len(cells)

    for done in each(fill, list(_portions(plan, np.argwhere(gaps)))):
        progress.advance(done)
    return sources


def _portions(plan: Plan, cells: NDArray[np.int64]) -> Iterator[tuple[NDArray[np.int64], ...]]:
    """Gaps that have the same border, for a thread: cells, offsets, and tables of blocks."""
    most = 1 if plan.hole.exists else min(_GAPS_AT_A_TIME, len(cells) // 8 + 1)
    for offsets, found in _with_offsets(plan, cells):
        blocks, near = _tables(plan, found, len(offsets), _NEIGHBORS)
        # By size: columns 3 and 4 are the height and the width.
        order = np.lexsort((blocks[:, 4], blocks[:, 3]))
        changes = np.flatnonzero(np.diff(blocks[order, 3:5], axis=0).any(axis=1)) + 1
        for own in np.split(order, changes):
            for part in (own[k : k + most] for k in range(0, len(own), most)):
                yield found[part], offsets, blocks[part], near[part]


def _with_offsets(
    plan: Plan, cells: NDArray[np.int64]
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
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
    plan: Plan, cells: NDArray[np.int64], offsets: int, near: list[tuple[int, int]]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Blocks, and the blocks `near` each of them, as `block_kernels` takes them."""
    layout, centers = plan.layout, plan.sample.windows.centers
    i, j = cells.T
    bits, phase = layout.bits[i, j], layout.phase[i, j]
    columns = layout.bits.shape[1]
    if plan.method.unconstrained:
        phase = np.zeros_like(phase)
    blocks = [i * columns + j, *phase.T, layout.rows.sizes[i], layout.columns.sizes[j]]
    blocks += [bits % np.uint64(offsets), centers[(bits % np.uint64(len(centers))).astype(int)]]
    i, j, (down, right) = i[:, None], j[:, None], np.array(near).T
    p, q = layout.rows.beside[down, i], layout.columns.beside[right, j]
    there = (p >= 0) & (q >= 0) & ((p != i) | (q != j))
    away = layout.rows.apart[down, i], layout.columns.apart[right, j]
    around = np.stack([np.where(there, p * columns + q, -1), *away], axis=2)
    return np.stack([b.astype(np.int64) for b in blocks], axis=1), around
