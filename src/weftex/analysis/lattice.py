"""The lattice of a near-regular sample: the translations at which it matches itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from weftex.analysis.autocorrelations import Autocorrelations, autocorrelations
from weftex.analysis.candidates import (
    CLEAR,
    LEAST,
    better_pair,
    checked_by_rows,
    course_candidate,
    lattice_of_rows,
    pair_candidates,
    row_candidate,
    with_alternation,
)
from weftex.analysis.goodness import ALPHA, SIGNIFICANT, check_rule
from weftex.analysis.pairs import reduced
from weftex.analysis.relief import maps_alone
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar

Vector = tuple[float, float]

_LONGEST = 1e9  # pixels; no picture is as large, and products of vectors stay numbers
_LEAST_ROWS = 0.6  # confidence of rows that are reported: drawn rubble had up to 0.57


@dataclass(frozen=True)
class Lattice:
    """Translations under which a material looks the same.

    Attributes
    ----------
    vectors : tuple of (float, float)
        Two vectors (x, y) in pixels, x to the right and y downwards, with fractions; their
        parallelogram is the tile. Or one, where a material repeats along one direction only.
    confidence : float
        From 0 to 1.

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

    @property
    def area(self) -> float:
        """Pixels of the tile (eq. 3.25); 0 for one vector."""
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
            a, b = math.floor((x * by - y * bx) / det), math.floor((ax * y - ay * x) / det)
            corners = [(i * ax + j * bx, i * ay + j * by) for i in (a, a + 1) for j in (b, b + 1)]
        return min(corners, key=lambda c: math.hypot(c[0] - x, c[1] - y))


#: Cached by goodness, alpha and share, as methods, scale and `auto` all ask.
_FOUND: WeakKeyDictionary[Exemplar, dict[tuple[str, float, float], Lattice | None]] = (
    WeakKeyDictionary()
)


def _rightward(vector: Vector) -> Vector:
    """Return the vector or its opposite (observation iii), stable near an axis."""
    x, y = vector
    return (x, y) if x + y / 8 > 0 else (-x, -y)


def find_lattice(
    exemplar: Exemplar,
    *,
    goodness: str = "contrast",
    alpha: float = ALPHA,
    significant: float = SIGNIFICANT,
) -> Lattice | None:
    """Find the translations under which a sample looks the same, once for each sample.

    Section 3.3 of the paper on near-regular textures, with pairs rated by contrast; see
    `weftex.analysis.goodness`. Where a sample with its maps shows none, the maps alone are looked
    at: stones of many colors hide joints that normals show.

    Parameters
    ----------
    exemplar : Exemplar
        The sample; a mask may leave out parts of it. Slow lighting is taken off first.
    goodness : str
        How pairs of vectors are rated: "contrast", "height" (eq. 3.22 of the paper) or "dominance".
    alpha : float
        That of eq. 3.22, from 1 to 4; the larger, the rather it is a small tile.
    significant : float
        Share of a tile that the overlap at a multiple must hold to count (section 3.3.1).

    Returns
    -------
    Lattice or None
        Its shortest vectors, rounded to hundredths of a pixel; one vector where a sample repeats
        along one direction only, as boards do, and None where it does not repeat or has
        pieces that lie apart.

    Raises
    ------
    InvalidInputError
        If there is no such goodness, or a number is out of its range.

    Examples
    --------
    >>> from weftex.exemplar import Exemplar
    >>> tile = np.random.default_rng(0).integers(0, 255, (12, 16), np.uint8)
    >>> find_lattice(Exemplar(np.tile(tile, (6, 5)))).vectors
    ((0.0, 12.0), (16.0, 0.0))
    """
    check_rule(goodness, alpha, significant)
    rule = (goodness, alpha, significant)
    if exemplar.pieces:
        return None
    known = _FOUND.setdefault(exemplar, {})
    if rule not in known:
        known[rule] = lattice_in(autocorrelations(exemplar, alpha, significant), goodness)
        maps = maps_alone(exemplar)
        if known[rule] is None and maps is not None:
            known[rule] = lattice_in(autocorrelations(maps, alpha, significant), goodness)
    return known[rule]


def lattice_in(fields: Autocorrelations, goodness: str = "contrast") -> Lattice | None:
    """Return the better pair of vectors, or else rows; see `find_lattice`."""
    best = better_pair(fields, pair_candidates(fields, goodness))
    usual = goodness == "contrast"
    if usual and best is not None and LEAST <= best.confidence < CLEAR and best.kind != "stripes":
        best = checked_by_rows(fields, best)
    if best is not None and best.confidence >= LEAST:
        best = with_alternation(fields, best) if usual and len(best.vectors) == 2 else best
    else:
        best = row_candidate(fields)
        if best is None or best.confidence < _LEAST_ROWS:
            best = course_candidate(fields, best)
            if best is None or best.confidence < _LEAST_ROWS:
                return None
        best = lattice_of_rows(fields, best) if usual else best
    lattice = Lattice(tuple((float(x), float(y)) for x, y in best.vectors * fields.flat.step))
    plain = [(round(x, 2) + 0.0, round(y, 2) + 0.0) for x, y in lattice.reduced().vectors]
    return Lattice(tuple(plain), round(best.confidence, 2))
