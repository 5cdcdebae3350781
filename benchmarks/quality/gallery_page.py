"""The pages of gallery.py: tables of scores and figures, and a page of pictures."""

from __future__ import annotations

import csv
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import weftex
from weftex.pages.html import document
from weftex.quality.faults import as_shown
from weftex.quality.figures import FIGURES
from weftex.registry import AUTO, method_class

DATA = Path(__file__).resolve().parents[1] / "data"
JUDGED = DATA / "judged.csv"
PAGES = ("quality.md", "quality-figures.md")
KINDS = {"near-regular": ("near-regular", "regular"), "irregular": (), "stochastic": ()}
_MIDDLE = 320  # pixels a side of an output that is shown beside the others
_ACROSS = 5  # pictures in a row
_GAP = 6
_SKY = np.array((120, 160, 220))  # behind transparent pixels
_QUALITY = 85  # of WebP
LIMITED = {name: figure for name, figure in FIGURES.items() if figure.limit is not None}


@dataclass(frozen=True)
class Gallery:
    """What the pages show.

    Attributes
    ----------
    surfaces : mapping
        Rows of the list of surfaces by name.
    methods : sequence of str
        Columns.
    found : mapping
        The results of `gallery.Job.run`, by surface and method.
    keep : Path
        Where the full-size pictures are.
    """

    surfaces: Mapping[str, Mapping[str, str]]
    methods: Sequence[str]
    found: Mapping[tuple[str, str], Mapping[str, Any]]
    keep: Path

    @property
    def shown(self) -> list[str]:
        """The methods themselves."""
        return [method for method in self.methods if method != AUTO]

    def column(self, method: str, names: Iterable[str] | None = None) -> list[Mapping[str, Any]]:
        return [self.found[name, method] for name in names or self.surfaces]

    def kinds(self) -> dict[str, list[str]]:
        """The surfaces of each kind that there is."""
        kinds = {
            kind: [n for n, row in self.surfaces.items() if row["class"] in (kind, *more)]
            for kind, more in KINDS.items()
        }
        return {kind: names for kind, names in kinds.items() if names}


def write(
    docs: Path,
    surfaces: Mapping[str, Mapping[str, str]],
    methods: Sequence[str],
    found: Mapping[tuple[str, str], Mapping[str, Any]],
    keep: Path,
) -> None:
    """Write the tables to `docs`, and the pictures and their page to `keep`."""
    gallery = Gallery(surfaces, methods, found, keep)
    docs.mkdir(parents=True, exist_ok=True)
    images = keep / "pictures"
    images.mkdir(parents=True, exist_ok=True)
    for old in images.iterdir():
        old.unlink()
    for name in surfaces:
        draw(gallery, name, images)
    scored, measured = PAGES
    (docs / scored).write_text(QUALITY.format(
        summary=summary(gallery), scores=scores(gallery), judged=judged(gallery)
    ), encoding="utf-8")  # fmt: skip
    (docs / measured).write_text(FIGURES_PAGE.format(figures=figures(gallery)), encoding="utf-8")
    (keep / "index.html").write_text(pictures(gallery), encoding="utf-8")


QUALITY = """\
# Quality: scores

`python benchmarks/quality/gallery.py --jobs 2` writes this page; edits are lost.
[How to read it, and what the eye sees](../../background/quality.md).

## Summary

{summary}
## Scores

Bold: no figure is beyond its limit. [All figures](quality-figures.md).

{scores}
## An independent measure

[Whose it is](../measures-checked.md#beside-an-independent-measure). Bold: good by its own rule.

{judged}"""

FIGURES_PAGE = """\
# Quality: all figures

`python benchmarks/quality/gallery.py --jobs 2` writes this page; edits are lost.

Every figure of every output of [quality.md](quality.md). Bold figures are beyond their limits;
[measures.md](../../reference/measures.md) has their meanings, units and limits. Below each table
stand the verdict in words and, in brackets, the parameters that differ from the defaults.

{figures}"""


# --------------------------------------------------------------------------------------- tables


def page_of(method: str) -> str:
    folder = "background" if method == AUTO else "reference/methods"
    return f"[{method}](../../{folder}/{method}.md)"


def good(made: Mapping[str, Any]) -> bool:
    """Whether all figures are within their limits."""
    return made["figures"]["score"] is not None and not made["figures"]["flags"]


def score(made: Mapping[str, Any]) -> str:
    value = made["figures"]["score"]
    return "–" if value is None else f"**{value:.2f}**" if good(made) else f"{value:.2f}"


def values(made: Iterable[Mapping[str, Any]], name: str) -> list[float]:
    return [one["figures"][name] for one in made if one["figures"][name] is not None]


