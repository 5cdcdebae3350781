"""The analysis that a choice depends on: lattice, scale, colors and evenness of a sample."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.properties import Evenness, evenness, sidedness
from weftex.analysis.relief import LOOK, maps_alone, smaller_copy
from weftex.analysis.rows import find_boards
from weftex.analysis.scale import structure_scale
from weftex.exemplar import Exemplar
from weftex.progress import counted

SMALLEST_ANALYZED = 32  #: pixels a side; a smaller sample is not analyzed


@dataclass(frozen=True)
class Findings:
    """The analysis of a sample that the choice depends on."""

    shape: tuple[int, int]  # height and width
    lattice: Lattice | None
    exact: bool  # whether the lattice is of the sample itself, not of a smaller copy or a part
    scale: float  # in pixels of the sample
    colors: int  # different colors; approximate above some thousand
    evenness: Evenness
    #: How far it is from looking the same upside down, and turned by 90 degrees or in a mirror;
    #: 1 where such copies cannot be made.
    sidedness: tuple[float, float] = 1.0, 1.0
    rows: bool = False  # whether it has no lattice, but joints between rows that run through it
    full: Lattice | None = None  # that of the sample itself, where `lattice` is not exact


def look(exemplar: Exemplar) -> Findings:
    """Analyze a sample for the rule, in 0.2 s to 1 s; maps count for the lattice alone.

    Larger than 320 pixels a side it is averaged down; where that has no lattice, a part of it is
    analyzed at full resolution, because averages lose fine lattices.
    """
    small, step = smaller_copy(exemplar, LOOK)
    if min(small.shape) < SMALLEST_ANALYZED:
        return Findings(exemplar.shape, None, True, 1.0, count_colors(small), Evenness(0, 0, 0))
    with counted(4, "analysis") as advance:
        lattice = find_lattice(small)
        advance(1)
        seen = exemplar.changed(maps={}) if exemplar.maps else exemplar
        if exemplar.maps:
            small = smaller_copy(seen, LOOK)[0]
        scale = structure_scale(small, lattice).scale
        advance(1)
        if step > 1:
            maps = maps_alone(exemplar)
            lattice = _of_whole(lattice, step, exemplar)
            if lattice is None and maps is not None:
                lattice = _of_whole(find_lattice(smaller_copy(maps, LOOK)[0]), step, maps)
        plain = exemplar.mask is None and (lattice is None or len(lattice.vectors) == 1)
        advance(1)
        return Findings(
            shape=exemplar.shape,
            lattice=lattice,
            exact=step == 1,
            scale=round(scale * step, 2),
            colors=count_colors(small if step == 1 else _part(seen)),
            evenness=evenness(small),
            sidedness=_sidedness(exemplar, small),
            rows=plain and find_boards(seen.matching(), lattice is not None) is not None,
        )


def with_full(found: Findings, exemplar: Exemplar) -> Findings:
    """Add the lattice of the sample itself, as entire samples and canvases that wrap need it.

    Where it has none, that of the smaller copy is left out.
    """
    if found.exact or found.lattice is None:
        return found
    own = find_lattice(exemplar)
    return replace(found, lattice=found.lattice if own else None, full=own and own.reduced())


def _sidedness(exemplar: Exemplar, small: Exemplar) -> tuple[float, float]:
    """Return that of a smaller copy where turned copies can be made.

    Smaller maps would be enlarged, see `turned`; by 90 degrees normals can be turned only if their
    name says whether y is up.
    """
    fewer = any(exemplar.scale_of(name) < 1 for name in exemplar.maps)
    if exemplar.pieces or exemplar.tileable or fewer:
        return 1.0, 1.0
    unsaid = any(exemplar.map(name).role.name == "normal" for name in exemplar.maps)
    upside_down, turned = sidedness(small)
    return upside_down, 1.0 if unsaid else turned


def _of_whole(found: Lattice | None, step: int, exemplar: Exemplar) -> Lattice | None:
    """Return the lattice of a smaller copy in pixels of the sample, or that of a part."""
    if found is None:
        return find_lattice(_part(exemplar))
    vectors = tuple((x * step, y * step) for x, y in found.vectors)
    return Lattice(vectors, found.confidence)


def _part(exemplar: Exemplar) -> Exemplar:
    """Return the middle of the usable part of the sample."""
    usable = exemplar.usable
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
    """Return the number of colors in every third row, enough to tell few from many."""
    levels = exemplar.matching()[::3]
    levels = levels.reshape(-1, levels.shape[-1])
    names = np.zeros(len(levels), np.uint64)
    for k in range(min(levels.shape[1], 8)):
        names = names << np.uint64(8) | levels[:, k]
    names.sort()  # not np.unique, which loads masked arrays
    return 1 + int(np.count_nonzero(names[1:] != names[:-1]))
