"""Fill holes of a photo from their surroundings, or from a separate sample."""

from __future__ import annotations

import math
import os
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import starmap
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.relief import means, smaller_copy
from weftex.canvas import Canvas, as_canvas
from weftex.errors import InvalidInputError, is_whole, shown, size_words
from weftex.exemplar import Exemplar, load_exemplar
from weftex.naming import is_auto, make_method, method_for_task
from weftex.prepare.combining import paired
from weftex.progress import Progress, listening
from weftex.random import seed_number
from weftex.raster.arrays import Mask, as_array
from weftex.raster.boxes import AROUND, cell_sums, holes_in
from weftex.raster.masks import grown
from weftex.registry import AUTO, FOR_HOLES
from weftex.results.pixels import PixelSynthesis
from weftex.results.saved import in_common
from weftex.seams.boundary import cut_around

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from weftex.exemplar import Sample
    from weftex.io.pictures import Picture
    from weftex.method import Method
    from weftex.progress import ProgressCallback
    from weftex.random import Seed
    from weftex.results.synthesis import Synthesis

    #: A path, a PIL image or a bool array (H, W), True where the photo is to be filled.
    Hole = str | os.PathLike[str] | Mask | Any

#: Pixels around a hole that are used at least; more if the method needs them.
_LEAST_REACH = 256
#: Usable pixels near holes that patches come from. More are slower and look less like the place.
_NEIGHBORHOOD = 2**20
_LARGE = 5 * 2**18  # pixels around all holes from which on they are filled in groups
_SQUARE = 512  # pixels a side; holes whose middles are in the same square are one group
_MARGIN = 1024  # pixels around a group that sources are looked for in
_LARGE_HOLE = 2**18  # pixels of a group of holes from which on a smaller copy is filled
_CELL = 16  # pixels a side; the neighborhood grows by whole cells


