"""Patch distribution: whether small patches look as they do in the sample, coarse to fine."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from weftex.quality.view import View, some, window_corners
from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_WIDTH = 7  # pixels of a patch
_SCALES = 4
_PATCHES = 4096  # of each picture and scale
_FEATURES = 48
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
        drawn = [_patches(half) for pair in own.halves for half in pair]
        whole, ours = _patches(own), _patches(made)
        if ours is None or whole is None or any(patches is None for patches in drawn):
            break
        features = _features(own.values.shape[2], scale)
        values = whole @ features
        floor = 0.5 * np.sqrt((features**2).sum(axis=0))  # a feature of less is rounding
        spread = np.maximum(values.std(axis=0, dtype=np.float64), floor)
        quantiles = [_quantiles(patches @ features) for patches in drawn if patches is not None]
        between = [_apart(quantiles[k], quantiles[k + 1], spread) for k in (0, 2)]
        apart = _apart(_quantiles(values), _quantiles(ours @ features), spread)
        found.append(apart / max(float(np.mean(between)), _FLOOR))
    if not found:
        return None, ()
    return float(np.sqrt(np.mean(np.square(found)))), tuple(found)


def _patches(view: View) -> NDArray[np.float32] | None:
    """Some patches (n, 7 * 7 * K), or None if there are fewer than 16."""
    corners = window_corners(view.usable, _WIDTH)
    if len(corners) < 16:
        return None
    y, x = np.divmod(some(corners, _PATCHES, "patches"), view.shape[1])
    windows = sliding_window_view(view.values, (_WIDTH, _WIDTH), axis=(0, 1))
    return windows[y, x].reshape(len(y), -1).astype(np.float32)


@lru_cache(maxsize=16)
def _features(channels: int, scale: int) -> NDArray[np.float32]:
    """Weights (K * 7 * 7, 48), whole and so small that sums in float32 are exact."""
    result = np.zeros((_FEATURES, channels, _WIDTH, _WIDTH), np.float32)
    for k in range(_FEATURES):
        bits = draw(0, "measure features", scale, k, np.arange(8 + channels))
        sizes = 1 + (bits[:4] % np.uint64(4)).astype(int)
        corners = (bits[4:8] % (_WIDTH + 1 - sizes).astype(np.uint64)).astype(int)
        mixture = (bits[8:] % np.uint64(3)).astype(int) - 1
        mixture = mixture if mixture.any() else np.ones(channels, int)
        boxes = []
        for y, x, h, w in ((*corners[:2], *sizes[:2]), (*corners[2:], *sizes[2:])):
            box = np.zeros((_WIDTH, _WIDTH), np.float32)
            box[y : y + h, x : x + w] = 1
            boxes.append(box)
        first, second = boxes
        if k % 4:  # a mean of one box in every fourth
            first = first * second.sum() - second * first.sum()
        if not first.any():
            first = boxes[0]
        result[k] = mixture[:, None, None] * first
    return np.ascontiguousarray(result.reshape(_FEATURES, -1).T)


def _quantiles(values: NDArray[np.float32]) -> Floats:
    """(features, quantiles)."""
    ordered = np.sort(np.ascontiguousarray(values.T), axis=1)
    at = (np.arange(_QUANTILES) + 0.5) / _QUANTILES * len(values)
    return ordered[:, at.astype(int)].astype(np.float64)


def _apart(first: Floats, second: Floats, spread: Floats) -> float:
    return float((abs(first - second).mean(axis=1) / spread).mean())
