"""The sides of tiles, and the width of their borders, where these are left open."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.errors import InvalidInputError
from weftex.methods.best_tile.tiles import tile_errors, tile_fits, tile_rows

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

    Vectors = tuple[float, ...]

_BORDER = 10  # px (section 4.1.1)
_CHOICE = (0.4, 0.7)  # of the sample's sides, that a tile is between where nothing repeats
_SIZES_TRIED = 16  # there


def border_for(given: int | None, vectors: Vectors, exemplar: Exemplar) -> int:
    """The width of borders: the given one, or at most 10 if the sample is large enough.

    Raises `InvalidInputError` if the sample has no room for the given one.
    """

    def fits(width: int) -> bool:
        return width == 0 or tile_fits(exemplar.shape, tile_rows(vectors, width))

    border = _BORDER if given is None else given
    if exemplar.mask is not None or fits(border):
        return border
    if given is not None:
        better = next(width for width in range(min(given, *exemplar.shape), -1, -1) if fits(width))
        raise InvalidInputError(
            f"border_width is {given}; {exemplar.name} has room for a tile with borders of "
            f"{better} at most"
        )
    while not fits(border):
        border //= 2
    return border


def complete_vectors(vectors: Vectors, given_border: int | None, exemplar: Exemplar) -> Vectors:
    """Two vectors, also where the sample repeats along one direction only, or not at all.

    Of upright tiles, or of tiles across that direction, the one that fits itself best is taken.
    """
    if len(vectors) == 4:
        return vectors
    border = _BORDER if given_border is None else given_border
    best: Vectors = ()
    scale = 1
    while not best and scale <= min(exemplar.shape):
        best = _least(_choices(vectors, exemplar.shape, scale), border, exemplar)
        scale *= 2
    return best or (1.0, 0.0, 0.0, 1.0)


def _choices(vectors: Vectors, shape: tuple[int, int], scale: int) -> list[Vectors]:
    """Vectors to choose from: of tiles smaller by `scale` than those tried first."""
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


def _least(choices: list[Vectors], border: int, exemplar: Exemplar) -> Vectors:
    """The vectors whose best tile has the least error for its circumference; () if none fits."""
    best: Vectors = ()
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
    """Lengths to try for a side of a tile."""
    low, high = (max(1, round(share * side / scale)) for share in _CHOICE)
    return list(range(low, high + 1, max(1, (high - low) // _SIZES_TRIED)))
