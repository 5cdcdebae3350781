"""A report on how good a result is: images, maps of its flaws, every figure; one HTML file."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex import Assessment, Exemplar, Synthesis, assess, load_exemplar
from weftex.errors import wrong_value
from weftex.pages.html import Page, document, number, parameters, pictures, small, table
from weftex.quality import FIGURES, LARGEST_MEASURED, SCORE, as_shown, fault_maps, real_crops

Bytes = NDArray[np.uint8]

_CAPTIONS = {
    "broken": (
        "Broken things",
        "Red: windows of a third of the sample's side that look like no window of the sample.",
    ),
    "source": (
        "Source",
        "False colors by position in the sample: red increases to the right, green downwards.",
    ),
    "use": (
        "Use of the sample",
        "The sample: orange where it was used more often than average, blue where seldom or never.",
    ),
}
_HEAD = ("Measure", "Result", "Real", "Limit", "", "Judges", "Meaning")
_LEGEND = (
    "Real: each half of the sample, measured as a result of the other half. Judges: the share of "
    "image pairs that the measure alone orders as a judge did; 50 % is chance. A dash: no value."
)


@dataclass(frozen=True, eq=False)
class MapReport:
    """One map of a set: images of it in the sample and in the result, and its measures."""

    sample: Bytes
    result: Bytes
    assessment: Assessment


@dataclass(frozen=True, eq=False)
class Report(Page):
    """The report on a result, as returned by `weftex.pages.report`.

    Attributes
    ----------
    sample, result : uint8 array (H, W, 3)
        The image of the sample on the page; the image of the result on the page.
    name, result_name : str
        Name of the sample; name of the result.
    assessment : Assessment
        All measures of the result.
    real : dict of str to float or None
        The same measures of the halves of the sample, as if one was made from the other.
    maps : dict of str to uint8 array (H, W, 3)
        Images of the page: "broken" and, with a source, "source" and "use" (of the sample).
    provenance : dict
        How the result was made, if it is known.
    notes : tuple of str
        Limits of the measures in this case.
    of_maps : dict of str to MapReport
        Images and measures of each map that both sample and result have.
    """

    sample: Bytes
    result: Bytes
    name: str
    result_name: str
    assessment: Assessment
    real: dict[str, float | None]
    maps: dict[str, Bytes]
    provenance: dict[str, Any]
    notes: tuple[str, ...]
    of_maps: dict[str, MapReport]

    def __repr__(self) -> str:
        return f"<Report on {self.result_name!r} of {self.name!r}: {self.assessment.verdict()}>"

    def verdict(self) -> str:
        """Return the verdict on the picture, then one line for each map."""
        told = [f"{name}: {one.assessment.verdict()}" for name, one in self.of_maps.items()]
        return "\n".join([self.assessment.verdict(), *told])

    def told(self) -> str:
        """Return the verdict, and a line for each measure that is not None."""
        lines = [self.verdict()]
        for name, figure in FIGURES.items():
            value = getattr(self.assessment, name)
            if value is not None:
                limit = f" (limit {figure.within()})" if figure.within() else ""
                said = f"{figure.title}: {number(value, figure)}{limit}"
                lines.append(f"{said}. {_sentence(self, name)}")
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """Return all figures as numbers, texts, lists, dicts and None, as JSON has them."""
        return {
            "sample": self.name,
            "result": self.result_name,
            "verdict": self.assessment.verdict(),
            **self.assessment.as_dict(),
            "real": self.real,
            "provenance": self.provenance,
            "notes": list(self.notes),
            "of_maps": {name: one.assessment.as_dict() for name, one in self.of_maps.items()},
        }

    def html(self) -> str:
        """Return the whole page as one file."""
        score, verdict = self.assessment.score, escape(self.assessment.verdict())
        kind = "" if score is None else "bad" if self.assessment.flags else "good"
        about = "" if score is None else f" Score {score:.2f}: {SCORE}"
        both = (self.sample, "Sample", self.name), (self.result, "Result", self.result_name)
        parts = [
            f'<p class="verdict {kind}">{verdict}<br><span class="small">{about}</span></p>',
            *map(small, self.notes),
            "<h2>Pictures</h2>",
            pictures(both),
        ]
        for name, one in self.of_maps.items():
            parts += [
                f"<h2>{escape(name)}</h2>",
                f"<p>{escape(one.assessment.verdict())}</p>",
                pictures([(one.sample, "Sample", name), (one.result, "Result", name)]),
            ]
        if self.maps:
            shown = ((picture, *_CAPTIONS[name]) for name, picture in self.maps.items())
            parts += ["<h2>Where it fails</h2>", pictures(shown)]
        rows = (_figure_row(self, name) for name in FIGURES)
        parts += ["<h2>Measures</h2>", table(rows, _HEAD), small(_LEGEND)]
        if self.provenance:
            parts.append(parameters("How it was made", self.provenance))
        return document(f"{self.result_name} from {self.name}", parts)


def _figure_row(found: Report, name: str) -> str:
    figure, value = FIGURES[name], getattr(found.assessment, name)
    limit, over = figure.within(), name in found.assessment.flags
    mark = "" if value is None or not limit else "over" if over else "within"
    agrees = "–" if figure.agrees is None else f"{figure.agrees:.0%}"
    return (
        f'<th scope="row">{escape(figure.title)}<br>'
        f'<span class="small">{escape(figure.unit)}</span></th>'
        f'<td class="number">{number(value, figure)}</td>'
        f'<td class="number">{number(found.real.get(name), figure)}</td>'
        f'<td class="number">{escape(limit)}</td><td class="{mark}">{mark}</td>'
        f'<td class="number">{agrees}</td><td>{escape(_sentence(found, name))} '
        f'<span class="small">Blind to {escape(figure.blind)}.</span></td>'
    )


def _sentence(found: Report, name: str) -> str:
    """Return what a measure says of this result, or means."""
    figure = FIGURES[name]
    if name not in found.assessment.flags:
        return figure.meaning
    return f"The result {figure.fault(getattr(found.assessment, name))}."


_SAME = 2.0  # levels; a picture further than this from that of its source is another one


def report(
    sample: Any,
    result: Any,
    source: Synthesis | str | os.PathLike[str] | None = None,
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
    source : Synthesis or path, optional
        The Synthesis that the result is a picture of, or what `Synthesis.save` wrote.
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
    ((), ['broken', 'source', 'use'], True)
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
        pixels, named, made_maps = made.pixels, made.name, made.maps
    if not isinstance(source, Synthesis | None):
        raise wrong_value("source", source, "a Synthesis or its file")
    maps = fault_maps(exemplar, pixels, source)
    notes: list[str] = []
    if source is not None:
        notes += _another(source, exemplar, pixels)
        tileable = source.canvas.wrap if tileable is None else tileable
    found = assess(exemplar, pixels, tileable=tileable)
    same = {name: _same_map(name, made_maps) for name in exemplar.maps}
    of_maps = {}
    for name, other in same.items():
        if other is not None:
            own, one = exemplar.map(name), made_maps[other]
            shown_maps = as_shown(own, own.pixels), as_shown(own, one)
            of_maps[name] = MapReport(*shown_maps, assess(own, one, tileable=tileable))
    if max(pixels.shape[:2]) > LARGEST_MEASURED:
        notes.append(
            f"Only the middle of the result, {LARGEST_MEASURED} pixels a side, was measured."
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
        maps=maps,
        provenance={} if source is None else source.provenance,
        notes=tuple(notes),
        of_maps=of_maps,
    )


def _same_map(name: str, made: Collection[str]) -> str | None:
    """Return the name of a map in the result; normals of either convention match."""
    normals = [other for other in made if {name, other} <= {"normal", "normal_gl", "normal_dx"}]
    return name if name in made else next(iter(normals), None)


def _another(source: Synthesis, exemplar: Exemplar, pixels: NDArray[Any]) -> list[str]:
    """Return a note if the picture differs from that of its source."""
    if source.canvas.hole is not None:
        return []
    both = source.render(exemplar), pixels
    levels = (exemplar.as_matching(one).astype(np.int16) for one in both)
    apart = float(abs(np.subtract(*levels)).mean())
    if apart <= _SAME:
        return []
    return [f"The result differs from the image of its sources by {apart:.1f} levels on average."]
