"""How iterative refinement makes one output: the start, the sweeps, and when to stop."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.refinement import sweep_kernels as kernels
from weftex.methods.refinement.guide import ONE, guides_of
from weftex.methods.refinement.seed_points import plant_seeds
from weftex.random import draw
from weftex.raster.pyramids import gaussian_pyramid, mask_pyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.pixels.growth import Growth
    from weftex.methods.refinement import RefinementModel
    from weftex.methods.refinement.levels import Level
    from weftex.results.synthesis import Synthesis

_TRIED = 2**23  # comparisons of the first iteration with places of the whole sample, in all
_TRIED_LEAST = 64  # of these, at each pixel
_ONE = 1024  # weight of evenness on the coarsest level, in 1/256
_ROOM = 2  # a part of the sample may be used so many times as often as all others
_NO_PERIOD = np.zeros(4, np.int32)  # what is beyond the border of a sample is laid
_ALL = 8  # compare with all windows where less than one part in so many of a window is known


class Refining:
    """One output in the making, level by level.

    Parameters
    ----------
    model : RefinementModel
        The sample.
    growth : Growth
        What is known, and where the result goes.
    made : Synthesis, optional
        What to start from, if that is there already.
    """

    def __init__(
        self, model: RefinementModel, growth: Growth, made: Synthesis | None = None
    ) -> None:
        self.model, self.growth, self.method, self.made = model, growth, model.method, made
        # A coarse level would move what lies between pieces that stay where they are.
        self.depth = depth = len(model.levels) if made is None else 1
        wrap = growth.canvas.wrap
        self.known = mask_pyramid(growth.done.astype(bool), depth, wrap)
        self.pictures = gaussian_pyramid(growth.levels, depth, wrap)
        self.guides = guides_of(model, growth)
        self.cyclic = growth.hole is not None
        self.rounds = [max(1, self.method.iterations // 2) for _ in range(depth)]
        # Structure is settled on the coarsest level, where iterations cost least.
        self.rounds[-1] = self.method.iterations * (2 if model.levels[0].components is None else 1)
        pixels = [int((~known).sum()) * n for known, n in zip(self.known, self.rounds, strict=True)]
        self.progress = growth.progress(sum(pixels), "pixels")
        self.curve: list[dict[str, float]] = []

    def run(self) -> None:
        """Make every pixel that is not known."""
        coarsest = self.depth - 1
        source = self._start(coarsest)
        self._refine(coarsest, source)
        for number in range(coarsest - 1, -1, -1):
            source = self._children(number, source)
            self._refine(number, source)
        made, model = ~self.known[0], self.model
        self.growth.source[made] = model.windows.from_sample(
            model.levels[0].places.ravel()[source]
        )[made]
        self.growth.about["convergence"] = self.curve

    def _refine(self, number: int, source: NDArray[np.int32]) -> None:
        """Sweep over a level until it stays as it is."""
        level, known, picture = self.model.levels[number], self.known[number], self.pictures[number]
        flat = level.pixels.reshape(-1, picture.shape[2])
        made = ~known & (source >= 0)
        picture[made] = flat[source[made]]
        source[known] = self._own_places(number)[known]
        kind = _ComponentSweep if level.components else _CoherentSweep
        sweep = kind(self, number, (known | made).astype(np.uint8), source)
        lines = _lines(~known)
        for turn in range(self.rounds[number]):
            before, there = picture.copy(), sweep.done.astype(bool)
            changed = 0
            for line in sweep.orders(lines, turn):
                changed += sweep.run(line, turn)
                self.progress.advance(len(line))
            self._show(number)
            if self._note(number, turn, changed, before, there):
                self.progress.advance((self.rounds[number] - 1 - turn) * sweep.wanted)
                break

    def _start(self, number: int) -> NDArray[np.int32]:
        """Seed points, or another method's result as far as this level shows it."""
        level, growth, model = self.model.levels[number], self.growth, self.model
        guided = growth.canvas.guide is not None
        if model.start is None or (guided and model.open):
            spacing = max(1, round(model.scale / (2**number * self.method.seed_density)))
            shape, wrap = self.known[number].shape, growth.canvas.wrap
            places, y, x = plant_seeds(
                level.plain,
                shape,
                wrap,
                spacing,
                self.method.matches,
                growth.seed,
                self.guides[number],
            )
            source = np.full(shape, -1, np.int32)
            v, u = np.divmod(level.plain.to_sample(places), level.plain.shape[1])
            source[np.ix_(y, x)] = level.at(v << number, u << number)
            return source
        canvas = growth.canvas
        if "guide" not in model.start.method.supports:
            canvas = dataclasses.replace(canvas, guide=None)
        made = self.made or model.start.sample(canvas, seed=growth.seed, threads=growth.threads)
        step = 2**number
        y, x = np.moveaxis(made.source[::step, ::step], -1, 0)
        return np.where(y < 0, np.int32(-1), level.at(y, x))

    def _children(self, number: int, coarser: NDArray[np.int32]) -> NDArray[np.int32]:
        """The source of each pixel goes on from its parent's."""
        exemplar, step = self.model.exemplar, 2**number
        places = self.model.levels[number + 1].places.ravel()
        y, x = np.indices(self.known[number].shape)
        v, u = np.divmod(places[coarser[y // 2, x // 2]], exemplar.shape[1])
        v, u = v + y % 2 * step, u + x % 2 * step
        return self.model.levels[number].at(v, u, exemplar.tileable)

    def _own_places(self, number: int) -> NDArray[np.int32]:
        """Where known pixels are in the sample, if they are; sources of their neighbours go on."""
        step = 2**number
        index = self.model.windows.to_sample(self.growth.source)[::step, ::step]
        y, x = np.divmod(index, self.model.exemplar.shape[1])
        return np.where(index < 0, np.int32(-1), self.model.levels[number].at(y, x))

    def _show(self, number: int) -> None:
        """Let the preview show a coarse level; the finest is what it shows."""
        if number:
            height, width = self.growth.done.shape
            large = self.pictures[number].repeat(2**number, 0).repeat(2**number, 1)[:height, :width]
            unknown = ~self.known[0]
            self.growth.levels[unknown] = large[unknown]

    def _note(
        self,
        number: int,
        turn: int,
        changed: int,
        before: NDArray[np.uint8],
        there: NDArray[np.bool_],
    ) -> bool:
        """Add a point to the curve of Fig. 7; return whether to stop by eq. (1).

        As printed (1) grows with the picture and divides by 0 on black; this is its mean over
        the pixels that are made, none counts as darker than a grey level, and those that were
        not there before count 1.
        """
        made = ~self.known[number]
        old, new = before[made].astype(np.float64), self.pictures[number][made].astype(np.float64)
        step = ((new - old) ** 2).sum(axis=1)
        ratio = np.sqrt(step / np.maximum((old**2).sum(axis=1), 1))
        ratio[~there[made]] = 1
        count = len(step)
        # Summed as integers, so that every machine stops at the same iteration.
        difference = int(np.rint(ratio * 2**20).astype(np.int64).sum()) / 2**20 / count
        self.curve.append(
            {
                "level": number,
                "iteration": turn + 1,
                "changed": changed / count,
                "difference": difference,
                "mse": float(step.sum()) / (count * before.shape[2]),
            }
        )
        # Before it was refined the picture is unknown, or another method's; a hole takes four
        # sweeps to be seen from all sides.
        return turn >= (3 if self.cyclic else 1) and difference < self.method.threshold


class _Sweep(ABC):
    """What goes over the pixels of one level, again and again."""

    def __init__(
        self, refining: Refining, number: int, done: NDArray[np.uint8], source: NDArray[np.int32]
    ) -> None:
        self.level: Level = refining.model.levels[number]
        self.picture, self.done, self.source = refining.pictures[number], done, source
        self.wrap, self.cyclic = refining.growth.canvas.wrap, refining.cyclic
        self.wanted = int((~refining.known[number]).sum())
        width = 2 * self.level.reach + 1
        self.runs = np.zeros((max(width, 3) * (max(width, 3) + 1), 3), np.int32)
        self.query = np.zeros(max(width, 3) ** 2 * self.picture.shape[2], np.uint8)

    @abstractmethod
    def orders(self, lines: list[NDArray[np.int32]], turn: int) -> list[NDArray[np.int32]]:
        """The lines in the order of this iteration."""

    @abstractmethod
    def run(self, line: NDArray[np.int32], turn: int) -> int:
        """Refine the pixels of a line; return how many changed."""


class _CoherentSweep(_Sweep):
    """Compares with the places that the neighbours' sources lead to, and with those like them."""

    def __init__(
        self, refining: Refining, number: int, done: NDArray[np.uint8], source: NDArray[np.int32]
    ) -> None:
        super().__init__(refining, number, done, source)
        level, unknown = self.level, ~refining.known[number]
        coarser = refining.depth - 1 - number
        self.seed, self.guide = refining.growth.seed, refining.guides[number]
        # Trying places all over tears apart what is whole; but what surrounds a hole must decide,
        # and a guide.
        free = (self.cyclic and refining.made is None) or self.guide.weight > 0
        self.settled = bool(done.all()) and (coarser > 0 or not free)
        cells = level.cells
        made = source[unknown & (done > 0)]
        self.usage = np.bincount(cells[made], minlength=cells.max() + 1).astype(np.int32)
        # As often as all others, or once: on a coarse level for all that a pixel stands for.
        centres = level.centres
        least = len(centres) >> 2 * number
        room: NDArray[Any]
        if self.guide.weight:
            demand = self.guide.demand(unknown, centres, max(ONE >> 2 * number, 1))
            room = _ROOM * np.bincount(cells[centres], demand, len(self.usage)) // ONE
        else:
            count = np.bincount(cells[centres], minlength=len(self.usage))
            room = _ROOM * count * max(self.wanted, least) // len(centres)
        self.capacity = np.maximum(room, 1).astype(np.int32)
        self.weight = round(_ONE * refining.method.evenness / 2**coarser)
        self.margin = round(256 * refining.method.coherence)
        self.places = np.zeros(10 * (1 + level.similar.shape[1]), np.int32)
        self.around = np.ones(done.shape, np.uint8)
        self.guide_runs = np.zeros_like(self.runs)
        self.guide_query = np.zeros(
            len(self.query) // self.picture.shape[2] * self.guide.canvas.shape[2], np.uint8
        )

    def orders(self, lines: list[NDArray[np.int32]], turn: int) -> list[NDArray[np.int32]]:
        """To and fro, or from all four sides."""
        if self.cyclic:
            return _cyclic(lines, turn, self.done.shape)
        return [line[::-1].copy() for line in lines[::-1]] if turn % 2 else lines

    def run(self, line: NDArray[np.int32], turn: int) -> int:
        level = self.level
        return int(
            kernels.refine_coherently(
                self.picture, self.done, self.source, line, self.wrap,
                level.pixels, level.usable, level.settled, _NO_PERIOD, level.reach,
                level.similar, self.margin, self._tried(int(line[0]), turn),
                level.cells, self.usage, self.capacity, self.weight,
                self.guide.canvas, self.guide.sample, self.guide.weight, self.around,
                self.runs, self.query, self.guide_runs, self.guide_query, self.places,
            )
        )  # fmt: skip

    def _tried(self, first: int, turn: int) -> NDArray[np.int32]:
        """Places that the first iteration tries at every pixel: all, if they are not too many."""
        centres = self.level.centres
        if self.settled or turn:
            return centres[:0]
        count = max(_TRIED // self.wanted, _TRIED_LEAST)
        if count >= len(centres):
            return centres
        bits = draw(self.seed, "tried place", first, np.arange(count))
        tried: NDArray[np.int32] = centres[bits % np.uint64(len(centres))]
        return tried


class _ComponentSweep(_Sweep):
    """Compares with the windows that are nearest by their principal components."""

    def __init__(
        self, refining: Refining, number: int, done: NDArray[np.uint8], source: NDArray[np.int32]
    ) -> None:
        super().__init__(refining, number, done, source)
        components = self.level.components
        assert components is not None
        self.components = components
        count = len(components.features)
        candidates = min(refining.method.candidates, len(self.level.centres))
        self.scratch = (
            self.runs,
            self.query,
            np.zeros(len(self.query), np.int16),
            np.zeros(count, np.int64),
            np.zeros(count, np.int16),
            np.zeros(candidates, np.int64),
            np.zeros(candidates, np.int32),
        )

    def orders(self, lines: list[NDArray[np.int32]], turn: int) -> list[NDArray[np.int32]]:
        """In scan order, or a hole from all four sides (Fig. 12)."""
        return _cyclic(lines, turn, self.done.shape) if self.cyclic else lines

    def run(self, line: NDArray[np.int32], turn: int) -> int:
        level, by = self.level, self.components
        # From the second iteration neighbourhoods are full, around the borders (section 3).
        wrap = (True, True) if turn and not self.cyclic else self.wrap
        return int(
            kernels.refine_by_components(
                self.picture, self.done, self.source, line, wrap,
                level.pixels, level.centres, level.reach,
                by.mean, by.basis, by.level, by.offset, by.shift, by.features,
                len(self.query) // _ALL, *self.scratch,
            )
        )  # fmt: skip


def _lines(wanted: NDArray[np.bool_]) -> list[NDArray[np.int32]]:
    """Flat indices of the wanted pixels, row by row, without empty rows."""
    width = wanted.shape[1]
    rows = np.flatnonzero(wanted.any(axis=1))
    return [(y * width + np.flatnonzero(wanted[y])).astype(np.int32) for y in rows]


def _cyclic(
    lines: list[NDArray[np.int32]], turn: int, shape: tuple[int, ...]
) -> list[NDArray[np.int32]]:
    """From the top, from the left, from below, from the right, and so on (Fig. 12)."""
    if turn % 2:
        every = np.concatenate(lines)
        turned = np.zeros(shape[::-1], bool)
        turned[every % shape[1], every // shape[1]] = True
        lines = [k % shape[0] * shape[1] + k // shape[0] for k in _lines(turned)]
    if turn % 4 > 1:
        lines = [line[::-1] for line in lines[::-1]]
    return [np.ascontiguousarray(line, np.int32) for line in lines]