def summary(gallery: Gallery) -> str:
    """All surfaces together, by kind, and by fault."""

    def row(title: str, cell: Callable[[list[Mapping[str, Any]]], str], names: Any = None) -> Any:
        return [title, *(cell(gallery.column(method, names)) for method in gallery.methods)]

    def middle(name: str, form: str) -> Callable[[list[Mapping[str, Any]]], str]:
        return lambda made: _over(statistics.median, values(made, name), form)

    def mean(made: list[Mapping[str, Any]]) -> str:
        return _over(statistics.fmean, values(made, "score"), ".2f")

    head = ["", *map(page_of, gallery.methods)]
    count = len(gallery.surfaces)
    whole = [
        row("mean score", mean),
        row("median score", middle("score", ".2f")),
        row(f"good, of {count}", lambda made: str(sum(map(good, made)))),
        row("seconds, median", lambda made: _seconds(s["seconds"] for s in made)),
        row("seam at the wrap, median", middle("wrap", ".3f")),
    ]
    kinds = [
        row(f"{kind}, {len(names)}", lambda made: f"{mean(made)} ({sum(map(good, made))})", names)
        for kind, names in gallery.kinds().items()
    ]
    faults = []
    for name, figure in LIMITED.items():
        counts = row(
            f"{figure.title}, {figure.within()}",
            lambda made, name=name: str(sum(_over_limit(one, name) for one in made) or ""),
        )
        if any(counts[1:]):
            faults.append(counts)
    parts = (
        rows_of(head, whole),
        "By kind of surface, the mean score (and how many are good):\n",
        rows_of(head, kinds),
        f"How many of the {count} are beyond each limit (at the wrap: of the tileable outputs):\n",
        rows_of(head, faults),
    )
    return "\n".join(parts)


def _over_limit(made: Mapping[str, Any], name: str) -> bool:
    value = made["figures"][name]
    return value is not None and LIMITED[name].badness(value) > 1


def _over(mean: Callable[[list[float]], float], found: list[float], form: str) -> str:
    return format(mean(found), form) if found else "–"


def _seconds(found: Iterable[float]) -> str:
    middle = statistics.median(found)
    return f"{middle:.2g}" if middle < 10 else f"{middle:.0f}"


def scores(gallery: Gallery) -> str:
    """The score of every surface with every method; for auto also the method it took."""
    rows = []
    for name, about in gallery.surfaces.items():
        cells = []
        for method in gallery.methods:
            made = gallery.found[name, method]
            chosen = f" {made['provenance']['method']}" if method == AUTO else ""
            cells.append(f"{score(made)}{chosen}")
        rows.append([f"[{name}](quality-figures.md#{name})", about["class"], *cells])
    return rows_of(["surface", "kind", *map(page_of, gallery.methods)], rows)


def judged(gallery: Gallery) -> str:
    """Scores of the independent measure, of the pictures that are still the same."""
    with open(JUDGED, encoding="utf-8", newline="") as file:
        listed = {(row["surface"], row["method"]): row for row in csv.DictReader(file)}
    changed, rows, same = 0, [], {method: [] for method in gallery.methods}
    for name in gallery.surfaces:
        cells = []
        for method in gallery.methods:
            row = listed.get((name, method))
            if row is None:
                cells.append("–")
            elif row["picture"] != gallery.found[name, method]["picture"]:
                cells.append("picture changed")
                changed += 1
            else:
                same[method].append(row)
                cells.append(_marked(row))
        real = listed.get((name, "real"))
        rows.append([name, "" if real is None else _marked(real), *cells])
    totals = [_totals([listed[key] for key in listed if key[1] == "real"])]
    totals += [_totals(found) for found in same.values()]
    rows.insert(0, ["mean (good, of)", *totals])
    known = sum(map(len, same.values()))
    text = f"{known} of {known + changed} judged pictures are as they were when they were judged.\n"
    return f"{text}\n{rows_of(['', 'real', *map(page_of, gallery.methods)], rows)}"


def _marked(row: Mapping[str, str]) -> str:
    value = f"{float(row['score']):.2f}"
    return f"**{value}**" if row["good"] == "yes" else value


def _totals(found: list[Mapping[str, str]]) -> str:
    if not found:
        return ""
    mean = statistics.fmean(float(row["score"]) for row in found)
    return f"{mean:.2f} ({sum(row['good'] == 'yes' for row in found)}, {len(found)})"


def figures(gallery: Gallery) -> str:
    """A section for each surface, a row for each method."""
    titles = [figure.title for name, figure in LIMITED.items()]
    parts = []
    for name, about in gallery.surfaces.items():
        rows = []
        for method in gallery.methods:
            made = gallery.found[name, method]
            flags = made["figures"]["flags"]
            cells = [
                ("–" if value is None else f"**{value:.2f}**" if over else f"{value:.2f}")
                for value, over in (
                    (made["figures"][key], key in flags or _over_limit(made, key))
                    for key in LIMITED
                )
            ]
            rows.append([page_of(method), score(made), *cells])
        told = "".join(
            f"* {method}: {made['verdict']}{_parameters(made)}\n"
            for method, made in ((m, gallery.found[name, m]) for m in gallery.methods)
        )
        table = rows_of(["method", "score", *titles], rows)
        parts.append(f"## {name}\n\n{about['subject']}; {about['class']}.\n\n{table}\n{told}")
    return "\n".join(parts)


