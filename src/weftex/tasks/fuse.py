"""Texture fusion: one picture of several materials, where a map says (section 4)."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.scale import dominant_scale
from weftex.canvas import Canvas, as_canvas
from weftex.errors import InvalidInputError, shown
from weftex.exemplar import Exemplar
from weftex.loading import load_exemplar
from weftex.method import Method
from weftex.random import draw, seed_number
from weftex.raster.masks import squared_distance_to
from weftex.results.pixels import PixelSynthesis
from weftex.seams.merge import island
from weftex.tasks.label_map import circle_map, labels_of
from weftex.tasks.method_names import is_auto, make_method

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from weftex.loading import Sample
    from weftex.progress import ProgressCallback
    from weftex.random import Seed

#: The method for fusion; what "auto" stands for here.
DEFAULT = "refinement"

# Labels of mixed regions start here: that of samples a < b of n is _MIXED + a * n + b.
_MIXED = 1 << 16


def fuse(
    samples: Sequence[Sample],
    label_map: Any,
    size: int | tuple[int, int] | None = None,
    *,
    colors: Sequence[Any] | None = None,
    mixed: Mapping[Any, tuple[int, int]] | None = None,
    method: str | Method = DEFAULT,
    seed: Seed = None,
    tileable: bool | str = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    **parameters: Any,
) -> PixelSynthesis:
    """Make a picture of several materials that merge where a map says.

    Each region of the map is made from its own sample. Along the boundaries lie belts, half as
    wide as the larger window of the two; they are made last, with that window, from a sample that
    is merged of the two along a minimum cut, and see what is on both sides.

    Parameters
    ----------
    samples : sequence of path, array, PIL image or Exemplar
        Two or more, of one dtype and number of channels.
    label_map : path, array, PIL image or "gradient"
        A picture with one color for each sample; an integer array (H, W) of labels from 0; or
        "gradient", which goes over from the first of two samples at the top to the second.
    size : int or (int, int), optional
        Height and width of the output: those of the map by default, and needed with "gradient".
    colors : sequence of colors, optional
        The map's color for each sample; by default in order of appearance, from the upper left
        corner row by row.
    mixed : mapping of color to (int, int), optional
        Further colors, or labels, whose regions are made of two samples merged: their numbers.
    method : str or Method
        A name in `weftex.METHODS`, or a method with its parameters, that copies single pixels and
        fills holes. Belts get its larger `window_width`, where it has one.
    seed : int, numpy Generator or None
        The same seed gives the same bytes.
    tileable : bool or {"x", "y"}
        Axes that are to repeat without a seam; the map is taken to go around there.
    threads : int, optional
        At most so many.
    progress : callable, optional
        See `weftex.progress.ProgressCallback`.
    **parameters
        Of the method.

    Returns
    -------
    PixelSynthesis
        Its exemplar is the samples one under the other, see `combined`.

    Raises
    ------
    InvalidInputError
        If samples differ in kind, a color has no sample or a sample no color, the map is of
        another size, or a region is nowhere wider than its belts.
    UnsupportedError
        If the method blends, or does not fill holes.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> labels = np.repeat([[0], [1]], 40, axis=0) * np.ones((1, 90), int)
    >>> weftex.fuse(["sample:pebbles", "sample:leaves"], labels, seed=7).image.shape
    (80, 90, 3)
    """
    number = seed_number(seed)
    method = DEFAULT if is_auto(method) else method
    chosen = make_method(method, parameters)
    if not isinstance(samples, (list, tuple)):
        raise InvalidInputError(f"samples is {shown(samples)}; it must be a list of samples")
    if colors is not None and not isinstance(colors, (list, tuple, range)):
        raise InvalidInputError(f"colors is {shown(colors)}; it must be a list of colors")
    if mixed is not None and not isinstance(mixed, Mapping):
        raise InvalidInputError(
            f"mixed is {shown(mixed)}; it must be pairs of samples by their colors"
        )
    exemplars = [load_exemplar(sample) for sample in samples]
    _check_kinds(exemplars)
    whole = combined(exemplars)
    scales = [dominant_scale(exemplar).window_width for exemplar in exemplars]
    labels = _labels(label_map, size, exemplars, scales, (colors, mixed or {}), number)
    shape = labels.shape[0], labels.shape[1]
    canvas = as_canvas(shape, tileable)
    chosen.require_kind("many")
    chosen.require(canvas)
    fusion = _Fusion(whole, exemplars, chosen, scales, canvas, number, threads, progress)
    return PixelSynthesis(
        canvas,
        fusion.run(labels),
        sample_shape=whole.shape,
        exemplar=whole,
        provenance=chosen.describe() | {"seed": number, "samples": [e.name for e in exemplars]},
    )


def combined(exemplars: Sequence[Exemplar]) -> Exemplar:
    """Put samples one under the other, so that one source map can point into all of them.

    Parameters
    ----------
    exemplars : sequence of Exemplar
        Of one kind; maps that all of them have come along.

    Returns
    -------
    Exemplar
        As wide as the widest; its mask leaves out what lies beside a narrower one.
    """
    width = max(e.shape[1] for e in exemplars)

    def joined(pictures: list[NDArray[Any]]) -> NDArray[Any]:
        padded = [
            np.pad(p, [(0, 0), (0, width - p.shape[1]), *[(0, 0)] * (p.ndim - 2)], mode="edge")
            for p in pictures
        ]
        return np.concatenate(padded)

    inside = [np.arange(width) < np.full((e.shape[0], 1), e.shape[1]) for e in exemplars]
    mask = np.concatenate(inside)
    mask[mask] = np.concatenate(
        [(np.ones(e.shape, bool) if e.mask is None else e.mask).ravel() for e in exemplars]
    )
    shared = [k for k in exemplars[0].maps if all(k in e.maps for e in exemplars)]
    return Exemplar(
        joined([e.pixels for e in exemplars]),
        maps={k: joined([e.maps[k] for e in exemplars]) for k in shared},
        mask=mask,
        alpha=exemplars[0].alpha,
        icc=exemplars[0].icc,
        name="samples",
    )


class _Fusion:
    """One fusion in the making."""

    def __init__(
        self,
        whole: Exemplar,
        exemplars: list[Exemplar],
        method: Method,
        scales: list[int],
        canvas: Canvas,
        seed: int,
        threads: int | None,
        progress: ProgressCallback | None,
    ) -> None:
        self.whole, self.exemplars, self.method, self.scales = whole, exemplars, method, scales
        self.canvas, self.seed = canvas, seed
        self.options: dict[str, Any] = {"threads": threads, "progress": progress}
        self.index = np.full(canvas.shape, -1, np.int32)
        tops = np.cumsum([0] + [e.shape[0] for e in exemplars])
        self.places = [
            ((np.arange(e.shape[0])[:, None] + top) * whole.shape[1] + np.arange(e.shape[1]))
            for e, top in zip(exemplars, tops[:-1], strict=True)
        ]

    def run(self, labels: NDArray[np.int32]) -> NDArray[np.int32]:
        """Regions first, belts after; return what lies where in the stacked samples."""
        regions, pairs = self._belts(labels)
        for k in np.unique(regions[regions >= 0]):
            self._make_region(int(k), regions == k)
        for a, b in itertools.combinations(range(len(self.exemplars)), 2):
            belt = pairs == _MIXED + a * len(self.exemplars) + b
            if belt.any():
                self._fill_belt(a, b, belt)
        return self.index

    def _window(self, *numbers: int) -> int:
        return self.method.window_for(max(self.scales[k] for k in numbers))

    def _belt_width(self, *numbers: int) -> int:
        """A quarter of the window, on each side; a window that fits no sample is refused later."""
        return max(1, min(self._window(*numbers) // 4, sum(self.canvas.shape)))

    def _belts(self, labels: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Labels without belts, and the pair that each pixel of a belt belongs to; else -1."""
        count = len(self.exemplars)
        pairs = np.where(labels >= _MIXED, labels, -1)
        regions = np.where(labels >= _MIXED, -1, labels)
        reach = self._belt_width(*range(count))
        away = np.stack(
            [squared_distance_to(labels == k, reach, self.canvas.wrap) for k in range(count)]
        )
        for k in range(count):
            others = away.copy()
            others[k] = (reach + 1) ** 2
            nearest = others.argmin(axis=0)
            widths = np.array([self._belt_width(k, n) for n in range(count)])
            belt = (labels == k) & (others.min(axis=0) <= widths[nearest] ** 2)
            if belt.any() and np.array_equal(belt, labels == k):
                raise InvalidInputError(
                    f"the region of {self.exemplars[k].name} is nowhere wider than its belts of "
                    f"{2 * widths[nearest[belt]].min()} pixels; make it wider, the map larger, or "
                    "window_width smaller"
                )
            low, high = np.minimum(k, nearest), np.maximum(k, nearest)
            pairs[belt] = (_MIXED + low * count + high)[belt]
            regions[belt] = -1
        return regions.astype(np.int32), pairs.astype(np.int32)

    def _make_region(self, number: int, region: NDArray[np.bool_]) -> None:
        """Make the rectangle around a region from its own sample, and keep the region."""
        canvas, corner = self.canvas, (0, 0)
        if not any(canvas.wrap):
            rows, columns = (np.flatnonzero(region.any(axis=1 - axis)) for axis in (0, 1))
            corner = int(rows[0]), int(columns[0])
            canvas = Canvas(int(rows[-1]) - corner[0] + 1, int(columns[-1]) - corner[1] + 1)
        made = self._sample(self.exemplars[number], canvas, number)
        source = self.places[number].ravel()[made.index]
        area = tuple(slice(c, c + n) for c, n in zip(corner, canvas.shape, strict=True))
        self.index[area] = np.where(region[area], source, self.index[area])

    def _fill_belt(self, a: int, b: int, belt: NDArray[np.bool_]) -> None:
        """Fill the belt between two regions from their merged sample."""
        merged, places = self._merge(a, b)
        known = self.whole.pixels.reshape(-1, *self.whole.pixels.shape[2:])[self.index]
        if self.index.max() < 0:
            known = np.zeros((*self.canvas.shape, *self.whole.pixels.shape[2:]), known.dtype)
        hole = belt | (self.index < 0)
        canvas = Canvas(*self.canvas.shape, self.canvas.wrap, known=known, hole=hole)
        method = self.method.for_belt(self._window(a, b))
        made = self._sample(merged, canvas, _MIXED + a * len(self.exemplars) + b, method)
        self.index = np.where(belt, places.ravel()[made.index], self.index)

    def _merge(self, a: int, b: int) -> tuple[Exemplar, NDArray[np.int32]]:
        """Each sample as an island in the other, one above the other, and where its pixels are."""
        height, width = (
            min(s) for s in zip(*(self.exemplars[k].shape for k in (a, b)), strict=True)
        )
        cut = [self.places[k][:height, :width] for k in (a, b)]
        flat = self.whole.matching().reshape(-1, self.whole.matching().shape[2])
        levels = [flat[place] for place in cut]
        inner = island(levels[0], levels[1]), island(levels[1], levels[0])
        places = np.concatenate(
            [np.where(inner[0], cut[1], cut[0]), np.where(inner[1], cut[0], cut[1])]
        )
        pixels = self.whole.pixels.reshape(-1, *self.whole.pixels.shape[2:])[places]
        mask = np.ones(places.shape, bool)
        # No window may look over the edge from one into the other.
        mask[height] = False
        usable = self.whole.mask
        if usable is not None:
            mask &= usable.ravel()[places]
        name = f"{self.exemplars[a].name} and {self.exemplars[b].name}"
        merged = Exemplar(pixels, mask=mask, alpha=self.whole.alpha, name=name)
        return merged, places.astype(np.int32)

    def _sample(
        self, exemplar: Exemplar, canvas: Canvas, number: int, method: Method | None = None
    ) -> PixelSynthesis:
        seed = int(draw(self.seed, "region", number))
        made = (method or self.method).fit(exemplar).sample(canvas, seed=seed, **self.options)
        assert isinstance(made, PixelSynthesis)
        return made


