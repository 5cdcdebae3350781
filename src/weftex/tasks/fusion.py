"""Regions of materials and the boundaries between them (the paper on fusion, section 4)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.exemplar import Exemplar
from weftex.method import Method, Model
from weftex.random import draw
from weftex.raster.arrays import Floats, Ints, Mask
from weftex.raster.masks import grown, squared_distance_to
from weftex.results.synthesis import Synthesis
from weftex.seams.boundary import HELD, UNIT, cheapest_boundary
from weftex.seams.merge import islands
from weftex.tasks.auto import Auto, AutoModel
from weftex.tasks.auto.findings import SMALLEST_ANALYZED

#: A sample, or two that are mixed, by their numbers.
Material = tuple[int, ...]

#: Half the width of a belt, in windows of the coarser of its materials.
BELT = 0.25
_PULL = 6.0  # weight of the cost near the edges of a belt, relative to that of steps
_DEPTH = 1.5  # a belt reaches into a region of so many times its own depth; others get less
_OPEN = 0.05  # the cost at an edge is 1 / _OPEN times that in the middle


@dataclass(frozen=True)
class Fusion:
    """The settings of one fusion, and its steps.

    With a `belt_method`, which returns the method for a window width, the boundaries are finally
    synthesized again from merged samples.
    """

    whole: Exemplar  # the samples stacked, see `weftex.prepare.combining.combined`
    exemplars: Sequence[Exemplar]
    window_widths: Sequence[int]  # twice each sample's scale, in pixels
    method: Method
    by_auto: bool  # what suits each sample; `method` is for those of two, and tiny ones
    canvas: Canvas
    seed: int
    reach: int | None  # half the width of all belts; by default by the materials' scales
    belt_method: Callable[[int], Method] | None
    options: dict[str, Any]  # `threads` and `progress`
    told: list[dict[str, Any]] = field(default_factory=list)  # provenances, if `by_auto`

    def run(self, labels: NDArray[np.int32], materials: Sequence[Material]) -> NDArray[np.int32]:
        """Return the source in the stacked samples of each pixel, for labels (H, W)."""
        present = np.unique(labels).tolist()
        meeting = Meetings(labels, present, self._reaches(materials), self.canvas.wrap)
        layers = {k: self._layer(materials[k], labels == k, meeting.farthest) for k in present}
        for a, b in itertools.combinations(present, 2):
            if meeting.have_met(a, b):
                labels = self._settle(a, b, labels, layers, meeting)
        index = np.empty(labels.shape, np.int32)
        for k in present:
            index[labels == k] = layers[k][labels == k]
        if self.belt_method is not None:
            index = self._fill_belts(index, labels, materials, self.belt_method)
        return index

    def window(self, *numbers: int) -> int:
        """Return the width of the window for the coarsest of these samples."""
        return self.method.window_for(max(self.window_widths[k] for k in numbers))

    def _reaches(self, materials: Sequence[Material]) -> Ints:
        """Return half the widths of the belts between materials."""
        if self.reach is not None:
            return np.full((len(materials),) * 2, self.reach)
        # A window wider than the canvas reaches all over it; that it fits no sample is said later.
        most = sum(self.canvas.shape)
        own = [min(self.window(*material), most) for material in materials]
        return np.array([[max(1, round(BELT * max(a, b))) for a in own] for b in own])

    def _layer(self, material: Material, region: Mask, reach: int) -> NDArray[np.int32]:
        """Synthesize a material in its region and the belts around it; -1 elsewhere."""
        canvas, area = self.canvas, np.s_[:, :]
        layer = np.full(canvas.shape, -1, np.int32)
        if not any(canvas.wrap):
            area = _around(region, reach)
            canvas = Canvas(*layer[area].shape)
        if len(material) == 1:
            exemplar, index = self.exemplars[material[0]], self._stacked_index(material[0])
        else:
            exemplar, index = self._merged_sample(*material)
        by_auto = self.by_auto and len(material) == 1 and min(exemplar.shape) >= SMALLEST_ANALYZED
        # The stacked samples have no turned copies.
        model = AutoModel(Auto(), exemplar, upright=True) if by_auto else self.method.fit(exemplar)
        made = self._sampled(model, canvas, self._number(material))
        layer[area] = index[tuple(np.moveaxis(made.source, -1, 0))]
        if self.by_auto:
            notes = made.provenance.get("warnings", ())  # `fuse` has no --fit
            fit = " (--fit uses the nearest)"
            notes = [f"{exemplar.name}: {note.removesuffix(fit)}" for note in notes]
            self.told.append(made.provenance | {"warnings": notes})
        return layer

    def _settle(
        self,
        a: int,
        b: int,
        labels: NDArray[np.int32],
        layers: dict[int, NDArray[np.int32]],
        meeting: Meetings,
    ) -> NDArray[np.int32]:
        """Move the boundary between two materials to the cheapest cut within their belt."""
        area = meeting.belt_box(a, b)
        own, wraps, shape = labels[area], self.canvas.wrap, labels.shape
        wrap = wraps[0] and own.shape[0] == shape[0], wraps[1] and own.shape[1] == shape[1]
        free = ((own == a) | (own == b)) & (layers[a][area] >= 0) & (layers[b][area] >= 0)
        across, half = meeting.across(a, b, area)
        inside = 1 - np.minimum(np.abs(across), 1)
        pull = np.rint(_PULL * UNIT / (half * (inside + _OPEN)) * across)
        leaning = np.where(np.abs(across) < 1, pull, np.sign(across) * HELD).astype(np.int32)
        flat = self.whole.matching().reshape(-1, self.whole.matching().shape[2])
        shown = [flat[np.maximum(layers[k][area], 0)] for k in (a, b)]
        taken = cheapest_boundary(shown[0], shown[1], leaning, free, wrap)
        result = labels.copy()
        result[area] = np.where(free, np.where(taken, b, a), own)
        return result

    def _fill_belts(
        self,
        index: NDArray[np.int32],
        labels: NDArray[np.int32],
        materials: Sequence[Material],
        belt_method: Callable[[int], Method],
    ) -> NDArray[np.int32]:
        """Synthesize belts along the boundaries from merged samples, with the larger window."""
        flat = self.whole.pixels.reshape(-1, *self.whole.pixels.shape[2:])
        for a, b in itertools.combinations(np.unique(labels).tolist(), 2):
            # Two samples are merged; of mixed materials with more, the first two.
            pair = sorted({*materials[a], *materials[b]})[:2]
            width = self.window(*pair)
            # "one half of the width of the larger window", so a quarter to either side
            near = [grown(labels == k, max(1, width // 4), self.canvas.wrap) for k in (a, b)]
            belt = near[0] & near[1] & ((labels == a) | (labels == b))
            if not belt.any() or belt.all():  # nothing to join, or nothing left to join it to
                continue
            exemplar, own = self._merged_sample(*pair)
            canvas = Canvas(*self.canvas.shape, self.canvas.wrap, known=flat[index], hole=belt)
            made = self._sampled(belt_method(width).fit(exemplar), canvas, self._number((a, b)))
            index[belt] = own[tuple(np.moveaxis(made.source[belt], -1, 0))]
        return index

    def _stacked_index(self, number: int) -> NDArray[np.int32]:
        """Return the indices of a sample's pixels in the stacked samples."""
        top = sum(e.shape[0] for e in self.exemplars[:number])
        height, width = self.exemplars[number].shape
        rows = (np.arange(height)[:, None] + top) * self.whole.shape[1]
        return (rows + np.arange(width)).astype(np.int32)

    def _merged_sample(self, a: int, b: int) -> tuple[Exemplar, NDArray[np.int32]]:
        """Return each sample with islands of the other, stacked, and the indices of its pixels."""
        bytes_of = self.whole.matching().reshape(-1, self.whole.matching().shape[2])
        usable = self.whole.usable
        own = [self._stacked_index(k) for k in (a, b)]
        scale = max(1, max(self.window_widths[k] for k in (a, b)) // 2)
        parts = []
        for n in (0, 1):
            sea, land = own[n], own[1 - n]
            seed = int(draw(self.seed, "islands", self._number((a, b)), n))
            found = islands(bytes_of[sea], bytes_of[land], usable.ravel()[land], scale, seed)
            parts.append(np.where(found >= 0, land.ravel()[found], sea))
        # No window may look over the edge from one into the other, or beside the narrower.
        size = sum(p.shape[0] for p in parts) + 1, max(p.shape[1] for p in parts)
        places, mask = np.zeros(size, np.int32), np.zeros(size, bool)
        for top, part in zip((0, parts[0].shape[0] + 1), parts, strict=True):
            area = np.s_[top : top + part.shape[0], : part.shape[1]]
            places[area], mask[area] = part, usable.ravel()[part]
        pixels = self.whole.pixels.reshape(-1, *self.whole.pixels.shape[2:])[places]
        name = f"{self.exemplars[a].name} and {self.exemplars[b].name}"
        return Exemplar(pixels, mask=mask, alpha=self.whole.alpha, name=name), places

    def _number(self, material: Material) -> int:
        """Return a different number for each material, for random draws."""
        return material[0] if len(material) == 1 else (1 << 16) + material[0] * 4096 + material[1]

    def _sampled(self, model: Model, canvas: Canvas, number: int) -> Synthesis:
        """Return the output of a model, with a seed of its own for each number."""
        return model.sample(canvas, seed=int(draw(self.seed, "region", number)), **self.options)


class Meetings:
    """Where regions of a label map are near each other, and how far their belts reach."""

    def __init__(
        self,
        labels: NDArray[np.int32],
        present: Sequence[int],
        reaches: Ints,
        wrap: tuple[bool, bool],
    ) -> None:
        self.labels, self.reaches = labels, reaches
        self.farthest = int(reaches[np.ix_(present, present)].max()) if len(present) > 1 else 0
        far = int(np.ceil(_DEPTH * self.farthest))
        away = {k: squared_distance_to(labels == k, far, wrap) for k in present}
        self._away = {k: np.sqrt(squares) for k, squares in away.items()}
        # To the nearest other region: the second of all, for the own one is at 0.
        depth = np.sqrt(np.sort(np.stack([*away.values()]), axis=0)[min(1, len(present) - 1)])
        self._room = self._rooms(depth, wrap)

    def _rooms(self, depth: Floats, wrap: tuple[bool, bool]) -> Floats:
        """Return how far belts may reach into each pixel of a region, leaving some of it."""
        room = np.zeros(depth.shape)
        reach = float(self.farthest)
        while True:
            steps = int(np.ceil(_DEPTH * reach))
            for k in self._away:
                left = (self.labels == k) & (room == 0)
                if not left.any():
                    continue
                area = _around(left, steps, wrap)
                inside = (self.labels[area] == k) & (depth[area] >= steps)
                deep = squared_distance_to(inside, steps, wrap) <= steps**2
                room[area] = np.where(left[area] & deep, reach, room[area])
            if reach < 1 or (room > 0).all():
                return np.maximum(room, 0.5)
            reach /= 2

    def have_met(self, a: int, b: int) -> bool:
        """Return whether two regions touch, corners included."""
        return bool((self._away[a] + self._away[b] < 2).any())

    def belt_box(self, a: int, b: int) -> tuple[slice, slice]:
        """Return the box of the belt between two regions and one pixel around it."""
        return _around(np.maximum(self._away[a], self._away[b]) <= self.reaches[a, b] + 1)

    def across(self, a: int, b: int, area: tuple[slice, slice]) -> tuple[Floats, Floats]:
        """Return where pixels lie across the belt: -1 at its edge in the first region to 1.

        Also half the width of the belt there, in pixels; it takes few values.
        """
        apart = self._away[a][area] - self._away[b][area]
        room = np.minimum(self._room[area], self.reaches[a, b])
        return apart / room, room


def _around(
    mask: Mask, far: int = 0, wrap: tuple[bool, bool] = (False, False)
) -> tuple[slice, slice]:
    """Return the box of a mask and `far` pixels around it; all of an axis that wraps."""
    spans = []
    for axis, (side, wraps) in enumerate(zip(mask.shape, wrap, strict=True)):
        taken = np.flatnonzero(mask.any(axis=1 - axis))
        low, high = int(taken[0]) - far, int(taken[-1]) + far + 1
        spans.append(slice(0, side) if wraps else slice(max(0, low), min(side, high)))
    return spans[0], spans[1]
