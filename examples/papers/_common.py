"""What the scripts of this folder share: samples, sheets of pictures, tables and the command line.

Needs Pillow and SciPy beside weftex: pip install '.[test]'.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from time import perf_counter
from typing import TypeVar

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

import weftex

HERE = Path(__file__).parent
Item = TypeVar("Item")
#: Notes, the names of the columns, and the rows.
Table = tuple[str, Sequence[str], Sequence[Sequence[str]]]
#: Draws pictures into a folder, as files with this suffix.
Figure = Callable[[Path, str], None]

_MOST_SMALL_PIXELS = 64
_small = False


def make_small(small: bool = True) -> None:
    """From now on as with --small, or not."""
    global _small
    _small = small


def sized(side: int) -> int:
    """Side of a sample or of a picture to make; with --small no more than 64 pixels."""
    return min(side, _MOST_SMALL_PIXELS) if _small else side


def some(items: Iterable[Item], least: int = 1) -> list[Item]:
    """The samples, settings or trials to go through; with --small only the first."""
    return list(items)[: least if _small else None]


def load(name: str, side: int | None = None) -> np.ndarray:
    """Pixels of a sample that ships with weftex or lies in examples/samples, or a crop of them."""
    own = HERE.parent / "samples" / f"{name}.png"
    pixels = weftex.load_exemplar(own if own.exists() else f"sample:{name}").pixels
    return np.ascontiguousarray(pixels[:side, :side])


def shrunk(pixels: np.ndarray, factor: int) -> np.ndarray:
    """Means over factor x factor pixels."""
    height, width = (n // factor * factor for n in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // factor, factor, width // factor, factor, -1)
    return np.rint(blocks.mean(axis=(1, 3))).astype(np.uint8)


def clouds(side: int) -> np.ndarray:
    """A smooth texture of our own: noise whose power falls with its frequency."""
    noise = np.fft.rfft2(np.random.default_rng(2).normal(size=(side, side)))
    y, x = np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side)
    smooth = np.fft.irfft2(noise / (0.02 + np.hypot(y, x)) ** 2, (side, side))
    return np.rint(255 * (smooth - smooth.min()) / np.ptp(smooth)).astype(np.uint8)


def pieces(result: weftex.Synthesis) -> np.ndarray:
    """Size of the piece copied as a whole that each pixel belongs to."""
    source = result.source
    index = np.arange(source.shape[0] * source.shape[1]).reshape(result.shape)
    pairs = []
    for step, first, second in (
        ((1, 0), np.s_[:-1], np.s_[1:]),
        ((0, 1), np.s_[:, :-1], np.s_[:, 1:]),
    ):
        goes_on = (source[second] == source[first] + step).all(axis=2) & (source[first] >= 0).all(2)
        pairs.append((index[first][goes_on], index[second][goes_on]))
    rows, columns = (np.concatenate(ends) for ends in zip(*pairs, strict=True))
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(index.size, index.size))
    number = connected_components(graph, directed=False)[1].reshape(result.shape)
    return np.bincount(number.ravel())[number]


def sheet(path: Path, rows: Sequence[Sequence[tuple[str, np.ndarray]]], gap: int = 10) -> None:
    """Write pictures with labels under them, row by row."""
    font = ImageFont.load_default(13)
    line = 20
    columns = range(max(len(row) for row in rows))
    wide = [max(row[c][1].shape[1] for row in rows if c < len(row)) for c in columns]
    high = [max(pixels.shape[0] for _, pixels in row) + line for row in rows]
    size = (sum(wide) + gap * (len(wide) + 1), sum(high) + gap * (len(high) + 1))
    whole = Image.new("RGB", size, "white")
    pen = ImageDraw.Draw(whole)
    y = gap
    for row, height in zip(rows, high, strict=True):
        x = gap
        for (label, pixels), width in zip(row, wide, strict=False):
            whole.paste(Image.fromarray(np.squeeze(pixels)).convert("RGB"), (x, y))
            pen.text((x, y + pixels.shape[0] + 2), label, "black", font)
            x += width + gap
        y += height + gap
    whole.save(path, quality=85)
    print(f"wrote {path}")


def as_markdown(table: Table) -> str:
    notes, head, rows = table
    lines = [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]
    return "\n".join([*notes.strip().splitlines(), "", *lines, ""])


def run(
    doc: str | None,
    figures: Sequence[Figure],
    tables: Sequence[Callable[[], Table]] = (),
    name: str = "{}",
) -> None:
    """Run the experiments that the command line names; `name` is that of a table's file."""
    drawn = {f.__name__: f for f in figures}
    counted = {f.__name__: f for f in tables}
    every = [*drawn, *counted]
    lines = "\n".join(f"  {f.__name__:12}{f.__doc__}" for f in (*figures, *tables))
    parser = argparse.ArgumentParser(
        description=f"{doc}\n{lines}", formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("experiment", choices=(*every, "all"), nargs="+")
    parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
    parser.add_argument("--format", default="png", choices=("png", "jpg", "webp"))
    parser.add_argument(
        "--small",
        action="store_true",
        help="pictures of 64 pixels, of the first samples: shows that all runs, measures nothing",
    )
    args = parser.parse_args()
    make_small(args.small)
    args.output.mkdir(parents=True, exist_ok=True)
    for experiment in every if "all" in args.experiment else args.experiment:
        start = perf_counter()
        if experiment in drawn:
            drawn[experiment](args.output, f".{args.format}")
        else:
            text = as_markdown(counted[experiment]())
            path = args.output / f"{name.format(experiment)}.md"
            path.write_text(text, encoding="utf-8")
            print(f"\n{text}\nwrote {path}")
        print(f"{experiment}: {perf_counter() - start:.1f} s")
