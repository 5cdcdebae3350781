"""What a choice hangs on: lattice, scale, colors and evenness of a sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from weftex.analysis.evenness import Evenness, evenness
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.relief import maps_alone, smaller_copy
from weftex.analysis.scale import dominant_scale
from weftex.analysis.sidedness import sidedness
from weftex.exemplar import Exemplar

LOOK = 320  #: pixels a side; of larger samples a smaller copy and a part are looked at
SMALLEST_ANALYZED = 32  #: pixels a side of a sample that has something to be analyzed


@dataclass(frozen=True)
class Findings:
    """What the choice hangs on.

    Attributes
    ----------
    shape : (int, int)
        Height and width of the sample.
    lattice : Lattice or None
        See `weftex.analysis.lattice.find_lattice`.
    exact : bool
        Whether the lattice was found in the sample itself and not in a smaller copy or a part.
    scale : float
        See `weftex.analysis.scale.DominantScale`, in pixels of the sample.
    colors : int
        Different colors; many of more than some thousand.
    evenness : Evenness
        See `weftex.analysis.evenness`.
    sidedness : float
        See `weftex.analysis.sidedness`; 1 where copies that are turned cannot be made.
    """

    shape: tuple[int, int]
    lattice: Lattice | None
    exact: bool
    scale: float
    colors: int
    evenness: Evenness
    sidedness: float = 1.0


def look(exemplar: Exemplar) -> Findings:
    """Analyze a sample for the rule, in about 0.2 s, or a second where it is of some megapixels.

    A sample of more than 320 pixels a side is averaged down; where that shows no lattice, a part
    of it is looked at as it is, because fine lattices are lost in averages.

    Parameters
    ----------
    exemplar : Exemplar
        The sample.
    """
    small, step = smaller_copy(exemplar, LOOK)
    if min(small.shape) < SMALLEST_ANALYZED:
        return Findings(
            exemplar.shape, None, True, 1.0, count_colors(small), Evenness(0, 0, 0, (1, 1))
        )
    lattice = find_lattice(small)
    scale = dominant_scale(small, lattice).scale
    if step > 1:
        maps = maps_alone(exemplar)
        lattice = _of_whole(lattice, step, exemplar)
        if lattice is None and maps is not None:
            lattice = _of_whole(find_lattice(smaller_copy(maps, LOOK)[0]), step, maps)
    return Findings(
        shape=exemplar.shape,
        lattice=lattice,
        exact=step == 1,
        scale=round(scale * step, 2),
        colors=count_colors(small if step == 1 else _part(exemplar)),
        evenness=evenness(small),
        sidedness=sidedness(small) if _may_turn(exemplar) else 1.0,
    )


def _may_turn(exemplar: Exemplar) -> bool:
    """Maps of fewer pixels than the sample would come in as many as it has, see `turned`."""
    fewer = any(exemplar.scale_of(name) < 1 for name in exemplar.maps)
    return not (exemplar.pieces or exemplar.tileable or fewer)


def _of_whole(found: Lattice | None, step: int, exemplar: Exemplar) -> Lattice | None:
    """The lattice of a copy so many times smaller in pixels of the sample, or that of a part."""
    if found is None:
        return find_lattice(_part(exemplar))
    vectors = tuple((x * step, y * step) for x, y in found.vectors)
    return Lattice(vectors, found.confidence)


def _part(exemplar: Exemplar) -> Exemplar:
    """The middle of the sample; with a mask, of what may be used."""
    usable = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    corner = []
    for axis in (0, 1):
        places = np.flatnonzero(usable.any(axis=1 - axis))
        side = exemplar.shape[axis]
        middle = (int(places[0]) + int(places[-1]) + 1) // 2
        corner.append(max(0, min(middle - LOOK // 2, side - LOOK)))
    box = tuple(slice(at, at + LOOK) for at in corner)
    mask = None if exemplar.mask is None or not exemplar.mask[box].any() else exemplar.mask[box]
    levels = np.ascontiguousarray(exemplar.matching()[box])
    return Exemplar(levels, mask=mask, alpha=False, name=exemplar.name)


def count_colors(exemplar: Exemplar) -> int:
    """Different colors in every third row, which is enough to tell few from many."""
    levels = exemplar.matching()[::3]
    levels = levels.reshape(-1, levels.shape[-1])
    names = np.zeros(len(levels), np.uint64)
    for k in range(min(levels.shape[1], 8)):
        names = names << np.uint64(8) | levels[:, k]
    names.sort()  # not np.unique, which loads masked arrays
    return 1 + int(np.count_nonzero(names[1:] != names[:-1]))
