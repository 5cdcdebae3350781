"""Iterative refinement at several resolutions: the sample (section 3, steps 1, 2), the output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.method import Model
from weftex.methods.pixels import Growth
from weftex.methods.refinement.defaults import reach_and_level_count, seed_spacing
from weftex.methods.refinement.nearest import NearestSearch, nearest_search
from weftex.methods.refinement.similar import nearest_center, similar_places
from weftex.raster import pyramids
from weftex.raster.arrays import Bytes, Indices, Ints, Mask
from weftex.raster.boxes import whole_windows
from weftex.search.picture_kernels import Picture
from weftex.search.windows import Windows, windows_of

ONE = 256  # distances are multiplied with integers; this is a factor of 1
_FINE_REACH = 1  # pixels from the middle of a window to its side, on the finest of several levels
_MOST_MOVED = 0.15  # of a start; more would break patterns that it continues


@dataclass(frozen=True, eq=False)
class SampleLevel:
    """The sample at one resolution.

    Sources are pixels of the sample at full resolution, on coarser levels too, so pieces that fit
    to the pixel still fit on finer levels.
    """

    pyramid: Windows  # the level of the pyramid, with the windows that seed points are drawn from
    tileable: bool  # whether the sample tiles
    # (H', W', K): bytes that are compared, with margins that make all windows whole
    pixels: Bytes
    usable: Bytes  # (H', W'): 1 where a window may be centered
    # (H', W'): flat index of each pixel's source in the sample, -1 for none
    sample_index: Indices
    # (H, W): flat index into `pixels` of each pixel of the sample, within its borders
    padded_index: Indices
    reach: int  # pixels from the center of a window to its side

    @cached_property
    def centers(self) -> Indices:
        """Flat indices into `pixels` where a window may be centered, once for each place."""
        flat = np.flatnonzero(self.usable).astype(np.int32)
        own = self.padded_index.ravel()[self.sample_index.ravel()[flat]]
        once: Indices = flat[own == flat]
        return once

    @cached_property
    def nearest_center(self) -> Indices:
        """(H, W): flat index into `pixels` of the center nearest to each pixel of the sample."""
        may = self.usable.ravel()[self.padded_index]
        if may.all():
            return self.padded_index
        return self.padded_index.ravel()[nearest_center(may)]

    def may_center(self, y: NDArray[np.integer], x: NDArray[np.integer]) -> Mask:
        """Whether windows may be centered on pixels of the sample."""
        result: Mask = self.usable.ravel()[self.padded_index[y, x]] > 0
        return result

    def at(self, y: NDArray[np.integer], x: NDArray[np.integer]) -> Indices:
        """Return padded indices of the centers nearest to pixels of the sample."""
        height, width = self.padded_index.shape
        if self.tileable:
            y, x = y % height, x % width
        else:
            y, x = y.clip(0, height - 1), x.clip(0, width - 1)
        result: Indices = self.nearest_center[y, x]
        return result


@dataclass(frozen=True, eq=False)
class StackLayout:
    """A level of a Gaussian stack as one picture, so that windows are contiguous in memory.

    The phases of level `number` lie one below the other; level 0 is the finest.

    Each phase has a margin of `reach` pixels that makes all windows whole: its other side if the
    sample tiles, else its mirror image.
    """

    shape: tuple[int, int]
    number: int
    reach: int
    tileable: bool

    @property
    def margin(self) -> int:
        """One more than a window reaches: a step off a border that tiles is a place too."""
        return self.reach + 1

    def arranged(self, phases: list[NDArray[Any]]) -> NDArray[Any]:
        """Put phases below each other, each with its margin."""
        return self._below(phases, "wrap" if self.tileable else "symmetric")

    @cached_property
    def sample_index(self) -> Indices:
        """Flat index of the pixel of the sample that each shows; -1 for none and for a mirrored."""
        return self._numbers("wrap" if self.tileable else "constant") - 1

    @cached_property
    def padded_index(self) -> Indices:
        """The flat index of each pixel of the sample in the arrangement, never in a margin."""
        inside = self._numbers("constant").ravel()
        flat = np.flatnonzero(inside).astype(np.int32)
        result = np.empty(len(flat), np.int32)
        result[inside[flat] - 1] = flat
        return result.reshape(self.shape)

    def usable(self, masks: list[Mask]) -> Bytes:
        """1 where a window may be centered, given the phases of the mask."""
        m = self.margin
        mode: Any = "wrap" if self.tileable else "symmetric"
        whole = [whole_windows(np.pad(k, m, mode=mode), (self.reach,) * 4) for k in masks]
        if not self.tileable:
            whole = [np.pad(k[m:-m, m:-m], m) for k in whole]
        width = whole[0].shape[1]
        return np.concatenate([np.pad(k, ((0, 0), (0, width - k.shape[1]))) for k in whole])

    def _numbers(self, mode: str) -> Indices:
        """Arrange the pixels of the sample, numbered from 1; margins are 0, or its continuation."""
        every = np.arange(1, self.shape[0] * self.shape[1] + 1, dtype=np.int32)
        step, sample = 1 << self.number, every.reshape(self.shape)
        phases = [sample[y::step, x::step] for y, x in pyramids.phase_starts(self.number)]
        return self._below(phases, mode)

    def _below(self, phases: list[NDArray[Any]], mode: Any) -> NDArray[Any]:
        m, columns = self.margin, phases[0].shape[1]
        parts = []
        for phase in phases:
            more = ((0, 0),) * (phase.ndim - 2)
            part = np.pad(phase, ((m, m), (m, m), *more), mode=mode)
            parts.append(np.pad(part, ((0, 0), (0, columns - phase.shape[1]), *more)))
        return np.ascontiguousarray(np.concatenate(parts))


@dataclass(frozen=True, eq=False)
class CoherentLevel(SampleLevel):
    """A level of the Gaussian stack, for the coherent search."""

    layout: StackLayout  # where the phases lie in `pixels`
    # (H * W, k): the pixels of the sample most similar to each, -1 for none
    similar: Indices
    # (H * W,): number of each pixel's cell; cells measure how evenly the sample is used
    cells: Indices

    @cached_property
    def centers_in_cells(self) -> Ints:
        """How many of the centers lie in each cell."""
        own = self.cells[self.sample_index.ravel()[self.centers]]
        return np.bincount(own, minlength=int(self.cells.max()) + 1)


@dataclass(frozen=True, eq=False)
class NearestLevel(SampleLevel):
    """The only level of the paper's search (section 3, Search Tree Construction)."""

    search: NearestSearch


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for iterative refinement.

    `levels` are finest first: one for the paper's search and for belts. `starts` are the models
    that make the start, by slug, each used where the one before refuses; empty for seed points.
    """

    method: Any  # the `Refinement`, resolved
    windows: Windows  # of one pixel
    levels: list[SampleLevel]
    starts: dict[str, Model]
    rounds: tuple[int, ...]  # maximum number of iterations of each level, finest first
    seed_spacing: float  # pixels of the sample
    by_canvas: bool  # `init` was not given: the start may depend on the canvas

    @property
    def belt(self) -> int:
        """Width in pixels of the refined belts along the start's seams; 0 refines everything."""
        width: int | None = self.method.joints
        return width or 0


