"""A report on how good a result is: pictures, maps of where it fails, every figure."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError, shown
from weftex.exemplar import Exemplar, check_pixels
from weftex.loading import load_exemplar
from weftex.pages.html import as_shown
from weftex.pages.report_page import MapReport, Report
from weftex.quality.assess import LARGEST_MEASURED, assess, made_from, measured, real_crops
from weftex.quality.copying import check_source
from weftex.quality.seams import StepModel, seam_map
from weftex.quality.view import middle, views
from weftex.results.synthesis import Synthesis
from weftex.turns import as_made_from

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from numpy.typing import NDArray

    from weftex.loading import Sample

    Bytes = NDArray[np.uint8]

_SEAM = 0.5  # surprise beyond the usual that is drawn at full strength
_SAME = 2.0  # levels; a picture further than this from that of its source is another one


def report(
    sample: Sample,
    result: Sample | Synthesis,
    source: Synthesis | NDArray[Any] | str | os.PathLike[str] | None = None,
    *,
    tileable: bool | tuple[bool, bool] | None = None,
) -> Report:
    """Measure how good a result is, with pictures of where it fails.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        What the result was made from; see `weftex.load_exemplar`.
    result : path, array, PIL image, Exemplar or Synthesis
        The result, of the sample's dtype and channels. Maps that both have are measured too.
    source : Synthesis, path or array (H, W, 2), optional
        Where each pixel comes from: what `Synthesis.save` wrote, or `Synthesis.source`.
    tileable : bool or (bool, bool), optional
        Whether the vertical and the horizontal axis wrap around; by default as the source says.

    Raises
    ------
    FileError
        If a file cannot be read.
    InvalidInputError
        If result or source do not go with the sample.

    Examples
    --------
    >>> import weftex
    >>> made = weftex.synthesize("sample:weave", 128, method="quilting", seed=1)
    >>> found = report("sample:weave", made)
    >>> found.assessment.flags, sorted(found.maps), "<img" in found.html()
    ((), ['seams', 'source', 'use'], True)
    """
    pair = isinstance(tileable, tuple) and [*map(type, tileable)] == [bool, bool]
    if not (tileable is None or isinstance(tileable, bool) or pair):
        raise InvalidInputError(
            f"tileable is {shown(tileable)}; it must be True, False or two of them"
        )
    exemplar = load_exemplar(sample)
    if isinstance(source, (str, os.PathLike)):
        source = Synthesis.load(source)
    origin = source if isinstance(source, Synthesis) else result
    turn = origin.turn if isinstance(origin, Synthesis) else None
    pictured = as_made_from(exemplar, turn)
    named = "result"
    made_maps: Mapping[str, NDArray[Any]] = {}
    if isinstance(result, Synthesis):
        source = result if source is None else source
        pixels = result.image if result.exemplar is not None else result.render(exemplar)
        made_maps = {} if result.exemplar is None else result.maps
    else:
        made = load_exemplar(result)
        pixels, named, made_maps = made.pixels, made.name, made.maps
    pixels = check_pixels(pixels, "result")
    provenance: dict[str, Any] = {}
    notes: list[str] = []
    if isinstance(source, Synthesis):
        provenance = source.provenance
        tileable = source.canvas.wrap if tileable is None else tileable
        if source.sample_shape != pictured.shape or source.shape != pixels.shape[:2]:
            raise InvalidInputError(
                f"the source makes {_size(source.shape)} from {_size(source.sample_shape)}, but "
                f"result and sample are {_size(pixels.shape)} and {_size(pictured.shape)}"
            )
        notes += _another(source, pictured, pixels)
        source = made_from(source)
    wraps = False if tileable is None else tileable
    found = measured(exemplar, pixels, source, pictured, wraps)
    same = {name: _same_map(name, made_maps) for name in exemplar.maps}
    if source is None:
        notes.append("Without a source, the figures of copying cannot be measured.")
    if max(pixels.shape[:2]) > LARGEST_MEASURED:
        notes.append(
            f"The result is large: only its middle, {LARGEST_MEASURED} pixels a side, was measured."
        )
    if made_maps:
        notes += [f"The result has no {name}." for name, other in same.items() if other is None]
    if min(exemplar.shape) < 64:
        notes.append("The sample is small, so its halves are a weak reference.")
    return Report(
        sample=as_shown(exemplar, exemplar.pixels),
        result=as_shown(exemplar, pixels),
        name=exemplar.name,
        result_name=named,
        assessment=found,
        real=real_crops(exemplar),
        maps=fault_maps(exemplar, pixels, source, pictured),
        provenance=provenance,
        notes=tuple(notes),
        of_maps={
            name: _of_map(exemplar.map(name), made_maps[other], wraps)
            for name, other in same.items()
            if other is not None
        },
    )


def _same_map(name: str, made: Collection[str]) -> str | None:
    """Return the name of a map in the result; normals of either convention match."""
    normals = [other for other in made if {name, other} <= {"normal", "normal_gl", "normal_dx"}]
    return name if name in made else next(iter(normals), None)


def _of_map(own: Exemplar, made: NDArray[Any], tileable: bool | tuple[bool, bool]) -> MapReport:
    """Measure a map of the result; the figures of copying are those of the picture."""
    found = assess(own, made, tileable=tileable)
    return MapReport(as_shown(own, own.pixels), as_shown(own, made), found)


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]}x{shape[0]}"


def _another(source: Synthesis, exemplar: Exemplar, pixels: NDArray[Any]) -> list[str]:
    """Return a note if the picture differs from that of its source."""
    if source.canvas.hole is not None:
        return []
    given = source.render(exemplar)
    if given.shape != pixels.shape or given.dtype != pixels.dtype:
        return []  # refused later, in other words
    levels = (exemplar.as_matching(part).astype(np.int16) for part in (given, pixels))
    apart = float(abs(np.subtract(*levels)).mean())
    if apart <= _SAME:
        return []
    text = f"The result differs from the picture of its source by {apart:.1f} levels on average"
    return [f"{text}, so the figures of copying may not hold."]


def fault_maps(
    exemplar: Exemplar,
    pixels: NDArray[Any],
    source: NDArray[Any] | None,
    pictured: Exemplar | None = None,
) -> dict[str, Bytes]:
    """Return pictures of where a result fails, uint8 (h, w, 3), by name; see `Report.maps`.

    `pictured` is what the source refers to, if that is a picture of the sample's oriented copies.
    Of large results the middle is drawn.
    """
    shape = (min(pixels.shape[0], LARGEST_MEASURED), min(pixels.shape[1], LARGEST_MEASURED))
    pictured = exemplar if pictured is None else pictured
    if source is not None:
        source = middle(check_source(source, pictured.shape, pixels.shape[:2]), shape)
    pixels = middle(pixels, shape)
    own, made = views(exemplar, pixels)
    picture = as_shown(exemplar, pixels)
    maps = {}
    seams = seam_map(StepModel(own), made)
    if seams is not None:
        maps["seams"] = _marked(picture, np.minimum(seams / _SEAM, 1), (255, 40, 0))
    if source is not None:
        known = source[..., 0] >= 0
        scale = 255 / np.maximum(np.array(pictured.shape) - 1, 1)
        color = np.full((*made.shape, 3), 96, np.uint8)
        color[..., 1::-1] = np.rint(np.maximum(source, 0) * scale)
        color[~known] = 0
        maps["source"] = color
        count = np.zeros(pictured.shape)
        np.add.at(count, (source[known][:, 0], source[known][:, 1]), 1)
        usual = max(float(count.mean()), 1e-9)
        often = np.clip(np.log2((count + usual / 8) / usual) / 3, -1, 1)
        shown = as_shown(pictured, pictured.pixels)
        seldom = _marked(shown, np.maximum(-often, 0), (0, 90, 255))
        maps["use"] = _marked(seldom, np.maximum(often, 0), (255, 150, 0), 1.0)
    return maps


def _marked(
    picture: Bytes, strength: NDArray[Any], color: tuple[int, int, int], keep: float = 0.6
) -> Bytes:
    """Return the picture, in gray for `keep` below 1, with a color blended in by strength."""
    base = picture.astype(np.float64)
    if keep < 1:
        base = np.repeat(255 - (255 - base.mean(axis=2, keepdims=True)) * keep, 3, axis=2)
    share = 0.85 * strength[..., None]
    marked: Bytes = np.rint(base * (1 - share) + np.array(color) * share).astype(np.uint8)
    return marked
