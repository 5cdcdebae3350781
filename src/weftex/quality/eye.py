"""The score: how a demanding eye would rank a picture among others of one sample."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.exemplar import Exemplar
from weftex.quality.view import View, views
from weftex.raster.pyramids import gaussian_pyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

_COARSE = 64  # pixels, about, that the sample's shorter side has on the copy that is looked at
_THIRD = 3  # windows are a third of the sample
_MOST = 2500  # windows of the sample, and of a result
_SAME = 2  # coarse pixels that two sources may differ by and still be one


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
        self._levels = max(1, 1 + round(float(np.log2(max(side, 1) / _COARSE))))
        own = self._coarse(views(exemplar, exemplar.pixels)[0])
        self._width = max(2, min(own.shape[:2]) // _THIRD)
        self._contrast = float(own.reshape(-1, own.shape[2]).astype(np.float64).var(axis=0).mean())
        self._own, self._places = self._windows(own)

    def score(self, picture: NDArray[Any]) -> float | None:
        """How bad a picture looks beside others of this sample; less is better.

        Parameters
        ----------
        picture : array (H, W) or (H, W, C)
            Of the sample's dtype and channels.

        Returns
        -------
        float or None
            None where the picture is smaller than a third of the sample.
        """
        made = self._coarse(views(self.exemplar, picture)[1])
        if min(made.shape[:2]) < self._width:
            return None
        windows, _ = self._windows(made)
        apart = (
            (windows**2).sum(axis=1, dtype=np.float64)[:, None]
            - 2.0 * (windows @ self._own.T)
            + (self._own**2).sum(axis=1, dtype=np.float64)
        ) / windows.shape[1]
        broken = float(np.log(apart.min(axis=1).mean() / (self._contrast + 0.1) * 16 + 0.01))
        from_ = self._places[apart.argmin(axis=1)]
        same = (abs(from_[:, None] - from_) <= _SAME).all(axis=2).mean()
        return broken + 4 * float(same)

    def _coarse(self, view: View) -> NDArray[np.uint8]:
        return gaussian_pyramid(view.values, self._levels)[-1]

    def _windows(self, level: NDArray[np.uint8]) -> tuple[Floats, NDArray[np.int64]]:
        """Windows (n, values) on a grid, in six bits so that sums are exact, and their places."""
        width = self._width
        high, wide = (side - width + 1 for side in level.shape[:2])
        step = max(2, int(np.ceil(np.sqrt(high * wide / _MOST))))
        found = np.lib.stride_tricks.sliding_window_view(level >> 2, (width, width), axis=(0, 1))
        found = found[::step, ::step]
        y, x = np.mgrid[: found.shape[0], : found.shape[1]] * step
        places = np.stack([y.ravel(), x.ravel()], axis=1)
        return found.reshape(len(places), -1).astype(np.float32), places


def score(sample: Exemplar | NDArray[Any], picture: NDArray[Any]) -> float | None:
    """Return the score of one picture; `Eye` prepares the sample once for many."""
    exemplar = sample if isinstance(sample, Exemplar) else Exemplar(sample)
    return Eye(exemplar).score(picture)
