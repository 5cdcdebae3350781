"""A picture as the measures see it: bytes, in the same terms for sample and result."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.correlation import correlate
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.random import draw
from weftex.raster.arrays import Floats, check_pixels
from weftex.raster.boxes import centered_sums, whole_windows
from weftex.raster.pyramids import gaussian_pyramid, mask_pyramid

Kind = TypeVar("Kind", bound=np.generic)

_LARGEST_TRANSFORM = 640  # pixels a side of which the autocorrelation is taken
_MARGIN = 2  # pixels around a shift in which the highest correlation is taken
_SMOOTH = 4  # slow lighting is the mean over a square of 1 / 4 of the side


@dataclass(frozen=True, eq=False)
class View:
    """A picture as the measures see it."""

    values: NDArray[np.uint8]  # (H, W, K) as `Exemplar.as_matching` makes them
    usable: NDArray[np.bool_]  # (H, W): True everywhere in a result
    axis: NDArray[np.int64]  # (K,): the direction in which the sample's color varies most
    sample: tuple[int, int]  # the sample's height and width

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.values.shape[0], self.values.shape[1]

    @cached_property
    def gray(self) -> NDArray[np.float32]:
        """Brightness along the axis, in the unit of `values`; (H, W)."""
        # Not a matrix product, whose threads wait for one another longer than it takes.
        along = np.zeros(self.shape, np.int32)
        for k, weight in enumerate(self.axis.astype(np.int32)):
            along += np.multiply(self.values[..., k], weight, dtype=np.int32)
        return along.astype(np.float32) / np.float32(np.sqrt(float(self.axis @ self.axis)))

    @cached_property
    def flat(self) -> NDArray[np.float32]:
        """`gray` less slow lighting, the mean around each pixel; 0 where it may not be used."""
        # The sample's shorter side says what slow lighting is.
        radius = max(1, min(self.sample) // (2 * _SMOOTH))
        share = self.usable.astype(np.float64)
        count = np.maximum(centered_sums(share, radius), 1)
        slow = centered_sums(self.gray * share, radius) / count
        return np.where(self.usable, self.gray - slow, 0).astype(np.float32)

    @cached_property
    def correlation(self) -> Floats:
        """Autocorrelation of `flat` up to half the sample, shift 0 in the middle of the array.

        Of a large picture that of its center.
        """
        part = self.center(_LARGEST_TRANSFORM)
        reach = self.sample[0] // 2 + _MARGIN, self.sample[1] // 2 + _MARGIN
        return correlate(part.flat[None].astype(np.float64), part.usable, reach)

    def part(self, top: int, left: int, height: int, width: int) -> View:
        """Return a part of the picture."""
        box = slice(top, top + height), slice(left, left + width)
        return View(self.values[box], self.usable[box], self.axis, self.sample)

    def center(self, widest: int) -> View:
        """Return the middle of a picture with longer sides than `widest`."""
        if max(self.shape) <= widest:
            return self
        values, usable = middle(self.values, widest), middle(self.usable, widest)
        return View(values, usable, self.axis, self.sample)

    @cached_property
    def halves(self) -> tuple[tuple[View, View], ...]:
        """Upper and lower half; left and right half."""
        height, width = self.shape
        y, x = height // 2, width // 2
        return (
            (self.part(0, 0, y, width), self.part(height - y, 0, y, width)),
            (self.part(0, 0, height, x), self.part(0, width - x, height, x)),
        )

    def pyramid(self, count: int) -> list[View]:
        """Return the picture and its coarser levels, each of half the size."""
        levels = [self]
        while len(levels) < count:
            levels.append(levels[-1].coarser)
        return levels

    @cached_property
    def coarser(self) -> View:
        """The picture at half its size."""
        values = gaussian_pyramid(self.values, 2)[1]
        sample = max(1, self.sample[0] >> 1), max(1, self.sample[1] >> 1)
        return View(values, mask_pyramid(self.usable, 2)[1], self.axis, sample)


def middle(values: NDArray[Kind], widest: int) -> NDArray[Kind]:
    """Return the middle of a picture, of sides of at most `widest` pixels."""
    top, left = (max(0, side - widest) // 2 for side in values.shape[:2])
    return values[top : top + widest, left : left + widest]


def view_of(sample: Exemplar) -> View:
    """Return the view of a sample."""
    values = sample.as_matching(sample.pixels)
    usable = sample.usable
    colors = values.reshape(-1, values.shape[2]) if sample.mask is None else values[usable]
    return View(values, usable, _axis(colors), sample.shape)


def view_beside(own: View, sample: Exemplar, result: NDArray[Any]) -> View:
    """Return the view of a result beside its sample's; refuses other channels and dtypes."""
    pixels = check_pixels(result, "result")
    theirs = sample.pixels
    if (pixels.shape[2:] or (1,)) != (theirs.shape[2:] or (1,)) or pixels.dtype != theirs.dtype:
        kinds = [f"{p.dtype} with {math.prod(p.shape[2:])} channels" for p in (pixels, theirs)]
        raise InvalidInputError(
            f"the result is {kinds[0]}, the sample {kinds[1]}; dtype and channels must be equal"
        )
    made = sample.as_matching(pixels)
    return View(made, np.ones(made.shape[:2], bool), own.axis, sample.shape)


def _axis(pixels: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return the first principal component of the colors, as integers up to 127."""
    levels, count = np.ascontiguousarray(pixels.T, np.float64), len(pixels)
    levels -= np.rint(levels.mean(axis=1, keepdims=True))
    sums = levels.sum(axis=1)  # whole numbers, like the products: the same in any order
    products = np.einsum("ki,li->kl", levels, levels)
    weights, vectors = np.linalg.eigh((products - np.outer(sums, sums) / count) / count)
    if not weights[-1] > 0:
        return np.ones(len(vectors), np.int64)
    first = vectors[:, -1] / abs(vectors[:, -1]).max()
    first = first if first.sum() >= 0 else -first
    return np.asarray(np.rint(127 * first), np.int64)


def window_corners(usable: NDArray[np.bool_], width: int) -> NDArray[np.int64]:
    """Return the flat indices of the upper left corners of all usable windows."""
    return np.flatnonzero(whole_windows(usable, (0, width - 1, 0, width - 1)))


def some(places: NDArray[np.int64], count: int, purpose: str) -> NDArray[np.int64]:
    """Return at most `count` of the places, the same in every run."""
    if len(places) <= count:
        return places
    bits = draw(0, f"measure {purpose}", np.arange(count))
    return places[(bits % np.uint64(len(places))).astype(np.int64)]


def beside_halves(
    sample: View, result: View, distance: Callable[[View, View], float | None], least: float
) -> float | None:
    """Return the distance of a result over that of the sample's halves, at least `least`."""
    apart, *between = (distance(*pair) for pair in ((sample, result), *sample.halves))
    known = [value for value in between if value is not None]
    return None if apart is None or not known else apart / max(float(np.mean(known)), least)
