"""The lattice of a near-regular sample: the translations at which it matches itself.

With `goodness="height"` it is the thesis's: `correlation`, peaks (`autocorrelations`), `pairs`. The
default, "contrast", adds `evidence`: of `tile_multiples`, `lines`, `bonds` and `prediction`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from weftex.analysis import evidence
from weftex.analysis.autocorrelations import Autocorrelations, Field, autocorrelations
from weftex.analysis.evidence import CLEAR, LEAST, Evidence
from weftex.analysis.lines import ridges
from weftex.analysis.pairs import goodness_of, highest, rate, rated_pairs, reach_of, reduced
from weftex.analysis.relief import maps_alone
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.progress import counted
from weftex.raster.arrays import Floats

Vector = tuple[float, float]

_LONGEST = 1e9  # pixels; no picture is as large, and products of vectors stay numbers


@dataclass(frozen=True)
class Lattice:
    """Translations under which a material looks the same.

    Pass it to a method as `lattice`, or as the tuple (x1, y1, x2, y2), as `tuple(lattice)`.
    For rows, (x2, y2) is one pixel along the rows.

    Attributes
    ----------
    vectors : tuple of (float, float)
        Two vectors (x, y) in pixels, x to the right and y downwards; their parallelogram is the
        tile. One vector if only rows repeat, as of boards.
    confidence : float
        Confidence from 0 to 1.

    Raises
    ------
    InvalidInputError
        If the vectors are zero, not finite, or lie on one line.

    Examples
    --------
    >>> bond = Lattice(((64.0, 40.5), (128.0, 0.0)))
    >>> bond.area
    5184.0
    >>> bond.reduced().vectors
    ((64.0, 40.5), (64.0, -40.5))
    """

    vectors: tuple[Vector, ...]
    confidence: float = 1.0

    def __post_init__(self) -> None:
        plain = tuple((float(x), float(y)) for x, y in self.vectors)
        object.__setattr__(self, "vectors", plain)
        text = ", ".join(f"[{x:g}, {y:g}]" for x, y in plain)
        if len(plain) not in (1, 2):
            raise InvalidInputError(f"a lattice has one or two vectors, not {len(plain)}")
        if not all(math.isfinite(c) for v in plain for c in v):
            raise InvalidInputError(f"lattice vectors {text} are not finite")
        lengths = [math.hypot(*v) for v in plain]
        if min(lengths) < 1:
            raise InvalidInputError(f"lattice vectors {text}: each must be 1 pixel long or more")
        if max(lengths) > _LONGEST:
            raise InvalidInputError(
                f"lattice vectors {text}: each must be at most {_LONGEST:g} pixels long"
            )
        if len(plain) == 2 and abs(self.area) < 1e-6 * lengths[0] * lengths[1]:
            raise InvalidInputError(f"lattice vectors {text} lie on one line")

    def __iter__(self) -> Iterator[float]:
        """Yield x1, y1, x2, y2, as `lattice=` takes them; along rows the second vector is a pixel.

        >>> tuple(Lattice(((0, 47),))), tuple(Lattice(((0.94, 53.99),)))
        ((0.0, 47.0, 1.0, 0.0), (0.94, 53.99, 0.9999, -0.0175))
        """
        (x, y), *other = self.vectors
        length = math.hypot(x, y)
        along = [round(y / length, 4) + 0.0, round(-x / length, 4) + 0.0]
        if math.hypot(*along) < 1:  # as rounded, and no vector may be shorter than a pixel
            along = [round(at + math.copysign(1e-4, at) * bool(at), 4) for at in along]
        yield from (x, y, *(other[0] if other else along))

    @property
    def area(self) -> float:
        """Pixels of the cell (eq. 3.25); 0 for one vector."""
        if len(self.vectors) == 1:
            return 0.0
        (ax, ay), (bx, by) = self.vectors
        return abs(ax * by - bx * ay)

    def reduced(self) -> Lattice:
        """Return the lattice by its shortest vectors, shorter first, pointing right or down."""
        if len(self.vectors) == 1:
            return Lattice((_rightward(self.vectors[0]),), self.confidence)
        first, second = reduced(np.array(self.vectors)).tolist()
        return Lattice((_rightward(first), _rightward(second)), self.confidence)

    def same_as(self, other: Lattice, tolerance: float = 0.015) -> bool:
        """Return whether both span one lattice (observation iv), to a share of each vector."""
        if len(self.vectors) != len(other.vectors):
            return False
        ours, theirs = self.reduced(), other.reduced()
        for x, y in theirs.vectors:
            near = ours.nearest((x, y))
            if math.hypot(near[0] - x, near[1] - y) > tolerance * math.hypot(x, y):
                return False
        return len(ours.vectors) == 1 or 0.7 < ours.area / theirs.area < 1.4

    def nearest(self, place: Vector) -> Vector:
        """Return the multiple nearest to a place (x, y); of one vector, it or its opposite."""
        (ax, ay), (x, y) = self.vectors[0], place
        if len(self.vectors) == 1:
            corners = [(ax, ay), (-ax, -ay)]
        else:
            bx, by = self.vectors[1]
            det = ax * by - bx * ay
            a, b = (math.floor((x * by - y * bx) / det), math.floor((ax * y - ay * x) / det))
            corners = [(i * ax + j * bx, i * ay + j * by) for i in (a, a + 1) for j in (b, b + 1)]
        return min(corners, key=lambda c: math.hypot(c[0] - x, c[1] - y))


#: Cached by goodness, as methods, scale and `auto` all ask.
_FOUND: WeakKeyDictionary[Exemplar, dict[str, Lattice | None]] = WeakKeyDictionary()


def _rightward(vector: Vector) -> Vector:
    """Return the vector or its opposite (observation iii), stable near an axis."""
    x, y = vector
    return (x, y) if x + y / 8 > 0 else (-x, -y)


def find_lattice(exemplar: Exemplar, *, goodness: str = "contrast") -> Lattice | None:
    """Return the lattice of a sample, its rows, or None where neither repeats or pieces lie apart.

    Section 3.3 of the thesis; pairs of vectors are rated by `goodness`, "contrast" or "height", see
    `weftex.analysis.pairs`. Slow lighting is taken off first. Where a sample with its maps shows
    none, the maps alone are looked at: stones of many colors hide joints that normals show.

    >>> from weftex.exemplar import Exemplar
    >>> tile = np.random.default_rng(0).integers(0, 255, (12, 16), np.uint8)
    >>> find_lattice(Exemplar(np.tile(tile, (6, 5)))).vectors
    ((0.0, 12.0), (16.0, 0.0))
    """
    if exemplar.pieces:
        return None
    known = _FOUND.setdefault(exemplar, {})
    if goodness not in known:
        with counted(4, "analysis") as step:
            fields = autocorrelations(exemplar)
            step(1)
            known[goodness] = lattice_in(fields, goodness)
            step(1)
            maps = maps_alone(exemplar)
            if known[goodness] is None and maps is not None:
                known[goodness] = lattice_in(autocorrelations(maps), goodness)
    return known[goodness]


def lattice_in(fields: Autocorrelations, goodness: str = "contrast") -> Lattice | None:
    """Return the better pair of vectors, or else rows; see `find_lattice`."""
    best = _by_contrast(fields) if goodness == "contrast" else _as_in_thesis(fields, goodness)
    if best is None:
        return None
    return Lattice(_plain(best.vectors * fields.flat.step), round(best.confidence, 2))


def _as_in_thesis(fields: Autocorrelations, goodness: str) -> Evidence | None:
    """Return the pair with the highest goodness (section 3.3), or rows where it is not sure."""
    vectors = highest(rated_pairs(fields.field, goodness))
    best = None if vectors is None else evidence.evidence_of(fields, vectors)
    return best if best is not None and best.confidence >= LEAST else _rows(fields)


def _by_contrast(fields: Autocorrelations) -> Evidence | None:
    """Return the pair or rows with the best evidence."""
    with counted(2, "analysis") as step:
        best = evidence.better_pair(evidence.pair_candidates(fields))
        step(1)
        if best is not None and best.confidence >= LEAST:
            if best.confidence < CLEAR and best.kind != "stripes":
                best = evidence.checked_by_rows(fields, best)
            if len(best.vectors) == 1:
                return best
            best = evidence.predicted(fields, best)
            if best is not None:
                return evidence.with_alternation(fields, best)
        rows = _rows(fields)
        if rows is None:
            return None
        best = evidence.lattice_of_rows(fields, rows)
        return best if best is rows else evidence.predicted(fields, best) or rows


def _rows(fields: Autocorrelations) -> Evidence | None:
    """Return the rows that are sure enough."""
    best = evidence.row_candidate(fields)
    return best if best is not None and best.confidence >= LEAST else None


def _plain(vectors: Floats) -> tuple[Vector, ...]:
    """Return the shortest vectors of a lattice, rounded to hundredths of a pixel."""
    shortest = Lattice(tuple((float(x), float(y)) for x, y in vectors)).reduced()
    return tuple((round(x, 2) + 0.0, round(y, 2) + 0.0) for x, y in shortest.vectors)


@dataclass(frozen=True)
class Rated:
    """A lattice or rows, rated as in section 3.3 of the thesis by D. López Recas (2011).

    Attributes
    ----------
    vectors : tuple of (float, float)
        The shortest vectors (x, y) in pixels; one of rows.
    goodness : float
        Goodness, eq. 3.22; 0 if a vector has no significant multiple.
    mean : float
        Mean correlation at the multiples, eq. 3.24; for rows, along the lines of shifts that are
        multiples of the step.
    multiples : int
        Number of multiples with a significant overlap, n of eq. 3.22; for rows, of such lines.
    """

    vectors: tuple[tuple[float, float], ...]
    goodness: float
    mean: float
    multiples: int


def rate_lattices(
    exemplar: Exemplar,
    lattice: Lattice | None = None,
    *,
    goodness: str = "contrast",
    runners_up: int = 3,
    fields: Autocorrelations | None = None,
) -> tuple[Rated | None, tuple[Rated, ...]]:
    """Rate a lattice, and the best others that a sample could have."""
    fields = autocorrelations(exemplar) if fields is None else fields
    field, step = fields.field, fields.flat.step

    def rated(vectors: Floats) -> Rated:
        found = rate(field, vectors[None], reach_of(field, vectors), goodness, exact=True)
        return Rated(
            _plain(vectors * step),
            round(float(found.goodness[0]), 4),
            round(float(found.value[0]), 4),
            int(found.count[0]),
        )

    own = None
    if lattice is not None:
        vectors = np.array(lattice.reduced().vectors) / step
        own = rated(vectors) if len(vectors) == 2 else _rated_rows(lattice, field, vectors[0])
    if not runners_up:
        return own, ()
    others = (rated(vectors) for vectors, _ in rated_pairs(field, goodness))
    shown: list[Rated] = []
    for other in sorted(others, key=lambda other: -other.goodness):
        known = [] if lattice is None else [lattice]
        known += [Lattice(one.vectors) for one in shown]
        if other.goodness > 0 and not any(Lattice(other.vectors).same_as(one) for one in known):
            shown.append(other)
    return own, tuple(shown[:runners_up])


def _rated_rows(lattice: Lattice, field: Field, vector: Floats) -> Rated:
    mean, number = ridges(field.correlation, vector)
    goodness = round(float(goodness_of(mean, number)), 4)
    return Rated(lattice.reduced().vectors, goodness, round(mean, 4), number)
