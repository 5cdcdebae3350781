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

    from weftex.methods.near_regular.layout import Layout
    from weftex.methods.near_regular.sample import BlockSample, Border, Features
    from weftex.methods.near_regular.settings import Settings

    Each = Callable[..., Iterable[Any]]
    Steps = Iterator[tuple[NDArray[np.int64], NDArray[np.int32]]]

_GAPS_AT_A_TIME = 32  # that a thread fills, at most


def draw_constrained_blocks(
    sample: BlockSample,
    layout: Layout,
    place: NDArray[np.int32] | None = None,
    among: NDArray[np.bool_] | None = None,
) -> NDArray[np.int32]:
    """Draw a similar place for every second block, one color after the other (section 4.2.1).

    Of four colors no block is near another of its own.

    Parameters
    ----------
    place : int32 array (rows, columns), optional
        Places of blocks that are there, -1 elsewhere.
    among : bool array (rows, columns), optional
        Draw these only; by default all but gaps.

    Returns
    -------
    int32 array (rows, columns)
        Flat indices into the windows' pixels; -1 where there is none yet.
    """
    place = np.full(layout.bits.shape, -1, np.int32) if place is None else place.copy()
    among = ~layout.gap if among is None else among
    i, j = layout.rows.numbers[:, None], layout.columns.numbers[None, :]
    color = (i + j) // 2 % 2 * 2 + (i - j) // 2 % 2
    bundle, grid = kernel_sample(sample), layout.grid(place)
    for k in range(4):
        for steps, cells in _by_rows(sample, layout, np.argwhere(among & (color == k))):
            block_kernels.draw_blocks(bundle, grid, steps, cells)
    return place


def fill_gaps(
    settings: Settings,
    sample: BlockSample,
    layout: Layout,
    place: NDArray[np.int32],
    each: Each,
    callback: ProgressCallback | None,
) -> NDArray[np.int32]:
    """Choose for each gap that shows the piece that fits its four neighbors (section 4.2.2).

    Returns
    -------
    int32 array (rows, columns)
        The places with those of the gaps.
    """
    place, cells = place.copy(), np.argwhere(layout.gap & layout.shown).astype(np.int32)
    bundle, grid = kernel_sample(sample), layout.grid(place)
    search = kernel_search(settings, sample.features)
    progress = Progress(callback, len(cells), "gaps", lambda: layout.preview(sample, place))
    centers = sample.windows.centers

    def fill(job: tuple[Border, NDArray[np.int32]]) -> int:
        border, gaps = job
        if settings.unconstrained and len(sample.features.blocks) == 0:  # no borders: any place
            i, j = gaps.T
            place[i, j] = centers[(layout.bits[i, j] % np.uint64(len(centers))).astype(np.int64)]
            return len(gaps)
        known = np.zeros((*border.wedges.shape, sample.pixels.shape[2]), np.uint8)
        gap = kernel_gap(settings, sample.features, border, known)
        for steps, own in _by_rows(sample, layout, gaps):
            gap_kernels.fill_gaps(bundle, grid, steps, own, search, gap)
        return len(gaps)

    for done in each(fill, list(_jobs(settings, sample, layout, cells))):
        progress.advance(done)
    return place


def _jobs(
    settings: Settings, sample: BlockSample, layout: Layout, cells: NDArray[np.int32]
) -> Iterator[tuple[Border, NDArray[np.int32]]]:
    """Gaps of one size, so many that a thread fills at a time, and their border."""
    most = min(_GAPS_AT_A_TIME, len(cells) // 8 + 1)
    heights, widths = layout.rows.sizes[cells[:, 0]], layout.columns.sizes[cells[:, 1]]
    for height in np.unique(heights).tolist():
        for width in np.unique(widths).tolist():
            own = np.ascontiguousarray(cells[(heights == height) & (widths == width)])
            for k in range(0, len(own), most):
                border = sample.border(height, width, settings.margin, layout.reach)
                yield border, own[k : k + most]


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


def kernel_sample(sample: BlockSample) -> block_kernels.Sample:
    """The sample as kernels take it."""
    windows = sample.windows
    return block_kernels.Sample(
        sample.pixels, sample.turned, windows.usable, windows.period, windows.centers
    )


def kernel_search(settings: Settings, features: Features) -> gap_kernels.Search:
    """How gaps are searched for, as kernels take it."""
    correlation = settings.match == "gncc"
    return gap_kernels.Search(
        settings.tolerance, settings.candidates, round(256 * settings.variety), correlation,
        *features,
    )  # fmt: skip


def kernel_gap(
    settings: Settings, features: Features, border: Border, known: NDArray[np.uint8]
) -> gap_kernels.Gap:
    """A gap as kernels fill it; `known` has what the canvas knows of it."""
    channels = known.shape[2]
    return gap_kernels.Gap(
        *border,
        known,
        np.empty(np.count_nonzero(border.wedges) * channels, np.uint8),
        np.empty(len(features.blocks) * channels, np.int32),
        np.empty(len(features.basis), np.int16),
        np.empty(settings.candidates, np.int64),
        np.empty(settings.candidates, np.int32),
    )
