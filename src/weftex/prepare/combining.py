"""Several samples as one: converted to one kind, their maps paired by role, stacked."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.analysis.lattice import find_lattice
from weftex.analysis.relief import LOOK, smaller_copy
from weftex.errors import InvalidInputError, did_you_mean, is_number, shown, size_words, wrong_value
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.io.outputs import reversed_map
from weftex.raster.arrays import Floats
from weftex.raster.levels import scale_between

#: The value of a normal map that is missing.
FLAT = "flat"
#: Least correlation of the mean tiles of two photos of one pattern, and share of their contrast.
_ALIKE = 0.75
_DIGITS = 1e-6  # to which it is rounded, as machines differ in last digits
_SEEN = 1024  # pixels a side that mean tiles are made from


def together(samples: Sequence[Sample]) -> Exemplar:
    """Make one sample of several photos of a material; methods choose from all of them.

    A masked line separates any two, so that no patch is copied from two photos.

    Parameters
    ----------
    samples : sequence of path, array, PIL image or Exemplar
        Photos of one dtype, taken from one distance; gray and color may be mixed. Only maps that
        all of them have are kept.

    Returns
    -------
    Exemplar

    Raises
    ------
    FileError, InvalidInputError
        If a sample cannot be read; if the list is empty, or dtypes differ.

    Examples
    --------
    >>> together(["sample:pebbles", "sample:pebbles"]).shape
    (385, 192)
    """
    if isinstance(samples, (str, os.PathLike, Exemplar, np.ndarray)) or not len(samples):
        raise InvalidInputError("samples must be a list of one sample or more")
    exemplars = of_one_kind([load_exemplar(sample) for sample in samples])
    return combined(paired(exemplars)[0], apart=True)


def combined(exemplars: Sequence[Exemplar], *, apart: bool = False) -> Exemplar:
    """Put samples from `paired` under each other, so that one source map can point into all.

    If `apart`, masked lines separate them, and a lattice that they share goes on in all.
    """
    first = exemplars[0]
    # As high as a pixel of the map that has the fewest.
    block = math.lcm(*(first.scale_of(k).denominator for k in first.maps))
    shared = _shared_lattice(exemplars) if apart and len(exemplars) > 1 else None
    places, lowest = list[tuple[int, int]](), 0
    for number, exemplar in enumerate(exemplars):
        place = shared and _place(lowest, block, shared[0], shared[1][number])
        places.append(place or (lowest, 0))
        lowest = places[-1][0] + exemplar.shape[0] + block * apart

    def put(pictures: Sequence[NDArray[Any]], scale: Any = 1) -> NDArray[Any]:
        corners = [(int(y * scale), int(x * scale)) for y, x in places]
        both = [*zip(corners, pictures, strict=True)]
        height, width = np.max([np.add(corner, one.shape[:2]) for corner, one in both], axis=0)
        whole = np.zeros((height, width, *pictures[0].shape[2:]), pictures[0].dtype)
        for (y, x), one in both:
            whole[y : y + one.shape[0], x : x + one.shape[1]] = one
        return whole

    maps = {}
    for name in first.maps:
        pixels = put([e.maps[name] for e in exemplars], first.scale_of(name))
        maps[name] = first.map(name).changed(pixels=pixels)
    parts: dict[str, Any] = {"guide": None, "tileable": False, "name": "samples"}
    parts |= {"pieces": apart and not shared, "turn": None, "copy_shape": None}
    mask = put([e.usable for e in exemplars])
    return first.changed(pixels=put([e.pixels for e in exemplars]), maps=maps, mask=mask, **parts)


def _shared_lattice(exemplars: Sequence[Exemplar]) -> tuple[CanvasLattice, list[Floats]] | None:
    """Return the lattice of samples, and which part of its tile lies at the corner of each.

    Each part is relative to the first sample. None if it has no lattice, or not all have it.
    """
    small, step = smaller_copy(exemplars[0], LOOK)
    found = find_lattice(small)
    found = find_lattice(exemplars[0]) if found and step > 1 else found
    if found is None:
        return None
    lattice, parts = CanvasLattice(tuple(found)), list[Floats]()
    tiles = [_mean_tile(exemplar, lattice) for exemplar in exemplars]
    first = np.fft.rfft2(tiles[0][0], axes=(0, 1))
    for tile, share in tiles:
        products = (np.fft.rfft2(tile, axes=(0, 1)).conj() * first).sum(axis=2)
        alike = np.rint(np.fft.irfft2(products, s=tile.shape[:2]) / _DIGITS) * _DIGITS
        at = np.unravel_index(alike.argmax(), alike.shape)
        if alike[at] < _ALIKE or share < _ALIKE * tiles[0][1]:
            return None
        parts.append(np.divide(at, tile.shape[:2]))
    return lattice, parts


def _mean_tile(exemplar: Exemplar, lattice: CanvasLattice) -> tuple[Floats, float]:
    """Return the mean tile (n, m, K), of mean 0 and length 1, and its share of the variance."""
    sides = [max(1, round(float(np.hypot(*v)))) for v in lattice.sample]
    y, x = np.nonzero(exemplar.usable[:_SEEN, :_SEEN])
    cells, values = lattice.cell(y, x, sides), exemplar.matching()[y, x].astype(np.float64)
    values -= values.mean(axis=0)
    count = np.bincount(cells, minlength=math.prod(sides))
    sums = np.stack([np.bincount(cells, k, len(count)) for k in values.T], axis=1)
    tile = sums / np.maximum(count, 1)[:, None]
    share = (np.square(tile).sum(axis=1) * count).sum() / max(np.square(values).sum(), 1e-9)
    length = max(float(np.linalg.norm(tile)), 1e-9)
    return tile.reshape(*sides, -1) / length, float(share)


def _place(lowest: int, block: int, lattice: CanvasLattice, part: Floats) -> tuple[int, int]:
    """Return the place from a line on, in multiples of `block`, that has this part of a tile."""
    high, wide = (int(abs(lattice.sample[:, k]).sum()) + 1 for k in (0, 1))
    y, x = np.meshgrid(*(np.arange(0, n + block, block) for n in (high, wide)), indexing="ij")
    rest = [a - b for a, b in zip(lattice.multiples(y + lowest, x), part, strict=True)]
    off = np.tensordot([r - np.rint(r) for r in rest], lattice.sample, (0, 0))
    cost = np.rint(np.abs(off).max(axis=2) / block) * y.size + y + x
    best = np.unravel_index(cost.argmin(), cost.shape)
    return int(y[best]) + lowest, int(x[best])


def of_one_kind(exemplars: Sequence[Exemplar], what: str = "sample") -> list[Exemplar]:
    """Convert gray samples to color beside color ones; refuse other differences of kind."""
    most = max(e.channels for e in exemplars)
    same = [_as_color(e, most) for e in exemplars]
    first = same[0]
    for number, exemplar in enumerate(same[1:], 2):
        mine, other = (_kind(e) for e in (exemplar, first))
        if mine != other:
            raise InvalidInputError(
                f"{what} {number} ({exemplar.name}) is {mine}, {what} 1 ({first.name}) is {other}; "
                "save both in the same format"
            )
    return same


def paired(
    exemplars: Sequence[Exemplar], missing: Mapping[str, float | str] | None = None
) -> tuple[list[Exemplar], list[str]]:
    """Give all samples the same maps, by role; return them, and notes about maps left out.

    Normal maps of both conventions are one role, in the convention of the first sample with one.
    """
    values = _checked(missing)
    owned = [_slots(exemplar) for exemplar in exemplars]
    wanted: dict[str, list[str]] = {}  # map names by slot, of the first sample that has it
    for slots in owned:
        wanted |= {slot: names for slot, names in slots.items() if slot not in wanted}
    maps: list[dict[str, Exemplar]] = [{} for _ in exemplars]
    notes = []
    for slot, names in wanted.items():
        lacking = [e.name for e, slots in zip(exemplars, owned, strict=True) if slot not in slots]
        if lacking and slot not in values:
            notes.append(f"{slot} is ignored: {' and '.join(lacking)} has no such map")
            continue
        value = values.pop(slot) if lacking else 0.0
        for name in names:
            like = next(e for e in exemplars if name in e.maps)
            found = []
            for exemplar, slots in zip(exemplars, owned, strict=True):
                if slot not in slots:
                    found.append(_constant(exemplar, like, name, value))
                    continue
                found.append(_turned(exemplar, slots[slot], name))
                own = slots[slot][0]
                if name not in slots[slot] and "normal" in (name, own):
                    notes.append(
                        f"the {own} of {exemplar.name} is read as {name}, because its file "
                        "name does not say where y points"
                    )
            _check_scales(exemplars, found, like, name)
            for one, given in zip(of_one_kind(found, f"the {name} of sample"), maps, strict=True):
                given[name] = one
    for slot in values:
        near = "; all samples have it" if slot in wanted else did_you_mean(slot, wanted)
        raise InvalidInputError(f"missing has '{slot}', but no sample lacks it{near}")
    return [e.changed(maps=own) for e, own in zip(exemplars, maps, strict=True)], notes


def _slots(exemplar: Exemplar) -> dict[str, list[str]]:
    """Return names of equivalent maps: normals of both conventions, else the map itself."""
    slots: dict[str, list[str]] = {}
    for name, role in exemplar.roles.items():
        slots.setdefault("normal" if role.kind == "normal" else name, []).append(name)
    return slots


def _turned(exemplar: Exemplar, names: list[str], key: str) -> Exemplar:
    """Return the map of a name, or another normal map with its y in that name's convention."""
    if key in names:
        return exemplar.map(key)
    one = exemplar.map(names[0])
    if one.channels > 1 and {key, names[0]} == {"normal_gl", "normal_dx"}:
        return one.changed(pixels=reversed_map(one.pixels, key))
    return one


