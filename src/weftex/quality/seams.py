"""Seams: steps between neighboring pixels that the steps beside them do not predict."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import numpy as np

from weftex.quality.view import View, some
from weftex.raster.boxes import centered_sums

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]
    Model = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]

Kind = TypeVar("Kind", bound=np.generic)

_REACH = 3  # steps before and after that predict one
_ROWS = 2  # lines above and below
_LEARN = 2**14  # places
_ALONG = 8  # pixels to either side over which surprise is averaged along a line
_USUAL = 0.99  # quantile of the surprise; above it is a seam
_LONGEST_BORDER = 2048  # pixels a side that the border of a result is compared with
_BORDER = 2 * (_REACH + _ALONG)


class Seams:
    """A prediction of steps, fitted to a sample, and how surprising its own are; see `seams`.

    Parameters
    ----------
    sample : View
        Where it is too small or masked too much, `able` is False.
    """

    def __init__(self, sample: View) -> None:
        self._models = [_fit(sample.gray.T, sample.usable.T), _fit(sample.gray, sample.usable)]
        self.able = all(model is not None for model in self._models)
        if self.able:
            values = [self._along(sample, axis) for axis in (0, 1)]
            usable = [_whole(sample.usable, axis) for axis in (0, 1)]
            self.able = all(bool(place.any()) for place in usable)
        if self.able:
            self._usual = [
                float(np.quantile(value[place], _USUAL))
                for value, place in zip(values, usable, strict=True)
            ]
            self._own = [
                _own_rate(np.maximum(value - usual, 0), place)
                for value, place, usual in zip(values, usable, self._usual, strict=True)
            ]

    def _along(self, view: View, axis: int) -> Floats:
        """The surprise at each step along an axis: its prediction error over the usual one."""
        model = self._models[axis]
        assert model is not None
        gray = view.gray if axis else view.gray.T
        surprise = _pooled(_surprise(gray, model))
        return surprise if axis else surprise.T

    def excess(self, result: View, axis: int) -> tuple[Floats, float]:
        """Surprise above the sample's 99 % quantile, and its mean over the sample's own mean.

        Place [y, x] is the step from a pixel to the next along the axis; the outermost steps are
        left out.
        """
        over = np.maximum(self._along(result, axis) - self._usual[axis], 0)
        return over, float(over.mean(dtype=np.float64)) / self._own[axis]

    def fits(self, result: View) -> bool:
        """Whether a result is large enough to be looked at."""
        return min(result.shape) > _BORDER

    def border(self, result: View, axis: int) -> float:
        """The share of the border along an axis that is a seam; see `weftex.quality.wrap`."""
        usual = np.quantile(self._along(result.center(_LONGEST_BORDER), axis), _USUAL)
        across = np.take(result.values, np.arange(-_BORDER, _BORDER), axis)
        beside = View(across, np.ones(across.shape[:2], bool), result.axis, result.sample)
        found = self._along(beside, axis)
        return float((np.take(found, found.shape[axis] // 2, axis) > usual).mean())


def seams(model: Seams, result: View) -> float | None:
    """Compare how often and how strongly steps are not predicted.

    *Definition.* The step from each pixel to the next is predicted from the 30 steps beside it, in
    five lines, by weights that are fitted to the sample (least squares). The surprise is the error
    of this prediction, over the usual error where the steps beside are as large, averaged over 17
    pixels along the line. The figure is the mean excess of the surprise over the sample's 99 %
    quantile, divided by the same mean in that quarter of the sample that has most.

    *Unit.* 1 is as many and as strong as the sample's own. *Good.* Low, up to about 2. *Blind to*
    seams that are feathered or follow outlines, and to joints that end: what they break is not a
    line between two pixels.

    Parameters
    ----------
    model : Seams
        Of the sample.
    result : View
        From `views`.

    Returns
    -------
    float or None
        Mean of both directions; None for samples and results of less than about 30 pixels.
    """
    if not model.able or not model.fits(result):
        return None
    return float(np.mean([model.excess(result, axis)[1] for axis in (0, 1)]))


def seam_map(model: Seams, result: View) -> Floats | None:
    """Where the seams are, (H, W): 0 for none, 1 and more for what the sample hardly has."""
    if not model.able or not model.fits(result):
        return None
    found = np.zeros(result.shape, np.float32)
    for axis in (0, 1):
        over = model.excess(result, axis)[0]
        top, left = ((h - o) // 2 for h, o in zip(result.shape, over.shape, strict=True))
        part = found[top : top + over.shape[0], left : left + over.shape[1]]
        np.maximum(part, over, out=part)
    return found


def _steps(gray: Floats) -> Floats:
    return gray[:, 1:] - gray[:, :-1]


def _beside() -> list[tuple[int, int]]:
    across = [dx for dx in range(-_REACH, _REACH + 1) if dx]
    return [(dy, dx) for dy in range(-_ROWS, _ROWS + 1) for dx in across]


def _inner(steps: NDArray[Kind], dy: int = 0, dx: int = 0) -> NDArray[Kind]:
    """The steps that have all their neighbors, or their neighbors at (dy, dx)."""
    height, width = steps.shape
    rows = slice(_ROWS + dy, height - _ROWS + dy)
    return steps[rows, _REACH + dx : width - _REACH + dx]


def _fit(gray: Floats, usable: NDArray[np.bool_]) -> Model | None:
    """Fit the weights of the steps beside; mean squared errors by the activity of these steps."""
    height, width = gray.shape
    if height <= 2 * _ROWS + _ALONG or width <= 2 * _REACH + 2 * _ALONG:
        return None
    steps, whole = _steps(gray), usable[:, 1:] & usable[:, :-1]
    place = _inner(whole).copy()
    for dy, dx in _beside():
        place &= _inner(whole, dy, dx)
    places = some(np.flatnonzero(place), _LEARN, "steps")
    if len(places) < 200:
        return None
    y, x = np.divmod(places, place.shape[1])
    beside = np.stack([_inner(steps, *at)[y, x] for at in _beside()], axis=1).astype(np.float64)
    step = _inner(steps)[y, x].astype(np.float64)
    gram = np.einsum("ni,nj->ij", beside, beside, optimize=False)  # in one order everywhere
    ridge = 1e-4 * np.trace(gram) / len(gram) + len(places) / 12  # the rounding to bytes
    weights = np.linalg.solve(gram + ridge * np.eye(len(gram)), np.einsum("ni,n->i", beside, step))
    left = (step - beside @ weights) ** 2
    activity = (beside**2).mean(axis=1)
    order = np.argsort(activity, kind="stable")
    bins = np.array_split(order, min(24, len(places) // 50))
    knots = np.array([activity[part].mean() for part in bins])
    usual = np.array([left[part].mean() for part in bins]) + 1 / 6
    return weights, knots, np.maximum.accumulate(usual)


def _surprise(gray: Floats, model: Model) -> Floats:
    """The prediction error of each step over the usual one at its activity."""
    weights, knots, usual = model
    steps = _steps(gray)
    left, activity = _inner(steps).copy(), np.zeros_like(_inner(steps))
    for weight, at in zip(weights, _beside(), strict=True):
        beside = _inner(steps, *at)
        left -= np.float32(weight) * beside
        activity += beside * beside
    expected = np.interp(activity / len(weights), knots, usual)
    return np.sqrt(left * left / expected).astype(np.float32)


def _pooled(surprise: Floats) -> Floats:
    """Means along the lines."""
    sums = centered_sums(surprise, _ALONG, (0,))[_ALONG:-_ALONG]
    return (sums / (2 * _ALONG + 1)).astype(np.float32)


def _whole(usable: NDArray[np.bool_], axis: int) -> NDArray[np.bool_]:
    """Places of `Seams._along` whose steps, and all that predict them, are usable."""
    turned = usable if axis else usable.T
    whole = turned[:, 1:] & turned[:, :-1]
    place = _inner(whole).copy()
    for dy, dx in _beside():
        place &= _inner(whole, dy, dx)
    full = 2 * _ALONG + 1
    inside = centered_sums(place, _ALONG, (0,))[_ALONG:-_ALONG] > full - 0.5
    return inside if axis else inside.T


def _own_rate(over: Floats, place: NDArray[np.bool_]) -> float:
    """The mean in the quarter of the sample that has most, as all of a result may look like it."""
    rows, columns = (np.array_split(np.arange(side), 2) for side in over.shape)
    rates = [1e-3]
    for y in rows:
        for x in columns:
            inside = place[np.ix_(y, x)]
            if inside.any():
                rates.append(float(over[np.ix_(y, x)][inside].mean(dtype=np.float64)))
    return max(rates)
