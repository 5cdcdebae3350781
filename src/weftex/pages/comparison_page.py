"""A comparison of methods on one sample; one HTML file."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from weftex.pages.html import Page, as_shown, document, number, parameters, show
from weftex.quality.figures import FIGURES, SCORE

if TYPE_CHECKING:
    from weftex.choice import Choice
    from weftex.exemplar import Exemplar
    from weftex.quality.assess import Assessment
    from weftex.results.synthesis import Synthesis


@dataclass(frozen=True, eq=False)
class Entry:
    """The result of one method.

    Attributes
    ----------
    method : str
        Its name.
    result : Synthesis or None
        None where the method cannot make it.
    seconds : float
        Time of fitting and making.
    assessment : Assessment or None
        The figures.
    note : str
        Why there is no result.
    """

    method: str
    result: Synthesis | None
    seconds: float
    assessment: Assessment | None
    note: str

    @property
    def rank(self) -> float:
        """The score; infinite without one, so that it comes last."""
        score = None if self.assessment is None else self.assessment.score
        return float("inf") if score is None else score

    def as_dict(self) -> dict[str, Any]:
        """Return everything except the picture, ready for JSON."""
        return {
            "method": self.method,
            "seconds": round(self.seconds, 3),
            "note": self.note,
            "figures": None if self.assessment is None else self.assessment.as_dict(),
            "provenance": None if self.result is None else self.result.provenance,
        }


@dataclass(frozen=True, eq=False)
class Comparison(Page):
    """Results of several methods, as returned by `weftex.compare`.

    Attributes
    ----------
    exemplar : Exemplar
        The sample.
    shape : (int, int)
        Height and width of the outputs.
    seed : int
        Of all of them.
    choice : Choice
        What "auto" would choose, and why.
    entries : tuple of Entry
        Best score first, then those without a result.
    """

    exemplar: Exemplar
    shape: tuple[int, int]
    seed: int
    choice: Choice
    entries: tuple[Entry, ...]

    def __repr__(self) -> str:
        scores = ", ".join(f"{one.method} {one.rank:.2f}" for one in self.entries)
        return f"<Comparison on {self.exemplar.name!r}, by score: {scores}>"

    def as_dict(self) -> dict[str, Any]:
        """Return all figures as numbers, texts, lists, dicts and None, as JSON has them."""
        return {
            "sample": self.exemplar.name,
            "height": self.shape[0],
            "width": self.shape[1],
            "seed": self.seed,
            "auto": self.choice.as_dict(),
            "methods": [entry.as_dict() for entry in self.entries],
        }

    def html(self) -> str:
        """Return the whole page as one file."""
        return _page(self)


def _page(found: Comparison) -> str:
    """Return the whole page."""
    name, (height, width) = found.exemplar.name, found.shape
    title = f"{len(found.entries)} methods on {name}"
    parts = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="verdict">Auto: {escape(found.choice.reason)}</p>',
        *(f'<p class="small">{escape(warning)}</p>' for warning in found.choice.warnings),
        f"<p>All made {width}x{height} pixels from this sample, with seed {found.seed}.</p>",
        show(as_shown(found.exemplar, found.exemplar.pixels), "Sample", name),
        "<h2>Figures</h2>",
        _table(found),
    ]
    for entry in found.entries:
        parts += _section(found, entry)
    return document(title, parts)


def _table(found: Comparison) -> str:
    """Return a row for each method, with the figures beyond their limits marked."""
    limited = {name: figure for name, figure in FIGURES.items() if figure.limit is not None}
    head = ("Method", "Score", "Seconds", *(figure.title for figure in limited.values()))
    rows = ["".join(f'<th scope="col">{escape(text)}</th>' for text in head)]
    for entry in found.entries:
        link = f'<a href="#{entry.method}">{entry.method}</a>'
        link += " (auto)" if entry.method == found.choice.method else ""
        row = f'<th scope="row">{link}</th>'
        if entry.assessment is None:
            rows.append(f'{row}<td colspan="{len(head) - 1}">{escape(entry.note)}</td>')
            continue
        score, flags = entry.assessment.score, entry.assessment.flags
        cells = [("", "–" if score is None else f"{score:.2f}"), ("", f"{entry.seconds:.2f}")]
        for name, figure in limited.items():
            value = getattr(entry.assessment, name)
            cells.append(("over" if name in flags else "", number(value, figure)))
        rows.append(row + "".join(f'<td class="number {kind}">{text}</td>' for kind, text in cells))
    limits = "; ".join(f"{figure.title} {figure.within()}" for figure in limited.values())
    body = "\n".join(f"<tr>{row}</tr>" for row in rows)
    return (
        f'<div class="table"><table>\n{body}\n</table></div>\n<p class="small">Score: '
        f"{SCORE} Figures beyond their limits are in color. Limits: {escape(limits)}. A dash: "
        "cannot be measured.</p>"
    )


def _section(found: Comparison, entry: Entry) -> list[str]:
    head = f'<h2 id="{entry.method}">{entry.method}</h2>'
    if entry.result is None or entry.assessment is None:
        return [head, f"<p>It cannot make this: {escape(entry.note)}.</p>"]
    told = f"{entry.assessment.verdict()} {entry.seconds:.2f} s."
    colors = "false colors by place in the sample: more red to the right, more green downwards"
    return [
        head,
        f"<p>{escape(told)}</p>",
        '<div class="pictures">',
        show(as_shown(found.exemplar, entry.result.image), entry.method, "the result"),
        show(entry.result.draw(), "Source", colors),
        "</div>",
        "<details><summary>Parameters</summary>",
        parameters(entry.result.provenance),
        "</details>",
    ]
