"""A comparison of methods on one sample; one HTML file."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from weftex.pages.html import Page, document, number, parameters, pictures, show, small, table
from weftex.quality import FIGURES, SCORE, as_shown

if TYPE_CHECKING:
    from weftex import Assessment, Exemplar, Synthesis
    from weftex.choice import Choice

_COLORS = "false colors by place in the sample: more red to the right, more green downwards"


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
    """Results of several methods, as returned by `weftex.pages.compare`.

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
        name, (height, width) = self.exemplar.name, self.shape
        limited = {name: figure for name, figure in FIGURES.items() if figure.limit is not None}
        head = ("Method", "Score", "Seconds", *(figure.title for figure in limited.values()))
        limits = "; ".join(f"{figure.title} {figure.within()}" for figure in limited.values())
        parts = [
            f'<p class="verdict">Auto: {escape(self.choice.reason)}</p>',
            *map(small, self.choice.warnings),
            f"<p>All made {width}x{height} pixels from this sample, with seed {self.seed}.</p>",
            show(as_shown(self.exemplar, self.exemplar.pixels), "Sample", name),
            "<h2>Figures</h2>",
            table((self._row(entry, [*limited]) for entry in self.entries), head),
            small(
                f"Score: {SCORE} Figures beyond their limits are in color. Limits: {limits}. A "
                "dash: cannot be measured."
            ),
        ]
        for entry in self.entries:
            parts += self._section(entry)
        return document(f"{len(self.entries)} methods on {name}", parts)

    def _row(self, entry: Entry, names: list[str]) -> str:
        """A method and its figures, those beyond their limits marked."""
        link = f'<a href="#{entry.method}">{entry.method}</a>'
        link += " (auto)" if entry.method == self.choice.method else ""
        row, found = f'<th scope="row">{link}</th>', entry.assessment
        if found is None:
            return f'{row}<td colspan="{2 + len(names)}">{escape(entry.note)}</td>'
        cells = [("", number(found.score)), ("", number(entry.seconds))]
        for name in names:
            over = "over" if name in found.flags else ""
            cells.append((over, number(getattr(found, name), FIGURES[name])))
        return row + "".join(f'<td class="number {kind}">{text}</td>' for kind, text in cells)

    def _section(self, entry: Entry) -> list[str]:
        """The result of a method, and its parameters."""
        head = f'<h2 id="{entry.method}">{entry.method}</h2>'
        if entry.result is None or entry.assessment is None:
            return [head, f"<p>It cannot make this: {escape(entry.note)}.</p>"]
        image = as_shown(self.exemplar, entry.result.image)
        return [
            head,
            f"<p>{escape(entry.assessment.verdict())} {entry.seconds:.2f} s.</p>",
            pictures(
                [(image, entry.method, "the result"), (entry.result.draw(), "Source", _COLORS)]
            ),
            "<details><summary>Parameters</summary>",
            parameters(entry.result.provenance),
            "</details>",
        ]
