"""The page of a comparison: one HTML file with everything in it."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from weftex.pages.html import document, number, parameters, show
from weftex.quality.figures import FIGURES
from weftex.tasks.report import as_shown

if TYPE_CHECKING:
    from weftex.tasks.compare import Comparison, Entry


def page(found: Comparison) -> str:
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
    """A row for each method; a figure that passes its limit is marked."""
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
        f'<div class="table"><table>\n{body}\n</table></div>\n<p class="small">Score: 0 is '
        "perfect, 1 is at a limit. Figures beyond their limits stand out. Limits: "
        f"{escape(limits)}. A dash is what cannot be measured.</p>"
    )


def _section(found: Comparison, entry: Entry) -> list[str]:
    head = f'<h2 id="{entry.method}">{entry.method}</h2>'
    if entry.result is None or entry.assessment is None:
        return [head, f"<p>It cannot do this: {escape(entry.note)}.</p>"]
    note = f" {entry.note}." if entry.note else ""
    told = f"{entry.assessment.verdict()} {entry.seconds:.2f} s.{note}"
    colours = "false colours by place in the sample: more red to the right, more green downwards"
    return [
        head,
        f"<p>{escape(told)}</p>",
        '<div class="pictures">',
        show(as_shown(found.exemplar, entry.result.image), entry.method, "the result"),
        show(entry.result.draw(), "Source", colours),
        "</div>",
        "<details><summary>Parameters</summary>",
        parameters(entry.result.provenance),
        "</details>",
    ]
