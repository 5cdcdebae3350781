"""Pictures warped by a projective matrix, by the kind of their values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.io.formats import image_library
from weftex.raster.levels import tamed
from weftex.raster.mixing import Kind, stored, vectors_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar

    Floats = NDArray[np.float64]

_FILTER = "lanczos3"


def warped(picture: Exemplar, matrix: Floats, size: tuple[int, int]) -> NDArray[Any]:
    """Return a picture (H, W, ...) warped by a matrix for rows (x, y, 1).

    Values stay within their range, transparent pixels do not bleed, labels are not blended, and
    vectors are rotated.
    """
    pixels = picture.pixels
    if picture.role.kind == "labels":
        return nearest(pixels, matrix, size)
    planes = pixels.reshape(*pixels.shape[:2], -1)
    if picture.mixing.kind is Kind.VECTORS:
        down = picture.role.name == "normal_dx"
        found = _turned(planes, picture.mixing.middle, down, matrix, size)
    else:
        numbers, exponent = tamed(planes) if pixels.dtype.kind == "f" else (planes, 0)
        numbers = numbers.astype(np.float64)
        if picture.alpha:
            numbers[..., :-1] *= numbers[..., -1:]
        found = _resampled(numbers, matrix, size)
        if picture.alpha:
            found[..., :-1] /= np.where(found[..., -1:] > 0, found[..., -1:], 1)
        found = np.clip(np.ldexp(found, exponent), planes.min((0, 1)), planes.max((0, 1)))
        found = (np.rint(found) if pixels.dtype.kind == "u" else found).astype(pixels.dtype)
    return found.reshape(*size, *pixels.shape[2:])


def _turned(
    planes: NDArray[Any], middle: float, down: bool, matrix: Floats, size: tuple[int, int]
) -> NDArray[Any]:
    """Return vectors resampled as directions and lengths, and then rotated.

    A normal is the slope of the heights, which changes with distances along the surface; a change
    of size is ignored, as the scale of the heights is unknown.
    """
    vectors = vectors_of(planes[..., :3], middle)
    lengths = np.linalg.norm(vectors, axis=2, keepdims=True)
    found = _resampled(np.concatenate([vectors, lengths, planes[..., 3:]], axis=2), matrix, size)
    back = np.linalg.inv(matrix)
    y, x = np.indices(size) + 0.5
    place = np.stack([x, y, np.ones(size)], axis=-1) @ back
    # How far x and y of the photo are from pixel to pixel of the result, to the right and down.
    steps = [
        (back[axis, :2] - place[..., :2] / place[..., 2:] * back[axis, 2]) / place[..., 2:]
        for axis in (0, 1)
    ]
    area = abs(steps[0][..., 0] * steps[1][..., 1] - steps[0][..., 1] * steps[1][..., 0])
    sign = 1 if down else -1
    along = found[..., :2] * (1, sign)
    for axis in (0, 1):
        found[..., axis] = (along * steps[axis]).sum(axis=2) / np.sqrt(area)
    found[..., 1] *= sign
    now = np.linalg.norm(found[..., :3], axis=2, keepdims=True)
    longest = np.clip(found[..., 3:4], lengths.min(), lengths.max())
    found[..., :3] *= longest / np.where(now > 0, now, 1)
    made = stored(found[..., :3], planes.dtype, middle)
    if planes.shape[2] == 3:
        return made
    rest = np.clip(found[..., 4:], planes[..., 3:].min((0, 1)), planes[..., 3:].max((0, 1)))
    rest = np.rint(rest) if planes.dtype.kind == "u" else rest
    return np.concatenate([made, rest.astype(planes.dtype)], axis=2)


def _resampled(numbers: Floats, matrix: Floats, size: tuple[int, int]) -> Floats:
    """Return each channel of (H, W, C) resampled."""
    oiio = image_library()
    channels = numbers.shape[2]
    area = oiio.ROI(0, size[1], 0, size[0], 0, 1, 0, channels)
    given = oiio.ImageBuf(np.ascontiguousarray(numbers, np.float32))
    made = oiio.ImageBufAlgo.warp(given, tuple(matrix.ravel()), _FILTER, roi=area, wrap="clamp")
    if made.has_error:
        raise InvalidInputError(f"the photo cannot be straightened: {made.geterror()}")
    return np.asarray(made.get_pixels(oiio.FLOAT), np.float64).reshape(*size, channels)


def nearest(values: NDArray[Any], matrix: Floats, size: tuple[int, int]) -> NDArray[Any]:
    """Return labels resampled by the nearest pixel; see `warped`."""
    y, x = np.indices(size) + 0.5
    place = np.stack([x, y, np.ones(size)], axis=-1) @ np.linalg.inv(matrix)
    columns, rows = np.floor(place[..., :2] / place[..., 2:]).astype(int).transpose(2, 0, 1)
    height, width = values.shape[:2]
    found: NDArray[Any] = values[rows.clip(0, height - 1), columns.clip(0, width - 1)]
    return found
