"""Appearance: whether patches, colors, detail and repetition are as in the sample."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.lattice import Lattice
from weftex.analysis.pairs import multiples
from weftex.quality.view import View, beside_halves, middle, some, window_corners
from weftex.random import draw
from weftex.raster.arrays import Floats
from weftex.threads import one_blas_thread

_WIDTH = 7  # pixels of a patch
_SCALES = 4
_PATCHES = 4096  # of each picture and scale
_FEATURES = 48
_PATCH_QUANTILES = 128
_FLOOR = 0.03  # standard deviations: what two draws of so many patches differ by
_PIXELS = 2**15
_COLOR_QUANTILES = 256
_DIRECTIONS = 12
_COLOR_FLOOR = 1.0  # of 255
_ROUNDING = 1 / 12  # the variance of an error of up to half
_LAGS = 64  # pixels
_SAME = 0.02  # of correlations, which differ so much by chance
_CONFIDENCE = 0.5  # a lattice of less is not looked for in the result
_MULTIPLES = 3
_STEADY = 0.4  # of the sample's contrast, which its halves must have
_ROWS = 3  # rows that the sample must hold: fewer are no order
_FAINT = 0.08  # contrast of correlations, which the sample must have


def patch_distance(sample: View, result: View) -> float | None:
    """Return the distance of patch distributions over that of the sample's halves, 1 if as near.

    At each scale it is the mean of the features' Wasserstein distances, in standard deviations of
    the sample's; these count by their root mean square. None where the sample is too small.
    """
    found = []
    scales = zip(sample.pyramid(_SCALES), result.pyramid(_SCALES), strict=True)
    for scale, (own, made) in enumerate(scales):
        features = _features(own.values.shape[2], scale)
        views = [own, made, *(half for pair in own.halves for half in pair)]
        values = [one for view in views if (one := _described(view, features)) is not None]
        if len(values) < len(views):
            break
        floor = 0.5 * np.sqrt((features**2).sum(axis=1))  # a feature of less is rounding
        spread = np.maximum(values[0].std(axis=1, dtype=np.float64), floor)
        quantiles = [at_quantiles(part, _PATCH_QUANTILES) for part in values]
        apart, *between = (
            float((abs(first - second).mean(axis=1) / spread).mean())
            for first, second in zip(quantiles[::2], quantiles[1::2], strict=True)
        )
        found.append(apart / max(float(np.mean(between)), _FLOOR))
    return float(np.sqrt(np.mean(np.square(found)))) if found else None


def _described(view: View, features: NDArray[np.float32]) -> NDArray[np.float32] | None:
    """Return the features of some patches (48, n), or None for fewer than 16 patches."""
    corners = window_corners(view.usable, _WIDTH)
    if len(corners) < 16:
        return None
    y, x = np.divmod(some(corners, _PATCHES, "patches"), view.shape[1])
    patches = np.lib.stride_tricks.sliding_window_view(view.values, (_WIDTH,) * 2, axis=(0, 1))
    values = patches[y, x].reshape(len(y), -1).astype(np.float32)
    with one_blas_thread():  # sums of integers that float32 holds: the same in any order
        return features @ values.T


@lru_cache(maxsize=16)
def _features(channels: int, scale: int) -> NDArray[np.float32]:
    """Return integer weights (48, m) of a patch's K * 7 * 7 bytes.

    Features are means of random boxes, and differences of two, in random mixtures of the channels.
    """
    result = np.zeros((_FEATURES, channels, _WIDTH, _WIDTH), np.float32)
    for k in range(_FEATURES):
        bits = draw(0, "measure features", scale, k, np.arange(8 + channels))
        sizes = 1 + (bits[:4] % np.uint64(4)).astype(int)
        corners = (bits[4:8] % (_WIDTH + 1 - sizes).astype(np.uint64)).astype(int)
        mixture = (bits[8:] % np.uint64(3)).astype(int) - 1
        mixture = mixture if mixture.any() else np.ones(channels, int)
        first, second = boxes = np.zeros((2, _WIDTH, _WIDTH), np.int16)
        parts = zip(boxes, corners.reshape(2, 2), sizes.reshape(2, 2), strict=True)
        for box, (y, x), (h, w) in parts:
            box[y : y + h, x : x + w] = 1
        if k % 4:  # a mean of one box in every fourth
            first = first * second.sum() - second * first.sum()
        if not first.any():
            first = boxes[0]
        result[k] = first * mixture[:, None, None]
    return result.reshape(_FEATURES, -1)


def at_quantiles(values: NDArray[np.float32], number: int) -> Floats:
    """Return the values in the middle of `number` equal parts of each sorted row."""
    ranks = ((np.arange(number) + 0.5) / number * values.shape[1]).astype(np.int64)
    return np.sort(values, axis=1)[:, ranks].astype(np.float64)


def color_distance(sample: View, result: View) -> float | None:
    """Return the distance of color distributions over that of the sample's halves, 1 if as near.

    The Wasserstein distance, in the mean over each channel and 12 random mixtures of them. Halves
    closer than 1 of 255 count as 1.
    """
    return beside_halves(sample, result, _colors_apart, _COLOR_FLOOR)


def _colors_apart(first: View, second: View) -> float | None:
    if not (first.usable.any() and second.usable.any()):
        return None
    values = [_color_values(view) for view in (first, second)]
    return float(abs(values[0] - values[1]).mean())


def _color_values(view: View) -> NDArray[np.float64]:
    # The spelling of a purpose is part of the bits that are drawn for it.
    places = some(np.flatnonzero(view.usable), _PIXELS, "colours")
    channels = view.values.shape[2]
    pixels = np.ascontiguousarray(view.values.reshape(-1, channels)[places].T, np.float32)
    bits = draw(0, "measure colours", np.arange(_DIRECTIONS)[:, None], np.arange(channels))
    mixtures = (bits % np.uint64(17)).astype(np.float32) - 8
    mixtures[~mixtures.any(axis=1)] = 1
    values, lengths = pixels, np.ones(channels)
    if channels > 1:
        # Products of small integers: exact, so the same on every machine.
        values = np.concatenate([pixels, np.einsum("dk,kn->dn", mixtures, pixels)])
        lengths = np.append(lengths, np.sqrt((mixtures.astype(np.float64) ** 2).sum(axis=1)))
    return at_quantiles(values, _COLOR_QUANTILES) / lengths[:, None]


def sharpness(sample: View, result: View) -> float | None:
    """Return the ratio of the root mean squares of detail, the difference from a 3x3 blur.

    Below 1 the result is blurred, above it has noise or hard edges. None for sides below 3, and
    masks that leave no detail.
    """
    own, made = _detail(sample), _detail(result)
    if own is None or made is None:
        return None
    return float(np.sqrt((made + _ROUNDING) / (own + _ROUNDING)))


def _detail(view: View) -> float | None:
    """Return the mean squared detail where all pixels of the blur are usable."""
    if min(view.shape) < 3:
        return None
    smooth, usable = view.gray.astype(np.float64), view.usable
    for _ in range(2):  # along the rows, and transposed along the columns
        smooth = ((smooth[:-2] + 2 * smooth[1:-1] + smooth[2:]) / 4).T
        usable = (usable[:-2] & usable[1:-1] & usable[2:]).T
    if not usable.any():
        return None
    return float(((view.gray[1:-1, 1:-1] - smooth) ** 2)[usable].mean())


def autocorrelation_distance(sample: View, result: View) -> float | None:
    """Return the distance of autocorrelations at short shifts; 1 is that of the sample's halves.

    The root mean square difference of the normalized autocorrelations (slow lighting subtracted)
    at shifts of up to a quarter of the sample's side, at most 64 pixels.
    """
    reach = min(_LAGS, min(sample.shape) // 4, min(result.shape) - 1)
    if reach < 2:
        return None

    def apart(first: View, second: View) -> float:
        # at short shifts, without the mirror image
        parts = [middle(view.correlation, 2 * reach + 1)[reach:] for view in (first, second)]
        return float(np.sqrt(np.mean((parts[0] - parts[1]) ** 2)))

    return beside_halves(sample, result, apart, _SAME)


def lattice_kept(sample: View, result: View, lattice: Lattice | None) -> float | None:
    """Return how periodic the result is at the sample's lattice: 1 as the sample, 0 not at all.

    At multiples of the vectors, up to three and half the sample's size: the highest correlation
    within two pixels, less that half-way between multiples; in the result over in the sample.
    None without a sure and steady lattice, and for results smaller than its vectors.
    """
    if lattice is None or lattice.confidence < _CONFIDENCE:
        return None
    if len(lattice.vectors) == 1:
        (x, y), (height, width) = lattice.vectors[0], sample.shape
        if abs(_ROWS * x) > width or abs(_ROWS * y) > height:
            return None
    own, made = (_contrast(view, lattice, sample.shape) for view in (sample, result))
    if own is None or made is None or own < _FAINT:
        return None
    parts = [_contrast(half, lattice, sample.shape) for pair in sample.halves for half in pair]
    steady = [part for part in parts if part is not None]
    kept = bool(steady) and np.mean(steady) >= _STEADY * own
    return max(0.0, made / own) if kept else None


def _contrast(view: View, lattice: Lattice, sample: tuple[int, int]) -> float | None:
    """Return the correlation at multiples within half the sample, less that between them."""
    limit = np.minimum(np.array(sample) // 2, 0.75 * np.array(view.shape))[::-1]
    multiples, between = (places[(abs(places) < limit).all(axis=1)] for places in _places(lattice))
    if not len(multiples) or not len(between):
        return None
    at = _highest(view.correlation, multiples, 2).mean()
    return float(at - _highest(view.correlation, between, 0).mean())


def _places(lattice: Lattice) -> tuple[Floats, Floats]:
    """Return multiples of the vectors as (x, y), and the places half-way between them."""
    vectors = np.array(lattice.vectors)
    if len(vectors) == 1:
        steps = np.arange(1, _MULTIPLES + 1)[:, None]
        return steps * vectors, (steps - 0.5) * vectors
    times = multiples(_MULTIPLES, (0, 0))  # in the right half; the rest mirrors it
    halves = np.concatenate([times - (0.5, 0), times - (0, 0.5), times - (0.5, 0.5)])
    return times @ vectors, halves @ vectors


def _highest(correlation: Floats, places: Floats, reach: int) -> Floats:
    """Return the highest correlation within `reach` of each place."""
    side = np.arange(-reach, reach + 1)
    (x, y), (height, width) = np.rint(places).astype(int).T, correlation.shape
    rows = ((y + height // 2)[:, None, None] + side[:, None]).clip(0, height - 1)
    columns = ((x + width // 2)[:, None, None] + side).clip(0, width - 1)
    return np.asarray(correlation[rows, columns].max(axis=(1, 2)))
