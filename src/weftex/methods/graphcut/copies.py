"""Smaller copies of the sample and of the canvas, to match on (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.graphcut import match_kernels as kernels
from weftex.methods.graphcut.draws import variance
from weftex.search.translation import Spectra, fast_size

if TYPE_CHECKING:
    from numpy.typing import NDArray


_TOGETHER = 3  # places that one call looks up


@dataclass(frozen=True, eq=False)
class Copy:
    """A picture uint8 (H, W, K), and 1 where a pixel counts, uint8 (H, W)."""

    pixels: NDArray[np.uint8]
    mask: NDArray[np.uint8]

    @cached_property
    def all_count(self) -> bool:
        """Whether all pixels count."""
        return bool(self.mask.all())

    @cached_property
    def variance(self) -> float:
        """Of the pixels that count."""
        return variance(self.pixels[self.mask != 0])

    @cached_property
    def spectra(self) -> Spectra:
        """To be matched with a picture that is not larger."""
        return self.spectra_of([fast_size(n) for n in self.mask.shape])

    @cached_property
    def kernel(self) -> kernels.Copy:
        """For kernels."""
        return kernels.Copy(self.pixels, self.mask, np.empty((len(self.mask), 2), np.int32))

    def part(self, top: int, left: int, height: int, width: int) -> Copy:
        """A part of it."""
        here = np.s_[top : top + height, left : left + width]
        return Copy(*(np.ascontiguousarray(a[here]) for a in (self.pixels, self.mask)))

    def spectra_of(self, size: tuple[int, ...] | list[int]) -> Spectra:
        """To be matched by transforms of a size."""
        return Spectra(self.pixels, self.mask, tuple(size))


def copies_of(whole: Copy, reduction: int) -> list[Copy]:
    """The picture and copies half as large, a quarter, and so on.

    A pixel is the rounded mean of four. It counts if all of them do.

    Parameters
    ----------
    whole : Copy
        The picture.
    reduction : int
        The last copy is so many times smaller; a power of 2.
    """
    copies = [whole]
    while reduction > 1:
        rows, columns = (n // 2 for n in copies[-1].mask.shape)
        half = _blank(rows, columns, whole)
        kernels.make_half(copies[-1].kernel, half.pixels, half.mask)
        copies.append(half)
        reduction //= 2
    return copies


def box_of(canvas: Copy, rows: NDArray[np.int32], columns: NDArray[np.int32]) -> Copy:
    """Copy these rows and columns; nothing counts in those below 0."""
    box = _blank(len(rows), len(columns), canvas)
    kernels.gather_box(canvas.kernel, rows, columns, box.pixels, box.mask)
    return box


def _blank(rows: int, columns: int, like: Copy) -> Copy:
    pixels = np.empty((rows, columns, like.pixels.shape[2]), np.uint8)
    return Copy(pixels, np.empty((rows, columns), np.uint8))


def places_in_full(
    places: list[tuple[int, int]],
    boxes: list[Copy],
    samples: list[Copy],
    allowed: list[NDArray[np.uint8]],
    offset: Sequence[int],
    map_: Callable[..., Any] = map,
) -> list[tuple[int, int]]:
    """Find places that were found on the smallest copy in larger and larger ones.

    On each the best match is kept among the place and those beside it.

    Parameters
    ----------
    places : list of (row, column)
        On the smallest copy.
    boxes, samples : lists of Copy
        What is matched, and where, from the full size on.
    allowed : list of uint8 arrays (H, W)
        Where a place may be, likewise.
    offset : (int, int)
        In full size: the corner of the box lies on place - offset of the sample.
    map_ : callable
        Like `map`, perhaps in threads.
    """
    steps = []
    for k in range(len(boxes) - 2, -1, -1):
        sample, at = samples[k], np.array(offset, np.int32) >> k
        steps.append((boxes[k].kernel, sample.kernel, allowed[k], at, sample.all_count))
    # Places side by side often lead to the same one, which is looked up once in full size.
    for some in (steps[:-1], steps[-1:]):
        different = list(dict.fromkeys(places))
        parts = [different[k : k + _TOGETHER] for k in range(0, len(different), _TOGETHER)]
        found = chain.from_iterable(map_(partial(_in_larger, some), parts))
        larger = dict(zip(different, found, strict=True))
        places = [larger[place] for place in places]
    return places


def _in_larger(steps: list[Any], places: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The best matches on one larger copy after the other."""
    found = np.array(places, np.int32)
    for box, sample, where, at, whole in steps:
        found *= 2
        kernels.nudge_places(box, sample, where, at, found, whole)
    return [(y, x) for y, x in found.tolist()]
