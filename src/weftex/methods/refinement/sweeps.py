"""Sweeps over the output: the order of the pixels, their candidates, and when to stop."""

from __future__ import annotations

import numpy as np

from weftex.methods.refinement import sweep_kernels as kernels
from weftex.methods.refinement.levels import (
    ONE,
    CoherentLevel,
    NearestLevel,
    OutputLevel,
    Prepared,
    SampleLevel,
)
from weftex.progress import Progress
from weftex.random import draw
from weftex.raster.arrays import Indices, Mask
from weftex.search.picture_kernels import SampleWindows
from weftex.search.windows import new_query

#: The cell of each pixel of the sample, how often cells are used and may be, and the weight.
Usage = tuple[Indices, Indices, Indices, int]

_TRIED_IN_ALL = 2**23  # comparisons of the first sweep with places of the whole sample
_TRIED_AT_LEAST = 64  # of these, at each pixel
_EVENNESS = 4 * ONE  # weight on the coarsest level
_ROOM = 2  # a part of the sample may be used so many times as often as all others
#: How many times better a similar place must match than a coherent one: 1 breaks grain into tiny
#: pieces, 4 changes the start little.
_MARGIN = 2 * ONE
_BESIDE = 10  # a pixel's own source, where 8 neighbors' sources continue, and -1


def sweep_of(
    prepared: Prepared, output: OutputLevel, seed: int, cyclic: bool
) -> CoherentSweep | NearestSweep:
    """Return the sweep of the search that the level was prepared for.

    `NearestSweep` is the paper's. `cyclic` sweeps from all four sides, for a hole. `seed` is for
    `weftex.random.draw`.
    """
    level = prepared.levels[output.number]
    if isinstance(level, NearestLevel):
        return NearestSweep(level, output, cyclic)
    assert isinstance(level, CoherentLevel)
    return CoherentSweep(prepared, level, output, seed, cyclic)


def refine_texture(sweep: CoherentSweep | NearestSweep, iteration: int, progress: Progress) -> int:
    """Refine all wanted pixels once (RefineTexture, section 3); return how many changed."""
    changed = 0
    for line in sweep.lines(iteration):
        changed += sweep.refine(line, iteration)
        progress.advance(len(line))
    return changed


