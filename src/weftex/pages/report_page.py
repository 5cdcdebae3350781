"""A report: pictures, maps of where a result fails, every figure; one HTML file."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from weftex.pages.html import Page, document, number, parameters, pictures, small, table
from weftex.quality import FIGURES, SCORE

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from weftex import Assessment

    Bytes = NDArray[np.uint8]

_CAPTIONS = {
    "seams": (
        "Seams",
        "Red where neighboring lines of pixels differ in a way that is rare in the sample.",
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
_HEAD = ("Figure", "Result", "Real", "Limit", "", "Judges", "Meaning")
_LEGEND = (
    "Real: the halves of the sample, each measured as if it had been made from the other. Judges: "
    "the share of judged pairs of pictures that the figure alone orders as a judge did; 50% is a "
    "coin. A dash: cannot be measured."
)


@dataclass(frozen=True, eq=False)
class MapReport:
    """One map of a set: pictures of the sample's and the result's, and the figures."""

    sample: Bytes
    result: Bytes
    assessment: Assessment


@dataclass(frozen=True, eq=False)
class Report(Page):
    """The report on a result, as returned by `weftex.pages.report`.

    Attributes
    ----------
    sample, result : uint8 array (H, W, 3)
        Both pictures as shown on the page.
    name, result_name : str
        Of the sample, and of the result.
    assessment : Assessment
        All figures of the result.
    real : dict of str to float or None
        The same figures of real pictures of this surface; see `weftex.quality.real_crops`.
    maps : dict of str to uint8 array (H, W, 3)
        "seams" and, with a source, "source" and "use" (of the sample), as far as they can be
        made.
    provenance : dict
        How the result was made, if its source says so.
    notes : tuple of str
        Limits of the figures in this case.
    of_maps : dict of str to MapReport
        The maps that both sample and result have.
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
        parts = [
            f'<p class="verdict {kind}">{verdict}<br><span class="small">{about}</span></p>',
            *map(small, self.notes),
            "<h2>Pictures</h2>",
            pictures(
                [(self.sample, "Sample", self.name), (self.result, "Result", self.result_name)]
            ),
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
        parts += ["<h2>Figures</h2>", table(rows, _HEAD), small(_LEGEND)]
        if self.provenance:
            parts += ["<h2>How it was made</h2>", parameters(self.provenance)]
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
        f'<td class="number">{agrees}</td><td>{escape(figure.meaning)} '
        f'<span class="small">Blind to {escape(figure.blind)}.</span></td>'
    )
