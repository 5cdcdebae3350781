"""The score: in which order a viewer would put pictures that were made from one sample."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.lattice import Lattice, find_lattice
from weftex.exemplar import Exemplar
from weftex.quality.appearance import autocorrelation_distance, lattice_kept
from weftex.quality.seams import StepModel, seams
from weftex.quality.view import View, middle, view_beside, view_of, window_corners
from weftex.raster.boxes import cells_as_pixels
from weftex.raster.levels import resized
from weftex.results.synthesis import Synthesis
from weftex.threads import one_blas_thread

Floats = NDArray[np.float32]
Places = NDArray[np.int32]

WEIGHTS = {
    "worst": 3.25,
    "uneven": 3.63,
    "alike": 1.08,
    "lattice": 6.08,
    "autocorrelation": 1.55,
    "seams": 0.74,
}
"""Weights of the terms, fitted to judged pictures by benchmarks/quality/judged/agreement.py."""

_SIDE = 32  # pixels, about, of the sample's shorter side at the coarse level
_MAX_WINDOWS = 1600  # of a picture
_EXACT = 2**23  # float32 holds the mean of squared distances below it exactly
_QUANTILE = 0.97
_VISIBLE = 0.05  # of the sample's contrast: a distance that is visible
_ROUNDING = 0.05  # what rounding to few bits adds to a distance
_CELLS = 4  # a side, to count how evenly the sample is used
_LARGER_PHOTO = 0.5  # the closeness that the windows of a larger photo may gain
_AUTOCORRELATION_SCALE = 10.0
_BROKEN = 8.0  # weight of `broken` where results are chosen; the score is not fitted to it
_LARGEST_SCORED = 1024  # pixels a side of the middle by which a larger output is scored
_DIGITS = 3


def terms(figures: Mapping[str, Any]) -> dict[str, float]:
    """Return the terms of the score before weighting: 0 is perfect; unknown terms are left out."""
    known = {name: float(figures[name]) for name in WEIGHTS if figures.get(name) is not None}
    if "worst" in known:
        known["worst"] = math.log1p(known["worst"])
    if "lattice" in known:  # more regular than the sample is no fault
        known["lattice"] = max(1 - known["lattice"], 0.0)
    if "autocorrelation" in known:
        known["autocorrelation"] = math.log1p(_AUTOCORRELATION_SCALE * known["autocorrelation"])
    if "seams" in known:  # fewer seams than the sample's own are no merit
        known["seams"] = math.log(max(known["seams"], 1.0))
    return known


def weigh(figures: Mapping[str, Any]) -> float | None:
    """Return the score of a picture with these figures, or None if none of them is known."""
    found = terms(figures)
    return math.fsum(WEIGHTS[name] * found[name] for name in found) if found else None


class Rating(NamedTuple):
    """The score, and the same with `broken`, which sees stepped joints: the lowest is the best.

    The score is 0 for the sample itself. Of two pictures whose scores differ by d, judges prefer
    the lower in a share 1 / (1 + exp(-d)). Figures that cannot be measured add nothing.
    """

    score: float | None = None
    choice: float = math.inf


class Scorer:
    """Scores pictures that were made from one sample."""

    def __init__(self, exemplar: Exemplar) -> None:
        self.exemplar = exemplar
        self._levels = max(1, 1 + round(math.log2(min(exemplar.shape) / _SIDE)))
        self.own = view_of(exemplar)
        own = self.own.pyramid(self._levels)[-1]
        self._width = max(2, min(own.shape) // 3)
        values = self._width**2 * own.values.shape[2]
        self._shift = next(s for s in range(9) if values * (255 >> s) ** 2 < _EXACT)
        self._own = self._windows(own)
        if len(self._own):
            contrast = own.values[own.usable].astype(np.float64).var(axis=0).mean()
            self._visible = _VISIBLE * float(contrast) / 4**self._shift + _ROUNDING
            self._usual = self._between_halves(own.shape)
            self._own_closeness = self._closeness(self._own)

    @cached_property
    def lattice(self) -> Lattice | None:
        """The lattice of the sample."""
        return find_lattice(self.exemplar)

    @cached_property
    def steps(self) -> StepModel:
        """The prediction of steps, fitted to the sample."""
        return StepModel(self.own)

    def view(self, picture: NDArray[Any]) -> View:
        """Return the view of a picture in the sample's terms."""
        return view_beside(self.own, self.exemplar, picture)

    def windows(self, made: View) -> dict[str, float]:
        """Compare windows of a picture with the sample's; empty where the picture is too small."""
        windows = self._windows(made.pyramid(self._levels)[-1])
        if not len(windows) or not len(self._own):
            return {}
        apart, which = nearest(windows, self._own)
        closeness = self._closeness(windows) - self._own_closeness
        usual = self._usual + self._visible
        return {  # 1 is the distance between windows of the sample's halves
            "broken": float(np.sqrt(apart).mean(dtype=np.float64)) / math.sqrt(usual),
            "worst": float(np.quantile(apart, _QUANTILE)) / usual,
            "uneven": self._uneven(self._own.places[which]),
            # How much nearer to each other windows are than the sample's, as a logarithm.
            "alike": max(0.0, closeness - _LARGER_PHOTO),
        }

    def broken_map(self, made: View) -> NDArray[np.float64] | None:
        """Return `broken` of the windows around each pixel, (H, W); None where there are none."""
        coarse = made.pyramid(self._levels)[-1]
        windows = self._windows(coarse)
        if not len(windows) or not len(self._own):
            return None
        apart = np.sqrt(nearest(windows, self._own)[0] / (self._usual + self._visible))
        total, count = np.zeros((2, *coarse.shape))
        for (y, x), one in zip(windows.places.tolist(), apart.tolist(), strict=True):
            total[y : y + self._width, x : x + self._width] += one
            count[y : y + self._width, x : x + self._width] += 1
        means: NDArray[np.float64] = total / np.maximum(count, 1)
        return cells_as_pixels(means, 2 ** (self._levels - 1), made.shape)

    def figures(
        self, made: View, step: Callable[[float], None] = lambda _: None
    ) -> dict[str, float | None]:
        """Return the figures that the score adds up; none where a mask leaves no whole window."""
        if not len(self._own):
            return {}
        found: dict[str, float | None] = {**self.windows(made)}
        step(1)
        found["lattice"] = lattice_kept(self.own, made, self.lattice)
        step(1)
        found["autocorrelation"] = autocorrelation_distance(self.own, made)
        step(1)
        found["seams"] = seams(self.steps, made)
        return found

    def rate(self, picture: NDArray[Any]) -> Rating:
        """Return the score of a picture and the number by which pictures are chosen."""
        figures = self.figures(self.view(picture))
        score, broken = weigh(figures), figures.get("broken") or 0.0
        return Rating() if score is None else Rating(score, score + _BROKEN * math.log1p(broken))

    def _windows(self, view: View) -> Windows:
        """Return the usable windows on a grid, in few enough bits that distances are exact."""
        width, (height, across) = self._width, view.shape
        length = width**2 * view.values.shape[2]
        if min(height, across) < width:
            return Windows(np.zeros((0, length), np.float32), np.zeros((0, 2), np.int32))
        rows, columns = height - width + 1, across - width + 1
        step = max(1, math.ceil(math.sqrt(rows * columns / _MAX_WINDOWS)))
        places = np.stack(np.divmod(window_corners(view.usable, width), across), axis=1)
        places = places[(places % step == 0).all(axis=1)]
        bits = view.values >> self._shift
        found = np.lib.stride_tricks.sliding_window_view(bits, (width, width), axis=(0, 1))
        values = found[places[:, 0], places[:, 1]].reshape(len(places), length)
        return Windows(values.astype(np.float32), places.astype(np.int32))

    def _uneven(self, source: Places) -> float:
        """Return the relative entropy of the use of cells to an even use."""
        own = self._own.places
        sides = own.max(axis=0) + 1
        even, used = (
            np.bincount((place * _CELLS // sides) @ np.array([_CELLS, 1]), minlength=_CELLS**2)
            / len(place)
            for place in (own, source)
        )
        some = used > 0
        return max(0.0, float((used[some] * np.log(used[some] / even[some])).sum()))

    def _between_halves(self, shape: tuple[int, int]) -> float:
        """Return the mean distance from windows of one half to the nearest of the other.

        Of upper and lower, and left and right half the larger; 0 where no window fits a half.
        """
        found = [0.0]
        for axis, side in enumerate(shape):
            at = self._own.places[:, axis]
            first = self._own.of(at + self._width <= side // 2)
            second = self._own.of(at >= side - side // 2)
            if len(first) and len(second):
                apart = np.concatenate([nearest(second, first)[0], nearest(first, second)[0]])
                found.append(float(apart.mean(dtype=np.float64)))
        return max(found)

    def _closeness(self, windows: Windows) -> float:
        """Return minus the mean logarithm of distances to the nearest window without overlap."""
        apart = nearest(windows, windows, self._width)[0]
        known = apart[np.isfinite(apart)].astype(np.float64)
        return -float(np.log(known + self._visible / 2).mean()) if len(known) else 0.0


class MapsScorer:
    """Scores results by the sample's color and maps.

    The score is a mean of scores. All maps together count as much as the color, each by its
    weight in matching; maps of labels do not count.
    """

    def __init__(self, exemplar: Exemplar) -> None:
        self._color = Scorer(exemplar)
        self._maps: list[tuple[Scorer, float]] = []
        for name, weight in exemplar.weights.items():
            one = exemplar.map(name)
            if weight > 0 and one.role.kind != "labels":
                if exemplar.mask is not None:
                    usable = resized(exemplar.mask.astype(np.float32), exemplar.scale_of(name)) == 1
                    if not usable.any():
                        continue
                    one = one.changed(mask=usable)
                self._maps.append((Scorer(one), weight / len(exemplar.maps)))

    def rate(self, made: Synthesis) -> Rating:
        """Rate the middle 1024x1024 pixels; nothing is known where the color has no score."""
        total, choice = self._color.rate(middle(made.image, _LARGEST_SCORED))
        if total is None:
            return Rating()
        weights = 1.0
        for scorer, weight in self._maps:
            found = scorer.rate(middle(made.render(scorer.exemplar), _LARGEST_SCORED))
            if found.score is not None:
                total, choice = total + weight * found.score, choice + weight * found.choice
                weights += weight
        return Rating(round(total / weights, _DIGITS), round(choice / weights, _DIGITS))


@dataclass(frozen=True, eq=False)
class Windows:
    """Square windows of a picture: their numbers (n, m); their rows and columns (n, 2)."""

    values: Floats
    places: Places

    def __len__(self) -> int:
        return len(self.places)

    def of(self, chosen: NDArray[np.bool_]) -> Windows:
        """Return the chosen windows."""
        return Windows(self.values[chosen], self.places[chosen])


def nearest(first: Windows, second: Windows, least: int = 0) -> tuple[Floats, NDArray[np.intp]]:
    """Find for each window the nearest of `second`, the first of equals.

    Windows less than `least` rows and columns apart are not compared. Returns mean squared
    differences, infinite where none is compared, and indices into `second`.
    """
    with one_blas_thread():  # sums of integers below `_EXACT`: the same in any order
        apart = first.values @ second.values.T
    apart *= -2
    apart += (first.values**2).sum(axis=1)[:, None]
    apart += (second.values**2).sum(axis=1)
    if least:
        rows, columns = (
            abs(np.subtract.outer(one, other)) < least
            for one, other in zip(first.places.T, second.places.T, strict=True)
        )
        apart[rows & columns] = np.inf
    which = apart.argmin(axis=1)
    best: Floats = np.take_along_axis(apart, which[:, None], 1)[:, 0]
    return best / np.float32(first.values.shape[1]), which
