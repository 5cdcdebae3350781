"""Regions of materials and the boundaries between them (the paper on fusion, section 4)."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import Canvas
from weftex.exemplar import Exemplar
from weftex.random import draw
from weftex.raster.masks import grown, squared_distance_to
from weftex.results.pixels import PixelSynthesis
from weftex.seams.boundary import HELD, UNIT, cheapest_boundary
from weftex.seams.merge import islands

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from weftex.method import Method

    #: A sample, or two that are mixed, by their numbers.
    Material = tuple[int, ...]

#: Half the width of a belt, in windows of the coarser of its materials.
BELT = 0.75
_DEPTH = 1.5  # a belt reaches into a region of so many times its own depth; others get less
_PULL = 0.5  # how strongly a boundary is held off the edges of its belt, beside steps
_WANDER = 2.0  # how far it is led astray, in half widths of its belt
_OPEN = 0.05  # the pull at an edge is 1 / _OPEN times that in the middle


@dataclass(frozen=True)
class Fusion:
    """What one fusion is made of.

    Attributes
    ----------
    whole : Exemplar
        The samples one under the other, see `weftex.tasks.fuse.combined`.
    exemplars : sequence of Exemplar
    scales : sequence of int
        The window that follows from each one's dominant scale, in pixels.
    method : Method
    canvas : Canvas
    seed : int
        From `weftex.random.seed_number`.
    reach : int, optional
        Half the width of all belts in pixels; by default by the materials' scales.
    merged : bool
        Whether boundaries are made from merged samples at last.
    options : dict
        `threads` and `progress`.
    """

    whole: Exemplar
    exemplars: Sequence[Exemplar]
    scales: Sequence[int]
    method: Method
    canvas: Canvas
    seed: int
    reach: int | None
    merged: bool
    options: dict[str, Any]

    def run(
        self, labels: NDArray[np.int32], materials: Sequence[Material]
    ) -> NDArray[np.int32]:
        """Return what lies where in the stacked samples.

        Parameters
        ----------
        labels : int32 array (H, W)
            Numbers of materials.
        materials : sequence of Material
        """
        present = np.unique(labels).tolist()
        meeting = Meetings(labels, present, self._reaches(materials), self.canvas.wrap)
        layers = {
            k: self._layer(materials[k], labels == k, meeting.farthest) for k in present
        }
        for a, b in itertools.combinations(present, 2):
            if meeting.have_met(a, b):
                labels = self._settle(a, b, labels, layers, meeting)
        index = np.empty(labels.shape, np.int32)
        for k in present:
            index[labels == k] = layers[k][labels == k]
        return self._fill_belts(index, labels, materials) if self.merged else index

    def window(self, *numbers: int) -> int:
        """Width of the window for the coarsest of these samples."""
        return self.method.window_for(max(self.scales[k] for k in numbers))

    def _reaches(self, materials: Sequence[Material]) -> NDArray[np.int64]:
        """Half the widths of the belts between materials."""
        if self.reach is not None:
            return np.full((len(materials),) * 2, self.reach)
        own = [self.window(*material) for material in materials]
        return np.array([[max(1, round(BELT * max(a, b))) for a in own] for b in own])

    def _layer(
        self, material: Material, region: NDArray[np.bool_], reach: int
    ) -> NDArray[np.int32]:
        """Make a material all over its region and the belts around it; -1 elsewhere."""
        canvas, corner = self.canvas, (0, 0)
        if not any(canvas.wrap):
            spans = []
            for axis, side in enumerate(canvas.shape):
                taken = np.flatnonzero(region.any(axis=1 - axis))
                spans.append((max(0, int(taken[0]) - reach), min(side, int(taken[-1]) + reach + 1)))
            corner = spans[0][0], spans[1][0]
            canvas = Canvas(*(end - start for start, end in spans))
        if len(material) == 1:
            exemplar, places = self.exemplars[material[0]], self._places(material[0])
        else:
            exemplar, places = self._merged_sample(*material)
        made = self._sample(exemplar, canvas, self._number(material))
        layer = np.full(self.canvas.shape, -1, np.int32)
        area = tuple(slice(c, c + n) for c, n in zip(corner, canvas.shape, strict=True))
        layer[area] = places.ravel()[made.index]
        return layer

    def _settle(
        self,
        a: int,
        b: int,
        labels: NDArray[np.int32],
        layers: dict[int, NDArray[np.int32]],
        meeting: Meetings,
    ) -> NDArray[np.int32]:
        """Lay the boundary between two materials where it shows least, within their belt."""
        rows, columns = meeting.span(a, b)
        area = np.ix_(rows, columns)
        wrap = tuple(
            wraps and len(line) == n
            for wraps, line, n in zip(self.canvas.wrap, (rows, columns), labels.shape, strict=True)
        )
        own = labels[area]
        free = ((own == a) | (own == b)) & (layers[a][area] >= 0) & (layers[b][area] >= 0)
        place, reach = meeting.place(a, b, rows, columns)
        astray = wander(own.shape, reach, wrap, int(draw(self.seed, "boundary", a, b)))
        apart = 1 - np.minimum(np.abs(place), 1)
        side = place + _WANDER * apart * astray
        pull = _PULL * UNIT / (reach * (apart + _OPEN)) * side
        leaning = np.where(np.abs(place) < 1, np.rint(pull), np.sign(place) * HELD).astype(np.int32)
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
    ) -> NDArray[np.int32]:
        """Make belts along the boundaries from merged samples, with the window of the larger."""
        flat = self.whole.pixels.reshape(-1, *self.whole.pixels.shape[2:])
        for a, b in itertools.combinations(np.unique(labels).tolist(), 2):
            pair = sorted({*materials[a], *materials[b]})[:2]
            wide = self.window(*pair)
            # "one half of the width of the larger window"
            near = [grown(labels == k, max(1, wide // 4), self.canvas.wrap) for k in (a, b)]
            belt = near[0] & near[1] & ((labels == a) | (labels == b))
            if not belt.any() or belt.all():
                continue
            exemplar, places = self._merged_sample(*pair)
            canvas = Canvas(*self.canvas.shape, self.canvas.wrap, known=flat[index], hole=belt)
            made = self._sample(
                exemplar, canvas, self._number((a, b)), self.method.for_belt(wide)
            )
            index = np.where(belt, places.ravel()[made.index], index)
        return index

    def _places(self, number: int) -> NDArray[np.int32]:
        """Where the pixels of a sample are among all."""
        top = sum(e.shape[0] for e in self.exemplars[:number])
        height, width = self.exemplars[number].shape
        rows = (np.arange(height)[:, None] + top) * self.whole.shape[1]
        return (rows + np.arange(width)).astype(np.int32)

    def _merged_sample(self, a: int, b: int) -> tuple[Exemplar, NDArray[np.int32]]:
        """Each sample with islands of the other, one above the other, and where its pixels are."""
        bytes_of = self.whole.matching().reshape(-1, self.whole.matching().shape[2])
        usable = np.ones(self.whole.shape, bool) if self.whole.mask is None else self.whole.mask
        own = [self._places(k) for k in (a, b)]
        scale = max(1, max(self.scales[k] for k in (a, b)) // 2)
        parts = []
        for n in (0, 1):
            sea, land = own[n], own[1 - n]
            seed = int(draw(self.seed, "islands", self._number((a, b)), n))
            found = islands(
                bytes_of[sea], bytes_of[land], usable.ravel()[land], scale, seed
            )
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
        """A number of its own for each material, for draws."""
        return material[0] if len(material) == 1 else (1 << 16) + material[0] * 4096 + material[1]

    def _sample(
        self, exemplar: Exemplar, canvas: Canvas, number: int, method: Method | None = None
    ) -> PixelSynthesis:
        seed = int(draw(self.seed, "region", number))
        made = (method or self.method).fit(exemplar).sample(canvas, seed=seed, **self.options)
        assert isinstance(made, PixelSynthesis)
        return made


class Meetings:
    """Where regions of a map are near each other, and how far their belts reach.

    Parameters
    ----------
    labels : int32 array (H, W)
    present : sequence of int
        The labels in the map.
    reaches : int array (n, n)
        Half the width of the belt between each two of all labels, in pixels.
    wrap : (bool, bool)
        Whether the map goes around.
    """

    def __init__(
        self,
        labels: NDArray[np.int32],
        present: Sequence[int],
        reaches: NDArray[np.int64],
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

    def _rooms(self, depth: NDArray[np.float64], wrap: tuple[bool, bool]) -> NDArray[np.float64]:
        """How far a belt may reach into each place of a region, so that some of it is left."""
        room = np.zeros(depth.shape)
        reach = float(self.farthest)
        while True:
            deep = np.zeros(depth.shape, bool)
            for k in self._away:
                own = self.labels == k
                inside = own & (depth >= np.ceil(_DEPTH * reach))
                steps = int(np.ceil(_DEPTH * reach))
                deep |= own & (squared_distance_to(inside, steps, wrap) <= steps**2)
            room = np.where((room == 0) & deep, reach, room)
            if reach < 1 or (room > 0).all():
                return np.maximum(room, 0.5)
            reach /= 2

    def have_met(self, a: int, b: int) -> bool:
        """Whether two regions touch, corners included."""
        return bool((self._away[a] + self._away[b] < 2).any())

    def span(self, a: int, b: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows and columns of the belt between two regions, one pixel more on each side."""
        near = np.maximum(self._away[a], self._away[b]) <= self.reaches[a, b] + 1
        lines = []
        for axis in (0, 1):
            taken = np.flatnonzero(near.any(axis=1 - axis))
            lines.append(np.arange(taken[0], taken[-1] + 1))
        return lines[0], lines[1]

    def place(
        self, a: int, b: int, rows: NDArray[np.intp], columns: NDArray[np.intp]
    ) -> tuple[NDArray[np.float64], int]:
        """Where pixels lie in the belt: -1 at its edge in the first region, 1 in the second.

        Also half the width of the belt in pixels.
        """
        area, reach = np.ix_(rows, columns), int(self.reaches[a, b])
        apart = self._away[a][area] - self._away[b][area]
        room = np.minimum(self._room[area], reach)
        return apart / room, reach


