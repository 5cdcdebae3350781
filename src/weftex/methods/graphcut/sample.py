"""A sample prepared for graph-cut textures, and the pyramids of it and of the canvas.

Matching coarse to fine is not in the paper.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.rows import Boards, find_boards
from weftex.exemplar import Exemplar
from weftex.exemplar.turns import copies_in
from weftex.methods.graphcut import pyramid_kernels as kernels
from weftex.raster.arrays import Bytes, Mask, fast_size
from weftex.raster.turning import Box
from weftex.search.fft_mismatch import Spectra
from weftex.search.windows import Windows

_HALVINGS = 4  # at most, unless they are given
_LEAST = 24  # pixels a side that a patch has on the smallest level then
_TOGETHER = 3  # places that one call looks up


@dataclass(frozen=True, eq=False)
class CutSample:
    """A sample, with what depends on it alone; that is made once, for many outputs."""

    exemplar: Exemplar
    windows: Windows  # its single pixels
    by_gradients: bool  # costs of seams are divided by gradients
    most_halvings: int | None  # None: as many as leave patches 24 pixels a side, up to 4
    made: dict[Any, Any] = field(default_factory=dict, repr=False)  # by others, under their keys

    def __reduce__(self) -> tuple[Any, ...]:
        """Leave out what can be made again; kernels cannot be pickled."""
        return type(self), (self.exemplar, self.windows, self.by_gradients, self.most_halvings)

    @cached_property
    def boxes(self) -> list[Box]:
        """Where the sample and its oriented copies lie, if it is a picture of them."""
        return [] if self.exemplar.turn is None else copies_in(self.exemplar)

    @cached_property
    def boards(self) -> Boards | None:
        """Its rows, if their joints run through it."""
        plain = not self.boxes and self.is_whole(copies=False)
        return find_boards(self.windows.pixels[..., : self.exemplar.channels]) if plain else None

    def part(self, box: Box) -> CutSample:
        """One of the oriented copies."""
        part = Level(self.windows.pixels, self.windows.usable).part(*box)
        windows = Windows(part.pixels, part.mask, self.windows.period, box[2:])
        return replace(self, windows=windows, made={})

    def reduction_for(self, size: tuple[int, int], allowed: Bytes) -> int:
        """How many times smaller the smallest level is that patches of a size are matched on.

        A power of 2, such that the level has some of the `allowed` pixels of the sample.
        """
        most, least = (_HALVINGS, _LEAST) if (n := self.most_halvings) is None else (n, 1)
        reduction = 1
        while (
            2 * reduction <= 1 << most
            and 2 * reduction * least <= min(size)
            and allowed[:: 2 * reduction, :: 2 * reduction].any()
        ):
            reduction *= 2
        return reduction

    def levels(self, reduction: int) -> list[Level]:
        """The sample's pyramid."""
        return levels_of(Level(self.windows.pixels, self.windows.usable), reduction)

    @cached_property
    def kernel_arrays(self) -> tuple[NDArray[Any], ...]:
        """Pixels, whether they are usable, their neighbors and gradients, for `cost_kernels`."""
        pixels, usable = self.windows.pixels, self.windows.usable
        joins = _joins(usable != 0, self.exemplar.tileable)
        gradients = _gradients(pixels, joins) if self.by_gradients else np.zeros((0, 0), np.int32)
        return pixels.reshape(-1, pixels.shape[2]), usable.ravel(), joins.ravel(), gradients

    @cached_property
    def usual_cost(self) -> float:
        """The mean cost of a seam (equation 1) between pixels that have nothing to do with it."""
        pixels, usable, _, gradients = self.kernel_arrays
        total, count = 0.0, 0
        for step in (len(pixels) // 3, len(pixels) // 5):  # to another pixel, around the end
            both = usable * np.roll(usable, step) != 0
            cost = 2.0 * _differences(pixels, np.roll(pixels, step, 0))[both]
            if self.by_gradients:
                cross = gradients[0] + np.roll(gradients[0], step)
                cost *= 256 / (cross[both] + 32 * pixels.shape[1])
            total, count = total + float(cost.sum()), count + len(cost)
        return total / max(count, 1)

    def is_whole(self, copies: bool) -> bool:
        """Whether all pixels of patches are usable, in one of the oriented `copies` or anywhere."""
        usable = self.windows.usable  # there is a line between any two copies
        boxes = self.boxes if copies else [(0, 0, *usable.shape)]
        return all(usable[y : y + h, x : x + w].all() for y, x, h, w in boxes)


def _joins(usable: Mask, tileable: bool) -> Bytes:
    """The directions in which each pixel has a neighbor, as bits; see `cost_kernels.Labeling`."""
    joins = np.zeros(usable.shape, np.uint8)
    for d, (axis, step) in enumerate([(1, 1), (0, 1), (1, -1), (0, -1)]):
        beside = np.roll(usable, -step, axis)
        last = np.zeros_like(usable)  # the line whose neighbor is across the border
        last[(slice(None),) * axis + (-1 if step > 0 else 0,)] = True
        joins |= ((beside & (tileable | ~last)) * np.uint8(1 << d)).astype(np.uint8)
        joins |= (last * np.uint8(16 << d)).astype(np.uint8)
    return joins


def _gradients(pixels: Bytes, joins: Bytes) -> NDArray[np.int32]:
    """(2, H * W): differences of all pixels from their right and lower neighbors, 0 without one."""
    found = np.zeros((2, joins.size), np.int32)
    for d, axis in enumerate((1, 0)):
        found[d] = _differences(pixels, np.roll(pixels, -1, axis)).ravel()
        found[d] *= joins.ravel() >> d & 1
    return found


def _differences(pixels: Bytes, others: Bytes) -> NDArray[np.int32]:
    """(...): sums of the absolute differences of all channels (..., K)."""
    apart = np.maximum(pixels, others) - np.minimum(pixels, others)
    channels = np.moveaxis(apart, -1, 0)  # faster than a sum along the last axis
    return np.asarray(sum(channel.astype(np.int32) for channel in channels))


@dataclass(frozen=True, eq=False)
class Level:
    """A picture uint8 (H, W, K), and 1 where a pixel counts, uint8 (H, W)."""

    pixels: Bytes
    mask: Bytes

    @cached_property
    def all_count(self) -> bool:
        """Whether all pixels count."""
        return bool(self.mask.all())

    @cached_property
    def variance(self) -> float:
        """Variance of the pixels that count, all channels together, from exact sums."""
        pixels = self.pixels[self.mask != 0]
        total = [int(k) for k in pixels.sum(axis=0, dtype=np.int64)]
        squares = sum(int(np.square(k, dtype=np.int64).sum()) for k in pixels.T)
        return (len(pixels) * squares - sum(t * t for t in total)) / len(pixels) ** 2

    @cached_property
    def spectra(self) -> Spectra:
        """To be matched with a picture that is not larger."""
        return self.spectra_of([fast_size(n) for n in self.mask.shape])

    def part(self, top: int, left: int, height: int, width: int) -> Level:
        """A box of it."""
        here = np.s_[top : top + height, left : left + width]
        return Level(*(np.ascontiguousarray(a[here]) for a in (self.pixels, self.mask)))

    def spectra_of(self, size: tuple[int, ...] | list[int]) -> Spectra:
        """To be matched by transforms of a size."""
        return Spectra(self.pixels, self.mask, tuple(size))


def levels_of(whole: Level, reduction: int) -> list[Level]:
    """The picture and levels half as large each, the last one `reduction` times smaller.

    A pixel is the rounded mean of four, and counts if all of them do.
    """
    levels = [whole]
    while reduction > 1:
        rows, columns = (n // 2 for n in levels[-1].mask.shape)
        half = _blank(rows, columns, whole)
        kernels.halve(levels[-1].pixels, levels[-1].mask, half.pixels, half.mask)
        levels.append(half)
        reduction //= 2
    return levels


def box_of(canvas: Level, rows: NDArray[np.int32], columns: NDArray[np.int32]) -> Level:
    """Copy these rows and columns; nothing counts in those below 0."""
    box = _blank(len(rows), len(columns), canvas)
    kernels.copy_box(canvas.pixels, canvas.mask, rows, columns, box.pixels, box.mask)
    return box


def _blank(rows: int, columns: int, like: Level) -> Level:
    pixels = np.empty((rows, columns, like.pixels.shape[2]), np.uint8)
    return Level(pixels, np.empty((rows, columns), np.uint8))


def on_levels(allowed: Bytes, levels: list[Level]) -> list[Bytes]:
    """The allowed pixels that each level has."""
    shapes = [level.mask.shape for level in levels]
    every = [allowed[:: 1 << k, :: 1 << k][:high, :wide] for k, (high, wide) in enumerate(shapes)]
    return [np.ascontiguousarray(some) for some in every]


def coarsest(boxes: list[Level], allowed: list[Bytes]) -> int:
    """The smallest level that has an allowed pixel, and pixels of the box if there are any."""
    there = boxes[0].mask.any()
    return next(
        k
        for k in range(len(boxes) - 1, -1, -1)
        if allowed[k].any() and (boxes[k].mask.any() or not there)
    )


def in_full_size(
    places: list[tuple[int, int]],
    boxes: list[Level],
    samples: list[Level],
    allowed: list[Bytes],
    offset: Sequence[int],
    map_: Callable[..., Any] = map,
) -> list[tuple[int, int]]:
    """Find places of the smallest level on larger and larger ones: the best of each and beside it.

    The corner of the box lies on place - offset of the sample, in full size. All lists go from the
    full size on; `map_` may use threads.
    """
    for k in range(len(boxes) - 2, -1, -1):
        box, sample, at = boxes[k], samples[k], np.array(offset, np.int32) >> k
        both = box.pixels, box.mask, sample.pixels, sample.mask
        nudge = partial(kernels.nudge, *both, allowed[k], at, sample.all_count)
        # Places side by side often lead to the same one, which is looked up once.
        different = list(dict.fromkeys(places))
        found = 2 * np.array(different, np.int32)
        list(map_(nudge, [found[i : i + _TOGETHER] for i in range(0, len(found), _TOGETHER)]))
        larger = dict(zip(different, map(tuple, found.tolist()), strict=True))
        places = [larger[place] for place in places]
    return places
