"""The parameters of non-parametric sampling, settled for a sample."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError
from weftex.methods.pixels.growth import narrowed, settled_width
from weftex.search.windows import square_windows

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

_PROPOSED_WIDTH = 15
_PROPOSED_SEED = 3


@dataclass(frozen=True)
class Settings:
    """Every parameter of `EfrosLeung`, settled; each is described there."""

    window_width: int
    tolerance: float
    threshold: float
    seed_size: int
    search: str
    candidates: int
    variance: float


def settle(method: Any, exemplar: Exemplar) -> Settings:
    """Settle the parameters of a method for a sample.

    Raises
    ------
    InvalidInputError
        If the sample has no room for a window of the given width, or the seed is wider than it.
    """
    width: int = settled_width(method.window_width, exemplar, _PROPOSED_WIDTH)
    if method.window_width is None:
        width = narrowed(width, partial(square_windows, exemplar))
    seed_size = min(_PROPOSED_SEED, width) if method.seed_size is None else method.seed_size
    check_seed_size(seed_size, width)
    given = dataclasses.asdict(method)
    return Settings(**given | {"window_width": width, "seed_size": seed_size})


def check_seed_size(seed_size: int | None, width: int | None) -> None:
    """Raise `InvalidInputError` if the seed is wider than the window; None fits."""
    if seed_size and width and seed_size > width:
        raise InvalidInputError(
            f"seed_size is {seed_size}; it must be from 1 to the window_width of {width}"
        )
