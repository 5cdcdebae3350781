"""Seams: steps between neighboring pixels that the steps around them do not predict."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.quality.view import View, some
from weftex.raster.boxes import centered_sums

Floats = NDArray[np.float32]
Model = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]

_REACH = 3  # steps before and after that predict one
_ROWS = 2  # lines above and below
_LEARN = 2**14  # places
_ALONG = 8  # pixels to either side over which surprise is averaged along a line
_USUAL = 0.99  # quantile of the surprise; above it is a seam
_LONGEST_BORDER = 2048  # pixels a side that the border of a result is compared with
_STRIP = 32  # lines that are predicted at a time, for the processor's cache
_JOINT = 0.1, 0.25  # shares of a border that one joint of many may show
_BORDER = 2 * (_REACH + _ALONG)
_ACROSS = [dx for dx in range(-_REACH, _REACH + 1) if dx]
#: Offsets (dy, dx) of the steps that predict one.
_AROUND = [(dy, dx) for dy in range(-_ROWS, _ROWS + 1) for dx in _ACROSS]


class StepModel:
    """A prediction of the step between two pixels by the 30 steps around it, in five lines.

    The surprise is the prediction error over the usual error where the steps around are as large,
    averaged over 17 pixels along the line. `able` is False for samples too small or too masked.
    """

    def __init__(self, sample: View) -> None:
        self._models = [_fit(sample.gray.T, sample.usable.T), _fit(sample.gray, sample.usable)]
        self.able = all(model is not None for model in self._models)
        if self.able:
            values = [self._surprise(sample, axis) for axis in (0, 1)]
            usable = [_whole(sample.usable, axis) for axis in (0, 1)]
            self.able = all(bool(place.any()) for place in usable)
        if self.able:
            self._usual = [float(np.quantile(values[k][usable[k]], _USUAL)) for k in (0, 1)]
            over = [np.maximum(values[k] - self._usual[k], 0) for k in (0, 1)]
            self._own = [_own_rate(over[k], usable[k]) for k in (0, 1)]

    def fits(self, result: View) -> bool:
        """Return whether sample and result are large enough to be measured."""
        return self.able and min(result.shape) > _BORDER

    def excess(self, result: View, axis: int) -> float:
        """Return the mean surprise above the sample's 99 % quantile, over the sample's own."""
        over = np.maximum(self._surprise(result, axis) - self._usual[axis], 0)
        return float(over.mean(dtype=np.float64)) / self._own[axis]

    def border_places(self, result: View, axis: int) -> NDArray[np.bool_]:
        """Return where along the border the surprise is beyond 99 % of that inside.

        Nowhere on one joint of many, if a line inside shows as much; without the outermost places.
        """
        inside = self._surprise(result.center(_LONGEST_BORDER), axis)
        usual = np.quantile(inside, _USUAL)
        most = float((inside > usual).mean(axis=1 - axis).max())
        across = np.take(result.values, np.arange(-_BORDER, _BORDER), axis)
        around = View(across, np.ones(across.shape[:2], bool), result.axis, result.sample)
        found = self._surprise(around, axis)
        places = np.take(found, found.shape[axis] // 2, axis) > usual
        return np.asarray(places & (not _JOINT[0] < places.mean() <= min(most, _JOINT[1])))

    def _surprise(self, view: View, axis: int) -> Floats:
        model = self._models[axis]
        assert model is not None
        surprise = _surprise(_steps(view.gray if axis else view.gray.T), model)
        return surprise if axis else surprise.T


def seams(model: StepModel, result: View) -> float | None:
    """Return the mean excess of surprise of both axes: 1 is as in the sample, more has seams.

    Blind to seams that are feathered or follow outlines, and to joints that end.
    """
    if not model.fits(result):
        return None
    return float(np.mean([model.excess(result, axis) for axis in (0, 1)]))


def wrap_seam(model: StepModel, result: View, wrap: tuple[bool, bool]) -> float | None:
    """Return the share of a tileable result's border that looks like a seam; the worse axis.

    About 0.01 where nothing shows, 0.5 to 1 where a picture does not tile. None where no axis
    wraps around, and where `seams` is None.
    """
    if not any(wrap) or not model.fits(result):
        return None
    return max(float(model.border_places(result, axis).mean()) for axis in (0, 1) if wrap[axis])


def _steps(gray: Floats) -> Floats:
    rows = np.ascontiguousarray(gray)
    return rows[:, 1:] - rows[:, :-1]


def _predictable(usable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return where a step and all steps around it are usable."""
    whole = usable[:, 1:] & usable[:, :-1]
    height, width = whole.shape
    shape = max(height - 2 * _ROWS, 0), max(width - 2 * _REACH, 0)
    place = np.ones(shape, bool)
    if 0 not in shape and not usable.all():
        for dy, dx in (*_AROUND, (0, 0)):
            rows = slice(_ROWS + dy, _ROWS + dy + shape[0])
            place &= whole[rows, _REACH + dx : _REACH + dx + shape[1]]
    return place