def _constant(exemplar: Exemplar, like: Exemplar, key: str, value: float | str) -> Exemplar:
    """Return a map of one value, of the kind of another sample's map."""
    given, scale = like.map(key), like.scale_of(key)
    shape = tuple(int(side * scale) for side in exemplar.shape)
    if (value == FLAT) != (given.role.kind == "normal"):
        right = f"'{FLAT}'" if given.role.kind == "normal" else "a number from 0 to 1"
        raise wrong_value(f"missing['{key}']", value, right)
    levels = [0.5, 0.5, 1.0, 1.0][: given.channels] if value == FLAT else [value] * given.channels
    if given.alpha:
        levels[-1] = 1.0
    dtype, values = given.pixels.dtype, np.array(levels)
    values = values if dtype.kind == "f" else np.rint(values * np.iinfo(dtype).max)
    pixels = np.full((*shape, given.channels), values, dtype)
    return given.changed(pixels=pixels.reshape(*shape, *given.pixels.shape[2:]))


def _check_scales(
    exemplars: Sequence[Exemplar], found: Sequence[Exemplar], like: Exemplar, key: str
) -> None:
    """Refuse maps of one role with different resolutions relative to their samples."""
    scale = like.scale_of(key)
    for exemplar, one in zip(exemplars, found, strict=True):
        if scale_between(one.shape, exemplar.shape) != scale:
            size, own = (size_words(e.shape) for e in (one, exemplar))
            raise InvalidInputError(
                f"the {key} of {exemplar.name} is {size}, the sample {own}; that of {like.name} "
                f"has {scale} times as many pixels a side as its sample; scale one of them"
            )


