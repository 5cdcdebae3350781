"""The lattice of a near-regular sample: how it lies upon itself when it is shifted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weft.analysis.correlation import correlate
from weft.analysis.goodness import GOODNESS, Field, contrast_of, rate, stand_out
from weft.analysis.peaks import Peaks, find_peaks, fit_vectors
from weft.analysis.relief import relief
from weft.analysis.rows import find_rows
from weft.errors import InvalidInputError, did_you_mean

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weft.exemplar import Exemplar

    Floats = NDArray[np.float64]

Vector = tuple[float, float]

_PEAKS = 40  # that pairs are made of, of each octave of lengths the highest
_PAIRS = 24  # that are fitted and rated with all their multiples
_FEWEST = 3.0  # pixels of a vector; shorter ones are grain
_DOMINANT = 0.25  # of the shorter vector, that the peaks of both must dominate
_REACH = 24  # multiples of each vector that are looked at
_LOWER = 0.1  # of its mean, that a larger tile's multiples may be above those of a smaller
_HIGHER = 0.2  # and must be above them to count instead
_SIGMAS = 5.0  # of the difference's standard error
_FEWEST_OWN = 6  # and so many there must be of them
_ROWS = 0.012  # the same for rows
_CONTRAST = 0.05  # that gives a confidence of a half, which is the least for a lattice
# Of two and three times the tile, by their vectors in terms of its own.
_SUBLATTICES = [
    np.array(rows, np.float64)
    for rows in (
        ((2, 0), (0, 1)),
        ((1, 0), (0, 2)),
        ((1, 1), (1, -1)),
        ((3, 0), (0, 1)),
        ((1, 0), (0, 3)),
        ((1, 1), (0, 3)),
        ((1, -1), (0, 3)),
    )
]


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
        first = self.vectors[0]
        if len(self.vectors) == 1:
            return Lattice((_rightward(first),), self.confidence)
        second = self.vectors[1]
        while True:  # Gauss: observation (iv) of the paper, until neither gets shorter
            if math.hypot(*second) < math.hypot(*first):
                first, second = second, first
            dot, square = first[0] * second[0] + first[1] * second[1], math.hypot(*first) ** 2
            times = math.ceil(dot / square - 0.5 - 1e-9)
            if times == 0:
                return Lattice((_rightward(first), _rightward(second)), self.confidence)
            second = second[0] - times * first[0], second[1] - times * first[1]

    def same_as(self, other: Lattice, tolerance: float = 0.015) -> bool:
        """Whether both are one lattice, by whatever vectors (observation iv of the paper).

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
        return len(ours.vectors) == 1 or 0.5 < ours.area / theirs.area < 1.5

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


def _rightward(vector: Vector) -> Vector:
    """It or its opposite (observation iii), so that neither axis is where the sign turns."""
    x, y = vector
    return (x, y) if x + y / 8 > 0 else (-x, -y)


def find_lattice(exemplar: Exemplar, *, goodness: str = "contrast") -> Lattice | None:
    """Find the translations under which a sample looks the same.

    Section 3.3 of the paper on near-regular textures, with pairs rated by contrast; see
    `weft.analysis.goodness`.

    Parameters
    ----------
    exemplar : Exemplar
        The sample; a mask may leave out parts of it. Slow lighting is taken off first.
    goodness : str
        How pairs of vectors are rated: "contrast", "height" (eq. 3.22 of the paper) or "dominance".

    Returns
    -------
    Lattice or None
        Its shortest vectors, rounded to hundredths of a pixel; one vector where a sample repeats
        along one direction only, as boards do, and None where it does not repeat.

    Raises
    ------
    InvalidInputError
        If there is no such goodness.

    Examples
    --------
    >>> from weft.exemplar import Exemplar
    >>> tile = np.random.default_rng(0).integers(0, 255, (12, 16), np.uint8)
    >>> find_lattice(Exemplar(np.tile(tile, (6, 5)))).vectors
    ((0.0, 12.0), (16.0, 0.0))
    """
    if goodness not in GOODNESS:
        raise InvalidInputError(f"goodness is {goodness!r}{did_you_mean(goodness, GOODNESS)}")
    flat = relief(exemplar)
    mask = flat.usable >= 0.5
    correlation = correlate(np.moveaxis(flat.levels, 0, 2), first_mask=mask)
    field = Field(correlation)
    peaks = find_peaks(correlation)
    found = _best_pair(field, peaks, goodness)
    if found is not None:
        vectors, contrast = found
        confidence = contrast / (contrast + _CONTRAST)
    else:
        rows = find_rows(flat)
        if rows is None or rows[1] < _ROWS:
            return None
        vectors, contrast = rows[0][None], rows[1]
        confidence = contrast / (contrast + _ROWS)
    lattice = Lattice(tuple((float(x), float(y)) for x, y in vectors * flat.step)).reduced()
    plain = tuple((round(x, 2) + 0.0, round(y, 2) + 0.0) for x, y in lattice.vectors)
    return Lattice(plain, round(confidence, 2))


