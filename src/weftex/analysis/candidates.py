"""What may be the lattice of a sample or its rows, and what speaks for each.

Pairs of vectors come from the correlation, as it is and whitened; rows from its ridges or from
joints; and where rows are known, a second family of joints or the joints within the rows say what
repeats along them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.alternation import alternating
from weftex.analysis.bonds import Bonds
from weftex.analysis.evidence import Evidence
from weftex.analysis.goodness import contrast_of, rate, reach_of, stand_out
from weftex.analysis.joints import Courses, checked, find_courses, rated
from weftex.analysis.pairs import MOST_MULTIPLES, best_pair, fitted, made_of, reduced
from weftex.analysis.rows import find_rows, ridges

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from weftex.analysis.views import Views

    Floats = NDArray[np.float64]

LEAST = 0.5  # confidence of what is reported
CLEAR = 0.945  # the same, of a pair that nothing else is asked of
_LEAST_CROSSINGS = 0.6  # the same of what crosses rows, which are surer
_LEAST_STRIPES = 0.94  # the same of stripes along both vectors: setts in courses had up to 0.91
_LEAST_BOND = 0.92  # the same of the bond of rows: of 150 rows without one the surest had 0.91
_NOTHING = -0.02  # contrast, less its error, that says of a pair that it is not seen
_BETTER = 1.5  # times as surely as a pair, that another bond of its rows must be told
_OF_ROWS = 3.4  # how surely joints within rows must tell a pair
_SECOND = 0.2  # confidence of joints along a second family of lines, that keeps it
_FAINT = 0.1  # contrast of rows below which joints must be regular
_REGULAR = 0.35  # of what lines of different strips have in common: that rows have at multiples
_ASLANT = 0.9  # cosine below which lines are of another family than rows
_ERRORS = 4.0  # standard errors by which a larger tile's multiples stand out
_TWICE = 0.06  # of the distance, that rows may be off twice that of joints
#: Of crossings of two families of joints: all, or of each row every second, third or fourth,
#: shifted from row to row; either family may be the rows.
_SHIFTED = [(1, 0), (2, 1), (3, 1), (3, 2), (4, 1), (4, 3)]
_CROSSINGS = [np.array([[k, 0], [shift, 1]]) for k, shift in _SHIFTED]
_CROSSINGS += [whole[::-1, ::-1] for whole in _CROSSINGS[2:]]


def pairs_seen(seen: Views, goodness: str = "contrast") -> list[Evidence]:
    """The best pair of vectors of the correlation, that of the whitened one, and their evidence.

    Stones behind a mesh hide it in the first, and what has no edges is lost in the second.
    """
    found: list[Evidence] = []
    for field in (seen.field, seen.white) if goodness == "contrast" else (seen.field,):
        both = best_pair(field, goodness)
        if both is None:
            continue
        one = evidence_of(seen, both[1])
        if goodness == "contrast" and field is seen.field:
            one = _of_checks(seen, both[0], one)
        found.append(one)
    return found


def _of_checks(seen: Views, highest: Floats, settled: Evidence) -> Evidence:
    """The highest pair, where stripes along both vectors tell it, or what it was made into.

    A check has few multiples in a sample, no joints, and nothing that whitening leaves but its
    threads, of which it seems to be made.
    """
    times = made_of(highest, settled.vectors)
    if times is None:
        return settled
    smaller = abs(np.linalg.det(times)) > 1.5
    if settled.confidence >= CLEAR and not smaller:
        return settled
    told = checked(seen.flat, highest)
    if told is None:
        return settled
    found = Evidence(highest, told.contrast, told.alike, told.number, "stripes")
    least = _LEAST_STRIPES if smaller else max(_LEAST_STRIPES, settled.confidence)
    return found if found.confidence >= least else settled


def better(seen: Views, pairs: Sequence[Evidence]) -> Evidence | None:
    """Of the two pairs the second, if it is clearer or the first is made of its tiles.

    It must have half of the first one's contrast too: the threads of a checked cloth are clear, and
    have far less than its checks. Of larger tiles chance makes one better than the right one, but
    not so that its multiples stand out of the others in the whitened sample.
    """
    if len(pairs) < 2:
        return pairs[0] if pairs else None
    first, second = pairs
    if first.kind == "stripes":
        return first
    if max(second.contrast, 0.0) < max(first.contrast, 0.0) / 2:
        return first
    if made_of(second.vectors, first.vectors) is not None:  # or they are one lattice
        return first
    times = made_of(first.vectors, second.vectors)
    if times is not None:
        reach = reach_of(seen.white, second.vectors, MOST_MULTIPLES)
        errors = stand_out(seen.white, second.vectors, times, reach)[1]
        return first if errors > _ERRORS else second
    return second if second.clear > first.clear else first


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
    """The best rows, and what speaks for them; none where lines run on and come at any distance."""
    rows = find_rows(seen.flat)
    if rows is None:
        return None
    # Joints at both sides of what repeats are two to a row.
    joints = (rated(seen.flat, rows[0] / parts) for parts in (1, 2))
    if rows[1] < _FAINT and all(one.contrast < _REGULAR * one.alike for one in joints):
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
    """A pair itself; what joints of its rows tell better; the rows alone; or nothing.

    What only the whitened sample has is thin lines before something else, as a mesh, or a part of
    the sample that is a copy of another: without joints it is no pair. Rows make peaks along one
    line, and chance makes another: a pair that has joints along one family of its lines is rows, if
    neither joints within them tell it nor joints along another family.
    """
    rows = courses_seen(seen, None)
    if rows is None or rows.confidence < LEAST:
        return pair if pair.contrast > _NOTHING else None
    found = crossings_seen(seen, rows)
    if found is not None and found.confidence >= _LEAST_CROSSINGS:
        times = made_of(pair.vectors, found.vectors)
        if times is not None and abs(np.linalg.det(times)) < 1.5:  # they are one lattice
            return pair
        return found if _clear(seen, found.vectors) > _clear(seen, pair.vectors) else pair
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


def within_rows(seen: Views, rows: Evidence) -> Evidence:
    """The lattice that joints across rows tell, or those within them; or the rows alone.

    Rows without a bond have neither, so where each is too faint both together may be sure.
    """
    found = [one for one in (crossings_seen(seen, rows), bond_seen(seen, rows)) if one is not None]
    least = {"crossings": _LEAST_CROSSINGS, "bonds": _LEAST_BOND, "both": _LEAST_BOND}
    if len(found) == 2:
        across, within = found
        told = replace(within, contrast=across.figures[1], kind="both")
        found += [replace(told, vectors=one.vectors) for one in found]
    sure = [one for one in found if one.confidence >= least[one.kind]]
    return max(sure, key=lambda one: (_clear(seen, one.vectors), one.confidence), default=rows)


def crossings_seen(seen: Views, rows: Evidence) -> Evidence | None:
    """The lattice of rows and of the joints that cross them best, and what speaks for it.

    Two families of lines cross in a lattice. Tiles and meshes have a joint at each crossing, bricks
    only at every second, third or fourth, shifted from row to row: of these lattices that is taken
    whose multiples stand out most of the whitened sample.
    """
    second = find_courses(seen.flat, across=rows.vectors[0])
    if second is None:
        return None
    lines = np.stack([one / (one @ one) for one in (rows.vectors[0], second.vector)])
    crossings = np.linalg.inv(lines).T
    found = max((whole @ crossings for whole in _CROSSINGS), key=partial(_clear, seen))
    near = (found, *(fitted(field, reduced(found)) for field in (seen.field, seen.white)))
    vectors = max(near, key=partial(_clear, seen))
    return replace(_told(second), vectors=reduced(vectors), kind="crossings")


def _clear(seen: Views, vectors: Floats) -> float:
    """How far multiples stand out of the whitened sample."""
    vectors = reduced(vectors)
    return contrast_of(seen.white, vectors, reach_of(seen.white, vectors, MOST_MULTIPLES))


def _told(rows: Courses) -> Evidence:
    return Evidence(rows.vector[None], rows.contrast, rows.alike, rows.number, "joints")