def wander(
    shape: tuple[int, ...], cell: int, wrap: tuple[bool, ...], seed: int
) -> NDArray[np.float64]:
    """Smooth noise from -1 to 1, with hills of about `cell` pixels and of half as many.

    Examples
    --------
    >>> hills = wander((40, 50), 10, (False, True), seed=1)
    >>> hills.shape, bool(abs(hills).max() <= 1)
    ((40, 50), True)
    """
    result = np.zeros(shape)
    for octave, weight in enumerate((2 / 3, 1 / 3)):
        size = max(2, cell >> octave)
        whole, part = [], []
        for n, wraps in zip(shape, wrap, strict=True):
            count = max(1, round(n / size)) if wraps else n / size
            at = np.arange(n) * (count / n)
            low = at.astype(np.int64)
            whole.append([low % count, (low + 1) % count] if wraps else [low, low + 1])
            smooth = at - low
            part.append(smooth * smooth * (3 - 2 * smooth))
        total = np.zeros(shape)
        for i, j in np.ndindex(2, 2):
            bits = draw(seed, "hill", octave, whole[0][i][:, None], whole[1][j][None])
            height = (bits >> np.uint64(40)).astype(np.float64) / 2**23 - 1
            v = part[0] if i else 1 - part[0]
            u = part[1] if j else 1 - part[1]
            total += height * v[:, None] * u
        result += weight * total
    return result
