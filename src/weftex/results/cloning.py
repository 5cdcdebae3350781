"""A filling joined to the photo around it: seamless cloning with a screen.

As in `weftex.results.joining`, (f' - g)^2 + ((f - h) / reach)^2 is least, with f = h on the known
pixels: the step across the outline of a hole is that of the sample, and its rest falls off inwards.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.exemplar import Exemplar
from weftex.raster.arrays import Floats
from weftex.results import height_kernels as kernels
from weftex.results.joining import ends_of, finer, has_squares

#: Pixels within which the tones of a filling are joined to those around it.
TONE_REACH = 24.0
_GRAIN = 64  # of a level, to which shifts are rounded, as machines differ in last digits
_SWEEPS = 7  # for each pixel of reach; what is left of a step then is below 1e-4


def join_filling(
    picture: NDArray[Any],
    given: Exemplar,
    layers: tuple[NDArray[np.int32], NDArray[np.float32]],
    canvas: Canvas,
    known_from: tuple[int, int] | None,
    scale: int,
    reach: float,
) -> None:
    """Join the filling of a picture (H, W[, C]), rendered from `given`, to its known pixels.

    `layers` are those of all output pixels, of which a pixel is 1 / `scale` as fine as the picture;
    `reach` is in output pixels.
    """
    if canvas.hole is None or not canvas.hole.any() or not has_squares(picture):
        return
    sources, _ = finer(layers[0][:, :, :1], layers[1][:, :, :1], scale)
    hole = canvas.hole.repeat(scale, 0).repeat(scale, 1)
    sample = given.pixels.reshape(*given.shape, -1)
    usable = np.ones(given.shape, bool)
    if known_from is not None:  # what marks the hole is no slope
        top, left = (at * scale for at in known_from)
        usable[top:, left:][: len(hole), : hole.shape[1]] &= ~hole
    colors, places = picture.reshape(*hole.shape, -1), sources[:, :, 0]
    if given.alpha:
        usable &= sample[..., -1] > 0
        places = np.where(colors[..., -1:] > 0, places, -1)
        colors, sample = colors[..., :-1], sample[..., :-1]
    ends = ends_of(colors, given.role.kind)
    _clone(colors, hole, places, sample, usable, canvas.wrap, reach * scale, ends)


def _clone(
    picture: NDArray[Any],
    hole: NDArray[np.bool_],
    sources: NDArray[np.int32],
    sample: NDArray[Any],
    usable: NDArray[np.bool_],
    wrap: tuple[bool, bool],
    reach: float,
    ends: tuple[Any, Any],
) -> None:
    """Join the filling of a hole to the known pixels of a picture (H, W, C), in place.

    `sources` (H, W, 2) are places in the sample, -1 for none; pixels that are not `usable` say
    nothing about slopes. Values are cut to the `ends`, the least and largest of each channel.
    """
    number = np.full(hole.shape, -1, np.int32)  # of the pixels of the hole
    number[hole] = np.arange(np.count_nonzero(hole), dtype=np.int32)
    beside = np.full((number.max() + 1, 4), -1, np.int32)  # their neighbors in the hole
    degree = np.zeros(len(beside))
    steps = np.zeros((picture.shape[2], len(beside)))
    for axis in (0, 1):
        last = np.zeros(hole.shape, bool)  # has no next pixel
        last[(slice(None),) * axis + (-1,)] = not wrap[axis]
        first = np.stack(np.nonzero((hole | np.roll(hole, -1, axis)) & ~last), axis=1)
        second = first.copy()
        second[:, axis] = (second[:, axis] + 1) % hole.shape[axis]
        numbers = [number[tuple(end.T)] for end in (first, second)]
        for k, (own, other) in enumerate((numbers, numbers[::-1])):
            inside = own >= 0
            beside[own[inside], 2 * axis + k] = other[inside]
            degree[own[inside]] += 1
        missing = _missing_steps(picture, sources, sample, usable, first, second, axis)
        for own, way in zip(numbers, (-1, 1), strict=True):
            inside = own >= 0
            for total, step in zip(steps, missing.T, strict=True):
                total += way * np.bincount(own[inside], step[inside], len(total))
    shifts = np.zeros_like(steps)
    step_size = 2 / (1 + 1 / max(math.sqrt(2) * reach, 1.0))  # of over-relaxation
    sweeps = math.ceil(_SWEEPS * reach)
    kernels.solve_screened(shifts, steps, beside, degree + reach**-2, step_size, sweeps)
    filled = picture[hole][None]
    least, most = (np.array(end, np.float64) for end in ends)
    kernels.add_shifts(filled, shifts[:, None], least, most, _GRAIN)
    picture[hole] = filled[0]


def _missing_steps(
    picture: NDArray[Any],
    sources: NDArray[np.int32],
    sample: NDArray[Any],
    usable: NDArray[np.bool_],
    first: NDArray[np.intp],
    second: NDArray[np.intp],
    axis: int,
) -> Floats:
    """How much more pixels differ in the sample than here, the `first` from the `second` (N, C)."""
    ways = np.eye(2, dtype=np.int32)[axis]
    here, there = sources[tuple(first.T)], sources[tuple(second.T)]
    cut = (there != here + ways).any(axis=1)  # within one piece slopes are the sample's
    slopes, count = np.zeros((np.count_nonzero(cut), picture.shape[2])), np.zeros(cut.sum())
    for at, way in ((here[cut], 1), (there[cut], -1)):
        beyond = at + way * ways
        valid = ((at >= 0) & (beyond >= 0) & (beyond < usable.shape)).all(axis=1)
        at, beyond = at[valid], beyond[valid]
        known = usable[tuple(at.T)] & usable[tuple(beyond.T)]
        rows = np.flatnonzero(valid)[known]
        ends = (sample[tuple(end[known].T)].astype(np.float64) for end in (beyond, at))
        slopes[rows] += way * np.subtract(*ends)
        count[rows] += 1
    ends = (picture[tuple(end[cut].T)].astype(np.float64) for end in (second, first))
    result = np.zeros((len(cut), picture.shape[2]))
    given = np.flatnonzero(cut)[count > 0]
    result[given] = (slopes / np.maximum(count, 1)[:, None] - np.subtract(*ends))[count > 0]
    return result
