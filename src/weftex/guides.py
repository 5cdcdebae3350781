"""Outputs that follow a guide: what it costs to show parts of the sample where it asks for others.

As with `repeats`, a cut pays for each pixel that becomes new, less what the old one cost.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.relief import means
from weftex.exemplar import Exemplar
from weftex.raster.arrays import Bytes, Floats, fast_size
from weftex.repeats import Output
from weftex.search.fft_mismatch import Spectra, window_mismatch

_HIGHEST = 2.0**20  # of a pixel, so that sums over blocks are no larger than an int
_TONES = 32  # gray levels of a picture that are one material
Lines = NDArray[np.int32]  # rows or columns of a box


def own_guide(exemplar: Exemplar) -> Bytes:
    """The guide (H, W, G) of a sample: its own, or its pixels."""
    return exemplar.as_guide(exemplar.pixels if exemplar.guide is None else exemplar.guide)


def materials(exemplar: Exemplar) -> NDArray[np.uint16]:
    """The number (H, W) of each pixel's label or tone, between which no tones are spread."""
    own = own_guide(exemplar)
    if exemplar.labels is None:
        return np.asarray(own.mean(axis=2) // _TONES, np.uint16)
    return np.asarray(own // 255 @ np.arange(1, own.shape[2] + 1), np.uint16)


class Guiding:
    """What it costs that a sample's guide differs from the canvas's where an output shows it.

    Where labels differ, or pictures by half of their contrast, a pixel costs `weight` times `unit`.
    """

    def __init__(self, exemplar: Exemplar, output: Output, weight: float, unit: float) -> None:
        assert output.canvas.guide is not None
        self._output, self._spectra = output, dict[int, Spectra]()
        self._own, self._wanted = own_guide(exemplar), exemplar.as_guide(output.canvas.guide)
        contrast = float(np.square(np.ptp(self._own, axis=(0, 1)), dtype=np.float64).sum())
        most = contrast / 4 if exemplar.labels is None else min(contrast, 2 * 255.0**2)
        self.price = min(weight * unit, _HIGHEST)
        self._weight, self._most = weight, max(most, 1.0)  # squared difference

    def look(self, rows: Lines, columns: Lines) -> Lines:
        """See `now`; for `prices` of patches in this box."""
        self._before = self.now(rows, columns)
        return self._before

    def now(self, rows: Lines, columns: Lines) -> Lines:
        """What each pixel of a box costs; 0 of missing ones."""
        return self._shown(rows, columns, self._output.source[np.ix_(rows, columns)])

    def _shown(self, rows: Lines, columns: Lines, source: Lines) -> Lines:
        own = self._own.reshape(-1, self._own.shape[2])[source].astype(np.int32)
        own -= self._wanted[np.ix_(rows, columns)]
        apart = np.einsum("...k,...k", own, own)
        prices = np.rint(self.price / self._most * apart)
        return np.where(source < 0, 0, prices.clip(0, _HIGHEST)).astype(np.int32)

    def prices(self, box: tuple[Lines, ...], others: Lines, exponent: int) -> Lines:
        """What each pixel of a patch adds if it becomes new, with `others`, prices of squares."""
        rows, columns, from_rows, from_columns = box
        new = from_rows[:, None] * np.int32(self._own.shape[1]) + from_columns
        prices = self._shown(rows, columns, new) - self._before
        if others.size:
            others = others.repeat(1 << exponent, 0).repeat(1 << exponent, 1)
            prices += others[: len(rows), : len(columns)]
        return prices

    def mismatch(self, rows: Lines, columns: Lines, level: int) -> Floats:
        """How far a box is from each place of the sample, which begins again, on a level."""
        if level not in self._spectra:
            own = np.pad(self._own, ((0, len(rows)), (0, len(columns)), (0, 0)), "wrap")
            own = _smaller(own, level)
            size = tuple(map(fast_size, own.shape[:2]))
            self._spectra[level] = Spectra(own, np.ones(own.shape[:2]), size)
        whole, box = self._spectra[level], _smaller(self._wanted[np.ix_(rows, columns)], level)
        total = window_mismatch(whole, Spectra(box, np.ones(box.shape[:2]), whole.size))
        return np.asarray(total * (self._weight / self._most / box[..., 0].size))


def _smaller(picture: Bytes, level: int) -> Bytes:
    """Means of squares of 2**level pixels a side, rounded."""
    found = means(np.moveaxis(picture, 2, 0), 1 << level)
    return np.asarray(np.rint(np.moveaxis(found, 0, 2)), np.uint8)
