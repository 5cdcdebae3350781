"""A sample without landmarks, and outputs that show landmarks no more often than looks natural."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.relief import smaller_copy
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError, wrong_value
from weftex.exemplar import Exemplar
from weftex.exemplar.turns import as_made_from
from weftex.method import Model
from weftex.prepare.landmarks import find_landmarks, has_joint_network
from weftex.random import draw
from weftex.raster.arrays import Floats, Indices, Ints, Mask
from weftex.raster.masks import grown
from weftex.raster.turning import boxes_of, turned_pixels
from weftex.results.pixels import PixelSynthesis, rearranged
from weftex.results.saved import ABOUT
from weftex.results.synthesis import Synthesis
from weftex.seams.boundary import cut_around
from weftex.search.fft_mismatch import Spectra, correlations, window_mismatch
from weftex.tasks.auto import AutoModel, Findings, look
from weftex.tasks.auto.rule import may_place

Indices = Indices  # of pixels: row * width + column

#: What `synthesize` may do with landmarks.
LANDMARKS = ("auto", "keep", "thin", "remove")
_OVERLAP = 4  # pixels around landmarks within which fillings are cut
_FILLINGS = 2  # of each landmark, so that fillings repeat less, too
_MATCHED = 64  # pixels a side of the copy that parts are found on
_AROUND = 2  # of its pixels around a landmark that match
_TRIED = 4  # parts that are compared in full size
_AVOID = 8  # weight of landmarks, and of parts used before, in the cost of a part
_BESIDE = np.mgrid[-1:2, -1:2].reshape(2, -1).T
_NEVER = np.iinfo(np.int64).max
_FINE = 1 / 8  # scale over the side up to which `auto` thins landmarks, of most materials
_COARSE = 1 / 5  # of ground; and above which only rare landmarks are filled
_MANY = 8  # sample areas of the output below which only rare landmarks are thinned
_AREAS = 4  # sample areas of the output for each time that a rare landmark is shown
#: Distances in shorter sides of the sample: of a landmark from itself, rare or not; up to which
#: landmarks are neighbors; of two neighbors from the same two.
_RARE_APART, _OTHERS_APART, _NEIGHBORS, _PAIRS_APART = 1.0, 0.9, 0.35, 1.5


def remove_landmarks(exemplar: Exemplar) -> Exemplar:
    """Return a sample and its maps with the rare landmarks filled from the rest of them."""
    plain = plain_sample(exemplar, "remove")
    return exemplar if plain is None else plain.exemplar


def plain_sample(exemplar: Exemplar, landmarks: str) -> PlainSample | None:
    """Return a sample with its landmarks filled; None if it has none, or a lattice or rows."""
    if not isinstance(landmarks, str) or landmarks not in LANDMARKS:
        raise wrong_value("landmarks", landmarks, f"one of {', '.join(LANDMARKS)}")
    if exemplar.pieces:
        raise InvalidInputError(
            f"landmarks is {landmarks}; with several samples or rotated copies it must be keep"
        )
    findings = look(exemplar)
    if findings.lattice is not None and may_place(findings.lattice, findings.shape):
        return None
    thin = landmarks == "thin"
    masks, rare = find_landmarks(exemplar, thin and findings.scale <= _COARSE * min(exemplar.shape))
    fillings = _fillings(exemplar, masks, _FILLINGS if thin else 1) if masks else []
    return PlainSample(exemplar, masks, rare, fillings, findings, thin) if fillings else None


def thinned(model: Model, canvas: Canvas) -> PlainSample | None:
    """Return a sample whose landmarks `auto` thins on a canvas; None if it keeps them.

    It keeps those of samples with a lattice, rows, large features or a network of joints, as
    landmarks may be joints there, and where its method mixes patches.
    """
    assert isinstance(model, AutoModel)
    findings, choice = model.findings, model.choose(canvas)
    # What looks the same from all sides is ground, such as leaves: no landmark is part of a whole.
    most = _COARSE if choice.parameters.get("orientations") == "all" else _FINE
    small = findings.scale <= most * min(findings.shape)
    keeps = findings.lattice or findings.rows or not small or choice.method != "graphcut"
    if keeps or has_joint_network(model.exemplar):
        return None
    times = round(math.prod(canvas.shape) / math.prod(findings.shape), 1)
    # In smaller outputs the others may be what the material consists of.
    masks, rare = find_landmarks(model.exemplar, others=times >= _MANY)
    fillings = _fillings(model.exemplar, masks, _FILLINGS) if masks else []
    because = f"landmarks are thinned, because the output has {times:g} times the sample's area"
    plain = PlainSample(model.exemplar, masks, rare, fillings, findings, True, because)
    return plain if fillings else None


def _fillings(exemplar: Exemplar, masks: list[Mask], count: int) -> list[Indices]:
    """Return sources of all pixels with the landmarks filled, each from one part of the sample."""
    filler, index = _Filler(exemplar, masks), _indices(exemplar.shape)
    fillings = [index.copy() for _ in range(count)]
    for mask in masks:
        shifts = filler.shifts(mask, count)
        zone = np.nonzero(grown(mask, _OVERLAP, filler.wrap) & (mask | ~filler.hole))
        for filling, shift in zip(fillings, (shifts * count)[:count], strict=False):
            rows, columns = (at + by for at, by in zip(zone, shift, strict=True))
            filling[zone] = index[rows % index.shape[0], columns % index.shape[1]]
    for filling in fillings:
        moved = filling != index
        new = filler.pixels.reshape(index.size, -1)[filling]
        kept = ~cut_around(filler.pixels, new, moved, filler.hole & moved)
        filling[kept] = index[kept]
    return [filling for filling in fillings if (filling != index).any()]


class _Filler:
    """Finds parts of the sample that fill landmarks, on a smaller copy first."""

    def __init__(self, exemplar: Exemplar, masks: list[Mask]) -> None:
        small, self.step = smaller_copy(exemplar, _MATCHED)
        self.small, self.pixels = small.matching(), exemplar.matching()
        self.wrap, self.hole = (exemplar.tileable,) * 2, np.logical_or.reduce(masks)
        usable = exemplar.usable
        self.spectra = Spectra(self.small, np.ones(small.shape), small.shape)
        self.unknown = self._smaller(self.hole | ~usable)
        self.lost = self._smaller(grown(~usable, _OVERLAP + self.step, self.wrap))
        self.avoided = self._smaller(self.hole).astype(np.int64)  # landmarks, and parts in use

    def _smaller(self, mask: Mask) -> Mask:
        height, width, step = *self.small.shape[:2], self.step
        squares = mask[: height * step, : width * step].reshape(height, step, width, step)
        return np.asarray(squares.any(axis=(1, 3)))

    def shifts(self, mask: Mask, count: int) -> list[Ints]:
        """Return shifts (rows, columns) from a landmark to parts that may fill it; [] if none."""
        size, zone = np.array(self.spectra.size), self._smaller(mask)
        wide = grown(zone, _AROUND, self.wrap)
        ring = wide & ~self.unknown
        known = np.array(np.nonzero(ring)) * self.step
        window = Spectra(self.small, ring, self.spectra.size)
        avoided, lost = correlations(np.stack([self.avoided, self.lost]), zone, self.spectra.size)
        factors = int(zone.sum()) + _AVOID * avoided
        costs = factors * (window_mismatch(self.spectra, window) + 1)
        costs[lost > 0] = _NEVER
        low, high = np.zeros(2, np.int64), size - 1  # of shifts that stay inside
        for axis in (axis for axis in (0, 1) if not self.wrap[axis]):
            lines = np.flatnonzero(wide.any(axis=1 - axis))
            low[axis], high[axis] = -lines[0], size[axis] - 1 - lines[-1]
            outside = np.arange(high[axis] + 1, size[axis] + low[axis])
            costs.swapaxes(0, axis)[outside] = _NEVER
        apart = math.isqrt(int(zone.sum())) // 2 + 1
        _leave_out(costs, (0, 0), apart)
        found: list[Ints] = []
        while len(found) < count and costs.min() < _NEVER:
            tried: list[tuple[int, int]] = []
            while len(tried) < _TRIED and costs.min() < _NEVER:
                tried.append(divmod(int(costs.argmin()), size[1]))
                _leave_out(costs, tried[-1], 1)
            near = np.array(tried)
            near = np.where(near <= high, near, near - size)
            weights = np.array([factors[at] for at in tried])
            found.append(self._refined(known, near, weights, (low, high)))
            at = found[-1] // self.step
            _leave_out(costs, at, apart)
            self.avoided += np.roll(zone, at, (0, 1))
        return found

    def _refined(
        self, known: Ints, shifts: Ints, weights: Ints,
        inside: tuple[Ints, Ints]
    ) -> Ints:  # fmt: skip
        """Return the shift in pixels, near some of the copy, at which known pixels match best."""
        low, high = (self.step * limit for limit in inside)
        shifts, radius, here = shifts * self.step, self.step, self.pixels[tuple(known)]
        while len(shifts) > 1 or radius > 1:
            radius //= 2
            shifts = np.clip((shifts[:, None] + radius * _BESIDE).reshape(-1, 2), low, high)
            rows, columns = (
                (at + by[:, None]) % side
                for at, by, side in zip(known, shifts.T, self.hole.shape, strict=True)
            )
            differences = self.pixels[rows, columns].astype(np.int64) - here
            mismatch = (differences**2).sum(axis=(1, 2)) + 1
            best = int((mismatch.reshape(len(weights), -1) * weights[:, None]).argmin())
            shifts, weights = shifts[[best]], weights[[best // len(_BESIDE)]]
        result: Ints = shifts[0]
        return result


def _leave_out(costs: Ints, place: Any, reach: int) -> None:
    """Mark the costs around a place, across the borders."""
    around = np.arange(-reach, reach + 1)
    costs[np.ix_(*((at + around) % n for at, n in zip(place, costs.shape, strict=True)))] = _NEVER


def _indices(shape: tuple[int, ...]) -> Indices:
    return np.arange(math.prod(shape), dtype=np.int32).reshape(shape)


@dataclass(frozen=True)
class PlainSample:
    """A sample and fillings of its landmarks."""

    original: Exemplar
    masks: list[Mask]  # of landmarks, the rare ones first
    rare: int
    fillings: list[Indices]
    findings: Findings  # of the original
    thin: bool  # whether outputs show some landmarks
    because: str = ""  # said beside the reason of `auto`

    @cached_property
    def exemplar(self) -> Exemplar:
        """The sample with its rare landmarks filled; methods cut around the others."""
        return rearranged(self.original, self._filled(self.rare))

    def inform(self, model: Model) -> None:
        """Make `auto` choose as for the original."""
        if isinstance(model, AutoModel):
            model.findings = self.findings

    @cached_property
    def _zones(self) -> list[NDArray[np.intp]]:
        """For each landmark, the pixels that fillings change: its own and those of cuts near it."""
        free = np.logical_or.reduce([f != _indices(f.shape) for f in self.fillings])
        zones = []
        for mask in self.masks:
            zone = grown(mask, _OVERLAP, (self.original.tileable,) * 2) & free
            free &= ~zone
            zones.append(np.flatnonzero(zone))
        return zones

    def _filled(self, count: int) -> Indices:
        """Return the first filling of the first landmarks, and the sample elsewhere."""
        filled = _indices(self.original.shape)
        for zone in self._zones[:count]:
            filled.ravel()[zone] = self.fillings[0].ravel()[zone]
        return filled

    def finished(self, made: Synthesis, seed: int) -> Synthesis:
        """Return an output of the plain sample with sources in the original, and some landmarks.

        Where patches are mixed it stays an output of the plain sample.
        """
        count = 0
        if isinstance(made, PixelSynthesis):
            picture = as_made_from(self.original, made.turn)
            place, copy, there = _copies(picture)
            plain = self._filled(len(self.masks) if self.thin else self.rare).ravel()
            index = np.where(made.index < 0, -1, there[copy[made.index], plain[place[made.index]]])
            most = max(1, index.size // (_AREAS * math.prod(self.original.shape)))
            spacing = _Spacing(made.canvas, min(self.original.shape), most, self.rare)
            found = list(_occurrences(made, self._zones, there, picture.shape[1]))
            corners = np.array([where[:3] for where in found if self.thin]).reshape(-1, 3)
            for k in np.argsort(draw(seed, "landmarks", *corners.T), kind="stable"):
                zone, row, column, number, pixels, inside = found[k]
                source = self._zones[zone][inside]
                if spacing.take(zone, row, column):
                    count += 1
                else:
                    which = draw(seed, "filling", zone, row, column) % len(self.fillings)
                    source = self.fillings[int(which)].ravel()[source]
                index[pixels] = there[number, source]
            about = {name: getattr(made, name) for name in (*ABOUT, "threads")}
            made = PixelSynthesis(made.canvas, index, exemplar=picture, **about)
        made.provenance["landmarks"] = {"found": len(self.masks), "rare": self.rare, "shown": count}
        if self.because:
            made.provenance["reason"] = f"{made.provenance['reason']}; {self.because}"
        return made


def _copies(picture: Exemplar) -> tuple[Indices, Indices, Indices]:
    """Return the place in the sample and the copy of each pixel of a picture of turned copies.

    Also, for each copy and place in the sample, the index in the picture.
    """
    shape = picture.copy_shape or picture.shape
    place, boxes = _indices(shape), [(0, 0, *shape)]
    if picture.turn is not None:
        place = turned_pixels(place, picture.turn)
        boxes = [box for _, box in boxes_of(picture.turn, shape)]
    number, there = np.zeros(place.shape, np.int32), np.empty((len(boxes), math.prod(shape)), int)
    for copy, (top, left, height, width) in enumerate(boxes):
        box = np.s_[top : top + height, left : left + width]
        number[box] = copy
        there[copy, place[box]] = _indices(place.shape)[box]
    return place.ravel(), number.ravel(), there.astype(np.int32)


def _occurrences(
    made: PixelSynthesis, zones: list[NDArray[np.intp]], there: Indices, width: int
) -> Iterator[tuple[int, int, int, int, Any, Mask]]:
    """Yield where an output shows a zone in one piece, but for what lies beyond its border.

    Zone, row and column, copy; rows and columns of its pixels; which of the zone's pixels they are.
    """
    shapes: list[tuple[int, int, Indices, Ints]] = []
    anchors = np.full(there.max() + 1, -1, np.int32)
    for zone, copy in np.ndindex(len(zones), len(there)):
        index = there[copy, zones[zone]]
        if len(index):
            at = np.stack(np.divmod(index, width))
            middle = int(np.square(at - at.mean(axis=1, keepdims=True)).sum(axis=0).argmin())
            anchors[index[middle]] = len(shapes)
            shapes.append((zone, copy, index, at - at[:, middle, None]))
    shown_here = np.where(made.index < 0, -1, anchors[made.index])
    size, wrap = (np.array(pair)[:, None] for pair in (made.shape, made.canvas.wrap))
    for row, column in np.argwhere(shown_here >= 0).tolist():
        zone, copy, index, apart = shapes[shown_here[row, column]]
        at = apart + [[row], [column]]
        inside = (wrap | ((at >= 0) & (at < size))).all(axis=0)
        rows, columns = (at % size)[:, inside]
        if (made.index[rows, columns] == index[inside]).all():
            yield zone, row, column, copy, (rows, columns), inside


class _Spacing:
    """Where landmarks may be shown so that neither they nor pairs of neighbors repeat nearby."""

    def __init__(self, canvas: Canvas, side: int, most: int, rare: int) -> None:
        self.canvas, self.side, self.most, self.rare = canvas, side, most, rare
        self.kept = np.empty((0, 3), np.int64)  # zone, row and column
        self.pairs: dict[tuple[int, int], list[tuple[int, int]]] = {}

    def take(self, zone: int, row: int, column: int) -> bool:
        """Decide whether to show a landmark, and remember it."""
        apart, own = self._apart(self.kept[:, 1:], row, column), self.kept[:, 0] == zone
        if (apart[own] < (_RARE_APART if zone < self.rare else _OTHERS_APART)).any():
            return False
        if zone < self.rare and own.sum() >= self.most:
            return False
        near = self.kept[~own & (apart < _NEIGHBORS), 0].tolist()
        pairs = [self.pairs.setdefault((min(zone, one), max(zone, one)), []) for one in near]
        for pair in pairs:
            again = self._apart(np.array(pair).reshape(-1, 2), row, column) < _PAIRS_APART
            if len(pair) >= self.most or again.any():
                return False
        for pair in pairs:
            pair.append((row, column))
        self.kept = np.concatenate([self.kept, [[zone, row, column]]])
        return True

    def _apart(self, places: Ints, row: int, column: int) -> Floats:
        """Return distances of places (N, 2), in sides of the sample, across borders that wrap."""
        far = np.abs(places - (row, column))
        round_ = np.where(self.canvas.wrap, self.canvas.shape - far, far)
        result: Floats = np.sqrt((np.minimum(far, round_) ** 2).sum(axis=1))
        return result / self.side
