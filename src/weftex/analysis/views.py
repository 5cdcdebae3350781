"""A sample as lattices are looked for in it: without slow lighting, and its correlations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.correlation import correlate, correlation_and_power
from weftex.analysis.goodness import ALPHA, SIGNIFICANT, Field
from weftex.analysis.peaks import find_peaks
from weftex.analysis.relief import Relief, relief
from weftex.analysis.whitening import whitened

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

_SIGMAS = 3.0  # of what chance makes of one multiple, that do not count


@dataclass(frozen=True, eq=False)
class Views:
    """A sample without slow lighting, and its correlations: as it is, and whitened."""

    flat: Relief
    field: Field
    white: Field
    chance: float


def views(exemplar: Exemplar, alpha: float = ALPHA, significant: float = SIGNIFICANT) -> Views:
    """What lattices of a sample are looked for in; alpha and significant as for `find_lattice`."""
    flat = relief(exemplar)
    usable, power = flat.usable >= 0.5, None
    if usable.all():
        own, power = correlation_and_power(flat.levels)
    else:
        own = correlate(np.moveaxis(flat.levels, 0, 2), first_mask=usable)
    even, chance = whitened(flat, power)
    white = Field(even, find_peaks(even), alpha, significant, _SIGMAS * chance)
    return Views(flat, Field(own, find_peaks(own), alpha, significant), white, chance)