def prepare(
    method: Any, exemplar: Exemplar, starts: dict[str, Model], *, by_canvas: bool
) -> Prepared:
    """Return a sample prepared for a resolved method (steps 1 and 2)."""
    reach, count = reach_and_level_count(method, exemplar)
    # A coarse level would move what lies between patches that stay where they are.
    finer = 0 if method.joints else count - 1
    last = method.iterations
    levels: list[SampleLevel] = []
    if method.search == "nearest":
        levels += [_nearest_level(exemplar, reach)]
    else:
        last *= 2  # structure is determined on the coarsest level, where it costs least
        levels += _pyramid_levels(method, exemplar, reach, count)
    rounds = (*[max(1, method.iterations // 2)] * finer, last)
    spacing = seed_spacing(method, exemplar, by_canvas=by_canvas)
    windows = windows_of(exemplar, (0,) * 4)
    return Prepared(method, windows, levels, starts, rounds, spacing, by_canvas)


def _nearest_level(exemplar: Exemplar, reach: int) -> NearestLevel:
    """One resolution, and windows as large as they are."""
    windows = windows_of(exemplar, (reach,) * 4)
    every = np.arange(windows.usable.size, dtype=np.int32)
    sample_index = windows.to_sample(every).reshape(windows.usable.shape)
    padded_index = windows.from_sample(every[: exemplar.shape[0] * exemplar.shape[1]])
    return NearestLevel(
        pyramid=windows,  # seed points lie where windows are whole
        tileable=exemplar.tileable,
        pixels=windows.pixels,
        usable=windows.usable,
        sample_index=sample_index,
        padded_index=padded_index.reshape(exemplar.shape),
        reach=reach,
        search=nearest_search(windows, reach),
    )


def _pyramid_levels(method: Any, exemplar: Exemplar, reach: int, count: int) -> list[CoherentLevel]:
    """Return the refined levels of a Gaussian stack of `count` levels; for belts, the finest."""
    tiles = (exemplar.tileable,) * 2
    mask = exemplar.usable
    pictures = pyramids.gaussian_stack(exemplar.matching(), count, tiles)
    masks = pyramids.mask_stack(mask, count, tiles)
    samples = [
        Exemplar(p[0], mask=m[0], tileable=tiles[0], alpha=False, name=exemplar.name)
        for p, m in zip(pictures, masks, strict=True)
    ]
    every = np.arange(mask.size, dtype=np.int32)
    like, coarser = np.zeros((0, 0), np.int32), None
    for sample, phases in list(zip(samples, pictures, strict=True))[::-1]:
        windows = windows_of(sample, (reach,) * 4, phases[0])
        like = similar_places(windows, reach, method.similar, coarser)
        coarser = windows, like
    like = windows.to_sample(like[windows.from_sample(every)])
    cells = _cells(exemplar.shape, max(1, method.window_width // 2))  # the scale (section 3)
    levels = []
    for number in range(1 if method.joints else count):
        # Coarser levels have determined what goes where. Now the picture has to go on across seams,
        # and wide windows would draw these straight instead. A belt is refined on one level only.
        fine = number == 0 and count > 1 and not method.joints
        own_reach = min(reach, _FINE_REACH) if fine else reach
        layout = StackLayout(exemplar.shape, number, own_reach, exemplar.tileable)
        levels.append(
            CoherentLevel(
                pyramid=windows_of(samples[number], (0,) * 4, pictures[number][0]),
                tileable=layout.tileable,
                pixels=layout.arranged(pictures[number]),
                usable=layout.usable(masks[number]),
                sample_index=layout.sample_index,
                padded_index=layout.padded_index,
                reach=layout.reach,
                layout=layout,
                similar=like,
                cells=cells,
            )
        )
    return levels


def _cells(shape: tuple[int, int], side: int) -> Indices:
    """See `CoherentLevel.cells`."""
    down, along = (np.arange(n, dtype=np.int32) // np.int32(side) for n in shape)
    cells: Indices = np.add.outer(down * np.int32(shape[1] // side + 1), along).ravel()
    return cells


class OutputLevel:
    """The output at one level while it is refined; level 0 is the finest."""

    def __init__(
        self, number: int, pixels: Bytes, source: Indices, known: Mask, wrap: tuple[bool, bool]
    ) -> None:
        # pixels (H, W, K); source (H, W): flat indices into `SampleLevel.pixels`, -1 for none
        self.number, self.pixels, self.source = number, pixels, source
        # done (H, W): 1 where a pixel is known or made; known (H, W): pixels that do not change;
        # wrap: whether the vertical and the horizontal axis wrap
        self.done, self.known, self.wrap = known.astype(np.uint8), known, wrap
        self.wanted = ~known
        self.count = int(self.wanted.sum())

    def begin(self, level: SampleLevel, source: Indices) -> None:
        """Show the sources of the pixels that are to be made; -1 leaves one to be made later."""
        shown = self.wanted & (source >= 0)
        self.pixels[shown] = level.pixels.reshape(-1, self.pixels.shape[2])[source[shown]]
        self.source[self.wanted] = source[self.wanted]
        self.done[shown] = 1

    def picture(self, wrap: tuple[bool, bool]) -> Picture:
        """Return the output as kernels take it."""
        return Picture(self.pixels, self.done, self.source, wrap)


def output_pyramid(
    windows: Windows, levels: Sequence[SampleLevel], growth: Growth
) -> list[OutputLevel]:
    """Return the known pixels at each level, the finest first."""
    wrap = growth.canvas.wrap
    masks = pyramids.mask_pyramid(growth.done.astype(bool), len(levels), wrap)
    pictures = pyramids.gaussian_pyramid(growth.pixels, len(levels), wrap)
    y, x = np.divmod(windows.to_sample(growth.source), growth.exemplar.shape[1])
    outputs = []
    for number, (level, known) in enumerate(zip(levels, masks, strict=True)):
        # Known pixels may be in the sample too: then their sources go on in their neighbors.
        own = _every(y, number), _every(x, number)
        source = np.where(known & (own[0] >= 0), level.at(*own), np.int32(-1))
        outputs.append(OutputLevel(number, pictures[number], source, known, wrap))
    return outputs


def levels_that_show(sources: Indices, levels: Sequence[SampleLevel], growth: Growth) -> int:
    """Return the number of levels on which few pixels of a source map (H, W, 2) are moved.

    Windows are wide on coarse levels, and none is centered near a hole of the sample.
    """
    known = pyramids.mask_pyramid(growth.done.astype(bool), len(levels), growth.canvas.wrap)
    for number in range(len(levels) - 1, 0, -1):
        y, x = (_every(axis, number) for axis in np.moveaxis(sources, -1, 0))
        wanted = ~known[number] & (y >= 0)
        whole = levels[number].may_center(y[wanted], x[wanted])
        if np.count_nonzero(~whole) <= _MOST_MOVED * whole.size:
            return number + 1
    return 1


def sources_shown(sources: Indices, number: int, level: SampleLevel) -> Indices:
    """Return the sources (H, W, 2) of a picture as far as a level shows it; -1 stays."""
    y, x = (_every(axis, number) for axis in np.moveaxis(sources, -1, 0))
    return np.where(y < 0, np.int32(-1), level.at(y, x))


def sources_of_children(
    coarser: OutputLevel, coarser_level: SampleLevel, shape: tuple[int, ...], level: SampleLevel
) -> Indices:
    """Return (H, W) source of each pixel of a level: the one that continues its parent's."""
    step = 2 ** (coarser.number - 1)
    y, x = np.ogrid[: shape[0], : shape[1]]
    parents = coarser_level.sample_index.ravel()[coarser.source[y // 2, x // 2]]
    v, u = np.divmod(parents, level.padded_index.shape[1])
    return level.at(v + y % 2 * step, u + x % 2 * step)


def finish(output: OutputLevel, level: SampleLevel, windows: Windows, growth: Growth) -> None:
    """Hand the sources of the finest level over."""
    index = level.sample_index.ravel()[output.source[output.wanted]]
    growth.source[output.wanted] = windows.from_sample(index)


def _every(rows: Indices, number: int) -> Indices:
    """The pixels of a picture that those of a level lie on."""
    return rows[:: 2**number, :: 2**number]
