"""A lattice in a mason's words: how long and high pieces are, and how far courses are shifted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from weftex.analysis.lattice import Lattice

_UPRIGHT = 0.05  # of its length, that a vector along an axis may be off it
_LONGEST = 12.0  # a piece, for its height
_LYING = 1.5  # the same, from which courses are taken to lie
_SQUARE = 1.1  # times as long as high, at most
_SHIFT = 0.06  # of a piece, that a shift may be off a name
_NAMES = {1 / 2: "every other {} shifted by half"}
_NAMES |= {1 / 3: "each {} shifted by a third", 1 / 4: "each {} shifted by a quarter"}


def courses(lattice: Lattice) -> str:
    """Say the width and height of the pieces of a lattice in pixels, and their shift.

    Which way courses lie cannot be seen in a lattice: they lie where that makes pieces clearly
    longer than high, and are rows there; where they stand, they are columns. The vectors of a
    running bond lead to the next row, half a piece aside, so their lengths are diagonals.
    """
    shortest = lattice.reduced().vectors
    if len(shortest) == 1:
        return f"{_number(math.hypot(*shortest[0]))} px"
    vectors = np.array(shortest)
    times = np.stack(np.meshgrid(np.arange(-4, 5), np.arange(-4, 5)), axis=-1).reshape(-1, 2)
    sums = times @ vectors
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