def _parameters(made: Mapping[str, Any]) -> str:
    """The parameters that were settled from the sample and differ from the method's defaults."""
    given = made["provenance"]
    usual = {field.name: field.default for field in fields(method_class(given["method"]))}
    told = [
        f"{name} {_plain(given[name])}"
        for name, default in usual.items()
        if name in given and given[name] != default and given[name] is not None
    ]
    reason = f" {given['reason']}." if "reason" in given else ""
    return f"{reason} ({', '.join(told)})" if told else reason


def _plain(value: Any) -> str:
    return " ".join(f"{v:g}" for v in value) if isinstance(value, (list, tuple)) else str(value)


# ------------------------------------------------------------------------------------- pictures


def pictures(gallery: Gallery) -> str:
    """A page with a section for each surface: sample and output of auto, and all methods."""
    parts = ["<h1>Every surface with every method</h1>"]
    for name, about in gallery.surfaces.items():
        parts.append(f'<h2 id="{name}">{name}</h2>\n<p>{escape(about["subject"])}</p>')
        if (name, AUTO) in gallery.found:
            made = gallery.found[name, AUTO]
            chosen = f"auto: {made['provenance']['reason']}; score {_plain_score(made)}"
            parts.append(
                _figure(f"{name}.webp", f"{name}: sample, tileable output, output; {chosen}")
            )
        if gallery.shown:
            told = [f"{m} {_plain_score(gallery.found[name, m])}" for m in gallery.shown]
            lines = [", ".join(told[k : k + _ACROSS]) for k in range(0, len(told), _ACROSS)]
            parts.append(_figure(f"{name}-methods.webp", "; ".join(lines)))
    return document("Every surface with every method", parts)


def _plain_score(made: Mapping[str, Any]) -> str:
    return score(made).strip("*")


def _figure(file: str, told: str) -> str:
    told = escape(told)
    return (
        f'<figure><img src="pictures/{file}" alt="{told}"><figcaption>{told}</figcaption></figure>'
    )


def draw(gallery: Gallery, name: str, images: Path) -> None:
    """Write the pictures of a surface."""
    file = (DATA / "surfaces" / gallery.surfaces[name]["file"]).resolve()
    exemplar = weftex.load_exemplar(file)

    def shown(method: str, kind: str = "") -> np.ndarray:
        path = gallery.keep / method / f"{name}{kind}.png"
        return flat(exemplar, weftex.read_image(path).pixels)

    if (name, AUTO) in gallery.found:
        tile = as_shown(
            exemplar, weftex.read_image(gallery.keep / AUTO / f"{name}-tile.png").pixels
        )
        tile = np.roll(tile, [side // 2 for side in tile.shape[:2]], (0, 1))
        left = _stack([flat(exemplar, exemplar.pixels), tile])
        _save(images / f"{name}.webp", [[left, shown(AUTO)]])
    middles = [_middle(shown(method)) for method in gallery.shown]
    lines = [middles[at : at + _ACROSS] for at in range(0, len(middles), _ACROSS)]
    if lines:
        _save(images / f"{name}-methods.webp", lines)


def flat(exemplar: weftex.Exemplar, pixels: np.ndarray) -> np.ndarray:
    """Three channels of bytes, over a plain background where there is alpha."""
    if not exemplar.alpha:
        return as_shown(exemplar, pixels)
    share = pixels[..., -1:] / 255
    found: np.ndarray = np.rint(pixels[..., :3] * share + _SKY * (1 - share)).astype(np.uint8)
    return found


def _middle(pixels: np.ndarray) -> np.ndarray:
    """The middle of a large picture; a small one in the middle of white."""
    found = np.full((_MIDDLE, _MIDDLE, 3), 255, np.uint8)
    high, wide = (min(side, _MIDDLE) for side in pixels.shape[:2])
    top, left = ((side - cut) // 2 for side, cut in zip(pixels.shape, (high, wide), strict=False))
    y, x = (_MIDDLE - high) // 2, (_MIDDLE - wide) // 2
    found[y : y + high, x : x + wide] = pixels[top : top + high, left : left + wide]
    return found


def _stack(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """Pictures one below the other."""
    size = sum(p.shape[0] + _GAP for p in pictures) - _GAP, max(p.shape[1] for p in pictures)
    found = np.full((*size, 3), 255, np.uint8)
    y = 0
    for pixels in pictures:
        found[y : y + pixels.shape[0], : pixels.shape[1]] = pixels
        y += pixels.shape[0] + _GAP
    return found


def _save(path: Path, lines: Sequence[Sequence[np.ndarray]]) -> None:
    """Lay pictures in lines; those of a line may differ in size."""
    wide = max(sum(p.shape[1] + _GAP for p in line) for line in lines) - _GAP
    heights = [max(p.shape[0] for p in line) for line in lines]
    whole = Image.new("RGB", (wide, sum(heights) + _GAP * (len(lines) - 1)), "white")
    y = 0
    for line, height in zip(lines, heights, strict=True):
        x = 0
        for pixels in line:
            whole.paste(Image.fromarray(pixels), (x, y))
            x += pixels.shape[1] + _GAP
        y += height + _GAP
    whole.save(path, quality=_QUALITY, method=6)


def rows_of(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = (f"| {' | '.join(cells)} |\n" for cells in (head, ["---"] * len(head), *rows))
    return "".join(lines)
