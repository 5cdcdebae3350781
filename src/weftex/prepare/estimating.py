"""Estimates of height and normals of a photo by its brightness."""

from __future__ import annotations

import numbers
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError, shown
from weftex.exemplar import Exemplar, load_exemplar
from weftex.raster.levels import tamed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Sample

    Floats = NDArray[np.float64]

_GRAIN = 1.0  # pixels: the standard deviation of the blur that removes noise
_LIGHT = 8  # structure wider than 1 / 8 of the shorter side counts as light
_ENDS = (0.01, 0.99)  # quantiles of the height that become black and white
_MOST = 1000  # pixels


def estimate_maps(sample: Sample, *, relief: float = 6.0, invert: bool = False) -> Exemplar:
    """Estimate height and normals of a photo, assuming that dark pixels are deep.

    The height is the brightness without structure finer than a pixel (noise) or wider than an
    eighth of the photo (light). This is right for pits and dark joints, and wrong for paint,
    stains, and light joints between dark bricks (use `invert`).

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        A photo without height and normals. If it is tileable, so are the maps.
    relief : float
        Height of the surface, from its deepest to its highest pixel, in pixels; up to 1000.
    invert : bool
        Bright pixels are deep.

    Returns
    -------
    Exemplar
        The same with the maps "height" (uint16, white is high) and "normal_gl" (uint8, y up).

    Raises
    ------
    FileError
        If the photo cannot be read.
    InvalidInputError
        If it has such a map, or a number is out of range.

    Examples
    --------
    >>> pit = 200 - 120 * (np.hypot(*np.mgrid[-16:16, -16:16]) < 6)
    >>> maps = estimate_maps(pit.astype(np.uint8)).maps
    >>> bool(maps["height"][16, 16] < maps["height"][4, 4]), maps["normal_gl"].shape
    (True, (32, 32, 3))
    """
    exemplar = load_exemplar(sample)
    number = isinstance(relief, numbers.Real) and not isinstance(relief, bool)
    if not number or not 0 < relief <= _MOST:
        raise InvalidInputError(f"relief is {shown(relief)}; it must be above 0, at most {_MOST}")
    if not isinstance(invert, bool):
        raise InvalidInputError(f"invert is {shown(invert)}; it must be True or False")
    there = [name for name, role in exemplar.roles.items() if role.kind in ("height", "normal")]
    if there:
        raise InvalidInputError(f"{exemplar.name} has {' and '.join(there)}; nothing to estimate")
    surface = _surface(exemplar) * (-1 if invert else 1)
    low, high = np.quantile(surface, _ENDS)
    # A flat photo is a flat surface.
    height = (
        np.clip((surface - low) / (high - low), 0, 1) if high > low else np.full_like(surface, 0.5)
    )
    maps: dict[str, Any] = {name: exemplar.map(name) for name in exemplar.maps}
    maps["height"] = np.rint(height * 65535).astype(np.uint16)
    maps["normal_gl"] = _normals(relief * height, exemplar.tileable)
    return exemplar.changed(maps=maps)


def _surface(exemplar: Exemplar) -> Floats:
    """Return brightness without noise and slow light."""
    colors = exemplar.pixels.reshape(*exemplar.shape, -1)
    colors = tamed(colors[..., : exemplar.channels - exemplar.alpha])[0].astype(np.float64)
    bright = colors.mean(axis=2)
    wide = min(exemplar.shape) / _LIGHT
    return _blurred(bright, _GRAIN, exemplar.tileable) - _blurred(bright, wide, exemplar.tileable)


def _blurred(values: Floats, deviation: float, wraps: bool) -> Floats:
    """Return values blurred by a Gaussian, wrapped or mirrored at the borders."""
    margins = [min(int(3 * deviation) + 1, side) for side in values.shape]
    pads = [(margin, margin) for margin in margins]
    padded = np.pad(values, pads, "wrap" if wraps else "symmetric")
    spectrum = np.fft.rfft2(padded)
    for axis, side in enumerate(padded.shape):
        turns = np.fft.fftfreq(side) if axis == 0 else np.fft.rfftfreq(side)
        weight = np.exp(-2 * (np.pi * deviation * turns) ** 2)
        spectrum *= weight[:, None] if axis == 0 else weight
    found: Floats = np.fft.irfft2(spectrum, padded.shape)
    return found[margins[0] : -margins[0], margins[1] : -margins[1]]


def _normals(height: Floats, wraps: bool) -> NDArray[np.uint8]:
    """Return the normals of a surface in pixels, y up."""
    padded = np.pad(height, 1, "wrap" if wraps else "edge")
    right = (padded[1:-1, 2:] - padded[1:-1, :-2]) / 2
    down = (padded[2:, 1:-1] - padded[:-2, 1:-1]) / 2
    vectors = np.dstack([-right, down, np.ones(height.shape)])
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    return np.rint((vectors + 1) * 127.5).astype(np.uint8)