def _fit(gray: Floats, usable: NDArray[np.bool_]) -> Model | None:
    """Fit the weights of the steps around; return them, and mean squared errors by activity."""
    height, width = gray.shape
    if height <= 2 * _ROWS + _ALONG or width <= 2 * _REACH + 2 * _ALONG:
        return None
    place = _predictable(usable)
    places = some(np.flatnonzero(place), _LEARN, "steps")
    if len(places) < 200:
        return None
    y, x = np.divmod(places, place.shape[1])
    steps = _steps(gray)
    at = (y + _ROWS) * steps.shape[1] + x + _REACH
    step = steps.ravel()[at].astype(np.float64)
    shifts = [dy * steps.shape[1] + dx for dy, dx in _AROUND]
    around = steps.ravel()[at[:, None] + shifts].astype(np.float64)
    # Not by matrix products, whose order of summation is not the same everywhere.
    gram = np.einsum("ni,nj->ij", around, around)
    ridge = 1e-4 * np.trace(gram) / len(gram) + len(places) / 12  # the rounding to bytes
    weights = np.linalg.solve(gram + ridge * np.eye(len(gram)), np.einsum("ni,n->i", around, step))
    left = (step - np.einsum("ni,i->n", around, weights)) ** 2
    activity = (around**2).mean(axis=1)
    bins = np.array_split(np.argsort(activity, kind="stable"), min(24, len(places) // 50))
    knots = np.array([activity[part].mean() for part in bins])
    usual = np.array([left[part].mean() for part in bins]) + 1 / 6
    return weights, knots, np.maximum.accumulate(usual)


def _surprise(steps: Floats, model: Model) -> Floats:
    """Return the prediction error of each step over the usual one; means along lines."""
    weights, knots, usual = model
    height, width = steps.shape[0] - 2 * _ROWS, steps.shape[1] - 2 * _REACH
    error = steps[_ROWS:-_ROWS, _REACH:-_REACH].copy()
    activity = np.zeros_like(error)
    for top in range(0, height, _STRIP):
        lines = np.s_[top : top + _STRIP]
        for (dy, dx), weight in zip(_AROUND, weights.astype(np.float32), strict=True):
            step = steps[_ROWS + dy :, _REACH + dx :][:height, :width][lines]
            error[lines] -= weight * step
            activity[lines] += step * step
    expected = np.interp(activity / np.float32(len(weights)), knots, usual)
    found = np.sqrt(error * error / expected).astype(np.float32)
    # Sums of all lines so far, less those of 17 lines ago.
    sums = np.pad(found.cumsum(axis=0, dtype=np.float64), [(1, 0), (0, 0)])
    pooled = 2 * _ALONG + 1
    return np.asarray((sums[pooled:] - sums[:-pooled]) / pooled, np.float32)


def _whole(usable: NDArray[np.bool_], axis: int) -> NDArray[np.bool_]:
    """Return where the averaged steps, and all that predict them, are usable."""
    place, full = _predictable(usable if axis else usable.T), 2 * _ALONG + 1
    inside = centered_sums(place, _ALONG, (0,))[_ALONG:-_ALONG] > full - 0.5
    return inside if axis else inside.T


def _own_rate(over: Floats, place: NDArray[np.bool_]) -> float:
    """Return the mean of the sample's worst quarter, as all of a result may look like it."""
    rows, columns = (np.array_split(np.arange(side), 2) for side in over.shape)
    rates = [1e-3]
    for y in rows:
        for x in columns:
            inside = place[np.ix_(y, x)]
            if inside.any():
                rates.append(float(over[np.ix_(y, x)][inside].mean(dtype=np.float64)))
    return max(rates)
