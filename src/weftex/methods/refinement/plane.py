"""Windows of a plane that is refined: level by level, and on each level block by block.

A plane of the start is there, of any size. On the coarsest level its blocks are refined in the
order of `weftex.endless.grid`, corners first, each with all its sweeps; then those of the next
level, which are smaller. So a block sees all around it what the coarser level made, and where
pixels are many a window depends on little more than itself.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weftex.endless.boxes import Box, Span, around
from weftex.endless.grid import ACROSS, CORNER, DOWN, INSIDE, Axis, Grid, Sizes
from weftex.methods.refinement.output import Output, sources_of_children
from weftex.methods.refinement.start import start_window
from weftex.methods.refinement.sweeps import BlockSweep
from weftex.progress import Progress
from weftex.threads import thread_map

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from weftex.endless.boxes import PlaneRequest
    from weftex.endless.grid import Block
    from weftex.exemplar import Exemplar
    from weftex.methods.refinement.levels import Level, Prepared
    from weftex.progress import ProgressCallback

_PITCHES = 64, 48, 32, 24  # pixels of each level from node to node, the finest level first
_AROUND = 16  # pixels of the coarsest level around a block, where evenness is looked at
_FEWEST = 2  # nodes around a plane that repeats


class Part(NamedTuple):
    """What a window depends on at one level, in its pixels: blocks, and a box around them."""

    grid: Grid
    blocks: list[Block]
    box: Box


def refined_window(
    prepared: Prepared,
    exemplar: Exemplar,
    box: Box,
    asked: PlaneRequest,
    callback: ProgressCallback | None = None,
) -> NDArray[np.int32]:
    """Return flat indices (H, W) of the sample's pixels in a window of the refined plane."""
    levels, coarsest = prepared.levels, len(prepared.levels) - 1
    parts = parts_of(levels, box, asked)
    begun = _finer(parts[-1].box, coarsest)
    step = 1 << coarsest
    flat = start_window(prepared.starts, begun, asked, step)
    assert flat is not None
    start = np.divmod(flat, np.int32(exemplar.shape[1]))

    def preview() -> NDArray[Any]:
        shown: NDArray[Any] = exemplar.pixels[start].repeat(step, 0).repeat(step, 1)
        return shown[box.within(begun)]

    progress = Progress(callback, sum(len(part.blocks) for part in parts), "blocks", preview)
    source = levels[-1].at(*start)
    output = _begun(levels[-1], coarsest, source)
    with thread_map(asked.threads) as each:
        for number in range(coarsest, -1, -1):
            level, part = levels[number], parts[number]
            if number < coarsest:
                corners = _corner(part.box), _corner(parts[number + 1].box)
                source = sources_of_children(
                    output, levels[number + 1], part.box.shape, level, corners
                )
                output = _begun(level, number, source)
            near = _AROUND if number == coarsest else 0
            sweep = BlockSweep(prepared, number, source, near)
            before = output
            for kind in (CORNER, ACROSS, DOWN, INSIDE):
                own = [part.grid.own(b).within(part.box) for b in part.blocks if b.kind == kind]
                if kind == ACROSS:
                    before = output.copy()
                # Edges meet at their ends: those down do not see those across.
                shown = before if kind == DOWN else output
                for _ in each(partial(sweep.refine, shown), own):
                    progress.advance(1)
                if kind == DOWN:
                    output.take(before, own)
    made: NDArray[np.int32] = levels[0].places.ravel()[output.source[box.within(parts[0].box)]]
    return made


def parts_of(levels: Sequence[Level], box: Box, asked: PlaneRequest) -> list[Part]:
    """What a window depends on at each level, the finest first."""
    parts = list[Part]()
    for number, level in enumerate(levels):
        pitch = _PITCHES[min(number, len(_PITCHES) - 1)]
        axes = [Axis(pitch, 1)] * 2
        if asked.period is not None:
            lengths = [length >> number for length in asked.period]
            axes = [Axis(n, max(_FEWEST, n // pitch), wraps=True) for n in lengths]
        grid = Grid(Sizes(pitch, pitch // 2), *axes)
        blocks = grid.of_window(box)
        near = _AROUND if number == len(levels) - 1 else max(level.reach, 1)
        seen = around([grid.own(block) for block in blocks]).grown(near, near)
        parts.append(Part(grid, blocks, seen))
        box = Box(*(Span(first // 2, (last + 1) // 2) for first, last in seen))
    return parts


def goes_around(levels: Sequence[Level], period: tuple[int, int] | None) -> bool:
    """Whether all levels are periodic and their blocks fit into the period."""
    step = 1 << (len(levels) - 1)
    least = _FEWEST * _PITCHES[-1] * step
    return all(length % step == 0 and length >= least for length in period or ())


def _begun(level: Level, number: int, source: NDArray[np.int32]) -> Output:
    """The output at one level as the start or the coarser level shows it."""
    nothing = np.zeros((*source.shape, level.pixels.shape[2]), np.uint8)
    known = np.zeros(source.shape, bool)
    output = Output(number, nothing, np.full_like(source, -1), known, (False, False))
    output.begin(level, source)
    return output


def _finer(box: Box, number: int) -> Box:
    """The pixels that a box of a level stands for."""
    return Box(*(Span(first << number, last << number) for first, last in box))


def _corner(box: Box) -> tuple[int, int]:
    return box.rows.first, box.columns.first
