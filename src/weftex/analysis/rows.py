"""Rows: the period of a sample that repeats along one direction only, such as boards or courses.

Along a row anything may happen, but between rows there are joints, or edges at least. Edges added
up along lines of one direction leave these (see `weftex.analysis.joints`). Rows are those of the
direction and distance at which the sums correlate with themselves most above what is half and a
third of the way to it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.joints import Joints, alike, width_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_CLOSEST = 5.0  # pixels from row to row, at least
_FINEST = 3.0  # of the pixels that all directions are tried on
_STEP = 0.5  # pixels between distances that are tried
_RIDGES = 8  # rows whose joints are rated, as far as the sample has them
_FEWEST = 2  # rows away from any that must be in the sample
_REACH = 0.8  # of what is across: the farthest that is rated
_COARSE_SIDE = 192  # pixels a side of what all directions are tried on
_COARSE = np.deg2rad(np.arange(0, 180, 2.0))
_FINE = [np.deg2rad(np.arange(-n, n + 1) * step) for n, step in ((3, 2.0), (3, 0.5), (1, 0.25))]
_NEAR = 0.05  # of a distance, within which a finer look looks for it
_PARTS = 7  # closer rows that are tried
_AS_HIGH, _SURER = 0.8, 0.5  # of the contrast, that closer rows must have; the same if surer
_HIGHER = 0.5  # of its height: the most that every second row is above the others
_EVEN = 0.1  # of the variance of the strongest family's sums; less is nothing
_LIKE = 0.3  # correlation that every second row must have for that
_ERRORS = 3.0  # standard errors that tones of every second row must be above the others
_PHASES = (0.0, 1 / 2, 1 / 3, 2 / 3)


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows, and what tells them.

    Attributes
    ----------
    vector : float64 array (2,)
        From one to the next, as (x, y).
    contrast : float
        How far the correlation of joints at multiples is above that between them, -2 to 2.
    chance : float
        The standard error of that.
    number : int
        Of multiples.
    apart : float
        The variance of sums along the rows over that along other directions.
    """

    vector: Floats
    contrast: float
    chance: float
    number: int
    apart: float = 1.0

    @property
    def sure(self) -> float:
        """Standard errors that the contrast is."""
        return self.contrast / max(self.chance, 1e-9)

    @property
    def angle(self) -> float:
        """The direction along the rows."""
        return math.atan2(-self.vector[0], self.vector[1])

    @property
    def distance(self) -> float:
        """Pixels from one to the next."""
        return math.hypot(*self.vector)


def find_rows(joints: Joints) -> Rows | None:
    """Find the rows that a sample's joints tell best, right or not.

    Parameters
    ----------
    joints : Joints
        The sample's edges.

    Returns
    -------
    Rows or None
        None for a sample that is too small or constant.

    Examples
    --------
    >>> from weftex.analysis.relief import Relief
    >>> ribs = np.add.outer(np.arange(90) % 9 / 9, np.zeros(60))[None]
    >>> rows = find_rows(Joints(Relief(ribs, np.ones((90, 60)), 1)))
    >>> abs(rows.vector).round().tolist(), rows.contrast > 1, rows.apart > 2
    ([0.0, 9.0], True, True)
    """
    coarse, step = joints.coarser(_COARSE_SIDE)
    if _REACH * min(joints.inner.shape) / _FEWEST <= _CLOSEST + 2 * step or not joints.parts.any():
        return None
    sums = [coarse.lines(angle) for angle in _COARSE]
    best, angle, distance, closest = 0.0, 0.0, 0.0, max(_CLOSEST / step, _FINEST)
    kind = 0
    for turn, first in zip(_COARSE, sums, strict=True):
        for which, line in enumerate((first, _tones(coarse, float(turn)))):
            profile = _profile(line)
            far = (len(profile) - 1) / _FEWEST
            found, rated = _nearest_best(profile, len(line), np.arange(closest, far, _STEP))
            if rated > best:
                best, angle, distance, kind = rated, float(turn), found * step, which
    if best <= 0:
        return None
    near = distance * np.linspace(1 - _NEAR, 1 + _NEAR, 41)
    # Sums along lines that are a little off are blurred, and then correlate more and are less.
    for offs in _FINE:
        turns = [angle + off for off in offs]
        angle = max(turns, key=lambda turn: _sharpness(_sums(joints, turn)[kind], near))
    edges, tones = _sums(joints, angle)
    edges = tones if kind else edges
    profile = _profile(edges)
    distance = float(near[np.argmax(_stands(profile, len(edges), near)[0])])
    distance = _divided(profile, _profile(tones), len(edges), distance)
    by_chance = _ERRORS * math.sqrt(distance / len(edges))  # rows of any tone come in turn, too
    doubled = _alternates(profile, distance, 0.0)
    doubled |= _alternates(_profile(tones), distance, by_chance)
    if doubled and not kind:
        distance *= 2
    # A grating has its edges at half of its period, or closer than rows can be; tones tell it.
    waves, far = _profile(tones), (len(profile) - 1) / _FEWEST
    other, rated = _nearest_best(waves, len(tones), np.arange(_CLOSEST, far, _STEP / 2))
    (contrast,), (chance,), _ = _stands(profile, len(edges), np.array([distance]))
    if rated > contrast - chance:
        distance, profile = _divided(waves, waves, len(tones), other), waves
    near = distance * np.linspace(0.98, 1.02, 33)
    distance = float(near[np.argmax([_height(profile, one) for one in near])])
    down = distance * np.array([-np.sin(angle), np.cos(angle)])
    rows = rated_rows(joints, down if down[0] / 8 + down[1] > 0 else -down)
    others = float(np.median([part.var() for part in sums]))
    return replace(rows, apart=float(coarse.lines(angle).var()) / max(others, 1e-12))


