"""Maps of a photo that are estimated: height by brightness, and what follows from a height."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.lattice import find_lattice
from weftex.analysis.relief import smaller_copy
from weftex.errors import InvalidInputError, did_you_mean, shown, wrong_value
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.prepare.surfaces import (
    check_relief,
    height_from_normals,
    heights_of,
    normals_from_height,
    occlusion_from_height,
)
from weftex.progress import counted
from weftex.raster.arrays import Floats
from weftex.raster.levels import tamed

#: The maps that can be estimated.
MAPS = ("height", "normal_gl", "normal_dx", "ao", "roughness")
_USUAL = ("height", "normal_gl", "ao", "roughness")
_GRAIN = 1.0  # pixels: the standard deviation of the blur that removes noise
_LIGHT = 8  # structure wider than 1 / 8 of the shorter side counts as light
_ENDS = (0.01, 0.99)  # quantiles of the height that become black and white
_ROUGH, _ROUGHER = 0.65, 0.1  # the roughness of weak detail, and how much more strong detail has
_FINE, _AROUND = 2.0, 6.0  # pixels: what is fine detail, and where its strength is averaged
_LOOK = 512  # pixels a side; larger samples are searched for joints in a smaller copy and a part
_BIN = 2  # pixels of the mean tile of a lattice
_ALIKE, _SKEWED = 0.4, 0.5  # the tile's share of the variance, and its skewness: joints are light


def estimate_maps(
    sample: Sample,
    *,
    maps: Sequence[str] | None = None,
    relief: float = 6.0,
    invert: bool = False,
    radius: int = 16,
) -> Exemplar:
    """Estimate maps that a photo or a map set lacks.

    The height is the brightness of the photo, without noise and without changes wider than an
    eighth of the photo: dark pixels are deep. This is right for pits and dark joints. It is wrong
    for paint and stains, and for light joints between dark bricks: there, use `invert`; see
    `light_joints`. A sample that has a height or normals keeps them, and the other maps are
    computed from these. The roughness is a guess, because a photo does not show it: 0.65, and up
    to 0.1 more where fine detail is strong.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        A photo, a map set, or a single height or normal map. If it is tileable, so are the maps.
    maps : sequence of {"height", "normal_gl", "normal_dx", "ao", "roughness"}, optional
        The maps to add. By default all that are missing, with normals whose green points up.
    relief : float
        Height difference between the deepest and the highest pixel, in pixels, up to 1000. No
        effect if the sample has normals and no height.
    invert : bool
        Bright pixels are deep.
    radius : int
        Radius of the ambient occlusion in pixels; see `occlusion_from_height`.

    Returns
    -------
    Exemplar
        The sample with more maps: height as uint16 (white is high), all others as uint8.

    Raises
    ------
    FileError
        If the photo cannot be read.
    InvalidInputError
        If the sample already has a map of `maps`, or a value is out of range.

    Examples
    --------
    >>> pit = 200 - 120 * (np.hypot(*np.mgrid[-16:16, -16:16]) < 6)
    >>> maps = estimate_maps(pit.astype(np.uint8)).maps
    >>> bool(maps["height"][16, 16] < maps["height"][4, 4]), maps["normal_gl"].shape
    (True, (32, 32, 3))
    """
    exemplar = load_exemplar(sample)
    check_relief(relief)
    if not isinstance(invert, bool):
        raise wrong_value("invert", invert, "True or False")
    there = {name: exemplar.map(name) for name in exemplar.maps}
    known = {exemplar.role.name: exemplar} | there
    wanted = _wanted(exemplar, maps, list(known))
    kinds = {one.role.kind: one for one in reversed(known.values())}
    wraps = exemplar.tileable
    made: dict[str, NDArray[Any]] = {}
    with counted(1 + len(wanted), "estimates") as step:
        if "height" in kinds:
            pixels = kinds["height"].pixels
            high = heights_of(pixels if pixels.ndim == 2 else pixels[..., 0], relief)
        elif "normal" in kinds:
            given = kinds["normal"]
            y_up = given.role.name != "normal_dx"
            high = height_from_normals(given.pixels, y_up=y_up, tileable=wraps)
        else:
            high = relief * _shares(_surface(exemplar) * (-1 if invert else 1), 0.5)
        top = float(high.max()) or 1.0
        for name in wanted:
            step(1)
            if name == "height":
                made[name] = np.rint(high / top * 65535).astype(np.uint16)
            elif name == "ao":
                made[name] = _bytes(occlusion_from_height(high, 1, radius=radius, tileable=wraps))
            elif name == "roughness":
                made[name] = _bytes(_roughness(exemplar))
            else:
                made[name] = normals_from_height(high, 1, y_up=name == "normal_gl", tileable=wraps)
    return exemplar.changed(maps=there | made)


def _wanted(exemplar: Exemplar, maps: Sequence[str] | None, known: list[str]) -> list[str]:
    """Return the maps to estimate: those named, or all usual ones that are missing."""
    asked = _USUAL if maps is None else [maps] if isinstance(maps, str) else [*maps]
    normals = [name for name in known if name.startswith("normal")]
    wanted = []
    for name in asked:
        if name not in MAPS:
            raise InvalidInputError(f"maps has {shown(name)}{did_you_mean(str(name), MAPS)}")
        there = normals if name.startswith("normal") else [one for one in known if one == name]
        no_color = name == "roughness" and exemplar.role.kind != "color"
        if maps is not None and (there or no_color):
            why = f"has {there[0]}" if there else "has no color to estimate roughness from"
            raise InvalidInputError(f"{exemplar.name} {why}; leave {name} out")
        if not there and not no_color:
            wanted.append(name)
    if not wanted:
        raise InvalidInputError(f"{exemplar.name} already has {', '.join(known)}")
    return wanted


def light_joints(sample: Sample) -> bool:
    """Return whether thin bright lines divide a regular pattern, as mortar divides bricks.

    If they are joints, `estimate_maps` needs `invert`. Wires of a fence look the same.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        A photo.

    Returns
    -------
    bool
        False for a sample without a lattice.

    Examples
    --------
    >>> light_joints("sample:bricks"), light_joints("sample:tiles")
    (True, False)
    """
    exemplar = load_exemplar(sample).changed(maps={}, guide=None)
    small, step = smaller_copy(exemplar, _LOOK)
    divided = _has_light_joints(small)
    if divided or step == 1 or exemplar.mask is not None:
        return divided
    # Averages lose thin joints; the middle keeps them.
    box = tuple(slice(max(0, side - _LOOK) // 2, (side + _LOOK) // 2) for side in exemplar.shape)
    return _has_light_joints(exemplar.changed(pixels=exemplar.pixels[box], tileable=False))


def _has_light_joints(exemplar: Exemplar) -> bool:
    lattice = find_lattice(exemplar)
    if lattice is None or len(lattice.vectors) < 2:
        return False
    surface = _surface(exemplar)
    y, x = np.mgrid[: surface.shape[0], : surface.shape[1]]
    vectors = np.array(lattice.vectors, np.float64)
    counts = np.maximum(4, np.hypot(*vectors.T) // _BIN).astype(int)
    places = np.linalg.solve(vectors.T, np.stack([x.ravel(), y.ravel()])) % 1
    bins = np.ravel_multi_index(tuple((places * counts[:, None]).astype(int)), counts, mode="clip")
    total, number = np.bincount(bins, surface.ravel()), np.bincount(bins)
    tile = total[number > 0] / number[number > 0]
    tile -= tile.mean()
    variance = float((tile**2).mean())
    if variance <= _ALIKE * float(surface.var()):
        return False
    return bool((tile**3).mean() > _SKEWED * variance**1.5)


def _shares(values: Floats, flat: float) -> Floats:
    """Return values as shares of the way between their quantiles `_ENDS`; `flat` if all agree."""
    low, high = np.quantile(values, _ENDS)
    return np.clip((values - low) / (high - low), 0, 1) if high > low else 0 * values + flat


def _roughness(exemplar: Exemplar) -> Floats:
    """Return a guess: more where detail of two pixels is strong."""
    bright = _brightness(exemplar)
    detail = abs(bright - blurred(bright, _FINE, exemplar.tileable))
    return _ROUGH + _ROUGHER * _shares(blurred(detail, _AROUND, exemplar.tileable), 0.0)


def _bytes(values: NDArray[Any]) -> NDArray[np.uint8]:
    return np.asarray(np.rint(values * 255), np.uint8)


def _brightness(exemplar: Exemplar) -> Floats:
    """Return the mean of the color channels."""
    colors = exemplar.pixels.reshape(*exemplar.shape, -1)
    colors = tamed(colors[..., : exemplar.channels - exemplar.alpha])[0].astype(np.float64)
    return np.asarray(colors.mean(axis=2))


def _surface(exemplar: Exemplar) -> Floats:
    """Return brightness without noise and slow light."""
    bright = _brightness(exemplar)
    wide = min(exemplar.shape) / _LIGHT
    return blurred(bright, _GRAIN, exemplar.tileable) - blurred(bright, wide, exemplar.tileable)


def blurred(values: Floats, deviation: float, wraps: bool = False) -> Floats:
    """Return values blurred by a Gaussian, wrapped or mirrored at the borders."""
    margins = [0 if wraps else min(int(3 * deviation) + 1, side) for side in values.shape]
    padded = np.pad(values, [(margin, margin) for margin in margins], "symmetric")
    spectrum = np.fft.rfft2(padded)
    for axis, side in enumerate(padded.shape):
        turns = np.fft.fftfreq(side) if axis == 0 else np.fft.rfftfreq(side)
        weight = np.exp(-2 * (np.pi * deviation * turns) ** 2)
        spectrum *= weight[:, None] if axis == 0 else weight
    found: Floats = np.fft.irfft2(spectrum, padded.shape)
    (top, left), (height, width) = margins, values.shape
    return found[top : top + height, left : left + width]
