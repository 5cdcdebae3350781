"""A lattice on a sample and on a canvas: where similar positions are (section 4.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.lattice import Lattice, find_lattice
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.parameters import numbers_of
from weftex.random import draw
from weftex.raster.arrays import Floats, Ints
from weftex.results.pixels import rearranged

_UNIT = 1 << 16  # positions are in 1/65536 pixel
_SMALLEST_SAMPLE = 32  # side below which noise may look like a lattice by chance
_ALONG = 1.01  # pixels: a vector as short as that says nothing but a direction
_FARTHEST = 1 << 16  # pixels, before which outputs begin on a lattice
_SIZES_TRIED = 256  # pixels on both sides of a size where a better one is looked for
_MOST_TRIED = 1 << 10  # pixels up to which the search is widened if there is none
_SURE = 0.6  # confidence from which blocks may be laid by a lattice
_TILES = 3  # that a sample must show, so that a block has more than one place to come from
#: Strain of a lattice that goes around a canvas, from which it shows. Joints of bricks, tiles and a
#: fence met at up to 0.07, whatever the tolerance; at 0.1 some were broken.
VISIBLE_STRAIN = 0.07
FITTING_STRAIN = 0.01  #: Strain of a lattice up to which a size counts as one that fits.
MOST_STRETCHED = 0.2  #: Strain up to which entire samples are stretched to fit.
_SEEN = 1.0  # pixels by which a strain moves parts of a sample, from which it is stretched
STIFF = 0.02  #: Strain of a lattice from which whole samples cannot make up for it.


class Around(NamedTuple):
    """A plane, which wraps around after `height` and `width` pixels along the axes of `wrap`."""

    height: int
    width: int
    wrap: tuple[bool, bool] = (True, True)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.height, self.width


class CanvasLattice:
    """The vectors x1, y1, x2, y2 of a sample, stretched to fit whole tiles on a canvas that wraps.

    `strain` is how much the canvas's vectors are longer, shorter or rotated. More than `limit`
    raises `InvalidInputError`, which names the nearest good size.
    """

    def __init__(
        self,
        vectors: tuple[float, ...],
        canvas: Canvas | Around | None = None,
        limit: float = float("inf"),
    ) -> None:
        x1, y1, x2, y2 = vectors
        self.sample = np.array([[y1, x1], [y2, x2]])
        self.canvas, self.strain = self.sample, 0.0
        if canvas is not None and any(canvas.wrap):
            self.canvas, self.strain = _stretched(self.sample, canvas.shape, canvas.wrap)
            if not self.strain <= limit:
                better = [f"{w}x{h} fits" for h, w in fitting_sizes(vectors, canvas, limit)]
                raise InvalidInputError(
                    f"the lattice would have to be stretched by {100 * self.strain:.1f} % to fit "
                    f"{canvas.width}x{canvas.height}, and at most {100 * limit:.1f} % is allowed; "
                    f"{[*better, 'make it larger'][0]}"
                )
        (a, b), (c, d) = self.canvas
        det = a * d - b * c
        self.inverse = np.array([[d, -b], [-c, a]]) / det

    def multiples(self, y: Any, x: Any) -> tuple[Any, Any]:
        """Return the multiples of the canvas's vectors that lead to places, with fractions."""
        (a, b), (c, d) = self.inverse
        return y * a + x * c, y * b + x * d

    def cell(self, y: Any, x: Any, counts: list[int]) -> Ints:
        """Return the cell of the tile that pixels lie in, for sides cut into `counts` parts."""
        number = []
        for along, count in zip(self.multiples(y, x), counts, strict=True):
            # A little on, so that multiples of whole vectors do not fall between two cells.
            part = along - np.floor(along) + 2.0**-20
            number.append((part * count).astype(np.int64) % count)
        return np.asarray(number[0] * counts[1] + number[1])

    def phase(self, y: NDArray[np.integer], x: NDArray[np.integer]) -> Ints:
        """Return the positions in the sample's first tile (eq. 3.29), (..., 2) in 1/65536 pixel."""
        parts = [along - np.floor(along) for along in self.multiples(y, x)]
        place = [parts[0] * self.sample[0, k] + parts[1] * self.sample[1, k] for k in (0, 1)]
        return np.asarray(np.rint(np.stack(place, axis=-1) * _UNIT), np.int64)

    def steps(self, height: int, width: int) -> Ints:
        """Return all multiples (n, 2) that lead from the first tile into a box at (0, 0).

        In 1/65536 pixel, from the smallest multiples of the first vector on.
        """
        inverse = np.linalg.inv(self.sample)
        corners = np.array([[0, 0], [0, width], [height, 0], [height, width]]) @ inverse
        low, high = np.floor(corners.min(axis=0)) - 1, np.ceil(corners.max(axis=0))
        a, b = (np.arange(low[k], high[k] + 1) for k in (0, 1))
        found = a[:, None, None] * self.sample[0] + b[None, :, None] * self.sample[1]
        found = found.reshape(-1, 2)
        tile = np.stack([0 * self.sample[0], *self.sample, self.sample.sum(axis=0)])
        near = (found + tile.max(axis=0) > -1) & (found + tile.min(axis=0) < (height, width))
        return np.asarray(np.rint(found[near.all(axis=1)] * _UNIT), np.int64)


