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
_SHIFT = 0.06  # of a piece, that a shift may be off a name
_NAMES = {0: "", 1 / 2: "half shift", 1 / 3: "third shift", 1 / 4: "quarter shift"}


def courses(lattice: Lattice) -> str:
    """Say the width and height of the pieces of a lattice in pixels, and their shift.

    Which way courses lie cannot be seen in a lattice: they lie where that makes pieces clearly
    longer than high. Where they stand, a shift is a drop. The vectors of a running bond lead to
    the next course, half a piece aside, so their lengths are diagonals.

    Parameters
    ----------
    lattice : Lattice
        By any of its vectors.

    Returns
    -------
    str
        Lengths of the vectors, where none of their sums lies along an axis; of one vector, its
        length.

    Examples
    --------
    >>> from weftex.analysis.lattice import Lattice
    >>> courses(Lattice(((64, 64), (64, -64)))), courses(Lattice(((31, 0), (1, 102))))
    ('128.0 x 64.0 px, half shift', '31.0 x 102.0 px')
    """
    shortest = lattice.reduced().vectors
    if len(shortest) == 1:
        return f"{math.hypot(*shortest[0]):.1f} px"
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
        return " x ".join(f"{math.hypot(*vector):.1f}" for vector in shortest) + " px"
    # Courses lie where pieces are clearly longer than high, and else where they are longest.
    lying = [one for one in found if one[1] == 0 and one[0] >= _LYING]
    _, axis, length, piece = lying[0] if lying else max(found, key=lambda one: one[:2])
    # How far along it the next course is moved, of the sums that are one course on.
    on = sums[np.rint(sums @ np.array([-piece[1], piece[0]]) / lattice.area) == 1]
    along = abs(on @ piece) / length**2
    moved = float(along.min())
    height = lattice.area / length if moved > _SHIFT else float(np.hypot(*on[along.argmin()]))
    sides = (length, height)[:: 1 if axis == 0 else -1]
    name = next((word for share, word in _NAMES.items() if abs(moved - share) <= _SHIFT), None)
    shift = f"shift {moved:.2f}" if name is None else name
    shift = shift.replace("shift", "drop") if axis else shift
    return f"{sides[0]:.1f} x {sides[1]:.1f} px" + (f", {shift}" if shift else "")
