"""The score: in which order a demanding eye would put pictures that were made from one sample."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.lattice import find_lattice
from weftex.exemplar import Exemplar
from weftex.quality import patch_kernels as kernels
from weftex.quality.lattice import lattice_kept
from weftex.quality.seams import Seams, seams
from weftex.quality.spectrum import autocorrelation_distance
from weftex.quality.view import View, view_beside, view_of, window_corners

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from weftex.analysis.lattice import Lattice

    Floats = NDArray[np.float32]
    Places = NDArray[np.int32]

_SIDE = 32  # pixels, about, of the sample's shorter side on the coarse copy
_MOST = 1600  # windows of a picture
_EXACT = 2**23  # of squared distances below it float32 holds every mean
_QUANTILE = 0.97
_AT_ONCE = 16  # numbers that processors multiply at once
_SEEN = 0.05  # of the sample's contrast: a distance that an eye sees, and half of it
_ROUNDING = 0.05  # what rounding to so few bits adds to a distance
_CELLS = 4  # a side, for how evenly the sample was used
_KIN = 0.5  # as much nearer to each other are the windows of a larger photo at most
_RHYTHM = 10.0  # so many times the autocorrelation is what an eye sees twice as much of


@dataclass(frozen=True)
class Look:
    """What is seen on the coarse copy; each figure is 0 for the sample itself, and low is good.

    Attributes
    ----------
    broken : float
        The 97 % quantile of the windows' distances to the nearest of the sample; 1 is as far as the
        windows of one half of the sample are from those of the other, in the mean.
    uneven : float
        How unevenly the parts of the sample are used: relative entropy over 4x4 cells.
    alike : float
        By how much nearer than the sample's windows are to others, beyond what is so in a larger
        photo; mean logarithm.
    """

    broken: float
    uneven: float
    alike: float


WEIGHTS = {
    "broken": 3.25,
    "uneven": 3.63,
    "alike": 1.08,
    "lattice": 6.08,
    "autocorrelation": 1.55,
    "seams": 0.74,
}
"""Of the terms of the score, as benchmarks/judged/agreement.py fits them to judged pictures."""


def terms(figures: Mapping[str, Any]) -> dict[str, float]:
    """What the score adds up, before weights: 0 is perfect; what is not known adds nothing."""
    known = {name: float(figures[name]) for name in WEIGHTS if figures.get(name) is not None}
    if "broken" in known:
        known["broken"] = math.log1p(known["broken"])
    if "lattice" in known:  # more regular than the sample is no fault
        known["lattice"] = max(1 - known["lattice"], 0.0)
    if "autocorrelation" in known:
        known["autocorrelation"] = math.log1p(_RHYTHM * known["autocorrelation"])
    if "seams" in known:  # nor are fewer seams than the sample's own
        known["seams"] = math.log(max(known["seams"], 1.0))
    return known


def weigh(figures: Mapping[str, Any]) -> float | None:
    """Return the score of a picture with these figures, or None if none of them is known."""
    found = terms(figures)
    return math.fsum(WEIGHTS[name] * found[name] for name in found) if found else None


class Eye:
    """A sample, prepared to have pictures of it scored.

    Parameters
    ----------
    exemplar : Exemplar

    Examples
    --------
    >>> import weftex
    >>> sample = weftex.load_exemplar("sample:bricks")
    >>> eye = Eye(sample)
    >>> good = weftex.synthesize(sample, 256, method="near-regular", seed=1)
    >>> bad = weftex.synthesize(sample, 256, method="patch-sampling", patch_size=12, seed=1)
    >>> eye.score(good.image) < eye.score(bad.image)
    True
    """

    def __init__(self, exemplar: Exemplar) -> None:
        self.exemplar = exemplar
        side = min(exemplar.shape)
        self._levels = max(1, 1 + round(math.log2(side / _SIDE)))
        self.own = view_of(exemplar)
        own = self._coarse(self.own)
        self._width = max(2, min(own.shape) // 3)
        values = self._width**2 * own.values.shape[2]
        self._shift = next(s for s in range(9) if values * (255 >> s) ** 2 < _EXACT)
        self._own = self._windows(own)
        if len(self._own):
            contrast = own.values[own.usable].astype(np.float64).var(axis=0).mean()
            self._seen = _SEEN * float(contrast) / 4**self._shift + _ROUNDING
            self._usual = self._between_halves(own.shape)
            self._alone = self._closeness(self._own)

    @cached_property
    def lattice(self) -> Lattice | None:
        """That of the sample."""
        return find_lattice(self.exemplar)

    @cached_property
    def seams(self) -> Seams:
        """What its steps are like."""
        return Seams(self.own)

    def view(self, picture: NDArray[Any]) -> View:
        """Return a picture as the measures see it, beside the sample."""
        return view_beside(self.own, self.exemplar, picture)

    def look(self, made: View) -> Look | None:
        """Return the figures of a picture as `views` has it; None where it is too small."""
        made = self._coarse(made)
        if min(made.shape) < self._width or not len(self._own):
            return None
        windows = self._windows(made)
        apart, which = nearest(windows, self._own)
        worst = float(np.quantile(apart, _QUANTILE))
        return Look(
            broken=worst / (self._usual + self._seen),
            uneven=self._uneven(self._own.places[which]),
            alike=max(0.0, self._closeness(windows) - self._alone - _KIN),
        )

    def figures(self, made: View) -> dict[str, float | None]:
        """Return all that the score is made of, of a picture as `views` has it.

        Nothing where a mask leaves no whole window of the sample.
        """
        if not len(self._own):
            return {}
        seen = self.look(made)
        return ({} if seen is None else asdict(seen)) | {
            "lattice": lattice_kept(self.own, made, self.lattice),
            "autocorrelation": autocorrelation_distance(self.own, made),
            "seams": seams(self.seams, made),
        }

    def score(self, picture: NDArray[Any]) -> float | None:
        """How bad a picture looks beside others of this sample; less is better.

        Parameters
        ----------
        picture : array (H, W) or (H, W, C)
            Of the sample's dtype and channels, at the sample's scale.

        Returns
        -------
        float or None
            0 for the sample itself. An eye prefers the picture whose score is less by d in a share
            1 / (1 + exp(-d)) of cases, by the judged pictures. What cannot be
            measured adds nothing, as windows of a picture smaller than a third of the sample. None
            where nothing can, and where a mask leaves no such window.
        """
        return weigh(self.figures(self.view(picture)))

    def _coarse(self, view: View) -> View:
        return view.pyramid(self._levels)[-1]

    def _windows(self, view: View) -> Windows:
        """Usable windows on a grid, in so few bits that distances are exact."""
        width, (height, across) = self._width, view.shape
        length = width**2 * view.values.shape[2]
        if min(height, across) < width:
            return Windows(np.zeros((0, 0), np.int16), np.zeros((0, 2), np.int32), length)
        rows, columns = height - width + 1, across - width + 1
        step = max(1, math.ceil(math.sqrt(rows * columns / _MOST)))
        places = np.stack(np.divmod(window_corners(view.usable, width), across), axis=1)
        places = places[(places % step == 0).all(axis=1)]
        bits = view.values >> self._shift
        found = np.lib.stride_tricks.sliding_window_view(bits, (width, width), axis=(0, 1))
        values = np.zeros((len(places), -(-length // _AT_ONCE) * _AT_ONCE), np.int16)
        values[:, :length] = found[places[:, 0], places[:, 1]].reshape(len(places), length)
        return Windows(values, places.astype(np.int32), length)

    def _uneven(self, source: Places) -> float:
        """Relative entropy of the use of cells to an even one."""
        own = self._own.places
        sides = own.max(axis=0) + 1
        even, used = (
            np.bincount((place * _CELLS // sides) @ np.array([_CELLS, 1]), minlength=_CELLS**2)
            / len(place)
            for place in (own, source)
        )
        seen = used > 0
        return max(0.0, float((used[seen] * np.log(used[seen] / even[seen])).sum()))

    def _between_halves(self, shape: tuple[int, int]) -> float:
        """The mean distance of windows of one half of the sample to the nearest of the other.

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
        """Of windows to the nearest that they do not touch: minus the mean logarithm."""
        apart = nearest(windows, windows, self._width)[0]
        known = apart[np.isfinite(apart)].astype(np.float64)
        return -float(np.log(known + self._seen / 2).mean()) if len(known) else 0.0