def _best_pair(field: Field, peaks: Peaks, goodness: str) -> tuple[Floats, float] | None:
    pairs = _candidates(peaks)
    if not len(pairs):
        return None
    first = rate(field, pairs, 2, goodness)
    best: tuple[float, Floats, int] | None = None
    tried: list[Floats] = []
    for k in np.argsort(-first.goodness, kind="stable")[:_PAIRS]:
        if first.goodness[k] <= 0:
            break
        fitted, _ = fit_vectors(field.correlation, pairs[k], _REACH)
        if any(abs(fitted - other).max() < 0.5 for other in tried):
            continue
        tried.append(fitted)
        rated = rate(field, fitted[None], _REACH, goodness, exact=True)
        if best is None or rated.goodness[0] > best[0] * (1 + 1e-9):
            best = float(rated.goodness[0]), fitted, int(rated.count[0])
    if best is None or best[0] <= 0:
        return None
    vectors = best[1]
    if goodness == "contrast":
        vectors = _divide(field, vectors, tried)
        vectors = _multiply(field, vectors)
    contrast = contrast_of(field, vectors, _REACH)
    return (vectors, contrast) if contrast >= _CONTRAST else None


def _divide(field: Field, vectors: Floats, others: list[Floats]) -> Floats:
    """The finest of the lattices which divide this one and are as good at all their multiples."""
    for finer in sorted(others, key=_area):
        times = vectors @ np.linalg.inv(finer)
        whole = np.rint(times)
        off = np.hypot(*((times - whole) @ finer).T).max()
        index = round(abs(np.linalg.det(whole)))
        if index >= 2 and off <= 0.1 * np.hypot(*finer.T).min():
            gap, _, count = stand_out(field, finer, whole, _REACH)
            if count and gap < _LOWER:
                return finer
    return vectors


def _multiply(field: Field, vectors: Floats) -> Floats:
    """A lattice of two or three times the tile, where its own multiples stand out."""
    for whole in _SUBLATTICES:
        gap, sigmas, count = stand_out(field, vectors, whole, _REACH)
        if gap > _HIGHER and sigmas > _SIGMAS and count >= _FEWEST_OWN:
            fitted, _ = fit_vectors(field.correlation, _short(whole @ vectors), _REACH)
            return fitted
    return vectors


def _area(vectors: Floats) -> float:
    return float(abs(np.linalg.det(vectors)))


def _short(vectors: Floats) -> Floats:
    (a, b), (c, d) = vectors
    return np.array(Lattice(((a, b), (c, d))).reduced().vectors)


def _candidates(peaks: Peaks) -> Floats:
    """Pairs of peaks that are reduced (step 4 of the paper), and neither in the other's shadow."""
    lengths = np.hypot(peaks.shifts[:, 0], peaks.shifts[:, 1])
    wide = (peaks.dominance >= 2) & (lengths >= _FEWEST)
    octave = np.log2(np.maximum(lengths, 1)).astype(int)
    # Multiples outnumber the vectors themselves, so each octave of lengths has its own highest.
    chosen = np.concatenate(
        [np.flatnonzero(wide & (octave == k))[:_PEAKS] for k in range(octave.max(initial=0) + 1)]
    )
    shifts, dominance = peaks.shifts[chosen], peaks.dominance[chosen]
    squares = (shifts**2).sum(axis=1)
    order = np.argsort(squares, kind="stable")
    shifts, dominance, squares = shifts[order], dominance[order], squares[order]
    i, j = np.triu_indices(len(shifts), 1)
    # Of all equivalent pairs the one with the greatest angle; a pixel of doubt for rounding.
    reduced = 2 * abs((shifts[i] * shifts[j]).sum(axis=1)) <= squares[i] + 2 * np.sqrt(squares[i])
    stands = np.minimum(dominance[i], dominance[j]) >= _DOMINANT * np.sqrt(squares[i])
    keep = reduced & stands
    return np.stack([shifts[i[keep]], shifts[j[keep]]], axis=1).astype(np.float64)
