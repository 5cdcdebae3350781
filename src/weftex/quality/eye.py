"""The score: in which order a demanding eye would put pictures that were made from one sample."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.lattice import find_lattice
from weftex.exemplar import Exemplar
from weftex.quality.lattice import lattice_kept
from weftex.quality.spectrum import spectrum_distance
from weftex.quality.view import View, views, window_corners

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from weftex.analysis.lattice import Lattice

    Floats = NDArray[np.float32]
    Places = NDArray[np.int64]

_SIDE = 32  # pixels, about, of the sample's shorter side on the coarse copy
_MOST = 1600  # windows of a picture
_EXACT = 2**23  # float32 holds sums of whole numbers up to twice this
_QUANTILE = 0.9
_FLOOR = 0.01  # of the sample's contrast: a distance that nobody sees
_CELLS = 4  # a side, for how evenly the sample was used
_COPY = 0.3  # of the distance of the sample's own nearest pairs
_NEAREST = 0.1  # quantile of the sample's own nearest distances


@dataclass(frozen=True)
class Look:
    """What is seen on the coarse copy; each figure is 0 for the sample itself, and low is good.

    Attributes
    ----------
    broken : float
        How far the worst windows are from all of the sample's: the logarithm of the 90 % quantile
        of the distances to the nearest, 0 where nobody sees them.
    again : float
        How often two windows show the same part of the sample, over even use of all of it; the
        logarithm.
    uneven : float
        How unevenly the parts of the sample are used: relative entropy over 4x4 cells.
    alike : float
        Share of the windows that have a copy elsewhere, nearer than any two of the sample's are.
    """

    broken: float
    again: float
    uneven: float
    alike: float


WEIGHTS = {
    "broken": 2.1,
    "again": 1.5,
    "uneven": 2.8,
    "alike": 1.8,
    "lattice": 5.9,
    "spectrum": 1.1,
}
"""Of the terms of the score, fitted to judged pictures; see benchmarks/judged/README.md."""


def terms(figures: Mapping[str, Any]) -> dict[str, float]:
    """What the score adds up, before weights: 0 is perfect; what is not known adds nothing."""
    known = {name: float(figures[name]) for name in WEIGHTS if figures.get(name) is not None}
    if "lattice" in known:  # more regular than the sample is no fault
        known["lattice"] = max(1 - known["lattice"], 0.0)
    if "spectrum" in known:
        known["spectrum"] = math.log1p(known["spectrum"])
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
        own = self._coarse(views(exemplar, exemplar.pixels)[0])
        channels = own.values.shape[2]
        self._width = max(2, min(own.shape) // 3)
        values = self._width**2 * channels
        self._shift = next(s for s in range(9) if values * (255 >> s) ** 2 < _EXACT)
        self._own, self._places = self._windows(own)
        if len(self._own):
            bytes_ = own.values[own.usable].astype(np.float64)
            self._floor = _FLOOR * float(bytes_.var(axis=0).mean()) / 4**self._shift + 0.05
            apart = distances(self._own, self._own)
            apart[~_apart(self._places, self._width)] = np.inf
            nearest = apart.min(axis=1)
            known = nearest[np.isfinite(nearest)]
            self._copy = _COPY * float(np.quantile(known, _NEAREST)) if len(known) else 0.0

    @cached_property
    def lattice(self) -> Lattice | None:
        """That of the sample."""
        return find_lattice(self.exemplar)

    def look(self, made: View) -> Look | None:
        """Return the figures of a picture as `views` has it; None where it is too small."""
        made = self._coarse(made)
        if min(made.shape) < self._width or not len(self._own):
            return None
        windows, places = self._windows(made)
        apart = distances(windows, self._own)
        nearest = apart.min(axis=1)
        worst = float(np.quantile(nearest, _QUANTILE))
        source = self._places[apart.argmin(axis=1)]
        return Look(
            broken=math.log1p(worst / self._floor),
            again=self._again(source, places),
            uneven=self._uneven(source),
            alike=self._alike(windows, places),
        )

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
            1 / (1 + exp(-d)) of cases, by the judged pictures. None where the picture is smaller
            than a third of the sample, and where a mask leaves no such window.
        """
        own, made = views(self.exemplar, picture)
        found = self.look(made)
        if found is None:
            return None
        kept, spectrum = lattice_kept(own, made, self.lattice), spectrum_distance(own, made)[1]
        return weigh(asdict(found) | {"lattice": kept, "spectrum": spectrum})

    def _coarse(self, view: View) -> View:
        return view.pyramid(self._levels)[-1]

    def _windows(self, view: View) -> tuple[Floats, Places]:
        """Usable windows (n, values) on a grid, in so few bits that sums are exact; places."""
        width, (height, across) = self._width, view.shape
        if min(height, across) < width:
            return np.zeros((0, 1), np.float32), np.zeros((0, 2), np.int64)
        rows, columns = height - width + 1, across - width + 1
        step = max(1, math.ceil(math.sqrt(rows * columns / _MOST)))
        places = np.stack(np.divmod(window_corners(view.usable, width), across), axis=1)
        places = places[(places % step == 0).all(axis=1)]
        bits = (view.values >> self._shift).astype(np.float32)
        found = np.lib.stride_tricks.sliding_window_view(bits, (width, width), axis=(0, 1))
        values = width**2 * view.values.shape[2]
        return found[places[:, 0], places[:, 1]].reshape(len(places), values), places

    def _again(self, source: Places, places: Places) -> float:
        """Pairs of windows that do not touch and have one source, over chance."""
        far = _apart(places, self._width // 2)
        same = ~_apart(source, 2)
        chance = float((~_apart(self._places, 2)).mean())
        return math.log1p(float((far & same).mean()) / chance)

    def _uneven(self, source: Places) -> float:
        """Relative entropy of the use of cells to an even one."""
        sides = self._places.max(axis=0) + 1
        even, used = (
            np.bincount((place * _CELLS // sides) @ np.array([_CELLS, 1]), minlength=_CELLS**2)
            / len(place)
            for place in (self._places, source)
        )
        seen = used > 0
        return max(0.0, float((used[seen] * np.log(used[seen] / even[seen])).sum()))

    def _alike(self, windows: Floats, places: Places) -> float:
        """Share of windows with a copy that they do not touch."""
        near = distances(windows, windows) < self._copy
        return float((near & _apart(places, self._width)).any(axis=1).mean())


def distances(first: Floats, second: Floats) -> Floats:
    """Mean squared differences of all pairs, (n, m), of whole numbers that float32 sums exactly."""
    squares = [np.einsum("nk,nk->n", side, side) for side in (first, second)]
    sums = squares[0][:, None] - 2 * (first @ second.T) + squares[1]
    means: Floats = sums / np.float32(first.shape[1])
    return means


def _apart(places: Places, least: int) -> NDArray[np.bool_]:
    """Which pairs of places differ by at least so many lines or columns."""
    y, x = places.astype(np.int32).T
    apart: NDArray[np.bool_] = (abs(y[:, None] - y) >= least) | (abs(x[:, None] - x) >= least)
    return apart