@dataclass(frozen=True, eq=False)
class Windows:
    """Square parts of a picture.

    Attributes
    ----------
    values : int16 array (n, m)
        The numbers of each, and zeros up to a multiple of 16.
    places : int32 array (n, 2)
        Row and column of each.
    length : int
        Numbers of a window.
    """

    values: NDArray[np.int16]
    places: Places
    length: int

    def __len__(self) -> int:
        return len(self.places)

    def of(self, chosen: NDArray[np.bool_]) -> Windows:
        """Some of them."""
        return Windows(self.values[chosen], self.places[chosen], self.length)


def nearest(first: Windows, second: Windows, least: int = 0) -> tuple[Floats, Places]:
    """Find for each window the nearest of others, the first of equals.

    Parameters
    ----------
    first, second : Windows
        The windows, and the others; of one length.
    least : int
        Windows that are less than so many rows and columns apart are not compared.

    Returns
    -------
    (float32 array (n,), int32 array (n,))
        Mean squared differences, infinite where there is none to compare; and numbers of `second`.
    """
    best, which = np.empty(len(first), np.int32), np.empty(len(first), np.int32)
    others = np.pad(second.values, [(0, -len(second) % 4), (0, 0)])  # four are compared at once
    squares = np.empty(len(others), np.int32)
    kernels.nearest(first.values, others, first.places, second.places, least, best, which, squares)
    apart = best.astype(np.float32) / np.float32(first.length)
    return np.where(best < 0, np.float32(np.inf), apart), which
