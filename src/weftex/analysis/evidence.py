"""The evidence for a lattice of a sample, or for its rows: beyond the thesis.

`contrast` is how far the correlation at multiples is above that between them; `clear` is the same
of the whitened sample, in units of chance. Lines (`weftex.analysis.lines`) have the contrast of
edges in different strips, and how alike these are. Logistic regressions combine them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from weftex.analysis.autocorrelations import Autocorrelations
from weftex.analysis.bonds import Bonds
from weftex.analysis.lines import checked, find_courses, find_rows, rated, ridges
from weftex.analysis.pairs import contrast_of, fitted, highest, rate, rated_pairs, reach_of, reduced
from weftex.analysis.prediction import correlation_across, predicting
from weftex.analysis.tile_multiples import alternating, made_of, settled
from weftex.raster.arrays import Floats

LEAST = 0.5  # confidence of a lattice that is reported
CLEAR = 0.945  # confidence of a pair that needs no further check
_LEAST_CROSSINGS = 0.6  # confidence of joints that cross rows
_LEAST_STRIPES = 0.94  # confidence of stripes along both vectors; setts had up to 0.91
_LEAST_BOND = 0.92  # confidence of the bond of rows; 150 rows without one had up to 0.91
_BETTER = 1.5  # times the evidence of a pair, that another bond of its rows must have
_OF_ROWS = 3.4  # evidence of joints within rows that a pair must have
_FAINT = 0.1  # contrast of rows below which joints must be regular
_REGULAR = 0.35  # of the correlation of strips: the part that regular rows have at multiples
_SURER = 0.05  # of confidence, from which rows by joints are surer than those by ridges
_NEAREST = np.array([[1, 0], [0, 1], [1, 1], [1, -1]])  # multiples whose heights are compared
_SEEN = 0.15  # of each side, that must overlap there
_EVEN = 0.27  # of the highest, that the lowest has: copies had up to 0.19, lattices from 0.36 on
#: Of crossings of two families of joints: all, or of each row every second, third or fourth,
#: shifted from row to row; either family may be the rows.
_SHIFTED = [(1, 0), (2, 1), (3, 1), (3, 2), (4, 1), (4, 3)]
_CROSSINGS = [np.array([[k, 0], [shift, 1]]) for k, shift in _SHIFTED]
_CROSSINGS += [whole[::-1, ::-1] for whole in _CROSSINGS[2:]]

#: Weights of `Evidence.figures`, for each kind of pattern.
WEIGHTS: dict[str, tuple[float, ...]] = {
    "pairs": (-4.32, 6.32, 1.54, 0.0, 0.0),
    "rows": (-7.08, 2.38, 2.18, 16.71, 0.0),
    "crossings": (-4.78, 0.0, 0.0, 15.82, 0.0),  # of joints across rows
    "stripes": (-2.09, 0.0, 0.0, 12.34, 0.0),  # along both vectors
    "bonds": (-9.02, 0.0, 0.0, 0.0, 3.06),  # joints within rows
    "both": (-10.0, 0.0, 0.0, 10.0, 3.06),  # joints across and within rows
    "running": (-16.0, 0.0, 0.0, 60.0, 1.0),  # edges across the rows, as of bricks
}
#: Of the surest: some tiles pass for lattices that are part of one, whatever is fields.
SUREST = 0.95

_HALF = 0.05  # contrast that counts half as much as any contrast could
_MOST = 40.0  # exponents beyond this are no numbers


class Evidence(NamedTuple):
    """The evidence for vectors (x, y) in pixels of the relief: two, or one from row to row.

    `kind` is a key of `WEIGHTS`; what it gives no weight may be left out.
    """

    vectors: Floats
    kind: str
    contrast: float = 0.0  # of the correlation at multiples, less its standard error
    clear: float = 0.0  # the same of the whitened correlation, in units of chance
    number: int = 1  # of multiples
    lines: float = 0.0  # `Courses.sure` of joints or stripes
    bond: float = 0.0  # of joints within rows, see `Bonds.best`

    @property
    def figures(self) -> tuple[float, ...]:
        """The figures that are weighted."""
        contrast = max(self.contrast, 0.0)
        clear = max(self.clear, 0.0) * math.sqrt(self.number)  # of all multiples together
        return 1.0, contrast / (_HALF + contrast), math.asinh(clear), self.lines, self.bond

    @property
    def confidence(self) -> float:
        """The share of lattices with such evidence that are right, from 0 to `SUREST`.

        >>> Evidence(np.eye(2), "pairs", contrast=0.4, clear=20.0, number=60).confidence > 0.9
        True
        """
        total = float(np.dot(self.figures, WEIGHTS[self.kind]))
        return SUREST / (1 + math.exp(-min(max(total, -_MOST), _MOST)))


def pair_candidates(fields: Autocorrelations) -> list[Evidence]:
    """Return the best pair of vectors of the correlation, and of the whitened one.

    Stones behind a mesh hide it in the first; structure without edges is lost in the second.
    """
    found: list[Evidence] = []
    for field in (fields.field, fields.white):
        best = highest(rated_pairs(field, "contrast"))
        if best is None or _is_copied(fields, best):
            continue
        # In the whitened sample threads are clear, and checks are made of them.
        one = evidence_of(fields, settled(field, best))
        found.append(one if field is fields.white else _of_checks(fields, best, one))
    return found


def _is_copied(fields: Autocorrelations, vectors: Floats) -> bool:
    """Return whether a pair is made by parts that are copies of others, as cloned photos have.

    Each copy makes one high multiple, beside which those of a lattice are even.
    """
    shifts = _NEAREST @ vectors
    far = np.array([fields.field.width, fields.field.height])
    x, y = shifts[((1 - abs(shifts) / far) >= _SEEN).all(axis=1)].T
    heights = [field.around(x, y) for field in (fields.field, fields.white)]
    return len(x) > 2 and all(one.min() < _EVEN * one.max() for one in heights)


def _of_checks(fields: Autocorrelations, highest: Floats, settled: Evidence) -> Evidence:
    """Return the highest pair where stripes along both vectors confirm it, else `settled`.

    A check has few multiples and no joints, and whitening leaves only its threads.
    """
    times = made_of(highest, settled.vectors)
    if times is None:
        return settled
    smaller = abs(np.linalg.det(times)) > 1.5
    if settled.confidence >= CLEAR and not smaller:
        return settled
    told = checked(fields.flat, highest)
    if told is None:
        return settled
    found = Evidence(highest, "stripes", lines=told.sure)
    least = _LEAST_STRIPES if smaller else max(_LEAST_STRIPES, settled.confidence)
    return found if found.confidence >= least else settled


def better_pair(pairs: Sequence[Evidence]) -> Evidence | None:
    """Return the second pair if it is clearer or the first consists of its tiles, else the first.

    It must have half of the first one's contrast, as the threads of a checked cloth are clear too.
    Chance makes some larger tile better, so all multiples count together.
    """
    if len(pairs) < 2:
        return pairs[0] if pairs else None
    first, second = pairs
    if first.kind == "stripes" or made_of(second.vectors, first.vectors) is not None:
        return first  # or they are one lattice
    if made_of(first.vectors, second.vectors) is None and second.figures[2] <= first.figures[2]:
        return first
    return second if max(second.contrast, 0.0) >= max(first.contrast, 0.0) / 2 else first


def predicted(fields: Autocorrelations, one: Evidence) -> Evidence | None:
    """Return the pair, or one of a larger tile, that maps joints onto joints; None without."""
    vectors = predicting(fields, one.vectors)
    return None if vectors is None else one._replace(vectors=vectors)


def with_alternation(fields: Autocorrelations, one: Evidence) -> Evidence:
    """Return the larger tile where cells alternate, with the confidence of the smaller one."""
    whole = alternating(fields.flat, one.vectors)
    if whole is None:
        return one
    return one._replace(vectors=fitted(fields.field, reduced(whole @ one.vectors)))


def evidence_of(fields: Autocorrelations, vectors: Floats) -> Evidence:
    """Return the evidence for two vectors."""
    reach = reach_of(fields.field, vectors)
    return Evidence(
        vectors,
        "pairs",
        contrast_of(fields.field, vectors),
        contrast_of(fields.white, vectors) / max(fields.chance, 1e-12),
        int(rate(fields.field, vectors[None], reach, "contrast").count[0]),
    )


def row_candidate(fields: Autocorrelations) -> Evidence | None:
    """Return the rows by ridges, or those by joints where these are clearly surer, or None."""
    ridged, joined = find_rows(fields.flat), find_courses(fields.flat)
    found = None if ridged is None else _rows_by(fields, *ridged)
    if found is not None and found.clear <= 0:  # ridges must be clear in the whitened sample
        found = None
    other = None if joined is None else _rows_by(fields, joined.vector, 0.0)
    if found is None or other is None:
        return found or other
    return other if other.confidence > found.confidence + _SURER else found


def _rows_by(fields: Autocorrelations, vector: Floats, contrast: float) -> Evidence | None:
    """Return the evidence for rows; None for faint lines at irregular distances."""
    # Joints at both sides of what repeats are two to a row.
    lines = [rated(fields.flat, vector / parts) for parts in (1, 2)]
    if contrast < _FAINT and all(one.contrast < _REGULAR * one.alike for one in lines):
        return None
    height, number = ridges(fields.white.correlation, vector)
    clear, sure = height / max(fields.chance, 1e-12), max(one.sure for one in lines)
    return Evidence(vector[None], "rows", contrast, clear, number, sure)


def bond_candidate(fields: Autocorrelations, rows: Evidence, half: bool = False) -> Evidence | None:
    """Return the best bond by joints within the rows, or running bond (`half`) by edges."""
    vector = rows.vectors[0]
    if half:
        found = Bonds(correlation_across(fields.flat, vector), vector).best(half=True)
        return found and Evidence(reduced(found[0]), "running", lines=found[2], bond=found[1])
    found = Bonds(fields.white.correlation, vector).best(fields.chance)
    return found and Evidence(fitted(fields.white, reduced(found[0])), "bonds", bond=found[1])


def checked_by_rows(fields: Autocorrelations, pair: Evidence) -> Evidence:
    """Return the pair, a better one by the joints of its rows, or its rows alone.

    A pair with joints along one family of lines only is rows, as chance makes the second vector.
    """
    rows = row_candidate(fields)
    if rows is None or rows.confidence < LEAST:
        return pair
    found = crossing_candidate(fields, rows)
    if found is not None and found.confidence >= LEAST:
        times = made_of(pair.vectors, found.vectors)
        if times is not None and abs(np.linalg.det(times)) < 1.5:  # they are one lattice
            return pair
    if found is not None and _sure(found):
        return found if _clear(fields, found.vectors) > _clear(fields, pair.vectors) else pair
    sure = Bonds(fields.white.correlation, rows.vectors[0]).of(pair.vectors)
    if sure is None:
        return pair
    bond = bond_candidate(fields, rows)
    if bond is not None and bond.confidence >= _LEAST_BOND and bond.bond > _BETTER * sure:
        return bond
    return pair if sure >= _OF_ROWS else rows


def lattice_of_rows(fields: Autocorrelations, rows: Evidence) -> Evidence:
    """Return the lattice by joints across or within the rows, or the rows alone.

    Rows without a bond have neither, so two faint kinds of evidence together may be sure.
    """
    across, within = crossing_candidate(fields, rows), bond_candidate(fields, rows)
    found = [across, within, bond_candidate(fields, rows, half=True)]
    if across is not None and within is not None:
        both = within._replace(lines=across.lines, kind="both")
        found += [both, both._replace(vectors=across.vectors)]
    sure = [one for one in found if one is not None and _sure(one)]
    return max(sure, key=lambda one: (_clear(fields, one.vectors), one.confidence), default=rows)


def _sure(one: Evidence) -> bool:
    """Return whether a lattice of rows is sure; joints that cross them also in white."""
    if one.kind == "crossings":
        return one.confidence >= _LEAST_CROSSINGS and one.clear > 0
    return one.confidence >= _LEAST_BOND


def crossing_candidate(fields: Autocorrelations, rows: Evidence) -> Evidence | None:
    """Return the lattice of the rows and of the joints that cross them best.

    Tiles and meshes have a joint at each crossing, bricks at every second, third or fourth, shifted
    from row to row: of these, the lattice with the clearest multiples in the whitened sample.
    """
    second = find_courses(fields.flat, across=rows.vectors[0])
    if second is None:
        return None
    lines = np.stack([one / (one @ one) for one in (rows.vectors[0], second.vector)])
    crossings = np.linalg.inv(lines).T
    found = max((whole @ crossings for whole in _CROSSINGS), key=partial(_clear, fields))
    near = (found, *(fitted(field, reduced(found)) for field in (fields.field, fields.white)))
    vectors = reduced(max(near, key=partial(_clear, fields)))
    return Evidence(vectors, "crossings", clear=_clear(fields, vectors), lines=second.sure)


def _clear(fields: Autocorrelations, vectors: Floats) -> float:
    """Return the contrast of multiples in the whitened correlation."""
    return contrast_of(fields.white, reduced(vectors))
