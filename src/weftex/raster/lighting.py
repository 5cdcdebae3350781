"""A material under a light from the side, in which faults of its normals and heights show."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.raster.levels import to_light, to_stored

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def lit(
    color: NDArray[Any],
    *,
    normal: NDArray[Any] | None = None,
    height: NDArray[Any] | None = None,
    light: tuple[float, float, float] = (-1.0, 1.0, 0.7),
    depth: float = 16.0,
    directx: bool = False,
) -> NDArray[np.uint8]:
    """Return a matte surface in parallel light, uint8 (H, W, 3) in sRGB.

    `color` is uint8, uint16 or floats of 0 to 1, in sRGB, of three channels or one; `normal` a map
    with y up, or down if `directx`; without it normals are taken from a `height` map, whose largest
    number stands `depth` pixels high. `light` is where it comes from: right, up, out of the
    surface. What faces the light is as bright as the color.

    >>> gray, ramp = np.full((8, 8), 128, np.uint8), np.arange(8.0) * np.ones((8, 1)) / 8
    >>> left, right = (lit(gray, height=ramp, light=(x, 0, 1)).mean() for x in (-1, 1))
    >>> bool(left > right)
    True
    """
    given = normal if normal is not None else height
    if given is None:
        raise InvalidInputError("there is nothing to light: give normal or height")
    if given.shape[:2] != color.shape[:2]:
        raise InvalidInputError(
            f"the map is {given.shape[1]}x{given.shape[0]}, the color {color.shape[1]}x"
            f"{color.shape[0]}; they must be equal"
        )
    if normal is not None:
        vectors = 2 * _unit(normal)[..., :3] - 1
        if directx:
            vectors[..., 1] *= -1
    else:
        down, across = np.gradient(depth * _unit(given)[..., 0])
        vectors = np.dstack([-across, down, np.ones(down.shape)])
    vectors /= np.maximum(np.linalg.norm(vectors, axis=2, keepdims=True), 1e-6)
    toward = np.array(light, np.float64) / np.linalg.norm(light)
    shade = np.maximum(vectors @ toward, 0)[..., None]
    base = _unit(color)
    base = base[..., :3] if base.shape[2] >= 3 else base[..., :1].repeat(3, axis=2)
    found: NDArray[np.uint8] = np.rint(255 * to_stored(to_light(base) * shade)).astype(np.uint8)
    return found


def _unit(pixels: NDArray[Any]) -> Floats:
    """As (H, W, C) in 0 to 1."""
    top = np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else 1
    return np.clip(pixels.reshape(*pixels.shape[:2], -1) / top, 0, 1)