def rated_rows(joints: Joints, vector: Floats) -> Rows:
    """What tells rows that are given by the vector from one to the next; `apart` is left at 1.

    Where both sides of a rib have edges, these come twice as often as it does, and steps of tone
    tell it.
    """
    found = []
    for sums in _sums(joints, math.atan2(-vector[0], vector[1])):
        contrast, chance, number = _stands(_profile(sums), len(sums), np.array([np.hypot(*vector)]))
        found.append(Rows(np.asarray(vector), float(contrast[0]), float(chance[0]), int(number[0])))
    return max(found, key=lambda rows: rows.sure)


def lines_seen(joints: Joints, vectors: Floats) -> tuple[float, float]:
    """How surely joints tell the lines of a lattice, of the two families that they tell best.

    Parameters
    ----------
    joints : Joints
        The sample's edges.
    vectors : float64 array (2, 2)
        The shortest of the lattice.

    Returns
    -------
    (float, float)
        Standard errors that the contrast of sums is, the higher first.
    """
    area = abs(float(np.linalg.det(vectors)))
    told, spread = [], []
    for side in (vectors[0], vectors[1], vectors[0] + vectors[1], vectors[0] - vectors[1]):
        across = np.array([-side[1], side[0]]) * area / (side @ side)
        told.append(rated_rows(joints, across).sure)
        spread.append(float(joints.lines(math.atan2(side[1], side[0])).var()))
    # Lines aslant those of a strong family are all but even, and still have some of its period.
    least = _EVEN * max(spread)
    first, second, *_ = sorted(
        (sure if own >= least else 0.0 for sure, own in zip(told, spread, strict=True)),
        reverse=True,
    )
    return first, second


def _sums(joints: Joints, angle: float) -> tuple[Floats, Floats]:
    """Edges, and steps of tone, of lines of a direction."""
    return joints.lines(angle), _tones(joints, angle)


def _tones(joints: Joints, angle: float) -> Floats:
    """Steps of tone from line to line."""
    tones = joints.lines(angle, joints.levels * joints.inner)
    return np.diff(tones) if len(tones) > 1 else tones


def _profile(line: Floats) -> Floats:
    return alike(line, max(2, int(_REACH * len(line))))


def _stands(
    profile: Floats, size: int, distances: Floats
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """For each distance the contrast of its multiples, its standard error, and their number."""
    reach = len(profile)
    count = np.clip(((reach - 1) / distances).astype(np.int64), 1, _RIDGES)
    times = np.arange(1, _RIDGES + 1)[:, None]
    overlap = np.maximum(size - times * distances, 1.0)
    weights = np.where(times <= count, overlap, 0.0)
    weights /= weights.sum(axis=0)
    at = np.minimum(np.stack([times - phase for phase in _PHASES]) * distances, reach - 1)
    heights = np.interp(at, np.arange(reach), profile)
    multiples, *between = (heights * weights).sum(axis=1)
    wide = width_of(profile)
    chance = np.sqrt((weights**2 * wide / np.maximum(overlap, wide)).sum(axis=0))
    return multiples - np.max(between, axis=0), chance, count


def _nearest_best(profile: Floats, size: int, distances: Floats) -> tuple[float, float]:
    """The distance whose contrast stands out most, of those at which it is highest; by how much."""
    if len(distances) < 3:
        return 0.0, 0.0
    contrast, chance, _ = _stands(profile, size, distances)
    # Contrast that still grows at the farthest distance tried belongs to rows that are farther.
    peak = np.append(contrast[:-1] >= contrast[1:], False)
    peak[1:] &= contrast[1:] >= contrast[:-1]
    rated = np.where(peak, contrast - chance, -1.0)
    best = int(rated.argmax())
    return float(distances[best]), float(rated[best])


def _height(profile: Floats, distance: float) -> float:
    """The mean correlation at all multiples."""
    times = np.arange(1, max(2, int((len(profile) - 1) / distance) + 1))
    return float(np.interp(times * distance, np.arange(len(profile)), profile).mean())


def _sharpness(line: Floats, distances: Floats) -> float:
    """What of the sums' variance comes back at multiples: most where lines are along joints."""
    profile = _profile(line)
    return float(line.var()) * max(_height(profile, float(one)) for one in distances[::4])


def _divided(profile: Floats, tones: Floats, size: int, distance: float) -> float:
    """The closest rows of which every so many-th are these, and that are told as well.

    Steps of tone that come back at this distance and not at the closer one are against it.
    """
    (own,), (chance,), _ = _stands(profile, size, np.array([distance]))
    (tone,), _, _ = _stands(tones, size, np.array([distance]))
    for parts in range(_PARTS, 1, -1):
        closer = distance / parts * np.linspace(0.97, 1.03, 25)
        contrast, errors, _ = _stands(profile, size, closer)
        best = int(contrast.argmax())
        sure = contrast[best] / errors[best] >= own / chance
        alike = contrast[best] >= (_SURER if sure else _AS_HIGH) * own
        if tone > _LIKE:
            alike &= _stands(tones, size, closer)[0].max() >= _AS_HIGH * tone
        if closer[best] >= _CLOSEST and alike:
            return float(closer[best])
    return distance


def _alternates(profile: Floats, distance: float, by_chance: float) -> bool:
    """Whether every second row is more alike: edges lie at both sides of what repeats."""
    times = np.arange(1, int((len(profile) - 1) / distance) + 1)
    if len(times) < 2 * _FEWEST:
        return False
    heights = np.interp(times * distance, np.arange(len(profile)), profile)
    odd, even = float(heights[::2].mean()), float(heights[1::2].mean())
    return even > _LIKE and even - odd > max(_HIGHER * even, by_chance)
