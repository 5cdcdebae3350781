"""How good lattices are for a sample: the one that was found, a given one, and runners-up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.autocorrelations import Autocorrelations, autocorrelations
from weftex.analysis.correlation import correlate
from weftex.analysis.goodness import ALPHA, SIGNIFICANT, Field, check_rule, rate, reach_of
from weftex.analysis.lattice import Lattice
from weftex.analysis.pairs import MOST_MULTIPLES, rated_pairs
from weftex.analysis.relief import relief
from weftex.analysis.rows import ridges

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar


@dataclass(frozen=True)
class Rated:
    """A lattice and how good it is by section 3.3 of the paper on near-regular textures.

    Attributes
    ----------
    vectors : tuple of (float, float)
        Its shortest vectors (x, y) in pixels; one of rows.
    goodness : float
        Of eq. 3.22; what is compared. 0 if a vector has no significant multiple.
    mean : float
        The mean of eq. 3.24: of the correlation for "height", of what stands for it otherwise.
    multiples : int
        n of eq. 3.22: those whose overlap is significant.

    Notes
    -----
    Of rows the mean is how far the ridges of the correlation are above what is between them,
    without the highest, and n is the number of ridges.
    """

    vectors: tuple[tuple[float, float], ...]
    goodness: float
    mean: float
    multiples: int


def gncc(exemplar: Exemplar) -> NDArray[np.float64]:
    """The normalized correlation of a sample with itself that its lattice is read from (3.2)."""
    flat = relief(exemplar)
    return correlate(np.moveaxis(flat.levels, 0, 2), first_mask=flat.usable >= 0.5)


def rate_lattices(
    exemplar: Exemplar,
    lattice: Lattice | None = None,
    *,
    goodness: str = "contrast",
    alpha: float = ALPHA,
    significant: float = SIGNIFICANT,
    runners_up: int = 3,
    fields: Autocorrelations | None = None,
) -> tuple[Rated | None, tuple[Rated, ...]]:
    """Rate a lattice, and the best others that a sample could have."""
    check_rule(goodness, alpha, significant)
    fields = autocorrelations(exemplar, alpha, significant) if fields is None else fields
    field, step = fields.field, fields.flat.step

    def rated(vectors: NDArray[np.float64]) -> Rated:
        reach = reach_of(field, vectors, MOST_MULTIPLES)
        found = rate(field, vectors[None], reach, goodness, exact=True)
        plain = Lattice(tuple((float(x), float(y)) for x, y in vectors * step)).reduced()
        return Rated(
            tuple((round(x, 2) + 0.0, round(y, 2) + 0.0) for x, y in plain.vectors),
            round(float(found.goodness[0]), 4),
            round(float(found.value[0]), 4),
            int(found.count[0]),
        )

    own = None
    if lattice is not None:
        vectors = np.array(lattice.reduced().vectors) / step
        own = rated(vectors) if len(vectors) == 2 else _rated_rows(lattice, field, vectors[0])
    if not runners_up:
        return own, ()
    others = [rated(vectors) for vectors, _ in rated_pairs(field, goodness)]
    others.sort(key=lambda other: -other.goodness)
    shown: list[Rated] = []
    for other in others:
        known = [] if lattice is None else [lattice]
        known += [Lattice(one.vectors) for one in shown]
        if other.goodness > 0 and not any(Lattice(other.vectors).same_as(one) for one in known):
            shown.append(other)
    return own, tuple(shown[:runners_up])


def _rated_rows(lattice: Lattice, field: Field, vector: NDArray[np.float64]) -> Rated:
    mean, number = ridges(field.correlation, vector)
    goodness = max(mean, 0.0) ** field.alpha * number ** (field.alpha - 1)
    return Rated(lattice.reduced().vectors, round(goodness, 4), round(mean, 4), number)