def fill(
    photo: Sample,
    mask: Hole | None = None,
    *,
    sample: Sample | None = None,
    method: str | Method = AUTO,
    overlap: int = 0,
    match_tone: bool | None = None,
    seed: Seed = None,
    tileable: bool | str = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    **parameters: Any,
) -> Synthesis:
    """Fill the holes of a photo; without `overlap`, every other pixel stays exactly as it is.

    Patches come from `sample`, or from the million pixels of the photo nearest to the holes ("auto"
    fills holes that are far apart each by itself). The maps of a map set are matched and filled
    together: see `Synthesis.maps`.

    Parameters
    ----------
    photo : path, array, PIL image or Exemplar
        The photo with holes. Values inside them are ignored; mask NaN and infinity, as
        with `numpy.ma.masked_invalid`.
    mask : path, PIL image or bool array (H, W), optional
        True, or white in an image, where the photo is to be filled. A copy of the photo with
        transparent holes is also accepted. By default, all pixels that are not fully opaque.
    sample : path, array, PIL image or Exemplar, optional
        Take patches from this sample instead of the photo. It must have the photo's dtype and
        channels, and maps of the same roles.
    method : str or Method
        "auto", a name in `weftex.METHODS`, or a method with its parameters. "auto" is `graphcut`
        with what suits the photo; if `sample` or `parameters` are given, `patch-sampling`. The
        result's `provenance` has the reason.
    overlap : int
        Width in pixels of a strip around the holes that may change too. The boundary between photo
        and filling is cut inside it, so that it does not follow the outline of the mask.
    match_tone : bool, optional
        Match the tone of the filling to the tone around the hole, if they differ by more than the
        texture itself varies. By default only if `method` is "auto" and no `parameters` are given.
    seed : int, numpy Generator or None
        The same seed gives the same bytes, with any number of threads.
    tileable : bool or {"x", "y"}
        Axes along which the photo repeats without a seam, so that holes may cross its border.
    threads : int, optional
        Maximum number of threads; one for each processor by default.
    progress : callable, optional
        See `weftex.progress.ProgressCallback`; the preview shows the surroundings of the holes.
    **parameters
        Parameters of the method. In holes, `patch-sampling` has the defaults `boundary_width` 4,
        `epsilon` 0.02, `candidates` 400, and `patch_size` 48 to 128, two fifths of a hole's width;
        but at most a fifth of the photo's side, and less if few whole patches fit outside.

    Returns
    -------
    Synthesis
        The filled photo. If the mask is empty, `image` equals the photo.

    Raises
    ------
    InvalidInputError
        If sizes, dtypes or channels differ, or no pixel outside the mask can be copied.
    UnsupportedError
        If the method does not fill holes.
    FileError
        If a file cannot be read.
    CancelledError
        If `progress` returned False.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> photo = weftex.read_image("sample:pebbles").pixels
    >>> hole = np.zeros(photo.shape[:2], bool)
    >>> hole[60:100, 70:130] = True
    >>> result = weftex.fill(photo, hole, seed=7)
    >>> bool((result.image[~hole] == photo[~hole]).all())
    True
    """
    by_auto = is_auto(method) and not parameters
    chosen = method_for_task("fill", FOR_HOLES, method, parameters)
    if not is_whole(overlap, 0):
        raise InvalidInputError(f"overlap is {overlap!r}; it must be a whole number, 0 or more")
    if match_tone is not None and not isinstance(match_tone, bool):
        raise InvalidInputError(f"match_tone is {shown(match_tone)}; it must be True or False")
    seed = seed_number(seed)
    photo = load_exemplar(photo)
    masked = hole_of(mask, photo)
    wrap = as_canvas(photo.shape, tileable).wrap
    hole = grown(masked, int(overlap), wrap) if overlap else masked
    inside = sample is None
    photo, source = (photo, photo) if inside else _load_sample(sample, photo)
    around: dict[str, Any] = {"known_from": (0, 0)} if inside else {"known_maps": photo.maps}
    canvas = Canvas(*photo.shape, wrap, photo.pixels, hole, **around)
    chosen.require(canvas)
    if not hole.any():
        index, said = np.full(canvas.shape, -1, np.int32), chosen.describe() | {"seed": seed}
        about: dict[str, Any] = {"known_from": canvas.known_from, "provenance": said}
        return PixelSynthesis(canvas, index, exemplar=source, **about)
    if inside and hole.all():
        raise InvalidInputError(
            f"the mask{' and the overlap cover' if overlap else ' covers'} all of {photo.name}; "
            "no pixels are left to copy from; give another image (--sample)"
        )
    # What was given stays; a method that is an object was given with all its values.
    given = frozenset(parameters) if isinstance(method, str) or is_auto(method) else None
    filling = _Filling(chosen, by_auto and inside, given, int(overlap), seed, threads, progress)
    with listening(progress):
        result = filling.of(photo, source, masked, canvas)
    if overlap:
        result.provenance["overlap"] = int(overlap)
    result.match_tone = by_auto if match_tone is None else match_tone
    return result