class CoherentSweep:
    """Gives each pixel the best of its neighbors' continued sources and of pixels similar to them.

    See `sweep_kernels.refine_coherently`. The paper proposes spatial coherency in section 7.
    """

    def __init__(
        self, prepared: Prepared, level: CoherentLevel, output: OutputLevel, seed: int, cyclic: bool
    ) -> None:
        self._rows, self._output_shape = rows_of(output.wanted), output.known.shape
        self._seed, self._cyclic, self._centers = seed, cyclic, level.centers
        coarser = len(prepared.rounds) - 1 - output.number
        # Places from all over the sample tear apart a start that is whole. But the surroundings of
        # a hole must decide.
        free = cyclic and not prepared.belt
        whole = bool(output.done.all()) and (coarser > 0 or not free)
        tried = max(_TRIED_IN_ALL // output.count, _TRIED_AT_LEAST)
        self._tried_count = 0 if whole else min(tried, len(level.centers))
        evenness = round(_EVENNESS * prepared.method.evenness / 2**coarser)
        usage = _usage_on(level, output, evenness)
        self._bundles = (
            output.picture(output.wrap),
            _sample(level),
            kernels.Sources(level, _MARGIN, usage),
            new_query(level.reach, output.pixels.shape[2]),
            np.zeros(_BESIDE * (1 + level.similar.shape[1]), np.int32),
        )

    def lines(self, iteration: int) -> list[Indices]:
        """Return flat indices of pixels in alternating directions, or from all four sides."""
        if self._cyclic:
            return cyclic_lines(self._rows, iteration, self._output_shape)
        if iteration % 2:
            return [row[::-1].copy() for row in self._rows[::-1]]
        return self._rows

    def refine(self, line: Indices, iteration: int) -> int:
        """Refine the pixels of a line; return how many changed."""
        tried = self._tried(int(line[0]), self._tried_count if iteration == 0 else 0)
        return int(kernels.refine_coherently(*self._bundles, line, tried))

    def _tried(self, first: int, count: int) -> Indices:
        """Places that are tried at every pixel of a line: all, if they are not too many."""
        if count in (0, len(self._centers)):
            return self._centers[:count]
        bits = draw(self._seed, "tried place", first, np.arange(count))
        tried: Indices = self._centers[bits % np.uint64(len(self._centers))]
        return tried


class NearestSweep:
    """Gives a pixel the nearest of all windows (Search Tree Construction, section 3)."""

    def __init__(self, level: NearestLevel, output: OutputLevel, cyclic: bool) -> None:
        self._rows, self._output_shape = rows_of(output.wanted), output.known.shape
        self._cyclic = cyclic
        # From the second iteration neighborhoods are full, around the borders (section 3).
        later = output.wrap if cyclic else (True, True)
        self._outputs = [output.picture(wrap) for wrap in (output.wrap, later)]
        self._bundles = (
            _sample(level),
            *level.search.bundles(),
            new_query(level.reach, output.pixels.shape[2]),
            np.zeros(_BESIDE, np.int32),
        )

    def lines(self, iteration: int) -> list[Indices]:
        """Return flat indices of pixels in scan order, or a hole's from all sides (Fig. 12)."""
        rows = self._rows
        return cyclic_lines(rows, iteration, self._output_shape) if self._cyclic else rows

    def refine(self, line: Indices, iteration: int) -> int:
        """Refine the pixels of a line; what is unknown in the first iteration is masked out."""
        output = self._outputs[min(iteration, 1)]
        return int(kernels.refine_to_nearest(output, *self._bundles, line))


class Convergence:
    """The differences between iterations (eq. 1), and whether they are below the threshold.

    Equation (1) is taken as a mean over the made pixels, with at least one gray level as divisor;
    new pixels count 1. `curve` has the points of Fig. 7.
    """

    def __init__(self, threshold: float, cyclic: bool) -> None:
        # Before it was refined the picture is unknown, or another method's; a hole takes four
        # sweeps to be seen from all sides.
        self._threshold, self._at_least = threshold, 4 if cyclic else 2
        self.curve: list[dict[str, float]] = []

    def remember(self, output: OutputLevel) -> None:
        """Keep the picture before an iteration."""
        self._before = output.pixels[output.wanted]
        self._there = output.done[output.wanted] > 0

    def reached(self, output: OutputLevel, iteration: int, changed: int) -> bool:
        """Compare with the picture before; return whether to stop."""
        old = self._before.astype(np.float64)
        step = ((output.pixels[output.wanted].astype(np.float64) - old) ** 2).sum(axis=1)
        ratio = np.sqrt(step / np.maximum((old**2).sum(axis=1), 1))
        ratio[~self._there] = 1
        # Summed as integers, so that every machine stops at the same iteration.
        total = int(np.rint(ratio * 2**20).astype(np.int64).sum()) / 2**20
        self.curve.append(
            {
                "level": output.number,
                "iteration": iteration + 1,
                "changed": changed / output.count,
                "difference": total / output.count,
                "mse": float(step.sum()) / (output.count * self._before.shape[1]),
            }
        )
        return iteration + 1 >= self._at_least and total / output.count < self._threshold


def _sample(level: SampleLevel) -> SampleWindows:
    """The sample at a level, without a period: the pixels beyond a border that tiles are there."""
    return SampleWindows(level.pixels, level.usable, np.zeros(4, np.int32))


def _usage_on(level: CoherentLevel, output: OutputLevel, weight: int) -> Usage:
    """How often each cell of the sample is used by the start, and may be."""
    shown = level.sample_index.ravel()[output.source[output.wanted & (output.done > 0)]]
    # As often as all others, or once: on a coarse level for all that a pixel stands for.
    count = max(output.count, len(level.centers) >> 2 * output.number)
    room = _ROOM * level.centers_in_cells * count // len(level.centers)
    used = np.bincount(level.cells[shown], minlength=len(room)).astype(np.int32)
    return level.cells, used, np.maximum(room, 1).astype(np.int32), weight


def rows_of(wanted: Mask) -> list[Indices]:
    """Flat indices of the wanted pixels, row by row, without empty rows."""
    width = wanted.shape[1]
    rows = np.flatnonzero(wanted.any(axis=1))
    return [(y * width + np.flatnonzero(wanted[y])).astype(np.int32) for y in rows]


def cyclic_lines(rows: list[Indices], iteration: int, shape: tuple[int, ...]) -> list[Indices]:
    """From the top, from the left, from below, from the right, and so on (Fig. 12)."""
    lines = rows
    if iteration % 2:
        every = np.concatenate(rows)
        turned = np.zeros(shape[::-1], bool)
        turned[every % shape[1], every // shape[1]] = True
        lines = [k % shape[0] * shape[1] + k // shape[0] for k in rows_of(turned)]
    if iteration % 4 > 1:
        lines = [line[::-1] for line in lines[::-1]]
    return [np.ascontiguousarray(line, np.int32) for line in lines]
