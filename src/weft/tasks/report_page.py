"""The page of a report: one HTML file with everything in it."""

from __future__ import annotations

import base64
import json
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from weft.formats import png
from weft.quality.figures import FIGURES, Figure

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weft.tasks.report import Report

_WIDEST = 1024  # pixels a side of a picture in the page

_STYLE = """
:root { color-scheme: light dark; --line: #8886; --bad: #b3261e; --good: #1b6e2c; }
@media (prefers-color-scheme: dark) { :root { --bad: #ff8a80; --good: #81d58f; } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.5rem; }
.verdict { font-size: 1.2rem; border-left: .4rem solid var(--line); padding: .4rem 1rem; }
.verdict.good { border-color: var(--good); } .verdict.bad { border-color: var(--bad); }
.pictures { display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-start; }
figure { margin: 0; max-width: 100%; } img { max-width: 100%; height: auto; display: block; }
figcaption { font-size: .9rem; max-width: 32rem; }
.table { overflow-x: auto; } table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; padding: .35rem .6rem; border-bottom: 1px solid var(--line);
  vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.over { color: var(--bad); font-weight: 600; } .within { color: var(--good); }
.small { font-size: .9rem; opacity: .85; }
"""

_CAPTIONS = {
    "seams": (
        "Seams",
        "Red where the picture breaks off between two lines of pixels as the sample hardly does.",
    ),
    "repetition": (
        "Repetition",
        "Pink where the picture comes back pixel by pixel at one of the commonest shifts.",
    ),
    "source": (
        "Source",
        "False colours by place in the sample: more red to the right, more green downwards.",
    ),
    "use": (
        "Use of the sample",
        "The sample: orange where it was used more often than usual, blue where seldom or never.",
    ),
}


def page(found: Report) -> str:
    """Return the whole page."""
    title = f"{found.result_name} from {found.name}"
    score = found.assessment.score
    shown = "" if score is None else f" Score {score:.2f}; 0 is perfect, 1 is at a limit."
    kind = "" if score is None else "bad" if found.assessment.flags else "good"
    verdict = f'{escape(found.assessment.verdict())}<br><span class="small">{shown}</span>'
    parts = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="verdict {kind}">{verdict}</p>',
        *(f'<p class="small">{escape(note)}</p>' for note in found.notes),
        "<h2>Pictures</h2>",
        '<div class="pictures">',
        _figure(found.sample, "Sample", found.name),
        _figure(found.result, "Result", found.result_name),
        "</div>",
    ]
    if found.maps:
        parts += ["<h2>Where it fails</h2>", '<div class="pictures">']
        parts += [_figure(picture, *_CAPTIONS[name]) for name, picture in found.maps.items()]
        parts.append("</div>")
    parts += ["<h2>Figures</h2>", _figures(found)]
    if found.provenance:
        parts += ["<h2>How it was made</h2>", _parameters(found.provenance)]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def _figure(picture: NDArray[np.uint8], title: str, text: str) -> str:
    """A picture in the page itself; a large one is shown by every so manieth pixel."""
    height, width = picture.shape[:2]
    step = -(-max(height, width) // _WIDEST)
    data = base64.b64encode(png(np.ascontiguousarray(picture[::step, ::step]))).decode("ascii")
    size = f"{width}x{height} pixels" + (f", shown at 1:{step}" if step > 1 else "")
    return (
        f'<figure><img alt="{escape(f"{title}: {text}")}" src="data:image/png;base64,{data}">'
        f"<figcaption><strong>{escape(title)}</strong>: {escape(text)} "
        f'<span class="small">({size})</span></figcaption></figure>'
    )


def _figures(found: Report) -> str:
    head = ("Figure", "Result", "Real", "Limit", "", "What it says")
    rows = ["".join(f'<th scope="col">{text}</th>' for text in head)]
    for name, figure in FIGURES.items():
        value = getattr(found.assessment, name)
        limit, over = figure.within(), name in found.assessment.flags
        mark = "" if value is None or not limit else "over" if over else "within"
        about = (
            f'{escape(figure.meaning)} <span class="small">Blind to {escape(figure.blind)}.</span>'
        )
        rows.append(
            f'<th scope="row">{escape(figure.title)}<br>'
            f'<span class="small">{escape(figure.unit)}</span></th>'
            f'<td class="number">{_number(value, figure)}</td>'
            f'<td class="number">{_number(found.real.get(name), figure)}</td>'
            f'<td class="number">{escape(limit)}</td><td class="{mark}">{mark}</td>'
            f"<td>{about}</td>"
        )
    body = "\n".join(f"<tr>{row}</tr>" for row in rows)
    return (
        f'<div class="table"><table>\n{body}\n</table></div>\n<p class="small">Real: the halves of '
        "the sample, each measured as if it had been made from the other. A dash is what cannot be "
        "measured.</p>"
    )


def _number(value: float | None, figure: Figure) -> str:
    if value is None:
        return "–"
    return f"{value:.0f}" if figure.unit == "pixels" else f"{value:.2f}"


def _parameters(provenance: dict[str, Any]) -> str:
    rows = [
        f'<tr><th scope="row">{escape(str(name))}</th><td>{escape(_plain(value))}</td></tr>'
        for name, value in provenance.items()
    ]
    return '<div class="table"><table>\n' + "\n".join(rows) + "\n</table></div>"


def _plain(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value, default=str)
    return text if len(text) <= 400 else text[:400] + " …"