def check_lattice(vectors: tuple[float, ...], exemplar: Exemplar) -> None:
    """Raise `InvalidInputError` unless two cells of these vectors lie in the sample."""
    x1, y1, x2, y2 = vectors
    lattice = Lattice(((x1, y1), (x2, y2))).reduced()
    height, width = exemplar.shape
    size = f"{exemplar.name} is {width}x{height}"
    for x, y in lattice.vectors:
        if abs(x) >= width or abs(y) >= height:
            raise InvalidInputError(
                f"lattice has the vector [{x:g}, {y:g}], but {size}; it must be smaller"
            )
    if 2 * lattice.area > height * width:
        raise InvalidInputError(
            f"one cell of the lattice has {lattice.area:.0f} pixels, but {size}, "
            "which is less than two cells; give a larger sample"
        )


def is_sure(lattice: Lattice | None, pixels: int) -> bool:
    """Return whether a lattice is sure enough to place blocks by it."""
    if lattice is None or len(lattice.vectors) == 1 or lattice.confidence < _SURE:
        return False
    return pixels >= _TILES * lattice.area


def given_lattice(vectors: tuple[float, ...]) -> Lattice:
    """Return the lattice of x1, y1, x2, y2: rows, if one of the vectors is a pixel long.

    >>> given_lattice((0, 47, 1, 0)).vectors
    ((0.0, 47.0),)
    """
    x1, y1, x2, y2 = vectors
    pair = sorted(((x1, y1), (x2, y2)), key=lambda one: float(np.hypot(*one)))
    if np.hypot(*pair[0]) <= _ALONG < np.hypot(*pair[1]):
        return Lattice((pair[1],))
    return Lattice(((x1, y1), (x2, y2)))


def checked_lattice(vectors: Sequence[float] | str, exemplar: Exemplar) -> Lattice:
    """Return a lattice given as x1, y1, x2, y2, if it fits the sample."""
    plain = numbers_of("lattice", vectors, 4)
    check_lattice(plain, exemplar)
    return given_lattice(plain)


def found_vectors(exemplar: Exemplar) -> tuple[float, ...]:
    """Return the lattice of a sample as x1, y1, x2, y2; x1, y1 for rows; () without one."""
    if min(exemplar.shape) < _SMALLEST_SAMPLE or (lattice := find_lattice(exemplar)) is None:
        return ()
    return tuple(part for vector in lattice.reduced().vectors for part in vector)


def first_place(canvas: Canvas, seed: int) -> Ints:
    """The row and column of the endless lattice where a canvas begins, by chance.

    So small outputs differ. Known pixels, planes, and axes that wrap have places of their own.
    """
    own = canvas.wrap if canvas.hole is None and canvas.shown is None else (True, True)
    drawn = draw(seed, "phase", np.arange(2)) % np.uint64(_FARTHEST)
    return np.where(own, canvas.origin, drawn.astype(np.int64))


