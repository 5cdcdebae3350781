"""A report on how good a result is: pictures, maps of where it fails, every figure."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex import Exemplar, Synthesis, assess, load_exemplar
from weftex.pages.report_page import MapReport, Report
from weftex.quality import LARGEST_MEASURED, as_shown, fault_maps, real_crops

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from numpy.typing import NDArray


_SAME = 2.0  # levels; a picture further than this from that of its source is another one


def report(
    sample: Any,
    result: Any,
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
    exemplar = load_exemplar(sample)
    if isinstance(source, (str, os.PathLike)):
        source = Synthesis.load(source)
    named = "result"
    made_maps: Mapping[str, NDArray[Any]] = {}
    if isinstance(result, Synthesis):
        source = result if source is None else source
        pixels = result.image if result.exemplar is not None else result.render(exemplar)
        made_maps = {} if result.exemplar is None else result.maps
    else:
        made = load_exemplar(result)
        result = pixels = made.pixels
        named, made_maps = made.name, made.maps
    found = assess(exemplar, result, source, tileable=tileable)
    notes: list[str] = []
    if isinstance(source, Synthesis):
        notes += _another(source, exemplar, pixels)
        tileable = source.canvas.wrap if tileable is None else tileable
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
        maps=fault_maps(exemplar, result, source),
        provenance=source.provenance if isinstance(source, Synthesis) else {},
        notes=tuple(notes),
        of_maps={
            name: _of_map(exemplar.map(name), made_maps[other], tileable)
            for name, other in same.items()
            if other is not None
        },
    )


def _same_map(name: str, made: Collection[str]) -> str | None:
    """Return the name of a map in the result; normals of either convention match."""
    normals = [other for other in made if {name, other} <= {"normal", "normal_gl", "normal_dx"}]
    return name if name in made else next(iter(normals), None)


def _of_map(
    own: Exemplar, made: NDArray[Any], tileable: bool | tuple[bool, bool] | None
) -> MapReport:
    """Measure a map of the result; the figures of copying are those of the picture."""
    found = assess(own, made, tileable=tileable)
    return MapReport(as_shown(own, own.pixels), as_shown(own, made), found)


def _another(source: Synthesis, exemplar: Exemplar, pixels: NDArray[Any]) -> list[str]:
    """Return a note if the picture differs from that of its source."""
    if source.canvas.hole is not None:
        return []
    both = source.render(exemplar), pixels
    levels = (exemplar.as_matching(one).astype(np.int16) for one in both)
    apart = float(abs(np.subtract(*levels)).mean())
    if apart <= _SAME:
        return []
    text = f"The result differs from the picture of its source by {apart:.1f} levels on average"
    return [f"{text}, so the figures of copying may not hold."]
