"""Landmarks of a sample: small regions of rare color, by which repeats are recognized."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.relief import LOOK, smaller_copy
from weftex.exemplar import Exemplar
from weftex.raster.arrays import Mask
from weftex.raster.boxes import cells_as_pixels, extended_sums
from weftex.raster.masks import grown

_SMALLEST = 64  # pixels a side; smaller samples have no landmarks
_FINEST = 2  # radius of the boxes, applied twice, whose means are compared
_RADII = (2, 4, 6)  # of others, on a copy half as large
_UNIT = 16  # of these means, to a level of 255
_FLOOR = 4.0  # levels that a color may differ by in any sample
_TYPICAL = 0.85  # share of the means that the covariance is taken from
_WHOLE = 2**28  # of the inverse covariance, so that distances are integers


@dataclass(frozen=True)
class _Tier:
    """What counts as a landmark, and how much of the sample landmarks may cover together."""

    distance: float  # least Mahalanobis distance of a mean
    times: float  # least ratio of that to the 95 % quantile of all means
    by_radius: tuple[float, ...]  # what distances count for, for each of these radii
    edge: float  # a landmark extends to this share of its largest distance
    margin: int  # pixels that are added around it
    least: float  # share of the sample
    most: float
    together: float


_RARE = _Tier(4.2, 1.45, (1.0, 1.0, 1.0, 1.0), 0.5, 4, 0.0, 0.03, 0.10)
_OTHERS = _Tier(2.4, 0.9, (1.0, 1.1, 1.2, 1.2), 0.6, 3, 0.0015, 0.05, 0.27)
_APART = 6  # pixels from a hole; what is nearer may go on inside
_LINES = (1, 12)  # radii of the boxes, applied twice, between which lines are seen
_SHARE = 0.3  # of the pixels that may be lines
_LONGEST = 16.0  # ratio of the variances along and across a landmark
_LEAST_SOLID = 0.6  # share of the ellipse of its variances that a landmark covers


def find_landmarks(exemplar: Exemplar, others: bool = True) -> tuple[list[Mask], int]:
    """Return masks (H, W) of landmarks, the rare ones first, and the number of rare ones.

    A color is rare by its Mahalanobis distance from most colors of the sample, at several scales;
    maps have no say. `others` are less salient, but are recognized where they repeat nearby.
    """
    small, step = smaller_copy(exemplar.changed(maps={}, guide=None), LOOK)
    usable = small.usable
    if min(small.shape) < _SMALLEST:
        return [], 0
    half, _ = smaller_copy(small, (max(small.shape) + 1) // 2)
    far = [_distances(small, _FINEST), *(_distances(half, radius) for radius in _RADII)]
    far[1:] = [(cells_as_pixels(one, 2, small.shape), typical) for one, typical in far[1:]]
    found = _with_tier(far, _RARE, usable, [])
    rare = len(found)
    found = _with_tier(far, _OTHERS, usable, found) if others else found
    return [cells_as_pixels(mask, step, exemplar.shape) for mask in found], rare


def has_joint_network(exemplar: Exemplar) -> bool:
    """Return whether the darkest or the brightest lines of a sample join all of its sides.

    So joints do, and cracks. Of grain, the darkest three tenths of the pixels are islands.
    """
    small, _ = smaller_copy(exemplar.changed(maps={}, guide=None), LOOK)
    usable = small.usable
    gray = np.where(usable, small.matching().sum(axis=2, dtype=np.int64), 0)
    fine, wide = (
        _UNIT * _smooth(gray, radius) // np.maximum(_smooth(usable.astype(np.int64), radius), 1)
        for radius in _LINES
    )
    for level in (fine - wide, wide - fine):
        most = np.sort(level[usable])[int(_SHARE * (int(usable.sum()) - 1))]
        mask = usable & (level <= most)
        if all(_connected(one, np.s_[0])[-1].any() for one in (mask, mask.T)):
            return True
    return False


def landmarks_shown_again(
    photo: Exemplar, hole: Mask, sources: NDArray[np.int32], wrap: tuple[bool, bool]
) -> Mask | None:
    """Return the rare landmarks of a photo apart from its hole, if a filling shows one of them.

    That is, if half of its pixels or more are sources of the hole. None if it shows none, or if
    landmarks may be joints.
    """
    masks, _ = find_landmarks(photo, others=False)
    shown, around = np.zeros_like(hole), grown(hole, _APART, wrap)
    shown.flat[sources[hole]] = True
    apart = [mask for mask in masks if not (mask & around).any()]
    again = any(2 * (mask & shown).sum() >= mask.sum() for mask in apart)
    if not again or has_joint_network(photo):
        return None
    return np.asarray(np.logical_or.reduce(apart))


def _distances(exemplar: Exemplar, radius: int) -> tuple[NDArray[np.float64], float]:
    """Return the Mahalanobis distance of the mean around each pixel, and the 95 % quantile."""
    pixels = exemplar.matching()
    usable = exemplar.usable
    weight = _smooth(usable.astype(np.int64), radius)
    sums = _smooth(pixels.astype(np.int64) * usable[..., None], radius)
    means = _UNIT * sums // np.maximum(weight, 1)[..., None]
    known = usable & (10 * weight > 3 * (2 * radius + 1) ** 4)
    if not known.any():
        return np.zeros(usable.shape), 1.0
    values = means[known][:: max(_FINEST, radius // 2) ** 2]
    typical, middle = values, np.sort(values, axis=0)[len(values) // 2]
    for trimmed in (False, True, True):
        if trimmed:
            middle = typical.sum(axis=0) // len(typical)
        inverse = _inverse_covariance(typical - middle, trimmed)
        squares = _squares(values - middle, inverse)
        order = np.argsort(squares, kind="stable")
        typical = values[order[: max(1, int(_TYPICAL * len(order)))]]
    distances = np.where(known, np.sqrt(_squares(means - middle, inverse) / _WHOLE), 0)
    return distances, float(np.sqrt(squares[order[int(0.95 * (len(order) - 1))]] / _WHOLE))


def _smooth(values: NDArray[np.int64], radius: int) -> NDArray[np.int64]:
    return extended_sums(extended_sums(values, radius), radius)


def _inverse_covariance(values: NDArray[np.int64], trimmed: bool) -> NDArray[np.int64]:
    """Return the inverse of the covariance of (N, K), rounded to integers times `_WHOLE`."""
    covariance = (1.25 if trimmed else 1) * (values.T @ values) / len(values)
    least = np.eye(len(covariance)) * (_FLOOR * _UNIT) ** 2
    return np.asarray(np.rint(np.linalg.inv(covariance + least) * _WHOLE), np.int64)


def _squares(values: NDArray[np.int64], inverse: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the squared Mahalanobis distances of (..., K), times `_WHOLE`."""
    squares: NDArray[np.int64] = np.einsum("...k,...k", values @ inverse, values)  # exact
    return np.maximum(squares, 0)


