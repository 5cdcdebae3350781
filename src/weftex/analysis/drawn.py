"""Lattices over a sample, for pages on which people look at them, draw others and rate them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from weftex.analysis.autocorrelations import autocorrelations
from weftex.analysis.canvas_lattice import check_lattice, four_numbers, given_lattice
from weftex.analysis.lattice import Lattice, Rated, rate_lattices
from weftex.analysis.overlay import courses, lattice_lines
from weftex.analysis.relief import smaller_copy
from weftex.parameters import numbers_of

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

__all__ = ["DrawnLattice", "Lattice", "LatticeRating", "Rated", "draw"]

_LARGEST_SIDE = 1024  # pixels of the sample by which lines are put into joints


@dataclass(frozen=True)
class DrawnLattice:
    """A lattice, or rows, for whoever draws it over the sample.

    Attributes
    ----------
    vectors : list of list of float
        Two vectors (x, y) in pixels; one of rows.
    numbers : str
        The lattice as the option ``--lattice`` takes it.
    words : str
        Width and height of its pieces, and their shift.
    lines : list of dict
        The sides of its tiles: along each line ``x * across[0] + y * across[1]`` is an integer
        plus ``phase``.
    goodness : float or None
        See `weftex.analysis.lattice.Rated`; None if it was not rated.
    """

    vectors: list[list[float]]
    numbers: str
    words: str
    lines: list[dict[str, object]]
    goodness: float | None


def draw(
    exemplar: Exemplar,
    vectors: tuple[tuple[float, float], ...],
    goodness: float | None = None,
) -> DrawnLattice:
    """Return a lattice with lines where the sample changes most."""
    lattice = Lattice(vectors)
    small, step = smaller_copy(exemplar, _LARGEST_SIDE)
    lines = lattice_lines(small, Lattice(tuple((x / step, y / step) for x, y in vectors)))
    return DrawnLattice(
        vectors=[list(map(float, vector)) for vector in vectors],
        numbers=",".join(f"{number:g}" for number in four_numbers(lattice)),
        words=courses(lattice),
        lines=[
            {"across": [float(part) / step for part in across], "phase": phase}
            for across, phase in lines
        ],
        goodness=goodness,
    )


class LatticeRating:
    """Rates lattices of a sample, of which it keeps the correlations: 64 bytes per pixel."""

    def __init__(self, exemplar: Exemplar) -> None:
        self._exemplar = exemplar
        self._fields = autocorrelations(exemplar)

    def rate(self, numbers: str) -> DrawnLattice:
        """Draw and rate a lattice given as x1,y1,x2,y2.

        Raises
        ------
        InvalidInputError
            If it does not fit into the sample.
        """
        plain = numbers_of("lattice", numbers, 4)
        check_lattice(plain, self._exemplar)
        lattice = given_lattice(plain)
        found, _ = rate_lattices(self._exemplar, lattice, runners_up=0, fields=self._fields)
        assert found is not None
        return draw(self._exemplar, lattice.vectors, found.goodness)
