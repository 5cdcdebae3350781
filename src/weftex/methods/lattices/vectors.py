"""The vectors that methods over a lattice take: given ones checked, or those of the sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weftex.analysis.lattice import Lattice, find_lattice
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

_SMALLEST_SAMPLE = 32  # side below which noise may look like a lattice by chance
#: The unconstrained mode's vectors: any place is similar to any other (section 5.2).
ANYWHERE = (1.0, 0.0, 0.0, 1.0)


def check_lattice(vectors: tuple[float, ...], exemplar: Exemplar) -> None:
    """Raise `InvalidInputError` unless two tiles of these vectors lie in the sample."""
    x1, y1, x2, y2 = vectors
    lattice = Lattice(((x1, y1), (x2, y2))).reduced()
    height, width = exemplar.shape
    size = f"{exemplar.name} is {width}x{height}"
    for x, y in lattice.vectors:
        if abs(x) >= width or abs(y) >= height:
            raise InvalidInputError(
                f"lattice has the vector [{x:g}, {y:g}], but {size}; it must be smaller"
            )
    if 2 * lattice.area > height * width:
        raise InvalidInputError(
            f"the lattice's tile has {lattice.area:.0f} pixels and {size}, "
            "which is less than two tiles; give a larger sample"
        )


def found_vectors(exemplar: Exemplar) -> tuple[float, ...]:
    """The lattice of a sample as x1, y1, x2, y2; x1, y1 where it repeats one way only; or ()."""
    if min(exemplar.shape) < _SMALLEST_SAMPLE:
        return ()
    lattice = find_lattice(exemplar)
    if lattice is None:
        return ()
    return tuple(part for vector in lattice.reduced().vectors for part in vector)
