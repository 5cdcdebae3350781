"""Remove slow lighting from a photo: one side brighter, corners darker."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial.legendre import leggrid2d, legvander2d

from weftex.errors import InvalidInputError, shown
from weftex.exemplar import Exemplar, load_exemplar
from weftex.raster.boxes import cell_sums
from weftex.raster.levels import to_light, to_stored

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Sample

    Floats = NDArray[np.float64]

_CELLS = 32  # along the longer side, whose means the light is fitted to
_HIGHEST = 8  # degree of the light
_ROUNDS = 8  # of fitting, each with less weight on what lies off the last
_DARKEST = 1e-4  # of the brightest; darker than that is black, whose light nobody can tell


def even_light(sample: Sample, degree: int = 2) -> Exemplar:
    """Divide a photo by the light that fell on it, so that it is equally bright all over.

    The light is taken for a smooth surface, a polynomial in x and y for each color channel. It is
    fitted to the logarithms of the values, as light multiplies, with less weight on outliers.
    Integers are taken for sRGB values, floats for linear values.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The photo. Pixels outside its mask do not count for the fit, but are evened too.
    degree : int
        Degree of the polynomial, 1 to 8: 2 for a lamp, a window or dark corners. Higher degrees
        follow more complex light, but may take large features for light.

    Returns
    -------
    Exemplar
        The photo with the same dtype and mean color (pixels too bright for the dtype are clipped).
        Alpha, maps, mask and guide stay unchanged.

    Raises
    ------
    FileError, InvalidInputError
        If the sample cannot be read or used.

    Examples
    --------
    >>> from weftex.analysis.properties import evenness
    >>> noise = np.random.default_rng(0).integers(60, 90, (64, 64))
    >>> photo = Exemplar((noise * np.linspace(1, 2.5, 64)).astype(np.uint8))
    >>> evenness(photo).light > 0.5, evenness(even_light(photo)).light < 0.1
    (True, True)
    """
    if isinstance(degree, bool) or degree not in range(1, _HIGHEST + 1):
        raise InvalidInputError(f"degree is {shown(degree)}; it must be from 1 to {_HIGHEST}")
    exemplar = load_exemplar(sample)
    pixels = exemplar.pixels.reshape(*exemplar.shape, -1)
    usable = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    if exemplar.alpha:
        usable = usable & (pixels[..., -1] > 0)
    even = pixels.copy()
    for channel in range(exemplar.channels - exemplar.alpha):
        linear = _linear(pixels[..., channel])
        light = _light(linear, usable, degree)
        even[..., channel] = _stored(linear / light, pixels.dtype)
    return exemplar.changed(pixels=even.reshape(exemplar.pixels.shape))


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
    linear: Floats = to_light(np.arange(top + 1) / top)[stored]
    return linear


def _stored(linear: Floats, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return stored values of linear light, clipped at white."""
    if dtype.kind == "f":
        most = np.finfo(dtype).max
        return np.clip(linear, -most, most).astype(dtype)
    shares = to_stored(np.clip(linear, 0, 1))
    stored: NDArray[Any] = np.rint(shares * np.iinfo(dtype).max).astype(dtype)
    return stored
