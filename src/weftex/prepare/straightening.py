"""Warp a photo: make rows level and tiles upright, correct its perspective, or scale it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import given_lattice
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.io.formats import image_library
from weftex.parameters import numbers_of
from weftex.raster.arrays import Floats
from weftex.raster.levels import tamed
from weftex.raster.mixing import Kind, stored, vectors_of

__all__ = ["is_tilted", "scaled", "straighten"]

_UPRIGHT = math.radians(20)  # rotation beyond which another orientation is preferred
_SQUARE = math.sin(math.radians(10))  # tolerance of the right angle of a piece
_TIMES = range(-3, 4)  # vectors of a lattice that are summed up to a piece's sides
_MOST_TIMES = 8  # that a photo is enlarged
_SHORTEST = 8  # pixels that must be left of a photo


def straighten(
    sample: Sample,
    *,
    lattice: Lattice | Sequence[float] | str | None = None,
    corners: Sequence[float] | str | None = None,
) -> Exemplar:
    """Rotate, shear or rectify a photo, so that its lattice or a rectangle in it is straight.

    By a lattice, rows become level, and the joints across them upright. The result is the largest
    central part of the photo without empty corners, in the photo's proportions. By four corners,
    the perspective is corrected, and the rectangle becomes the whole result.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The photo. Maps, mask and guide are straightened with it, and the vectors of normal maps
        are rotated to fit the straightened heights.
    lattice : Lattice, or x1, y1, x2, y2, optional
        Lattice of the photo. By default, weftex finds it.
    corners : eight numbers, optional
        x and y in pixels of the corners of a rectangle in the scene: top left, top right, bottom
        right, bottom left. Its proportions follow from the perspective if that is clear and the
        photo was not cropped to one side, otherwise from the lengths of the sides.

    Returns
    -------
    Exemplar
        The straight photo, with the same dtype and the same scale.

    Raises
    ------
    FileError
        If the sample cannot be read.
    InvalidInputError
        If no lattice or rows are found, or the corners are outside the photo, not convex, or not in
        this order.

    Examples
    --------
    >>> y, x = np.mgrid[:96, :96]
    >>> askew = Exemplar((127 + 99 * np.sin((y + 0.05 * x) / 2)).astype(np.uint8))
    >>> along = [np.diff(one.pixels.astype(int)) for one in (askew, straighten(askew))]
    >>> bool(abs(along[1]).mean() < 0.2 * abs(along[0]).mean())
    True
    """
    exemplar = load_exemplar(sample)
    if corners is not None:
        if lattice is not None:
            raise InvalidInputError("give a lattice or corners, not both")
        matrix, size = _by_corners(np.reshape(numbers_of("corners", corners, 8), (4, 2)), exemplar)
    else:
        matrix, size = _by_lattice(_lattice_of(lattice, exemplar), exemplar)
    whole = math.lcm(*(exemplar.scale_of(name).denominator for name in exemplar.maps))
    size = size[0] - size[0] % whole, size[1] - size[1] % whole
    return _all_warped(exemplar, matrix, size).changed(tileable=False)


def scaled(sample: Sample, times: float) -> Exemplar:
    """Scale a sample and its maps by Lanczos's filter.

    Sides are rounded to whole pixels, so that a tileable sample stays tileable. Normals keep their
    slopes, and heights their values. Labels, mask and guide take the nearest pixel.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The sample. If it is `tileable`, the filter wraps around.
    times : float
        Factor for both sides, such as 0.5 for half the size; above 0 and at most 8.

    Raises
    ------
    FileError
        If the sample cannot be read.
    InvalidInputError
        If `times` is out of range.

    Examples
    --------
    >>> scaled("sample:stone_wall", 0.5).shape
    (128, 128)
    """
    exemplar = load_exemplar(sample)
    height, width = exemplar.shape
    if not 0.5 / min(height, width) <= times <= _MOST_TIMES:
        raise InvalidInputError(
            f"{exemplar.name}, {width}x{height}, would be scaled {times:.4g} times; it must keep "
            f"a pixel, and be at most {_MOST_TIMES}, as no detail is added"
        )
    whole = math.lcm(*(exemplar.scale_of(name).denominator for name in exemplar.maps))
    high, wide = (max(1, round(side * times / whole)) * whole for side in (height, width))
    return _all_warped(exemplar, np.diag([wide / width, high / height, 1.0]), (high, wide))


def _all_warped(exemplar: Exemplar, matrix: Floats, size: tuple[int, int]) -> Exemplar:
    """Return a sample warped with its maps, mask and guide."""
    return exemplar.changed(
        pixels=_warped(exemplar, matrix, size),
        maps={name: _warped_map(exemplar, name, matrix, size) for name in exemplar.maps},
        mask=None if exemplar.mask is None else _nearest(exemplar.mask, matrix, size),
        guide=None if exemplar.guide is None else _nearest(exemplar.guide, matrix, size),
    )


def _warped_map(exemplar: Exemplar, name: str, matrix: Floats, size: tuple[int, int]) -> Exemplar:
    """Return a warped map at its own scale, with the same corners."""
    one, scale = exemplar.map(name), exemplar.scale_of(name)
    one = one.changed(tileable=exemplar.tileable)
    unit = np.diag([float(scale), float(scale), 1.0])
    own = np.linalg.inv(unit) @ matrix @ unit
    sides = int(size[0] * scale), int(size[1] * scale)
    return one.changed(pixels=_warped(one, own, sides))


def _lattice_of(given: Lattice | Sequence[float] | str | None, exemplar: Exemplar) -> Lattice:
    if isinstance(given, Lattice):
        return given
    if given is not None:
        return given_lattice(numbers_of("lattice", given, 4))
    found = find_lattice(exemplar)
    if found is None:
        raise InvalidInputError(
            f"no lattice or rows are found in {exemplar.name}; give lattice vectors, or the "
            "corners of a rectangle in the scene"
        )
    return found


def _by_lattice(lattice: Lattice, exemplar: Exemplar) -> tuple[Floats, tuple[int, int]]:
    """Return the affine matrix (3, 3) that makes a lattice level, and the size of the result."""
    sides = _sides(lattice)
    turn = np.linalg.inv(sides) @ np.diag(np.hypot(*sides.T))
    height, width = exemplar.shape
    middle = np.array([width, height]) / 2
    # The part of the photo's proportions whose corners come from within it.
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * middle
    share = min(1.0, float((middle / abs(corners @ np.linalg.inv(turn)).max(axis=0)).min()))
    high, wide = (int(side * share + 1e-6) for side in (height, width))
    if min(high, wide) < min(_SHORTEST, height, width):
        raise InvalidInputError(f"nothing of {exemplar.name} would be left after straightening it")
    matrix = np.eye(3)
    matrix[:2, :2] = turn
    matrix[2, :2] = np.array([wide, high]) / 2 - middle @ turn
    return matrix, (high, wide)


def _sides(lattice: Lattice) -> Floats:
    """Return the sides (x, y) that become level and upright, (2, 2)."""
    if len(lattice.vectors) == 1:
        x, y = lattice.vectors[0]
        down = np.array([x, y]) * (1 if y > 0 else -1)
        if abs(x) > abs(y):  # rows that stand
            across = np.array([x, y]) * (1 if x > 0 else -1)
            return np.array([across, (-across[1], across[0])])
        return np.array([(down[1], -down[0]), down])
    times = np.array([k for k in product(_TIMES, _TIMES) if k != (0, 0)])
    sums = times @ np.array(lattice.reduced().vectors)
    lengths = np.hypot(*sums.T)
    rightward = sums[:, 0] >= abs(sums[:, 1])
    downward = sums[:, 1] > abs(sums[:, 0])
    best: tuple[tuple[bool, float], Floats] | None = None
    for i, j in product(np.flatnonzero(rightward), np.flatnonzero(downward)):
        area = lengths[i] * lengths[j]
        if abs(sums[i] @ sums[j]) > _SQUARE * area:
            continue
        (x, y), (u, v) = sums[i], sums[j]
        askew = max(math.atan2(abs(y), x), math.atan2(abs(u), v))
        rank = (askew > _UPRIGHT, round(float(area), 3))
        if best is None or rank < best[0]:
            best = rank, sums[[i, j]]
    if best is None:
        raise InvalidInputError("the lattice has no right-angled piece; give corners")
    return best[1]


def is_tilted(lattice: Lattice) -> bool:
    """Return whether rows, or a side of the pieces, are half a degree or more off the axes."""
    try:
        turns = [abs(math.degrees(math.atan2(y, x))) % 90 for x, y in _sides(lattice)]
    except InvalidInputError:
        return False
    return 0.5 <= min(min(turn, 90 - turn) for turn in turns) <= 15


def _by_corners(corners: Floats, exemplar: Exemplar) -> tuple[Floats, tuple[int, int]]:
    """Return the matrix that maps four corners to those of a rectangle, and its size."""
    height, width = exemplar.shape
    if (corners < 0).any() or (corners > (width, height)).any():
        raise InvalidInputError(f"corners lie outside {exemplar.name}, which is {width}x{height}")
    along = np.roll(corners, -1, axis=0) - corners
    turns = along[:, 0] * np.roll(along[:, 1], -1) - along[:, 1] * np.roll(along[:, 0], -1)
    if (turns <= 0).any():
        raise InvalidInputError(
            "corners must be top left, top right, bottom right, bottom left of a convex shape"
        )
    lengths = np.hypot(*along.T)
    wide, high = (lengths[0] + lengths[2]) / 2, (lengths[1] + lengths[3]) / 2
    unit = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    ratio = _proportions(_projection(unit, corners - (width / 2, height / 2)))
    if ratio is not None:  # of the same area
        wide, high = math.sqrt(wide * high * ratio), math.sqrt(wide * high / ratio)
    size = (round(high), round(wide))
    if min(size) < 1:
        raise InvalidInputError("the corners leave no pixel between them")
    return _projection(corners, unit * size[::-1]), size


def _projection(places: Floats, to: Floats) -> Floats:
    """Return the projective matrix (3, 3), for rows (x, y, 1), that maps four points to others."""
    rows, right = [], []
    for (x, y), (u, v) in zip(places, to, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
        right += [u, v]
    return np.append(np.linalg.solve(rows, right), 1).reshape(3, 3).T


def _proportions(matrix: Floats) -> float | None:
    """Return width over height of a rectangle from the projection of a unit square, or None.

    Its sides are perpendicular, which gives the focal length and thus their lengths; the camera's
    axis goes through the middle of the photo. None without clear perspective.
    """
    along, down = matrix[0], matrix[1]
    far = along[2] * down[2]
    squared = -(along[0] * down[0] + along[1] * down[1]) / far if abs(far) > 1e-4 else 0.0
    if not squared > 0:
        return None
    weight = np.array([1 / squared, 1 / squared, 1])
    ratio = math.sqrt(float((along**2) @ weight) / float((down**2) @ weight))
    return ratio if 0.2 < ratio < 5 else None


def _warped(picture: Exemplar, matrix: Floats, size: tuple[int, int]) -> NDArray[Any]:
    """Return a picture (H, W, ...) warped by a matrix for rows (x, y, 1).

    Values stay within their range, transparent pixels do not bleed, labels are not blended, and
    vectors are rotated.
    """
    pixels = picture.pixels
    if picture.role.kind == "labels":
        return _nearest(pixels, matrix, size)
    planes = pixels.reshape(*pixels.shape[:2], -1)
    if picture.mixing.kind is Kind.VECTORS:
        found = _turned(planes, picture, matrix, size)
    else:
        numbers, exponent = tamed(planes) if pixels.dtype.kind == "f" else (planes, 0)
        numbers = numbers.astype(np.float64)
        if picture.alpha:
            numbers[..., :-1] *= numbers[..., -1:]
        found = _resampled(numbers, matrix, size, picture.tileable)
        if picture.alpha:
            found[..., :-1] /= np.where(found[..., -1:] > 0, found[..., -1:], 1)
        found = _within(planes, np.ldexp(found, exponent))
    return found.reshape(*size, *pixels.shape[2:])


def _turned(
    planes: NDArray[Any], picture: Exemplar, matrix: Floats, size: tuple[int, int]
) -> NDArray[Any]:
    """Return vectors resampled as directions and lengths, and then rotated.

    A normal is the slope of the heights, which changes with distances along the surface; a change
    of size is ignored, as the scale of the heights is unknown.
    """
    middle, down = picture.mixing.middle, picture.role.name == "normal_dx"
    vectors = vectors_of(planes[..., :3], middle)
    lengths = np.linalg.norm(vectors, axis=2, keepdims=True)
    parts = np.concatenate([vectors, lengths, planes[..., 3:]], axis=2)
    found = _resampled(parts, matrix, size, picture.tileable)
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
    return np.concatenate([made, _within(planes[..., 3:], found[..., 4:])], axis=2)


def _within(planes: NDArray[Any], found: Floats) -> NDArray[Any]:
    """Return numbers in the range and of the type of each channel of a picture."""
    inside = np.clip(found, planes.min((0, 1)), planes.max((0, 1)))
    return (np.rint(inside) if planes.dtype.kind == "u" else inside).astype(planes.dtype)


def _resampled(numbers: Floats, matrix: Floats, size: tuple[int, int], tileable: bool) -> Floats:
    """Return each channel of (H, W, C) resampled."""
    oiio = image_library()
    channels = numbers.shape[2]
    area = oiio.ROI(0, size[1], 0, size[0], 0, 1, 0, channels)
    given = oiio.ImageBuf(np.ascontiguousarray(numbers, np.float32))
    if tileable or (matrix != np.diag(np.diag(matrix))).any():
        how = {"roi": area, "wrap": "periodic" if tileable else "clamp"}
        made = oiio.ImageBufAlgo.warp(given, tuple(matrix.ravel()), "lanczos3", **how)
    else:  # the same of a matrix that only scales, four times as fast
        made = oiio.ImageBufAlgo.resize(given, filtername="lanczos3", roi=area)
    if made.has_error:
        raise InvalidInputError(f"the photo cannot be straightened: {made.geterror()}")
    return np.asarray(made.get_pixels(oiio.FLOAT), np.float64).reshape(*size, channels)


def _nearest(values: NDArray[Any], matrix: Floats, size: tuple[int, int]) -> NDArray[Any]:
    """Return labels resampled by the nearest pixel; see `_warped`."""
    y, x = np.indices(size) + 0.5
    place = np.stack([x, y, np.ones(size)], axis=-1) @ np.linalg.inv(matrix)
    columns, rows = np.floor(place[..., :2] / place[..., 2:]).astype(int).transpose(2, 0, 1)
    height, width = values.shape[:2]
    return np.asarray(values[rows.clip(0, height - 1), columns.clip(0, width - 1)])