@dataclass(frozen=True)
class _Filling:
    """How holes are filled: in groups, from a smaller copy, or all at once."""

    chosen: Method
    by_auto: bool  # with what suits the photo around the holes, where it can
    given: frozenset[str] | None  # parameters that stay
    overlap: int
    seed: int
    threads: int | None
    progress: ProgressCallback | None

    def of(self, photo: Exemplar, source: Exemplar, masked: Mask, canvas: Canvas) -> Synthesis:
        """Fill the hole of the canvas: `masked` anew, the rest only where that fits better."""
        if self.by_auto:
            with suppress(InvalidInputError):  # too few pixels are left for a part
                groups = _groups_of(_hole(canvas), canvas.wrap)
                if len(groups) > 1:
                    return self._by_groups(photo, masked, canvas, groups)
        return self._group(photo, source, masked, canvas)

    def _by_groups(
        self, photo: Exemplar, masked: Mask, canvas: Canvas, groups: list[NDArray[np.int_]]
    ) -> Synthesis:
        """Fill each group of holes from its own part of the photo."""
        hole, index = _hole(canvas), np.full(canvas.shape, -1, np.int32)
        left, cut = hole.copy(), np.zeros_like(hole)
        canvas = replace(canvas, hole=cut)
        whole = PixelSynthesis(canvas, index, exemplar=photo, known_from=canvas.known_from)
        steps = Progress(self.progress, len(groups), "holes", whole.render)
        by, told = replace(self, progress=steps.within()), []
        for boxes in groups:
            first, last = boxes[..., 0], boxes[..., 1]
            reach = np.maximum((last - first) // 2, AROUND)
            low, high = (first - reach).min(axis=0).clip(0), (last + reach).max(axis=0)
            corner = (low - _MARGIN).clip(0).tolist()
            crop = itemgetter(tuple(map(slice, corner, high + _MARGIN)))  # returns a view
            marked, matched = np.zeros_like(hole), np.zeros_like(hole)
            for box in boxes:
                marked[tuple(starmap(slice, box))] = True
            matched[tuple(map(slice, low, high))] = True
            own, missing = crop(left & marked), crop(hole & matched)
            crop(left)[own] = False
            usable = crop(photo.usable) & (missing | ~crop(hole))
            part = _cropped(photo, crop).changed(mask=usable)
            around = Canvas(*part.shape, canvas.wrap, part.pixels, missing, (0, 0))
            made = by._group(part, part, crop(masked) & missing, around)
            if not isinstance(made, PixelSynthesis):
                raise InvalidInputError("too few pixels are left around a group of holes")
            found = made.moved(made.canvas, photo, to=(0, 0), source_to=corner).arrays()["index"]
            crop(index)[own], crop(cut)[own] = found[own], _hole(made.canvas)[own]
            told.append(made.provenance)
            steps.advance(1)
        whole.provenance = in_common(told)
        return whole

    def _group(self, photo: Exemplar, source: Exemplar, masked: Mask, canvas: Canvas) -> Synthesis:
        """Fill holes that are near each other, large ones with the sources of a smaller copy."""
        hole = _hole(canvas)
        step = math.ceil(math.sqrt(hole.sum() / _LARGE_HOLE))
        if self.by_auto and step > 1 and not any(canvas.wrap):
            largest = -(-max(photo.shape) // step)
            small, step = smaller_copy(_cropped(photo, np.array, masked), largest)  # a copy
            usable = means(photo.usable & ~hole, step) == 1
            missing, anew = (means(mask, step) > 0 for mask in (hole, masked))
            small = small.changed(mask=usable | missing)
            whole = Canvas(*small.shape, canvas.wrap, small.pixels, missing, (0, 0))
            by = replace(self, overlap=-(-self.overlap // step))
            with suppress(InvalidInputError):  # too few pixels are left of it
                made = by._at_once(small, small, anew, whole)
                if isinstance(made, PixelSynthesis):
                    return made.enlarged(canvas, photo, step)
        return self._at_once(photo, source, masked, canvas)

    def _at_once(
        self, photo: Exemplar, source: Exemplar, masked: Mask, canvas: Canvas
    ) -> Synthesis:
        """Fill holes from the million usable pixels nearest to them, or from another source."""
        hole, inside = _hole(canvas), source is photo
        usable = ~hole & source.usable if inside else source.usable
        reach = max(_LEAST_REACH, self.chosen.hole_reach)
        region = Region(hole, canvas.wrap, usable if inside else None, reach)
        if inside:
            usable = region.crop(usable) & region.near
        cropped = _cropped(photo, region.crop, masked)
        # On bytes, which distances are taken on anyway, the maps have a say about known pixels too.
        features = cropped.matching() if inside else source.matching_of(cropped)
        supply = Exemplar(
            features if inside else source.matching(),
            mask=usable,
            tileable=source.tileable and (region.whole or not inside),
            alpha=False,
            name=source.name,
        )
        missing, anew = region.crop(hole), region.crop(masked)
        cropped_canvas = Canvas(*cropped.shape, region.wrap, features, missing, canvas.known_from)
        own = np.arange(missing.size, dtype=np.int32).reshape(missing.shape)

        def filled(
            by: Method, given: frozenset[str] | None, supply: Exemplar = supply
        ) -> Synthesis:
            fitted, begun = supply, cropped_canvas
            if self.overlap and inside and by.cuts_known:
                # The method cuts between the photo and its patches itself, by all that is there.
                border = region.near & region.crop(hole & ~masked & source.usable)
                fitted = supply.changed(mask=supply.usable | border)
                begun = replace(begun, shown=np.where(anew, np.int32(-1), own))
            model = by.for_hole(missing, supply.usable, given).fit(fitted)
            return model.sample(begun, seed=self.seed, threads=self.threads, progress=self.progress)

        made = None
        if self.by_auto:
            from weftex.prepare.landmarks import landmarks_shown_again
            from weftex.tasks.auto.rule import WHOLE, choose_for_hole

            choice = choose_for_hole(supply, cropped_canvas)
            with suppress(InvalidInputError):  # too few pixels are left for it
                by = make_method(choice.method, choice.parameters)
                made = filled(by, None)
                if choice.parameters == WHOLE and isinstance(made, PixelSynthesis):
                    again = landmarks_shown_again(supply, missing, made.index, region.wrap)
                    if again is not None:
                        made = filled(by, None, supply.changed(mask=usable & ~again))
            if made is not None:
                made.provenance["reason"] = choice.reason
        if made is None:
            made = filled(self.chosen, self.given)
        if self.overlap:
            if isinstance(made, PixelSynthesis) and made.canvas.shown is not None:
                cut = missing & (made.index != own)
            else:
                cut = cut_around(features, made.image.reshape(features.shape), missing, anew)
            canvas = replace(canvas, hole=region.put(cut, hole.shape))
        source_to = region.corner if inside else (0, 0)
        return made.moved(canvas, source, to=region.corner, source_to=source_to)


def _groups_of(hole: Mask, wrap: tuple[bool, bool]) -> list[NDArray[np.int_]]:
    """Return boxes around holes, (n, 2, 2) for each group; one group if all are near."""
    holes = np.array(holes_in(hole, wrap))
    spans = holes[..., 1].max(axis=0) - holes[..., 0].min(axis=0) + 2 * _LEAST_REACH
    if spans.prod() <= _LARGE:
        return [holes]
    squares = holes.sum(axis=2) // 2 // _SQUARE
    _, numbers = np.unique(squares, axis=0, return_inverse=True)
    return [holes[numbers == number] for number in range(numbers.max() + 1)]


def _cropped(
    photo: Exemplar, crop: Callable[[NDArray[Any]], NDArray[Any]], blank: Mask | None = None
) -> Exemplar:
    """Return a part of a photo and its maps; `blank` pixels get the value of another pixel."""
    empty = None if blank is None else crop(blank)

    def part_of(pixels: NDArray[Any]) -> NDArray[Any]:
        part = crop(pixels)
        # What marks a hole, such as white, must not stretch the range of values.
        if empty is not None and not empty.all():
            part[empty] = part[np.unravel_index(int(empty.argmin()), empty.shape)]
        return part

    return Exemplar(
        part_of(photo.pixels),
        maps={key: part_of(photo.aligned(key)) for key in photo.maps},
        weights=photo.weights,
        alpha=photo.alpha,
        name=photo.name,
    )


def _hole(canvas: Canvas) -> Mask:
    """Return the hole of a canvas that has one."""
    assert canvas.hole is not None
    return canvas.hole


def hole_of(mask: Hole | Picture | None, photo: Exemplar) -> Mask:
    """Return where a photo is to be filled, bool (H, W); see `fill`."""
    if mask is None:
        return transparent(photo)
    if isinstance(mask, (str, os.PathLike)):
        from weftex.io.pictures import read_image

        mask = read_image(mask)
    image: Any = mask
    if hasattr(image, "getbands"):  # of PIL
        alpha = "A" in image.getbands() or "transparency" in image.info
        image = load_exemplar(image.convert("RGBA" if alpha else "L"))
    if hasattr(image, "pixels"):
        hole = _hole_in(image.pixels, image.alpha, photo)
    else:
        hole = as_array(mask, "mask")
    if hole.dtype != bool or hole.ndim != 2:
        raise InvalidInputError(
            f"mask is {hole.dtype} with {hole.ndim} dimensions; it must be boolean with 2, "
            "True where the photo is to be filled, such as mask > 127"
        )
    if hole.shape != photo.shape:
        raise InvalidInputError(
            f"mask is {size_words(hole.shape)}, {photo.name} is {size_words(photo.shape)}; scale "
            "or crop the mask to the size of the photo"
        )
    return hole


def _hole_in(pixels: NDArray[Any], alpha: bool, photo: Exemplar) -> Mask:
    """Return the mask of a picture: its white, or its transparency if it is the cut-out photo."""
    from weftex.io.pictures import mask_of

    if alpha and pixels.shape[:2] == photo.shape and pixels.dtype == photo.pixels.dtype:
        clear = _clear(pixels)
        own = photo.pixels.reshape(*photo.shape, -1)[..., : photo.channels - photo.alpha]
        color = pixels[..., :-1]
        if clear.any() and color.shape == own.shape and (color == own)[~clear].all():
            return clear
    return mask_of(pixels, alpha)


def transparent(photo: Exemplar, flag: str = "--mask") -> Mask:
    """Return where a photo is not fully opaque, instead of the mask of an option."""
    if not photo.alpha or not (hole := _clear(photo.pixels)).any():
        raise InvalidInputError(f"{photo.name} has no transparent pixels; give a mask ({flag})")
    return hole


def _clear(pixels: NDArray[Any]) -> Mask:
    """Return where alpha is less than full."""
    full = 1 if pixels.dtype.kind == "f" else np.iinfo(pixels.dtype).max
    clear: Mask = pixels[..., -1] < full
    return clear


def _load_sample(sample: Sample, photo: Exemplar) -> tuple[Exemplar, Exemplar]:
    """Return the photo and the sample that fills it, with the same maps."""
    source = load_exemplar(sample)
    kinds = [f"{e.pixels.dtype} with {e.channels} channels" for e in (source, photo)]
    if kinds[0] != kinds[1]:
        raise InvalidInputError(
            f"the sample {source.name} is {kinds[0]}, the photo {photo.name} is {kinds[1]}; "
            "they must be equal"
        )
    pair, _ = paired([photo, source])
    lacking = [name for name in photo.maps if name not in pair[1].maps]
    if lacking:
        raise InvalidInputError(
            f"{photo.name} has maps, and the sample {source.name} has no {', '.join(lacking)} to "
            "fill them with"
        )
    return pair[0], pair[1]


class Region:
    """The part of a photo that is used to fill its holes."""

    def __init__(
        self, hole: Mask, wrap: tuple[bool, bool], usable: Mask | None, reach: int
    ) -> None:
        cells = cell_sums(hole, _CELL) > 0
        supply = np.zeros(cells.shape, np.int64) if usable is None else cell_sums(usable, _CELL)
        steps = -(-reach // _CELL)
        near = grown(cells, steps, wrap)
        if usable is not None:
            while not near.all():
                wider = grown(near, max(1, steps // 8), wrap)
                if supply[wider].sum() > _NEIGHBORHOOD:
                    break
                near = wider
        near = near.repeat(_CELL, 0).repeat(_CELL, 1)[: hole.shape[0], : hole.shape[1]]
        spans = [_span(np.any(near, axis=1 - axis), wrap[axis]) for axis in (0, 1)]
        self._rows, self._columns = (
            np.arange(start, start + length) % full
            for (start, length), full in zip(spans, hole.shape, strict=True)
        )
        full = [length == side for (_, length), side in zip(spans, hole.shape, strict=True)]
        self.whole = all(full)
        self.wrap = (wrap[0] and full[0], wrap[1] and full[1])
        self.corner = (int(self._rows[0]), int(self._columns[0]))
        self.near = self.crop(near)

    def put(self, part: Mask, shape: tuple[int, int]) -> Mask:
        """Return the mask of the whole photo: `part` in the region, False elsewhere."""
        whole = np.zeros(shape, bool)
        whole[self._rows[:, None], self._columns] = part
        return whole

    def crop(self, pixels: NDArray[Any]) -> NDArray[Any]:
        """Return the region of an array."""
        part: NDArray[Any] = pixels[self._rows[:, None], self._columns]
        return part


def _span(taken: Mask, wraps: bool) -> tuple[int, int]:
    """Return start and length of the shortest interval that holds all True values."""
    at = np.flatnonzero(taken)
    if not wraps:
        return int(at[0]), int(at[-1] - at[0] + 1)
    gaps = np.diff(at, append=at[0] + len(taken))
    widest = int(gaps.argmax())
    if gaps[widest] == 1:
        return 0, len(taken)
    return int(at[(widest + 1) % len(at)]), int(len(taken) - gaps[widest] + 1)
