"""Heights, normals and ambient occlusion of a surface, from each other."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from weftex.errors import InvalidInputError, is_number, is_whole, wrong_value
from weftex.raster.arrays import Floats, check_pixels
from weftex.raster.mixing import middle_of, stored, vectors_of

_STEEPEST = 0.05  # the least z of a normal; below it, slopes are 20
_MOST = 1000  # pixels of relief
_DIRECTIONS = 16
_STEPS = 12  # in each direction, about


def normals_from_height(
    height: NDArray[Any],
    relief: float,
    *,
    y_up: bool = True,
    tileable: bool = False,
    dtype: DTypeLike = np.uint8,
) -> NDArray[Any]:
    """Return the normal map of a height map, by central differences.

    Parameters
    ----------
    height : array (H, W)
        Height of each pixel, as uint8, uint16 or floats; larger is higher.
    relief : float
        Height in pixels of the largest integer, or of 1.0 for floats; up to 1000.
    y_up : bool
        Green points up (OpenGL, glTF, Blender); False for down (DirectX, Unreal).
    tileable : bool
        The surface wraps around; otherwise its border is repeated.
    dtype : {uint8, uint16, float32, float64}
        Type of the result. Integers from 0 to their maximum mean -1 to 1; floats are -1 to 1.

    Returns
    -------
    array (H, W, 3)

    Raises
    ------
    InvalidInputError
        If the height has other dimensions, or relief is not above 0.

    Examples
    --------
    >>> normals_from_height(np.zeros((2, 3), np.uint8), 6)[0, 0].tolist()
    [128, 128, 255]
    """
    if (kind := np.dtype(dtype).name) not in ("uint8", "uint16", "float32", "float64"):
        raise wrong_value("dtype", kind, "uint8, uint16, float32 or float64")
    surface = heights_of(height, relief)
    padded = np.pad(surface, 1, "wrap" if tileable else "edge")
    right = (padded[1:-1, 2:] - padded[1:-1, :-2]) / 2
    down = (padded[2:, 1:-1] - padded[:-2, 1:-1]) / 2
    vectors = np.dstack([-right, down if y_up else -down, np.ones(surface.shape)])
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    return stored(vectors, np.dtype(dtype), 0.0)


def height_from_normals(
    normals: NDArray[Any], *, y_up: bool = True, tileable: bool = False
) -> Floats:
    """Return the height of a surface with these normals (Frankot and Chellappa, 1988).

    A Fourier transform finds the surface whose slopes are nearest to the normals in least squares.
    For normals of 16 bits, the error is below 0.1 % of the relief. For 8 bits, it is 1 % or more of
    a relief of 6 pixels, and gentle slopes are uncertain. In a tileable surface, patterns with a
    period of two pixels are lost.

    Parameters
    ----------
    normals : array (H, W, 3)
        A normal map: integers, floats from -1 to 1, or, if none is negative, from 0 to 1.
    y_up : bool
        Green points up (OpenGL); False for down (DirectX).
    tileable : bool
        The surface wraps around; otherwise it is mirrored at its borders.

    Returns
    -------
    float64 array (H, W)
        Height in pixels; 0 is the deepest.

    Raises
    ------
    InvalidInputError
        If the array has fewer than three channels.

    Examples
    --------
    >>> hills = 4 + 3 * np.sin(np.arange(64) / 64 * 2 * np.pi) * np.ones((48, 1))
    >>> normals = normals_from_height(hills, 1, tileable=True, dtype=np.uint16)
    >>> bool(abs(height_from_normals(normals, tileable=True) - (hills - 1)).max() < 0.01)
    True
    """
    normals = check_pixels(normals, "normals")
    if normals.ndim != 3 or normals.shape[2] < 3:
        raise InvalidInputError(f"normals have the shape {normals.shape}; it must be (H, W, 3)")
    height, width = normals.shape[:2]
    vectors = vectors_of(normals[..., :3], middle_of(normals[..., :3]))
    if normals.dtype.kind == "u":  # 0 has no integer of its own, and flat must stay flat
        flat = normals[..., :2] == np.iinfo(normals.dtype).max // 2 + 1
        vectors[..., :2][flat.all(axis=2)] = 0
    steep = np.maximum(vectors[..., 2], _STEEPEST)
    right, down = -vectors[..., 0] / steep, (1 if y_up else -1) * vectors[..., 1] / steep
    if not tileable:
        right = np.hstack([right, -right[:, ::-1]])
        right = np.vstack([right, right[::-1]])
        down = np.hstack([down, down[:, ::-1]])
        down = np.vstack([down, -down[::-1]])
    # Central differences multiply a wave by i sin; a wave that both lose stays 0.
    y, x = (np.sin(2 * np.pi * turns) for turns in
            (np.fft.fftfreq(right.shape[0])[:, None], np.fft.rfftfreq(right.shape[1])))  # fmt: skip
    power = y * y + x * x
    power[power < 1e-12] = np.inf
    spectrum = x * np.fft.rfft2(right)
    spectrum += y * np.fft.rfft2(down)
    spectrum *= -1j / power
    surface: Floats = np.fft.irfft2(spectrum, right.shape)[:height, :width].copy()
    surface -= surface.min()
    return surface


def occlusion_from_height(
    height: NDArray[Any], relief: float, *, radius: int = 16, tileable: bool = False
) -> NDArray[np.float32]:
    """Return ambient occlusion: the share of a bright sky that reaches each pixel of a surface.

    In each of 16 directions, the steepest slope to a pixel within the radius is the horizon. Light
    from above the horizon arrives, weighted by the cosine: a share of 1 / (1 + slope**2).

    Parameters
    ----------
    height, relief, tileable
        As for `normals_from_height`.
    radius : int
        Largest distance in pixels at which a surface takes light away, 1 or more.

    Returns
    -------
    float32 array (H, W)
        1 is open, 0 is dark.

    Raises
    ------
    InvalidInputError
        If the height has other dimensions, or a number is out of range.

    Examples
    --------
    >>> trench = np.ones((9, 9)); trench[:, 4] = 0
    >>> occlusion_from_height(trench, 4)[4, [0, 4]].astype(float).round(2).tolist()
    [1.0, 0.23]
    """
    surface = heights_of(height, relief).astype(np.float32)
    if not is_whole(radius, 1):
        raise wrong_value("radius", radius, "1 or more")
    margin = min(int(radius), max(surface.shape))
    padded = np.pad(surface, margin, "wrap" if tileable else "symmetric")
    distances = np.unique(np.rint(np.geomspace(1, margin, _STEPS)).astype(int))
    rows, columns = surface.shape
    open_sky = np.zeros(surface.shape, np.float32)
    for turn in 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS:
        slope = np.zeros(surface.shape, np.float32)
        for y, x in sorted({(round(r * np.sin(turn)), round(r * np.cos(turn))) for r in distances}):
            other = padded[margin + y :, margin + x :][:rows, :columns]
            np.maximum(slope, (other - surface) / np.float32(np.hypot(y, x)), out=slope)
        open_sky += 1 / (1 + slope * slope)
    return open_sky / np.float32(_DIRECTIONS)


def heights_of(height: NDArray[Any], relief: float) -> Floats:
    """Return heights in pixels."""
    check_relief(relief)
    pixels = check_pixels(height, "height")
    if pixels.ndim != 2:
        raise InvalidInputError(f"height has the shape {pixels.shape}; it must be (H, W)")
    top = np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else 1
    return pixels * (relief / top)


def check_relief(relief: Any) -> None:
    """Raise `InvalidInputError` unless a relief is a number of pixels above 0, at most 1000."""
    if not is_number(relief) or not 0 < relief <= _MOST:
        raise wrong_value("relief", relief, f"above 0, at most {_MOST}")
