"""The boundary zone of a patch: the pixels that are compared, and its blending weights.

Liang et al. (2001), sections 2.1 and 2.2, draw three configurations for plain scan order (Fig. 3 b
to d) and two more for tileable output (Fig. 5). They and every shape that a hole gives follow from
one rule: the zone is every known pixel within the boundary width of an unknown one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from weftex.raster.arrays import Mask
from weftex.raster.boxes import box_sums
from weftex.raster.masks import row_runs, steps_to


@dataclass(frozen=True, eq=False)
class BoundaryZone:
    """One configuration of known and unknown pixels in a window."""

    #: (rows, columns): in 1/256, 256 where nothing was known, falling through the zone, 0 where the
    #: canvas stays. Where paths are cut, 1 to 255 mark the pixels that a path divides.
    weight: NDArray[np.uint16]
    #: (n, 4), the zone as strips of pixels (upright?, v, u, length): tall for tall parts.
    strips: NDArray[np.int32]
    #: (n, 2): corners (v, u) of squares in the zone, for the low resolution.
    squares: NDArray[np.int32]
    side: int  # of the squares
    #: (9,), where minimum-error paths run: how deep, the box (left, right, top, bottom) that the
    #: patch can show in, and whether there is a band at each of these sides.
    bands: NDArray[np.int32]
    area: int  # pixels in the zone


def boundary_zone(
    known: NDArray[np.bool_],
    width: int,
    *,
    frozen: NDArray[np.bool_] | None = None,
    outlines: bool = False,
    square_side: int = 4,
    most_squares: int = 96,
    paste: bool = False,
    core: tuple[int, int] | None = None,
) -> BoundaryZone:
    """Return the zone of a window: `known` pixels at most `width` (w_E) from an unknown one.

    `frozen` pixels stay, and with `core` all but these (a single pixel: Liang et al., section 2.5).
    `outlines` of a hole may lie anywhere in the window. `paste` replaces the zone without blending.
    """
    distance = steps_to(~known, width)
    zone = known & (distance <= width)
    falling = np.maximum((256 * (width + 1 - distance)) // (width + 1), 1)
    weight = np.where(zone & (not paste), falling, 256)
    weight[known & ~zone] = 0
    if frozen is not None:
        weight[frozen] = 0
    if core is not None:
        weight[:] = 0
        weight[core] = 256
    squares, side = squares_over(zone, min(square_side, width), most_squares)
    return BoundaryZone(
        weight=weight.astype(np.uint16),
        strips=strips_over(zone, width),
        squares=squares,
        side=side,
        bands=bands_of(zone, weight > 0, width, outlines),
        area=int(zone.sum()),
    )


def bands_of(zone: Mask, shows: Mask, width: int, outlines: bool) -> NDArray[np.int32]:
    """Return where minimum-error paths run, see `BoundaryZone`; `shows` is where the patch may."""
    rows, columns = (np.flatnonzero(shows.any(axis=a)) for a in (1, 0))
    top, left, bottom, right = 0, 0, *zone.shape
    if len(rows):
        top, left, bottom, right = rows[0], columns[0], rows[-1] + 1, columns[-1] + 1
    depth = min(width, bottom - top, right - left)
    if outlines:
        depth = max(depth, min(bottom - top, right - left) // 2)
    shown = zone[top:bottom, left:right]
    # A band for each side, line by line from its start to its end.
    sides = (shown[:, :depth], shown[:, -depth:], shown[:depth].T, shown[-depth:].T)
    # The corner of a zone is no side of it; the outline of a hole need not follow any.
    cut = [side.any() if outlines else side.any(axis=1).all() for side in sides]
    return np.array([depth, left, right, top, bottom, *cut], np.int32)


def squares_over(zone: NDArray[np.bool_], largest: int, most: int) -> tuple[NDArray[np.int32], int]:
    """Cover the zone with squares, at most half of it left out; return corners and their side."""
    side = 1 << largest.bit_length() - 1
    squares = _tile(zone, side)
    while side > 1 and len(squares) * side * side * 2 < zone.sum():
        side //= 2
        squares = _tile(zone, side)
    if len(squares) > most:
        squares = squares[np.linspace(0, len(squares) - 1, most).astype(int)]
    return np.ascontiguousarray(squares, np.int32), side


def strips_over(zone: NDArray[np.bool_], width: int) -> NDArray[np.int32]:
    """Cover the zone with strips: lying ones longer than its width, and upright ones elsewhere."""
    start, stop, row = row_runs(zone)
    lying = np.stack([0 * row, row, start, stop - start], axis=1)[stop - start > width]
    left = zone.copy()
    for _, v, u, length in lying.tolist():
        left[v, u : u + length] = False
    start, stop, column = row_runs(left.T)
    upright = np.stack([0 * column + 1, start, column, stop - start], axis=1)
    return np.ascontiguousarray(np.concatenate([lying, upright]), np.int32)


def _tile(zone: NDArray[np.bool_], side: int) -> NDArray[np.int64]:
    """Squares inside the zone that together cover it, each mostly pixels of its own."""
    if side == 1:
        return np.argwhere(zone)
    inside = box_sums(zone, side, side) == side * side
    left = zone.copy()
    chosen = []
    for own_share in (side * side, side * side // 2):  # whole squares first
        for v in np.flatnonzero(inside.any(axis=1)).tolist():
            counts = np.cumsum(left[v : v + side].sum(axis=0))
            own = np.append(counts[side - 1], counts[side:] - counts[:-side])
            places = np.flatnonzero(inside[v] & (own >= own_share))
            for u in places.tolist():
                # What was chosen further left in this row may have taken some of it.
                if np.count_nonzero(left[v : v + side, u : u + side]) >= own_share:
                    chosen.append((v, u))
                    left[v : v + side, u : u + side] = False
    return np.array(chosen, np.int64).reshape(-1, 2)
