"""A lattice drawn over its sample, for files and for pages, and in a mason's words."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from weftex.analysis.autocorrelations import all_times, autocorrelations
from weftex.analysis.canvas_lattice import checked_lattice
from weftex.analysis.lattice import Lattice, Rated, rate_lattices
from weftex.analysis.relief import smaller_copy
from weftex.exemplar import Exemplar
from weftex.raster.arrays import Bytes, Floats

__all__ = ["DrawnLattice", "Lattice", "LatticeRating", "Rated", "draw"]

_LARGEST_SIDE = 1024  # pixels of the sample by which lines are put into joints
_BINS = 48  # phases of a line that are tried
_UPRIGHT = 0.05  # of its length, that a vector along an axis may be off it
_LONGEST = 12.0  # a piece, for its height
_LYING = 1.5  # the same, from which courses are taken to lie
_SQUARE = 1.1  # times as long as high, at most
_SHIFT = 0.06  # of a piece, that a shift may be off a name
_NAMES = {1 / 2: "every other {} shifted by half"}
_NAMES |= {1 / 3: "each {} shifted by a third", 1 / 4: "each {} shifted by a quarter"}


def draw_lattice(exemplar: Exemplar, lattice: Lattice | None) -> Bytes:
    """Draw the sides of the tiles over a sample, or lines between rows.

    A lattice says how far to shift and not where tiles begin, so the lines lie where the sample
    changes most: in the joints, where there are some.
    """
    levels = _levels(exemplar)
    picture = levels.copy()
    if lattice is None:
        return picture
    height, width = exemplar.shape
    y, x = np.mgrid[:height, :width].astype(np.float64)
    lines = np.zeros((height, width), bool)
    for across, phase in _lines_over(levels, lattice):
        # Whole numbers are where a line could be; it is as thick as a pixel, more on big samples.
        off = x * across[0] + y * across[1] - phase
        thick = max(1.0, max(height, width) / 500)
        lines |= abs(off - np.rint(off)) < thick / 2 * float(np.hypot(*across)) + 1e-9
    red, green, blue = levels.reshape(-1, 3).mean(axis=0)
    picture[lines] = (0, 255, 0) if max(red, blue) > 1.2 * green + 10 else (255, 0, 255)
    return picture


@dataclass(frozen=True)
class DrawnLattice:
    """A lattice, or rows, for whoever draws it over the sample."""

    vectors: list[list[float]]  # two (x, y) in pixels; one of rows
    numbers: str  # the lattice as the option --lattice takes it
    words: str  # width and height of its pieces, and their shift
    #: The sides of its tiles: along each line ``x * across[0] + y * across[1]`` is an integer plus
    #: ``phase``.
    lines: list[dict[str, object]]
    goodness: float | None  # see `weftex.analysis.lattice.Rated`; None if it was not rated


def draw(
    exemplar: Exemplar, vectors: tuple[tuple[float, float], ...], goodness: float | None = None
) -> DrawnLattice:
    """Return a lattice with lines where the sample changes most."""
    lattice = Lattice(vectors)
    small, step = smaller_copy(exemplar, _LARGEST_SIDE)
    reduced = Lattice(tuple((x / step, y / step) for x, y in vectors))
    return DrawnLattice(
        vectors=[list(map(float, vector)) for vector in vectors],
        numbers=",".join(f"{number:g}" for number in lattice),
        words=courses(lattice),
        lines=[
            {"across": [float(part) / step for part in across], "phase": phase}
            for across, phase in _lines_over(_levels(small), reduced)
        ],
        goodness=goodness,
    )


class LatticeRating:
    """Rates lattices of a sample, of which it keeps the correlations: 64 bytes per pixel."""

    def __init__(self, exemplar: Exemplar) -> None:
        self._exemplar = exemplar
        self._fields = autocorrelations(exemplar)

    def rate(self, numbers: str) -> DrawnLattice:
        """Draw and rate a lattice given as x1,y1,x2,y2.

        Raises
        ------
        InvalidInputError
            If it does not fit into the sample.
        """
        lattice = checked_lattice(numbers, self._exemplar)
        found, _ = rate_lattices(self._exemplar, lattice, runners_up=0, fields=self._fields)
        assert found is not None
        return draw(self._exemplar, lattice.vectors, found.goodness)


def _levels(exemplar: Exemplar) -> Bytes:
    """The sample in three channels of bytes; clear pixels are white."""
    matching = exemplar.as_matching(exemplar.pixels)
    colors = exemplar.channels - exemplar.alpha
    levels = matching[..., :3] if colors >= 3 else np.repeat(matching[..., :1], 3, axis=2)
    if exemplar.alpha:
        clear = 255 - matching[..., -1:].astype(int)
        levels = np.minimum(levels + clear, 255).astype(np.uint8)
    return levels


def _lines_over(levels: Bytes, lattice: Lattice) -> list[tuple[Floats, float]]:
    """Each family of lines where the levels change most."""
    gray = levels.mean(axis=2)
    change = sum(
        abs(np.gradient(gray, axis=axis)) if side > 1 else 0 * gray
        for axis, side in enumerate(gray.shape)
    )
    y, x = np.mgrid[: gray.shape[0], : gray.shape[1]].astype(np.float64)
    vectors = np.array(lattice.vectors)
    # What times (x, y) counts the lines of each family: the rows of the inverse basis.
    one = len(vectors) == 1
    families = vectors / (vectors[0] @ vectors[0]) if one else np.linalg.inv(vectors).T
    return [(along, _busiest(x * along[0] + y * along[1], change)) for along in families]


def _busiest(place: Floats, change: Floats) -> float:
    """The phase of a line along which the sample changes most."""
    bins = (place % 1 * _BINS).astype(int) % _BINS
    total = np.bincount(bins.ravel(), change.ravel(), _BINS)
    count = np.bincount(bins.ravel(), minlength=_BINS)
    return float((np.argmax(np.rint(total / np.maximum(count, 1) * 1e6)) + 0.5) / _BINS)


def courses(lattice: Lattice) -> str:
    """Say the width and height of the pieces of a lattice in pixels, and their shift.

    Which way courses lie cannot be seen in a lattice: they lie where that makes pieces clearly
    longer than high, and are rows there; where they stand, they are columns. The vectors of a
    running bond lead to the next row, half a piece aside, so their lengths are diagonals.
    """
    shortest = lattice.reduced().vectors
    if len(shortest) == 1:
        return f"{_number(math.hypot(*shortest[0]))} px"
    sums = all_times(4, 2) @ np.array(shortest)
    found = []
    for axis in (0, 1):
        along, aside = abs(sums[:, axis]), abs(sums[:, 1 - axis])
        near = np.flatnonzero((along > 0) & (aside <= _UPRIGHT * along))
        if len(near) and (along[near] ** 2).min() <= _LONGEST * lattice.area:
            piece = sums[near[np.argmin(along[near])]]
            length = float(np.hypot(*piece))
            found.append((round(length**2 / lattice.area, 2), -axis, length, piece))
    if not found:
        return " x ".join(_number(math.hypot(*vector)) for vector in shortest) + " px"
    # Courses lie where pieces are clearly longer than high, else where they are as long as high, as
    # scales are, and else where they are longest.
    lying = [one for one in found if one[1] == 0 and one[0] >= _LYING]
    lying += [one for one in found if 1 / _SQUARE <= one[0] <= _SQUARE]
    _, axis, length, piece = lying[0] if lying else max(found, key=lambda one: one[:2])
    # How far along it the next course is moved, of the sums that are one course on.
    on = sums[np.rint(sums @ np.array([-piece[1], piece[0]]) / lattice.area) == 1]
    along = abs(on @ piece) / length**2
    moved = float(along.min())
    height = lattice.area / length if moved > _SHIFT else float(np.hypot(*on[along.argmin()]))
    sides = (length, height)[:: 1 if axis == 0 else -1]
    size = f"{_number(sides[0])} x {_number(sides[1])} px"
    if moved <= _SHIFT:
        return size
    line = "column" if axis else "row"
    name = next((words for share, words in _NAMES.items() if abs(moved - share) <= _SHIFT), None)
    return f"{size}, " + (name or f"each {{}} shifted by {moved:.2f}").format(line)


def _number(length: float) -> str:
    """To a tenth of a pixel.

    >>> _number(64.04), _number(41.77)
    ('64', '41.8')
    """
    return f"{length:.1f}".removesuffix(".0")
