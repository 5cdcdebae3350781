"""Parts of the HTML pages that weftex writes: one file with everything in it."""

from __future__ import annotations

import json
import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.io.pictures import check_output, write_text
from weftex.io.png import data_url
from weftex.quality import Figure

_LARGEST_PICTURE = 1024  # pixels a side of a picture in the page

_STYLE = Path(__file__).parent / "page.css"


class Page(ABC):
    """An object that can be shown in a notebook and saved as an HTML page."""

    @abstractmethod
    def html(self) -> str:
        """Return the whole page as one file."""

    def _repr_html_(self) -> str:
        frame = 'style="width: 100%; height: 40rem; border: 1px solid #8886"'
        return f'<iframe {frame} srcdoc="{escape(self.html())}"></iframe>'

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page."""
        check_output(path, suffixes=(".html",))
        write_text(path, self.html())


def document(title: str, parts: Iterable[str]) -> str:
    """Return a whole page as one file, with the title as its heading."""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{_STYLE.read_text('utf-8')}</style>\n</head>\n<body>\n"
        + "\n".join([f"<h1>{escape(title)}</h1>", *parts])
        + "\n</body>\n</html>\n"
    )


def show(picture: NDArray[np.uint8], title: str, text: str) -> str:
    """Return a figure with the picture embedded; a large one by every second, third, ... pixel."""
    height, width = picture.shape[:2]
    step = -(-max(height, width) // _LARGEST_PICTURE)
    size = f"{width}x{height} pixels" + (f", shown at 1:{step}" if step > 1 else "")
    reduced = picture[::step, ::step]
    return (
        f'<figure><img alt="{escape(f"{title}: {text}")}" src="{data_url(reduced)}">'
        f"<figcaption><strong>{escape(title)}</strong>: {escape(text)} "
        f'<span class="small">({size})</span></figcaption></figure>'
    )


def pictures(shown: Iterable[tuple[NDArray[np.uint8], str, str]]) -> str:
    """Return figures side by side."""
    return "\n".join(['<div class="pictures">', *(show(*one) for one in shown), "</div>"])


def table(rows: Iterable[str], head: Sequence[str] = ()) -> str:
    """Return a table; rows are cells as HTML."""
    top = ["".join(f'<th scope="col">{escape(text)}</th>' for text in head)] if head else []
    body = "\n".join(f"<tr>{row}</tr>" for row in [*top, *rows])
    return f'<div class="table"><table>\n{body}\n</table></div>'


def small(text: str) -> str:
    """Return a note."""
    return f'<p class="small">{escape(text)}</p>'


def number(value: float | None, figure: Figure | None = None) -> str:
    """Return a figure's value as text, or a dash where it could not be measured."""
    if value is None:
        return "–"
    return f"{value:.0f}" if figure is not None and figure.unit == "pixels" else f"{value:.2f}"


def parameters(summary: str, provenance: dict[str, Any]) -> str:
    """Return a table of parameters, which a click on the summary shows."""
    rows = (
        f'<th scope="row">{escape(str(name))}</th><td>{escape(_plain(value))}</td>'
        for name, value in provenance.items()
    )
    return f"<details><summary>{summary}</summary>\n{table(rows)}\n</details>"


def _plain(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value, default=str)
    return text if len(text) <= 400 else text[:400] + " …"
