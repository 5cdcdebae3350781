"""The pieces that blocks show: drawn (section 4.2.1), and filled in between (section 4.2.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.near_regular import block_kernels, gap_kernels
from weftex.methods.near_regular.rows import ANY
from weftex.progress import Progress, ProgressCallback

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.near_regular.holes import Hole
    from weftex.methods.near_regular.layout import Layout
    from weftex.methods.near_regular.sample import BlockSample
    from weftex.methods.near_regular.settings import Settings

    Each = Callable[..., Iterable[Any]]
    Steps = Iterator[tuple[NDArray[np.int64], NDArray[np.int32]]]

_GAPS_AT_A_TIME = 32  # that a thread fills, at most


def draw_constrained_blocks(
    sample: BlockSample, layout: Layout, hole: Hole, place: NDArray[np.int32]
) -> NDArray[np.int32]:
    """Draw a similar place for every second block, one color after the other (section 4.2.1).

    Of four colors no block is near another of its own.

    Parameters
    ----------
    place : int32 array (rows, columns)
        Places of blocks that are there, as flat indices into the windows' pixels, -1 elsewhere.

    Returns
    -------
    int32 array (rows, columns)
        With those of the drawn blocks.
    """
    place = place.copy()
    i, j = layout.rows.numbers[:, None], layout.columns.numbers[None, :]
    color = (i + j) // 2 % 2 * 2 + (i - j) // 2 % 2
    bundle, grid = _kernel_sample(sample), layout.grid(place)
    for k in range(4):
        for steps, cells in _by_rows(sample, layout, np.argwhere(hole.drawn & (color == k))):
            block_kernels.draw_blocks(bundle, grid, steps, cells)
    return place


def fill_gaps(
    settings: Settings,
    sample: BlockSample,
    layout: Layout,
    hole: Hole,
    place: NDArray[np.int32],
    gaps: NDArray[np.bool_],
    stage: str,
    each: Each,
    callback: ProgressCallback | None,
) -> NDArray[np.int32]:
    """Choose for these blocks the pieces that fit what is there around them (section 4.2.2).

    Returns
    -------
    int32 array (rows, columns)
        The places with those of the gaps.
    """
    place, cells = place.copy(), np.argwhere(gaps).astype(np.int32)
    bundle, grid = _kernel_sample(sample), layout.grid(place)
    # What the canvas knows is not a border that all windows were described by.
    search = None if hole.is_there else sample.search
    rule = gap_kernels.Rule(
        settings.tolerance, settings.candidates, round(256 * settings.variety),
        settings.match == "gncc", search and search.kernel,
    )  # fmt: skip
    progress = Progress(callback, len(cells), stage, lambda: layout.preview(sample, place))

    def fill(own: NDArray[np.int32]) -> int:
        wedges, runs, known = hole.border_of(settings, sample, layout, *own[0].tolist())
        numbers = search.zone.blocks.size // 2 * known.shape[2] if search else 0
        gap = gap_kernels.Gap(
            wedges,
            runs,
            known,
            query=np.empty(np.count_nonzero(wedges) * known.shape[2], np.uint8),
            means=np.empty(numbers, np.int32),
            coordinates=np.empty(len(search.pca.basis) if search else 0, np.int16),
            wanted=settings.candidates,
            keys=np.empty(settings.candidates, np.int64),
            places=np.empty(settings.candidates, np.int32),
            partial=np.empty(sample.pixels.shape[1], np.int32),
            total=np.empty(sample.pixels.shape[1], np.int64),
        )
        for steps, of_rows in _by_rows(sample, layout, own):
            gap_kernels.fill_gaps(bundle, grid, steps, of_rows, rule, gap)
        return len(own)

    for done in each(fill, list(_alike(layout, hole, cells))):
        progress.advance(done)
    return place


def _alike(layout: Layout, hole: Hole, cells: NDArray[np.int32]) -> Iterator[NDArray[np.int32]]:
    """Gaps that have the same border, so many that a thread fills at a time."""
    if hole.is_there:
        yield from (cells[k : k + 1] for k in range(len(cells)))
        return
    most = min(_GAPS_AT_A_TIME, len(cells) // 8 + 1)
    heights, widths = layout.rows.sizes[cells[:, 0]], layout.columns.sizes[cells[:, 1]]
    for height in np.unique(heights).tolist():
        for width in np.unique(widths).tolist():
            own = np.ascontiguousarray(cells[(heights == height) & (widths == width)])
            yield from (own[k : k + most] for k in range(0, len(own), most))


def _by_rows(sample: BlockSample, layout: Layout, cells: NDArray[Any]) -> Steps:
    """Steps that lead to the rows of the sample that blocks are to show, and these blocks."""
    cells = np.ascontiguousarray(cells, np.int32)
    if layout.row is None:
        yield sample.steps, cells
        return
    row = layout.row[cells[:, 0], cells[:, 1]]
    for number in np.unique(row).tolist():
        own = sample.multiples == number if number != ANY else slice(None)
        yield np.ascontiguousarray(sample.steps[own]), np.ascontiguousarray(cells[row == number])


def _kernel_sample(sample: BlockSample) -> block_kernels.Sample:
    """The sample as kernels take it."""
    windows = sample.windows
    return block_kernels.Sample(
        sample.pixels, sample.turned, windows.usable, windows.period, windows.centers
    )
