"""The lattice of a near-regular sample: the shifts at which it matches itself."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from weftex.analysis.alternation import alternating
from weftex.analysis.bonds import Bonds
from weftex.analysis.correlation import correlate
from weftex.analysis.evidence import Evidence
from weftex.analysis.goodness import (
    ALPHA,
    SIGNIFICANT,
    Field,
    check_rule,
    contrast_of,
    rate,
    reach_of,
    stand_out,
)
from weftex.analysis.joints import Courses, find_courses, rated
from weftex.analysis.pairs import MOST_MULTIPLES, best_pair, fitted, reduced
from weftex.analysis.peaks import find_peaks
from weftex.analysis.relief import Relief, maps_alone, relief
from weftex.analysis.rows import find_rows, ridges
from weftex.analysis.whitening import whitened
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

Vector = tuple[float, float]

_LONGEST = 1e9  # pixels; no picture is as large, and products of vectors stay numbers
_LEAST = 0.5  # confidence of what is reported
_LEAST_JOINTS = 0.6  # the same of rows of which joints alone tell: drawn rubble had up to 0.57
_LEAST_BOND = 0.92  # the same of the bond of rows: of 150 rows without one the surest had 0.91
_CLEAR = 0.945  # the same, of a pair that is not looked for among rows
_NOTHING = -0.02  # contrast, less its error, that says of a pair that it is not seen
_BETTER = 1.5  # times as surely as a pair, that another bond of its rows must be told
_OF_ROWS = 2.3  # how surely joints within rows must tell a pair
_SECOND = 0.2  # confidence of joints along a second family of lines, that keeps it
_ASLANT = 0.9  # cosine below which lines are of another family than rows
_OFF = 0.15  # of a vector, that multiples of smaller tiles may be off a larger one
_ERRORS = 4.0  # standard errors by which a larger tile's multiples stand out
_TWICE = 0.06  # of the distance, that rows may be off twice that of joints
_SIGMAS = 3.0  # of what chance makes of one multiple, that do not count


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
        """The same lattice by its shortest vectors, shorter first; they point right or down."""
        if len(self.vectors) == 1:
            return Lattice((_rightward(self.vectors[0]),), self.confidence)
        first, second = reduced(np.array(self.vectors)).tolist()
        return Lattice((_rightward(first), _rightward(second)), self.confidence)

    def same_as(self, other: Lattice, tolerance: float = 0.015) -> bool:
        """Whether both pairs span one lattice (observation iv of the paper).

        Parameters
        ----------
        other : Lattice
            The lattice to compare with.
        tolerance : float
            How far this lattice may miss each of the other's shortest vectors, to its length.
        """
        if len(self.vectors) != len(other.vectors):
            return False
        ours, theirs = self.reduced(), other.reduced()
        for x, y in theirs.vectors:
            near = ours.nearest((x, y))
            if math.hypot(near[0] - x, near[1] - y) > tolerance * math.hypot(x, y):
                return False
        return len(ours.vectors) == 1 or 0.7 < ours.area / theirs.area < 1.4

    def nearest(self, place: Vector) -> Vector:
        """The multiple that is nearest to a place (x, y); of one vector it or its opposite."""
        (ax, ay), (x, y) = self.vectors[0], place
        if len(self.vectors) == 1:
            corners = [(ax, ay), (-ax, -ay)]
        else:
            bx, by = self.vectors[1]
            det = ax * by - bx * ay
            a, b = math.floor((x * by - y * bx) / det), math.floor((ax * y - ay * x) / det)
            corners = [(i * ax + j * bx, i * ay + j * by) for i in (a, a + 1) for j in (b, b + 1)]
        return min(corners, key=lambda c: math.hypot(c[0] - x, c[1] - y))


#: What was found by each goodness, alpha and share; methods, scale and choice all ask.
_FOUND: WeakKeyDictionary[Exemplar, dict[tuple[str, float, float], Lattice | None]] = (
    WeakKeyDictionary()
)


def _rightward(vector: Vector) -> Vector:
    """The vector or its opposite (observation iii), by a sign that does not change near an axis."""
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
        known[rule] = lattice_in(views(exemplar, alpha, significant), goodness)
        maps = maps_alone(exemplar)
        if known[rule] is None and maps is not None:
            known[rule] = lattice_in(views(maps, alpha, significant), goodness)
    return known[rule]


@dataclass(frozen=True, eq=False)
class Views:
    """A sample without slow lighting, and its correlations: as it is, and whitened."""

    flat: Relief
    field: Field
    white: Field
    chance: float


def views(exemplar: Exemplar, alpha: float = ALPHA, significant: float = SIGNIFICANT) -> Views:
    """What lattices of a sample are looked for in; alpha and significant as for `find_lattice`."""
    flat = relief(exemplar)
    own = correlate(np.moveaxis(flat.levels, 0, 2), first_mask=flat.usable >= 0.5)
    even, chance = whitened(flat)
    white = Field(even, find_peaks(even), alpha, significant, _SIGMAS * chance)
    return Views(flat, Field(own, find_peaks(own), alpha, significant), white, chance)


def lattice_in(seen: Views, goodness: str = "contrast") -> Lattice | None:
    """The better pair of vectors, or else rows; see `find_lattice`."""
    best = better(seen, pairs_seen(seen, goodness))
    usual = goodness == "contrast"
    if usual and best is not None and _LEAST <= best.confidence < _CLEAR:
        best = among_rows(seen, best)
    if best is not None and best.confidence >= _LEAST:
        best = in_turn(seen, best) if usual and len(best.vectors) == 2 else best
    else:
        best = rows_seen(seen)
        if best is None or best.confidence < _LEAST:
            best = courses_seen(seen, best)
            if best is None or best.confidence < _LEAST_JOINTS:
                return None
        bond = bond_seen(seen, best) if usual else None
        best = best if bond is None or bond.confidence < _LEAST_BOND else bond
    lattice = Lattice(tuple((float(x), float(y)) for x, y in best.vectors * seen.flat.step))
    plain = [(round(x, 2) + 0.0, round(y, 2) + 0.0) for x, y in lattice.reduced().vectors]
    return Lattice(tuple(plain), round(best.confidence, 2))


def pairs_seen(seen: Views, goodness: str = "contrast") -> list[Evidence]:
    """The best pair of vectors of the correlation, that of the whitened one, and their evidence.

    Stones behind a mesh hide it in the first, and what has no edges is lost in the second.
    """
    found: list[Evidence] = []
    for field in (seen.field, seen.white) if goodness == "contrast" else (seen.field,):
        vectors = best_pair(field, goodness)
        if vectors is not None:
            found.append(evidence_of(seen, vectors))
    return found


def better(seen: Views, pairs: Sequence[Evidence]) -> Evidence | None:
    """Of the two pairs the second, if it is clearer or the first is made of its tiles.

    It must have half of the first one's contrast too: the threads of a checked cloth are clear, and
    have far less than its checks. Of larger tiles chance makes one better than the right one, but
    not so that its multiples stand out of the others in the whitened sample.
    """
    if len(pairs) < 2:
        return pairs[0] if pairs else None
    first, second = pairs
    if max(second.contrast, 0.0) < max(first.contrast, 0.0) / 2:
        return first
    if _made_of(second, first) is not None:  # or they are one lattice
        return first
    times = _made_of(first, second)
    if times is not None:
        reach = reach_of(seen.white, second.vectors, MOST_MULTIPLES)
        errors = stand_out(seen.white, second.vectors, times, reach)[1]
        return first if errors > _ERRORS else second
    return second if second.clear > first.clear else first


def _made_of(larger: Evidence, smaller: Evidence) -> Floats | None:
    """Which multiples of a smaller tile's vectors a larger one's are, if they are."""
    times = larger.vectors @ np.linalg.inv(smaller.vectors)
    whole: Floats = np.rint(times)
    apart = abs(times - whole).max() < _OFF and abs(np.linalg.det(whole)) > 0.5
    return whole if apart else None


def in_turn(seen: Views, one: Evidence) -> Evidence:
    """The larger tile, where cells alternate; as sure as the smaller one is."""
    whole = alternating(seen.flat, one.vectors)
    if whole is None:
        return one
    return replace(one, vectors=fitted(seen.field, reduced(whole @ one.vectors)))


def evidence_of(seen: Views, vectors: Floats) -> Evidence:
    """What speaks for two vectors."""
    reach = reach_of(seen.field, vectors, MOST_MULTIPLES)
    return Evidence(
        vectors,
        contrast_of(seen.field, vectors, reach),
        contrast_of(seen.white, vectors, reach) / max(seen.chance, 1e-12),
        int(rate(seen.field, vectors[None], reach, "contrast").count[0]),
    )


def rows_seen(seen: Views) -> Evidence | None:
    """The best rows, and what speaks for them."""
    rows = find_rows(seen.flat)
    if rows is None:
        return None
    clear, number = ridges(seen.white.correlation, rows[0])
    return Evidence(rows[0][None], rows[1], clear / max(seen.chance, 1e-12), number)


def courses_seen(seen: Views, rows: Evidence | None) -> Evidence | None:
    """The rows that joints tell best, whatever lies between them, and what speaks for them.

    Joints at both sides of what repeats are two to a row: where the levels' rows are twice as far
    apart in the same direction, they are taken.
    """
    found = find_courses(seen.flat)
    if found is None:
        return None
    vector = found.vector
    if rows is not None:
        own = rows.vectors[0] * (1 if rows.vectors[0] @ vector > 0 else -1)
        if np.hypot(*(own - 2 * vector)) < _TWICE * np.hypot(*own):
            vector = own
    return _told(replace(found, vector=vector))


def bond_seen(seen: Views, rows: Evidence) -> Evidence | None:
    """The bond that joints within rows tell best, and what speaks for it."""
    found = Bonds(seen.white.correlation, rows.vectors[0]).best(seen.chance)
    if found is None:
        return None
    return Evidence(fitted(seen.white, reduced(found[0])), 0.0, found[1], 1, "bonds")


def among_rows(seen: Views, pair: Evidence) -> Evidence | None:
    """A pair itself; another bond of its rows that is told better; the rows alone; or nothing.

    What only the whitened sample has is thin lines before something else, as a mesh, or a part of
    the sample that is a copy of another: without joints it is no pair. Rows make peaks along one
    line, and chance makes another: a pair that has joints along one family of its lines is rows, if
    neither joints within them tell it nor joints along another family.
    """
    rows = courses_seen(seen, None)
    if rows is None or rows.confidence < _LEAST:
        return pair if pair.contrast > _NOTHING else None
    down = rows.vectors[0]
    sure = Bonds(seen.white.correlation, down).of(pair.vectors)
    if sure is None:
        return pair
    bond = bond_seen(seen, rows)
    if bond is not None and bond.confidence >= _LEAST_BOND and bond.clear > _BETTER * sure:
        return bond
    if sure >= _OF_ROWS:
        return pair
    area = abs(float(np.linalg.det(pair.vectors)))
    first, second = reduced(pair.vectors)
    for side in (first, second, first + second, first - second):
        across = np.array([-side[1], side[0]]) * area / (side @ side)
        aslant = abs(across @ down) < _ASLANT * np.hypot(*across) * np.hypot(*down)
        if aslant and _told(rated(seen.flat, across)).confidence >= _SECOND:
            return pair
    return rows


def _told(rows: Courses) -> Evidence:
    return Evidence(rows.vector[None], rows.contrast, rows.alike, rows.number, "joints")