def _checked(missing: Mapping[str, float | str] | None) -> dict[str, float | str]:
    """Return the values by equivalent names."""
    if missing is not None and not isinstance(missing, Mapping):
        raise InvalidInputError(f"missing is {shown(missing)}; it must map names of maps to values")
    for name, value in (missing or {}).items():
        inside = is_number(value) and 0 <= value <= 1
        if not isinstance(name, str) or not (inside or value == FLAT):
            raise wrong_value(f"missing[{shown(name)}]", value, f"from 0 to 1, or '{FLAT}'")
    normals = ("normal_gl", "normal_dx")
    return {"normal" if k in normals else k: v for k, v in (missing or {}).items()}


def _as_color(exemplar: Exemplar, channels: int) -> Exemplar:
    clear = int(exemplar.alpha)
    if exemplar.channels - clear != 1 or channels - clear != 3:
        return exemplar
    pixels = exemplar.pixels.reshape(*exemplar.shape, -1)
    pixels = np.concatenate([*[pixels[..., :1]] * 3, pixels[..., 1:]], axis=2)
    return exemplar.changed(pixels=pixels)


def _kind(exemplar: Exemplar) -> str:
    clear = " and alpha" if exemplar.alpha else ""
    count = exemplar.channels - exemplar.alpha
    return f"{exemplar.pixels.dtype} with {count} channel{'s' * (count > 1)}{clear}"
