"""Pyramids of the sample and of the canvas, to match coarse to fine; not in the paper."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.graphcut import match_kernels as kernels
from weftex.search.translation import Spectra, fast_size

if TYPE_CHECKING:
    from numpy.typing import NDArray


_TOGETHER = 3  # places that one call looks up


@dataclass(frozen=True, eq=False)
class Level:
    """A picture uint8 (H, W, K), and 1 where a pixel counts, uint8 (H, W)."""

    pixels: NDArray[np.uint8]
    mask: NDArray[np.uint8]

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
    kernels.gather(canvas.pixels, canvas.mask, rows, columns, box.pixels, box.mask)
    return box


def _blank(rows: int, columns: int, like: Level) -> Level:
    pixels = np.empty((rows, columns, like.pixels.shape[2]), np.uint8)
    return Level(pixels, np.empty((rows, columns), np.uint8))


def on_levels(allowed: NDArray[np.uint8], levels: list[Level]) -> list[NDArray[np.uint8]]:
    """The allowed pixels that each level has."""
    result = []
    for k, level in enumerate(levels):
        height, width = level.mask.shape
        result.append(np.ascontiguousarray(allowed[:: 1 << k, :: 1 << k][:height, :width]))
    return result


def coarsest(boxes: list[Level], allowed: list[NDArray[np.uint8]]) -> int:
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
    allowed: list[NDArray[np.uint8]],
    offset: Sequence[int],
    map_: Callable[..., Any] = map,
) -> list[tuple[int, int]]:
    """Find places of the smallest level on larger and larger ones: the best of each and beside it.

    The corner of the box lies on place - offset of the sample, in full size. All lists go from the
    full size on; `map_` may use threads.
    """
    steps = []
    for k in range(len(boxes) - 2, -1, -1):
        box, sample, at = boxes[k], samples[k], np.array(offset, np.int32) >> k
        both = box.pixels, box.mask, sample.pixels, sample.mask
        steps.append(partial(kernels.nudge, *both, allowed[k], at, sample.all_count))
    # Places side by side often lead to the same one, which is looked up once in full size.
    for some in (steps[:-1], steps[-1:]):
        different = list(dict.fromkeys(places))
        parts = [different[k : k + _TOGETHER] for k in range(0, len(different), _TOGETHER)]
        found = chain.from_iterable(map_(partial(_in_larger, some), parts))
        larger = dict(zip(different, found, strict=True))
        places = [larger[place] for place in places]
    return places


def _in_larger(
    steps: Sequence[Callable[..., Any]], places: list[tuple[int, int]]
) -> list[tuple[int, int]]:
    """The best matches on one larger level after the other."""
    found = np.array(places, np.int32)
    for nudge in steps:
        found *= 2
        nudge(found)
    return [(y, x) for y, x in found.tolist()]
