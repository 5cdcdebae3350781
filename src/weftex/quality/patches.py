"""Patches: whether small patches look as they do in the sample, at four scales."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from weftex.quality import patch_kernels as kernels
from weftex.quality.view import View, some, window_corners
from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_WIDTH = 7  # pixels of a patch
_SCALES = 4
_PATCHES = 4096  # of each picture and scale
_FEATURES = 48
_SIMD = 16  # numbers that a processor multiplies at once
_QUANTILES = 128
_FLOOR = 0.03  # standard deviations: what two draws of so many patches differ by


def patch_distance(sample: View, result: View) -> tuple[float | None, tuple[float, ...]]:
    """Return the distance of patch distributions over that of the sample's halves, and each scale.

    Patches of 7x7 pixels at four scales are described by 48 features: means of random boxes, and
    differences of two, in random mixtures of the channels. The distance at a scale is the mean of
    the features' Wasserstein distances in standard deviations of the sample's; the first value is
    the root mean square over the scales. None where the sample is too small.
    """
    found = []
    scales = zip(sample.pyramid(_SCALES), result.pyramid(_SCALES), strict=True)
    for scale, (own, made) in enumerate(scales):
        features = _features(own.values.shape[2], scale)
        drawn = [_described(half, features) for pair in own.halves for half in pair]
        values, ours = _described(own, features), _described(made, features)
        if ours is None or values is None or any(part is None for part in drawn):
            break
        squares = (features.astype(np.float32) ** 2).sum(axis=1)
        floor = 0.5 * np.sqrt(squares)  # a feature of less is rounding
        spread = np.maximum(values.std(axis=1, dtype=np.float64), floor)
        quantiles = [at_quantiles(part, _QUANTILES) for part in drawn if part is not None]
        between = [_apart(quantiles[k], quantiles[k + 1], spread) for k in (0, 2)]
        apart = _apart(at_quantiles(values, _QUANTILES), at_quantiles(ours, _QUANTILES), spread)
        found.append(apart / max(float(np.mean(between)), _FLOOR))
    if not found:
        return None, ()
    return float(np.sqrt(np.mean(np.square(found)))), tuple(found)


def _described(view: View, features: NDArray[np.int16]) -> NDArray[np.int32] | None:
    """Return the features of some patches (48, n), or None for fewer than 16 patches."""
    corners = window_corners(view.usable, _WIDTH)
    if len(corners) < 16:
        return None
    corners = some(corners, _PATCHES, "patches")
    values = np.ascontiguousarray(view.values)
    found = np.empty((_FEATURES, len(corners)), np.int32)
    scratch = np.zeros(features.shape[1], np.int16)
    kernels.describe(values, corners, _WIDTH, features, scratch, found)
    return found


@lru_cache(maxsize=16)
def _features(channels: int, scale: int) -> NDArray[np.int16]:
    """Return weights (48, m) of a patch's 7 * 7 * K bytes, padded to a multiple of 16."""
    result = np.zeros((_FEATURES, _WIDTH, _WIDTH, channels), np.int16)
    for k in range(_FEATURES):
        bits = draw(0, "measure features", scale, k, np.arange(8 + channels))
        sizes = 1 + (bits[:4] % np.uint64(4)).astype(int)
        corners = (bits[4:8] % (_WIDTH + 1 - sizes).astype(np.uint64)).astype(int)
        mixture = (bits[8:] % np.uint64(3)).astype(int) - 1
        mixture = mixture if mixture.any() else np.ones(channels, int)
        boxes = []
        for y, x, h, w in ((*corners[:2], *sizes[:2]), (*corners[2:], *sizes[2:])):
            box = np.zeros((_WIDTH, _WIDTH), np.int16)
            box[y : y + h, x : x + w] = 1
            boxes.append(box)
        first, second = boxes
        if k % 4:  # a mean of one box in every fourth
            first = first * second.sum() - second * first.sum()
        if not first.any():
            first = boxes[0]
        result[k] = first[..., None] * mixture
    flat = result.reshape(_FEATURES, -1)
    return np.pad(flat, [(0, 0), (0, -flat.shape[1] % _SIMD)])


def at_quantiles(values: NDArray[np.int32], number: int) -> Floats:
    """Return the values in the middle of `number` equal parts of each sorted row."""
    ranks = ((np.arange(number) + 0.5) / number * values.shape[1]).astype(np.int64)
    return np.sort(values, axis=1)[:, ranks].astype(np.float64)


def _apart(first: Floats, second: Floats, spread: Floats) -> float:
    return float((abs(first - second).mean(axis=1) / spread).mean())