def fitted_sample(
    exemplar: Exemplar, vectors: tuple[float, ...] | None, canvas: Canvas
) -> tuple[Canvas, tuple[NDArray[np.int32], tuple[float, ...], Exemplar] | None]:
    """Return the canvas that fits a lattice if its lines are left out or doubled, and a sample.

    In the sample lines are shifted, too, and corners cut off, where that moves anything by a pixel:
    its pixels y * width + x in the given one, the lattice's vectors in it, and the sample.
    """
    if vectors is None or canvas.kinds != ("wrap",) or exemplar.pieces:
        return canvas, None
    lattice, last = CanvasLattice(vectors, canvas), np.subtract(exemplar.shape, 1)
    whole = np.rint(lattice.sample)  # as drawings have, and lattices are found to a fraction
    if _strain(np.linalg.solve(lattice.sample, whole)) * max(last) < _SEEN / 2:
        lattice = CanvasLattice(tuple(whole[:, ::-1].ravel().tolist()), canvas)
    if lattice.strain > MOST_STRETCHED:
        return canvas, None
    longer = np.diag(np.linalg.solve(lattice.sample, lattice.canvas))
    height, width = np.rint(np.divide(canvas.shape, longer)).astype(int).tolist()
    canvas = Canvas(height, width, canvas.wrap)
    lattice = CanvasLattice(vectors, canvas)
    if not _SEEN <= lattice.strain * max(last) <= MOST_STRETCHED * max(last):
        return canvas, None
    change = np.linalg.solve(lattice.sample, lattice.canvas)
    size = (last @ (2 * np.diag(np.diag(change)) - np.abs(change))).astype(int)
    block = math.lcm(*(exemplar.scale_of(name).denominator for name in exemplar.maps))
    size = np.maximum(size - (size + 1) % block, block - 1)  # whole pixels of coarse maps
    places = (np.moveaxis(np.indices(size + 1), 0, -1) - size / 2) @ np.linalg.inv(change)
    y, x = np.moveaxis(np.rint(places + last / 2).clip(0, last).astype(np.int32), -1, 0)
    index, found = y * np.int32(exemplar.shape[1]) + x, lattice.canvas[:, ::-1].ravel()
    parts = {"mask": exemplar.usable[y, x], "guide": None, "tileable": False}
    return canvas, (index, tuple(map(float, found)), rearranged(exemplar, index, **parts))


def _stretched(
    vectors: Floats, shape: tuple[int, ...], wrap: tuple[bool, ...], most: float = 1.0
) -> tuple[Floats, float]:
    """Return the vectors, changed as little as possible to wrap around the canvas; the strain.

    `most`: the strain above which no further multiples are tried.
    """
    around = np.diag(np.asarray(shape, float))[np.asarray(wrap)]
    times = around @ np.linalg.inv(vectors)
    near = np.rint(times)
    for k in range(len(near)):  # at least once around
        if not near[k].any():
            longest = int(np.abs(times[k]).argmax())
            near[k, longest] = np.copysign(1, times[k, longest])
    change = _change_to(near @ vectors, around)
    if FITTING_STRAIN < _strain(change) < most:
        others = np.stack(np.meshgrid(*[[0, -1, 1]] * near.size), axis=-1).reshape(-1, *near.shape)
        changes = [_change_to((near + other) @ vectors, around) for other in others]
        # Slanting joints show more than longer bricks.
        change = min(changes, key=lambda one: np.linalg.norm((one - np.eye(2)) * (2 - np.eye(2))))
    strain = _strain(change)
    return (vectors @ change, strain) if 1e-12 < strain < np.inf else (vectors, strain)


def _change_to(near: Floats, around: Floats) -> Floats:
    """Return the change of vectors that moves multiples of them onto those around the canvas."""
    if np.linalg.det(near @ near.T) < 1e-6:  # of pixels, to the power of two or four
        return np.full((2, 2), np.inf)
    change: Floats = np.linalg.pinv(near) @ (around - near)
    return np.eye(2) + change


def _strain(change: Floats) -> float:
    return float(np.linalg.norm(change - np.eye(2), 2)) if np.isfinite(change).all() else np.inf


def fitting_sizes(
    vectors: tuple[float, ...],
    canvas: Canvas | Around,
    limit: float = FITTING_STRAIN,
    near: int = _SIZES_TRIED,
) -> list[tuple[int, int]]:
    """Return the nearest size that strains a lattice at most this much, and the nearest larger."""
    x1, y1, x2, y2 = vectors
    pair, sides = np.array([[y1, x1], [y2, x2]]), list[list[int]]()
    for axis, (side, wraps) in enumerate(zip(canvas.shape, canvas.wrap, strict=True)):
        tried = np.arange(max(1, side - near), side + near + 1)
        around = tried[:, None] * np.eye(2)[axis]
        times = np.rint(around @ np.linalg.inv(pair))
        off = np.hypot(*(times @ pair - around).T) / tried
        fits = tried[(off <= limit) & times.any(axis=1)] if wraps else np.array([side])
        sides.append([int(one) for one in fits])
    height, width = canvas.shape
    pairs = sorted(
        ((y, x) for y in sides[0] for x in sides[1]),
        key=lambda one: abs(one[0] - height) + abs(one[1] - width),
    )
    good = (one for one in pairs if _stretched(pair, one, canvas.wrap, limit)[1] <= limit)
    found = list(islice(good, 1))
    if found and (found[0][0] < height or found[0][1] < width):
        found += islice((one for one in good if one[0] >= height and one[1] >= width), 1)
    if not found and near < min(max(canvas.shape) // 2, _MOST_TRIED):
        return fitting_sizes(vectors, canvas, limit, 2 * near)
    return found
