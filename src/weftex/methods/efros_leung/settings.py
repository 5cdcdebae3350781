"""The parameters of non-parametric sampling, settled for a sample."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError
from weftex.methods.pixels.growth import settled_width
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.search.windows import Windows

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
    # Narrower where the usable pixels have no room for the proposed width.
    while method.window_width is None and width > 1 and not _has_windows(exemplar, width):
        width -= 2
    seed_size = min(_PROPOSED_SEED, width) if method.seed_size is None else method.seed_size
    if seed_size > width:
        raise InvalidInputError(
            f"seed_size is {seed_size}; it must be from 1 to the window_width of {width}"
        )
    given = dataclasses.asdict(method)
    return Settings(**given | {"window_width": width, "seed_size": seed_size})


def square_windows(exemplar: Exemplar, width: int) -> Windows:
    """Return the square windows of a sample that lie wholly on usable pixels."""
    reach = width // 2
    return windows_of(exemplar, (reach, reach, reach, reach))


def _has_windows(exemplar: Exemplar, width: int) -> bool:
    try:
        square_windows(exemplar, width)
    except InvalidInputError:
        return False
    return True
