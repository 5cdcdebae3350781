"""Remove uneven light from a photo: one side brighter, corners darker, a soft shadow."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggrid2d, legvander2d
from numpy.typing import NDArray

from weftex.errors import wrong_value
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.prepare.estimating import blurred
from weftex.raster.arrays import Floats
from weftex.raster.boxes import cell_sums
from weftex.raster.levels import to_light, to_stored

_CELLS = 32  # along the longer side, whose means the light is fitted to
_HIGHEST = 8  # degree of the light
_ROUNDS = 8  # of fitting, each with less weight on what lies off the last
#: Of shadows: cells along the longer side, and the blur of their areas and borders in cells.
_FINE, _COARSE, _PENUMBRAS = 64, 3.0, (0.4, 0.7, 1, 1.5, 2, 3, 4, 5)
_CLEAR = 2.5  # times as deep as cells differ: of more, smaller areas are believed
_LEAST, _WIDTH = 0.05, 6  # least share of the photo, and width in cells
#: Least depth in logarithms, and how much less deep blue is than red at least.
_DEPTH, _BLUER = 0.3, 0.05
_DARKEST = 1e-4  # of the brightest; darker than that is black, whose light nobody can tell


def even_light(sample: Sample, degree: int = 2) -> Exemplar:
    """Divide a photo by the light that fell on it, so that it is equally bright all over.

    First, a shadow with a soft border is removed, if an area is evenly darker by a quarter or more
    and also bluer, as in light from the sky alone. Then the light is modeled as a polynomial in x
    and y for each color channel. It is fitted to the logarithms of the values, with less weight on
    outliers. Integers are read as sRGB values, floats as linear values.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The photo. Pixels outside its mask do not influence the fit, but are corrected too.
    degree : int
        Degree of the polynomial, 1 to 8: 2 for a lamp, a window or dark corners. Higher degrees
        follow more complex light, but may remove large dark features too.

    Returns
    -------
    Exemplar
        The photo with the same dtype and mean color (pixels too bright for the dtype are clipped).
        Alpha, maps, mask and guide stay unchanged.

    Raises
    ------
    FileError, InvalidInputError
        If the sample cannot be read; if it cannot be used, or `degree` is out of range.

    Examples
    --------
    >>> from weftex.analysis.properties import evenness
    >>> noise = np.random.default_rng(0).integers(60, 90, (64, 64))
    >>> photo = Exemplar((noise * np.linspace(1, 2.5, 64)).astype(np.uint8))
    >>> evenness(photo).light > 0.5, evenness(even_light(photo)).light < 0.1
    (True, True)
    """
    if isinstance(degree, bool) or degree not in range(1, _HIGHEST + 1):
        raise wrong_value("degree", degree, f"from 1 to {_HIGHEST}")
    exemplar = load_exemplar(sample)
    pixels = exemplar.pixels.reshape(*exemplar.shape, -1)
    usable = exemplar.usable
    if exemplar.alpha:
        usable = usable & (pixels[..., -1] > 0)
    even = pixels.copy()
    bands = [_linear(pixels[..., k]) for k in range(exemplar.channels - exemplar.alpha)]
    for channel, linear in enumerate(_without_shadow(bands, usable)):
        even[..., channel] = _stored(linear / _light(linear, usable, degree), pixels.dtype)
    return exemplar.changed(pixels=even.reshape(exemplar.pixels.shape))


def _without_shadow(bands: list[Floats], usable: NDArray[np.bool_]) -> list[Floats]:
    """Return channels (H, W), divided by the light in a soft shadow if there is one."""
    side = max(1, max(usable.shape) // _FINE)
    seen = usable & np.all([band > _DARKEST * band.max() for band in bands], axis=0)
    count = cell_sums(seen.astype(np.float64), side)
    if not seen.any() or min(count.shape) < _WIDTH:
        return bands
    there = count > 0
    sums = (cell_sums(np.log(np.where(seen, band, 1)), side) for band in bands)
    logs = np.array([np.where(there, one / np.maximum(count, 1), 0) for one in sums])
    logs = np.where(there, logs, logs[:, there].mean(axis=1)[:, None, None])
    found = _step(logs, _COARSE)
    if found is None:
        return bands
    share, depths, _ = (found[2] > _CLEAR and _step(logs, _COARSE / 2)) or found
    whole, even = _enlarged(share, side, usable.shape), []
    for band, depth in zip(bands, depths, strict=True):
        lit = band * np.exp(depth * whole)
        even.append(lit * (band[seen].sum() / lit[seen].sum()))
    return even


def _step(logs: Floats, sigma: float) -> tuple[Floats, Floats, float] | None:
    """Return the share of shadow of each cell, its depth in each channel, and how clear it is.

    Cells are divided into two areas by Merriman, Bence and Osher's threshold dynamics, and their
    border is blurred as it fits best. None unless they differ as shadows do.
    """
    mean = logs.mean(axis=0)
    smooth = np.round(blurred(mean, sigma), 9)
    cut = np.sort(smooth, axis=None)  # at Otsu's threshold
    below, number = np.cumsum(cut)[:-1], np.arange(1, cut.size)
    apart = below / number - (cut.sum() - below) / (cut.size - number)
    dark = smooth <= cut[np.argmax(np.round(apart**2 * number * number[::-1], 6))]
    for _ in range(_ROUNDS * 4):
        if not _LEAST < dark.mean() < 1 - _LEAST:
            return None
        off = (mean - mean[dark].mean()) ** 2 - (mean - mean[~dark].mean()) ** 2
        before, dark = dark, np.round(blurred(off, sigma), 9) < 0
        if (before == dark).all():
            break
    border = sum(int((np.diff(dark, axis=axis)).sum()) for axis in (0, 1))
    if 2 * min(dark.sum(), (~dark).sum()) < _WIDTH * border:
        return None
    rows, columns = (_span(np.arange(n) + 0.5, n) for n in mean.shape)
    y, x = np.meshgrid(rows, columns, indexing="ij")
    slow: Any = legvander2d(y.ravel(), x.ravel(), (2, 2))[:, _terms(2).ravel()]
    values = logs.reshape(len(logs), -1).T

    def fitted(terms: Any) -> tuple[Any, Any]:
        factors = np.linalg.lstsq(terms, values, rcond=1e-9)[0]
        return factors, (values - terms @ factors).mean(axis=1).reshape(mean.shape)

    found = []
    for width in _PENUMBRAS:
        share = blurred(dark.astype(np.float64), width)
        factors, off = fitted(np.concatenate([share.reshape(-1, 1), slow], axis=1))
        found.append((share, np.round(-factors[0], 6), off))
    share, depths, off = min(found, key=lambda one: round(float((one[2] ** 2).sum()), 6))
    left = [blurred(one, _COARSE * 2 / 3).var() for one in (off, fitted(slow)[1])]
    sky = _BLUER < depths[0] - depths[-1] < depths.mean()  # whose light is what shadows get
    if depths.min() < _DEPTH or left[0] > left[1] / 2 or not sky:
        return None
    return np.round(share, 6), depths, float(depths.mean() / max(off.std(), 1e-9))


def _enlarged(cells: Floats, side: int, shape: tuple[int, ...]) -> Floats:
    """Return values of cells, of `side` pixels, between their centers for each pixel."""
    for axis, length in enumerate(shape):
        centers = side * (np.arange(cells.shape[axis]) + 0.5)
        at = np.arange(length) + 0.5
        cells = np.apply_along_axis(lambda line: np.interp(at, centers, line), axis, cells)  # noqa: B023
    return cells


def _light(linear: Floats, usable: NDArray[np.bool_], degree: int) -> Floats:
    """Return the light (H, W) on values (H, W), around 1."""
    seen = usable & (linear > _DARKEST * linear.max())
    if not seen.any():
        return np.ones(linear.shape)
    side = -(-max(linear.shape) // _CELLS)
    count = cell_sums(seen.astype(np.float64), side)
    there = count > 0
    means = cell_sums(np.log(np.where(seen, linear, 1)), side)[there] / count[there]
    y, x = ((np.nonzero(there)[axis] + 0.5) * side for axis in (0, 1))
    terms = legvander2d(_span(y, linear.shape[0]), _span(x, linear.shape[1]), (degree, degree))
    terms = terms[:, _terms(degree).ravel()]
    weight = count[there]
    for _ in range(_ROUNDS):
        root = np.sqrt(weight)
        factors = np.linalg.lstsq(terms * root[:, None], means * root, rcond=1e-9)[0]
        off = abs(means - terms @ factors)
        # Huber's weights: of cells farther off than most, distances count and not squares.
        weight = count[there] / np.maximum(1, off / (1.5 * np.median(off) + 1e-9))
    surface = np.zeros((degree + 1, degree + 1))
    # The last digits of a fit differ between machines.
    surface[_terms(degree)] = np.round(factors, 6)
    rows, columns = (_span(np.arange(side) + 0.5, side) for side in linear.shape)
    light: Floats = np.exp(leggrid2d(rows, columns, surface))
    light *= (linear[seen] / light[seen]).sum() / linear[seen].sum()
    return light


def _terms(degree: int) -> NDArray[np.bool_]:
    """Return which products of two polynomials have at most this degree."""
    return np.add.outer(np.arange(degree + 1), np.arange(degree + 1)) <= degree


def _span(place: NDArray[np.floating[Any]], side: int) -> Floats:
    """Return pixel positions from -1 to 1."""
    return 2 * place / side - 1


def _linear(stored: NDArray[Any]) -> Floats:
    """Return linear light of stored values."""
    if stored.dtype.kind == "f":
        return stored.astype(np.float64)
    top = np.iinfo(stored.dtype).max
    return to_light(np.arange(top + 1) / top).take(stored)


def _stored(linear: Floats, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return stored values of linear light, clipped at white."""
    if dtype.kind == "f":
        most = np.finfo(dtype).max
        return np.clip(linear, -most, most).astype(dtype)
    return np.rint(to_stored(np.clip(linear, 0, 1)) * np.iinfo(dtype).max).astype(dtype)
