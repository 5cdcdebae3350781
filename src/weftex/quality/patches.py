"""Patch distribution: whether small patches look as they do in the sample, coarse to fine."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from weftex.quality import patch_kernels as kernels
from weftex.quality.quantiles import at_quantiles
from weftex.quality.view import View, some, window_corners
from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_WIDTH = 7  # pixels of a patch
_SCALES = 4
_PATCHES = 4096  # of each picture and scale
_FEATURES = 48
_AT_ONCE = 16  # numbers that processors multiply at once
_QUANTILES = 128
_FLOOR = 0.03  # standard deviations: what two draws of so many patches differ by


def patch_distance(sample: View, result: View) -> tuple[float | None, tuple[float, ...]]:
    """Compare the distributions of patches.

    *Definition.* Patches of 7x7 pixels at four scales, each half of the one before, are described
    by 48 features: differences between the means of two boxes in it, and means of one box, in a
    random mixture of the channels. The distance at a scale is the mean over the features of the
    Wasserstein distance between both pictures' values, in standard deviations of the sample's; it
    is divided by the same distance between the sample's halves.

    *Unit.* 1 is as near as the sample's own halves are to each other. *Good.* Low: up to about 1;
    below 1 where a result shows the sample evenly. *Blind to* where in the picture patches are, so
    to repetition, and to anything larger than about 50 pixels.

    Parameters
    ----------
    sample, result : View
        From `views`.

    Returns
    -------
    (float or None, tuple of float)
        Root mean square over the scales, and each scale, finest first. None where the sample is
        too small for halves of a patch's size.
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
        quantiles = [_quantiles(part) for part in drawn if part is not None]
        between = [_apart(quantiles[k], quantiles[k + 1], spread) for k in (0, 2)]
        apart = _apart(_quantiles(values), _quantiles(ours), spread)
        found.append(apart / max(float(np.mean(between)), _FLOOR))
    if not found:
        return None, ()
    return float(np.sqrt(np.mean(np.square(found)))), tuple(found)


def _described(view: View, features: NDArray[np.int16]) -> NDArray[np.int32] | None:
    """Some patches by their features (48, n), or None if there are fewer than 16 patches."""
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
    """Weights (48, m) of a patch's 7 * 7 * K bytes, and zeros up to a multiple of 16."""
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
    return np.pad(flat, [(0, 0), (0, -flat.shape[1] % _AT_ONCE)])


def _quantiles(values: NDArray[np.int32]) -> Floats:
    """(features, quantiles)."""
    return at_quantiles(values, _QUANTILES).astype(np.float64)


def _apart(first: Floats, second: Floats, spread: Floats) -> float:
    return float((abs(first - second).mean(axis=1) / spread).mean())