def _with_tier(
    far: list[tuple[NDArray[np.float64], float]], tier: _Tier, usable: Mask, found: list[Mask]
) -> list[Mask]:
    """Return the landmarks found before and those of a tier, the most salient first."""
    least = [max(tier.distance, tier.times * typical) for _, typical in far]
    ratios = zip(tier.by_radius, least, far, strict=True)
    relative = np.stack([factor / low * distances for factor, low, (distances, _) in ratios])
    found, free = list(found), usable & ~np.logical_or.reduce([~usable, *found])
    radius, left = relative.argmax(axis=0), np.where(free, relative.max(axis=0), 0)
    area, covered = int(usable.sum()), int(np.sum(found))
    reach = int(1.6 * (tier.most * area) ** 0.5) + tier.margin
    while left.max() >= 1:
        y, x = divmod(int(left.argmax()), left.shape[1])
        top, side = max(0, y - reach), max(0, x - reach)
        box = np.s_[top : y + reach + 1, side : x + reach + 1]
        near = relative[radius[y, x]][box] >= tier.edge * left[y, x]
        blob = _connected(near & free[box], (y - top, x - side))
        mask = grown(blob, tier.margin, (False, False)) & free[box]
        left[box][mask] = 0
        own, fits = int(mask.sum()), tier.least * area <= blob.sum() <= tier.most * area
        if fits and covered + own <= tier.together * area and _is_compact(blob):
            free[box] &= ~mask
            covered += own
            found.append(np.zeros_like(usable))
            found[-1][box] = mask
    return found


def _connected(mask: Mask, seeds: tuple[int, int] | slice | int) -> Mask:
    """Return the pixels of a mask that are connected with some of them, given by an index."""
    framed = np.pad(mask, 1)
    found = np.zeros_like(framed)
    found[1:-1, 1:-1][seeds] = mask[seeds]
    # Pixels of one row or column have one number if no other pixel is between them.
    shape = framed.shape
    numbers = [(~framed).cumsum().reshape(shape), (~framed.T).cumsum().reshape(shape[::-1]).T]
    count = 0
    while count < (count := int(found.sum())):
        for number in numbers:
            reached = np.zeros(framed.size + 1, bool)
            reached[number[found]] = True
            found = reached[number] & framed
    return found[1:-1, 1:-1]


def _is_compact(blob: Mask) -> bool:
    """Return whether a blob is neither a line nor a network."""
    spread = np.cov(np.nonzero(blob), bias=True) + np.eye(2) / 12
    area, trace = float(np.sqrt(np.linalg.det(spread))), float(spread.trace())
    is_long = trace**2 > (1 + _LONGEST) ** 2 / _LONGEST * area**2
    return not is_long and bool(blob.sum() >= _LEAST_SOLID * 4 * np.pi * area)
