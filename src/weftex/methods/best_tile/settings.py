"""The settings of best tile repetition: every value settled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.canvas_lattice import check_lattice, found_vectors
from weftex.errors import InvalidInputError
from weftex.methods.best_tile.tiles import has_room, tile_errors, tile_rows

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

_BORDER = 10  # px (section 4.1.1)
_LIMIT = 0.05  # strain of a lattice that goes around a canvas
_CHOICE = (0.4, 0.7)  # of the sample's sides, between which a tile is chosen where nothing repeats
_SIZES_TRIED = 16  # there


@dataclass(frozen=True)
class Settings:
    """The parameters of best tile repetition, settled.

    Attributes
    ----------
    lattice : (float, float, float, float)
        x1, y1, x2, y2 in pixels.
    limit : float
        Strain that the lattice takes to go around; tiles of a sample without one may have any size.
    border_width : int
        In pixels; if it was left open, narrower where the sample has no room, at last 0.
    tiles : int
        Of the best ones, repeat at most so many.
    """

    lattice: tuple[float, ...]
    limit: float
    border_width: int
    tiles: int


def settle(method: Any, exemplar: Exemplar) -> Settings:
    """Find the lattice, if none is given, and borders that there is room for.

    Parameters
    ----------
    method : BestTile
        Parameters; None where they are left open.
    exemplar : Exemplar
        The sample.

    Raises
    ------
    InvalidInputError
        If the vectors or the borders do not fit the sample.
    """
    border = _BORDER if method.border_width is None else method.border_width
    limit = _LIMIT
    if method.lattice is not None:
        check_lattice(method.lattice, exemplar)
        vectors = method.lattice
    else:
        found = found_vectors(exemplar)
        vectors = _completed(found, border, exemplar)
        limit = _LIMIT if found else float("inf")
    if exemplar.mask is None:
        border = _with_room(method.border_width, border, vectors, exemplar)
    return Settings(vectors, limit, border, method.tiles)


def _with_room(
    given: int | None, border: int, vectors: tuple[float, ...], exemplar: Exemplar
) -> int:
    """The width of borders that the sample has room for; a given one is refused, not narrowed."""

    def fits(width: int) -> bool:
        return width == 0 or has_room(exemplar.shape, tile_rows(vectors, width))

    if given is not None and not fits(given):
        better = next(width for width in range(min(given, *exemplar.shape), -1, -1) if fits(width))
        raise InvalidInputError(
            f"border_width is {given}; {exemplar.name} has room for a tile with borders of "
            f"{better} at most"
        )
    while not fits(border):
        border //= 2
    return border


def _completed(vectors: tuple[float, ...], border: int, exemplar: Exemplar) -> tuple[float, ...]:
    """Complete the vectors where a sample repeats along one direction, or not at all."""
    if len(vectors) == 4:
        return vectors
    best: tuple[float, ...] = ()
    scale = 1
    while not best and scale <= min(exemplar.shape):
        best = _least(_choices(vectors, exemplar.shape, scale), border, exemplar)
        scale *= 2
    return best or (1.0, 0.0, 0.0, 1.0)


def _choices(
    vectors: tuple[float, ...], shape: tuple[int, int], scale: int
) -> list[tuple[float, ...]]:
    height, width = shape
    if vectors:
        x, y = vectors
        length = float(np.hypot(x, y))
        aside = min(height / max(abs(x), 0.1), width / max(abs(y), 0.1)) * length
        return [(x, y, -y / length * n, x / length * n) for n in _lengths(aside, scale)]
    across, down = _lengths(width, scale), _lengths(height, scale)
    count = max(len(across), len(down))
    return [
        (float(across[k * len(across) // count]), 0.0, 0.0, float(down[k * len(down) // count]))
        for k in range(count)
    ]


def _least(choices: list[tuple[float, ...]], border: int, exemplar: Exemplar) -> tuple[float, ...]:
    """Of these vectors those whose tile fits itself best, for its circumference."""
    best: tuple[float, ...] = ()
    least = float("inf")
    for given in choices:
        errors = tile_errors(exemplar, given, border)
        if (errors < 0).all() and exemplar.mask is None:
            errors = tile_errors(exemplar, given, 0)
        if (errors >= 0).any():
            x1, y1, x2, y2 = given
            around = float(np.hypot(x1, y1) + np.hypot(x2, y2))
            value = float(errors[errors >= 0].min()) / around
            if value < least:
                best, least = given, value
    return best


def _lengths(side: float, scale: int) -> list[int]:
    low, high = (max(1, round(share * side / scale)) for share in _CHOICE)
    return list(range(low, high + 1, max(1, (high - low) // _SIZES_TRIED)))