def _check_kinds(exemplars: list[Exemplar]) -> None:
    if len(exemplars) < 2:
        raise InvalidInputError(f"{len(exemplars)} sample to fuse; give two or more")
    kinds = [f"{e.pixels.dtype} with {e.channels} channels" for e in exemplars]
    for exemplar, kind in zip(exemplars, kinds, strict=True):
        if kind != kinds[0]:
            raise InvalidInputError(
                f"{exemplar.name} is {kind}, {exemplars[0].name} is {kinds[0]}; "
                "all samples must be of one kind"
            )


def _labels(
    label_map: Any,
    size: int | tuple[int, int] | None,
    exemplars: list[Exemplar],
    scales: list[int],
    named: tuple[Sequence[Any] | None, Mapping[Any, tuple[int, int]]],
    seed: int,
) -> NDArray[np.int32]:
    """Numbers of samples, and those of mixed regions."""
    count, (colors, mixed) = len(exemplars), named
    wanted = None if size is None else as_canvas(size).shape
    if isinstance(label_map, str) and label_map == "gradient":
        if count != 2 or wanted is None or colors is not None or mixed:
            raise InvalidInputError(
                "the map 'gradient' takes two samples and the size of the output, and no colors"
            )
        labels = circle_map(wanted, (scales[0] // 2, scales[1] // 2), seed)
        return np.where(labels == 2, _MIXED + 1, labels).astype(np.int32)
    for key, pair in mixed.items():
        pair = pair if isinstance(pair, (list, tuple)) else ()
        if len(set(pair)) != 2 or not set(pair) <= set(range(count)):
            raise InvalidInputError(
                f"mixed[{shown(key)}] is {shown(pair)}; it must be two numbers of samples, "
                f"0 to {count - 1}"
            )
    picture = label_map
    if not (isinstance(label_map, np.ndarray) and label_map.dtype.kind in "iu"):
        picture = load_exemplar(label_map).pixels
    known = [*range(count), *mixed]
    if colors is None and picture.ndim == 2 and np.isin(picture, known).all():
        colors = range(count)
    if colors is None and mixed:
        raise InvalidInputError("give the colors of the samples beside those of mixed regions")
    if colors is not None:
        colors = [*colors, *mixed]
    labels, _ = labels_of(picture, count + len(mixed), colors)
    for number, pair in enumerate(mixed.values()):
        a, b = sorted(pair)
        labels[labels == count + number] = _MIXED + a * count + b
    if wanted is not None and labels.shape != wanted:
        raise InvalidInputError(
            f"the map is {labels.shape[1]}x{labels.shape[0]}, the size {wanted[1]}x{wanted[0]}; "
            "leave size out, or scale the map (nearest neighbor)"
        )
    return labels
