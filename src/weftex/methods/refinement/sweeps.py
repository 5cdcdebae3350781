"""Sweeps over the output: the order of the pixels, their candidates, and when to stop."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from weftex.methods.refinement import sweep_kernels as kernels
from weftex.methods.refinement.levels import CoherentLevel, NearestLevel
from weftex.methods.refinement.settings import ONE
from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.refinement.levels import Level
    from weftex.methods.refinement.output import Guide, Output
    from weftex.methods.refinement.settings import Settings
    from weftex.progress import Progress

_NO_PERIOD = np.zeros(4, np.int32)  # pixels beyond a border that tiles are laid out
_TRIED_IN_ALL = 2**23  # comparisons of the first sweep with places of the whole sample
_TRIED_AT_LEAST = 64  # of these, at each pixel
_EVENNESS = 4 * ONE  # weight on the coarsest level
_ROOM = 2  # a part of the sample may be used so many times as often as all others
_BESIDE = 10  # a pixel's own place, where its eight neighbors' go on, and one for none


class Sweep(Protocol):
    """Refines an output at one level, line by line."""

    def lines(self, iteration: int) -> list[NDArray[np.int32]]:
        """Flat indices of the wanted pixels in the order of an iteration."""

    def refine(self, line: NDArray[np.int32], iteration: int) -> int:
        """Refine the pixels of a line; return how many changed."""


def sweep_of(
    settings: Settings, level: Level, output: Output, guide: Guide, seed: int, cyclic: bool
) -> Sweep:
    """Return the sweep of the search that the level was prepared for.

    Parameters
    ----------
    settings : Settings
    level, output, guide
        The sample, the output and the guides at one resolution.
    seed : int
        For `weftex.random.draw`.
    cyclic : bool
        A hole is filled, from all four sides.
    """
    if isinstance(level, NearestLevel):
        return NearestSweep(level, output, cyclic)
    if isinstance(level, CoherentLevel):
        return CoherentSweep(settings, level, output, guide, seed, cyclic)
    raise TypeError(f"no sweep for {type(level).__name__}")


def refine_texture(sweep: Sweep, iteration: int, progress: Progress) -> int:
    """Go over all wanted pixels once (RefineTexture, section 3); return how many changed."""
    changed = 0
    for line in sweep.lines(iteration):
        changed += sweep.refine(line, iteration)
        progress.advance(len(line))
    return changed


class CoherentSweep:
    """Gives a pixel the best of the places its neighbors' sources lead to, or of similar ones.

    See `sweep_kernels.refine_coherently`. The paper proposes spatial coherency in section 7.
    """

    def __init__(
        self,
        settings: Settings,
        level: CoherentLevel,
        output: Output,
        guide: Guide,
        seed: int,
        cyclic: bool,
    ) -> None:
        self._rows, self._output_shape = rows_of(output.wanted), output.known.shape
        self._seed, self._cyclic, self._centers = seed, cyclic, level.centers
        coarser = len(settings.rounds) - 1 - output.number
        # Places from all over the sample tear apart a start that is whole. But the surroundings of
        # a hole must decide, and a guide.
        free = (cyclic and not settings.belt) or guide.weight > 0
        whole = bool(output.done.all()) and (coarser > 0 or not free)
        tried = max(_TRIED_IN_ALL // output.count, _TRIED_AT_LEAST)
        self._tried_count = 0 if whole else min(tried, len(level.centers))
        channels, candidates = output.pixels.shape[2], _BESIDE * (1 + level.similar.shape[1])
        self._bundles = (
            kernels.Output(output.pixels, output.done, output.source, output.wrap),
            kernels.Sample(level, _NO_PERIOD),
            kernels.Similar(level.similar, settings.margin),
            _usage(level, output, guide, round(_EVENNESS * settings.evenness / 2**coarser)),
            kernels.GuidePair(
                guide,
                np.ones(guide.output.shape[:2], np.uint8),
                *_room_for_window(level.reach, guide.output.shape[2]),
            ),
            _scratch(level.reach, channels, candidates),
        )

    def lines(self, iteration: int) -> list[NDArray[np.int32]]:
        """To and fro, or from all four sides."""
        if self._cyclic:
            return cyclic_lines(self._rows, iteration, self._output_shape)
        if iteration % 2:
            return [row[::-1].copy() for row in self._rows[::-1]]
        return self._rows

    def refine(self, line: NDArray[np.int32], iteration: int) -> int:
        """See `Sweep.refine`."""
        tried = self._tried(int(line[0]), self._tried_count if iteration == 0 else 0)
        return int(kernels.refine_coherently(*self._bundles, line, tried))

    def _tried(self, first: int, count: int) -> NDArray[np.int32]:
        """Places that are tried at every pixel of a line: all, if they are not too many."""
        if count in (0, len(self._centers)):
            return self._centers[:count]
        bits = draw(self._seed, "tried place", first, np.arange(count))
        tried: NDArray[np.int32] = self._centers[bits % np.uint64(len(self._centers))]
        return tried


class NearestSweep:
    """Gives a pixel the nearest of all windows (Search Tree Construction, section 3)."""

    def __init__(self, level: NearestLevel, output: Output, cyclic: bool) -> None:
        self._rows, self._output_shape = rows_of(output.wanted), output.known.shape
        self._cyclic = cyclic
        # From the second iteration neighborhoods are full, around the borders (section 3).
        self._outputs = [
            kernels.Output(output.pixels, output.done, output.source, wrap)
            for wrap in (output.wrap, output.wrap if cyclic else (True, True))
        ]
        self._bundles = (
            kernels.Sample(level, _NO_PERIOD),
            level.search.bundle(),
            _scratch(level.reach, output.pixels.shape[2], _BESIDE),
        )

    def lines(self, iteration: int) -> list[NDArray[np.int32]]:
        """In scan order, or a hole from all four sides (Fig. 12)."""
        return (
            cyclic_lines(self._rows, iteration, self._output_shape) if self._cyclic else self._rows
        )

    def refine(self, line: NDArray[np.int32], iteration: int) -> int:
        """See `Sweep.refine`; what is unknown in the first iteration is masked out."""
        output = self._outputs[min(iteration, 1)]
        return int(kernels.refine_to_nearest(output, *self._bundles, line))


class Convergence:
    """The differences between iterations (eq. 1), and whether they are small enough.

    As printed (1) grows with the picture and divides by 0 on black; this is its mean over the
    pixels that are made, none counts as darker than a gray level, and those that were not there
    before count 1.

    Attributes
    ----------
    curve : list of dict
        The points of Fig. 7: level, iteration, and the share of pixels changed, the difference of
        eq. (1) and the mean square error to the iteration before.
    """

    def __init__(self, threshold: float, cyclic: bool) -> None:
        # Before it was refined the picture is unknown, or another method's; a hole takes four
        # sweeps to be seen from all sides.
        self._threshold, self._at_least = threshold, 4 if cyclic else 2
        self.curve: list[dict[str, float]] = []
        self._before: NDArray[np.uint8]
        self._there: NDArray[np.bool_]

    def remember(self, output: Output) -> None:
        """Keep the picture before an iteration."""
        self._before = output.pixels[output.wanted]
        self._there = output.done[output.wanted] > 0

    def reached(self, output: Output, iteration: int, changed: int) -> bool:
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
                "mse": float(step.sum()) / (output.count * old.shape[1]),
            }
        )
        return iteration + 1 >= self._at_least and total / output.count < self._threshold


def _room_for_window(reach: int, channels: int) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
    """Arrays for the runs and the bytes of a window, and of the eight neighbors."""
    width = max(2 * reach + 1, 3)
    return np.zeros((width * (width + 1), 3), np.int32), np.zeros(width**2 * channels, np.uint8)


def _scratch(reach: int, channels: int, candidates: int) -> kernels.Scratch:
    """Room for the window of a pixel, and for its candidates."""
    return kernels.Scratch(*_room_for_window(reach, channels), np.zeros(candidates, np.int32))


def _usage(level: CoherentLevel, output: Output, guide: Guide, weight: int) -> kernels.Usage:
    """How often each cell of the sample is used by the start, and may be."""
    cells, places = level.cells, level.places.ravel()
    centers = places[level.centers]
    made = places[output.source[output.wanted & (output.done > 0)]]
    used = np.bincount(cells[made], minlength=cells.max() + 1).astype(np.int32)
    room: NDArray[Any]
    if guide.weight:
        least = max(ONE >> 2 * output.number, 1)
        demand = guide.demand(output.wanted, level.centers, least)
        room = _ROOM * np.bincount(cells[centers], demand, len(used)) // ONE
    else:
        # As often as all others, or once: on a coarse level for all that a pixel stands for.
        least = len(centers) >> 2 * output.number
        count = np.bincount(cells[centers], minlength=len(used))
        room = _ROOM * count * max(output.count, least) // len(centers)
    return kernels.Usage(cells, used, np.maximum(room, 1).astype(np.int32), weight)


def rows_of(wanted: NDArray[np.bool_]) -> list[NDArray[np.int32]]:
    """Flat indices of the wanted pixels, row by row, without empty rows."""
    width = wanted.shape[1]
    rows = np.flatnonzero(wanted.any(axis=1))
    return [(y * width + np.flatnonzero(wanted[y])).astype(np.int32) for y in rows]


def cyclic_lines(
    rows: list[NDArray[np.int32]], iteration: int, shape: tuple[int, ...]
) -> list[NDArray[np.int32]]:
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
