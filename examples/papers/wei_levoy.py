"""The experiments of Wei and Levoy's paper, run again with weftex.

python examples/papers/wei_levoy.py EXPERIMENT -o FOLDER [--small]

Experiments that draw a picture: surfaces levels windows search constrained tileable comparison;
that print a table and write it as Markdown: times; `all` runs every one. Seconds are of processor
time. L.-Y. Wei and M. Levoy, Fast texture synthesis using tree-structured vector quantization,
SIGGRAPH 2000.
Needs Pillow beside weftex: pip install '.[test]'.
"""

from __future__ import annotations

from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

import numpy as np
from _common import Table, load, run, sheet, sized, some

import weftex

#: A picture and its label.
Labelled = tuple[str, np.ndarray]


def timed(pixels: np.ndarray, size: int, trials: int = 1, **parameters: Any) -> tuple[Any, ...]:
    """A result with the seconds that analysis and synthesis took, medians of the trials."""
    method = weftex.METHODS[parameters.pop("method", "wei-levoy")](**parameters)
    fits, samples = [], []
    for _ in range(trials):
        start = process_time()
        model = method.fit(weftex.Exemplar(pixels))
        middle = process_time()
        result = model.sample(sized(size), seed=1)
        fits.append(middle - start)
        samples.append(process_time() - middle)
    return result, median(fits), median(samples)


def drawn(label: str, pixels: np.ndarray, size: int = 192, **parameters: Any) -> Labelled:
    result, fit, sample = timed(pixels, size, **parameters)
    return f"{label}, {fit + sample:.2f} s", result.image


# ------------------------------------------------------------------------------------- pictures


def surfaces(folder: Path, suffix: str) -> None:
    """Sample, output and where each pixel comes from, with the defaults."""
    rows = []
    for name in some(("weave", "pebbles", "bricks")):
        exemplar = weftex.load_exemplar(f"sample:{name}")
        result = weftex.WeiLevoy().fit(exemplar).sample(sized(256), seed=1)
        sources = result.draw("sources")
        rows.append(
            [("sample", exemplar.pixels), ("wei-levoy", result.image), ("sources", sources)]
        )
    sheet(folder / f"wei_levoy_surfaces{suffix}", rows)


def levels(folder: Path, suffix: str) -> None:
    """One resolution beside pyramids of two to four levels."""
    rows = []
    for name in some(("pebbles", "bricks", "grass")):
        sample = load(name, 160)
        row = [("sample", sample)]
        row += [drawn(f"levels {n}", sample, levels=n) for n in (1, 2, 3, 4)]
        rows.append(row)
    sheet(folder / f"wei_levoy_levels{suffix}", rows)


def windows(folder: Path, suffix: str) -> None:
    """Window widths S and N, at three levels."""
    rows = []
    for name in some(("pebbles", "bricks", "weave")):
        sample = load(name, sized(160))
        row = [("sample", sample)]
        for own, parent in ((5, 1), (5, 3), (9, 3), (9, 7)):
            widths = {"window_width": own, "parent_width": parent, "levels": 3}
            row.append(drawn(f"S {own}, N {parent}", sample, **widths))
        rows.append(row)
    sheet(folder / f"wei_levoy_windows{suffix}", rows)


SEARCHES: dict[str, dict[str, Any]] = {
    "full": {"search": "full"},
    "256 leaves, 1": {"tree_size": 256, "leaves": 1},
    "all leaves, 1": {"leaves": 1},
    "all leaves, 8": {"leaves": 8},
    "all leaves, 64": {"leaves": 64},
}


def search(folder: Path, suffix: str) -> None:
    """Full search beside trees: how many leaves there are and how many are looked into."""
    rows = []
    for name in some(("pebbles", "bricks", "wood")):
        sample = load(name, sized(128))
        row = [("sample", sample)]
        row += [drawn(label, sample, levels=3, **how) for label, how in SEARCHES.items()]
        rows.append(row)
    sheet(folder / f"wei_levoy_search{suffix}", rows)


def constrained(folder: Path, suffix: str) -> None:
    """Holes, filled in two passes from the border inwards."""
    rows = []
    for name in some(("bricks", "weave", "pebbles")):
        photo = load(name, sized(192))
        y, x = np.indices(photo.shape[:2]) * (192 / len(photo)) - 96
        hole = (y / 40) ** 2 + (x / 54) ** 2 < 1
        empty = np.where(hole[..., None], 0, photo).astype(np.uint8)
        row = [("photo", photo), ("hole", empty)]
        for label, how in {
            "one level": {"levels": 1},
            "pyramid": {},
            "full search": {"search": "full"},
        }.items():
            start = process_time()
            filled = weftex.fill(empty, hole, method="wei-levoy", seed=1, **how).image
            assert (filled[~hole] == photo[~hole]).all()
            row.append((f"{label}, {process_time() - start:.2f} s", filled))
        rows.append(row)
    sheet(folder / f"wei_levoy_constrained{suffix}", rows)


def tileable(folder: Path, suffix: str) -> None:
    """Two by two tiles: the causal pass alone, and with the border processed again."""

    def twice(result: weftex.Synthesis) -> np.ndarray:
        return np.tile(result.image, (2, 2, 1))

    rows = []
    for name in some(("pebbles", "wood")):
        sample = load(name, sized(160))
        row = [("sample", sample)]
        for count in (1, 3):
            model = weftex.WeiLevoy(levels=count).fit(weftex.Exemplar(sample))
            plain, closed = (
                model.sample(sized(96), seed=2, tileable=wrap) for wrap in (False, True)
            )
            row.append((f"levels {count}, one causal pass", twice(plain)))
            row.append((f"levels {count}, tileable", twice(closed)))
        rows.append(row)
    sheet(folder / f"wei_levoy_tileable{suffix}", rows)


def comparison(folder: Path, suffix: str) -> None:
    """Beside non-parametric sampling (section IV), 128x128 to 200x200."""
    rows = []
    for name in some(("pebbles", "bricks", "weave")):
        sample = load(name, sized(128))
        rows.append(
            [
                ("sample", sample),
                drawn("efros-leung 15", sample, 200, method="efros-leung", window_width=15),
                drawn("full", sample, 200, levels=3, search="full"),
                drawn("tsvq", sample, 200, levels=3),
            ]
        )
    sheet(folder / f"wei_levoy_comparison{suffix}", rows)


# --------------------------------------------------------------------------------------- tables


def times() -> Table:
    """Analysis and synthesis, 128x128 to 200x200, three levels, of each search."""
    notes = """
128x128 to 200x200, three levels, windows of 9 and 7 pixels; medians of 3 runs and of three samples.
"x" is how many times shorter synthesis is than with the full search.
"""
    seconds: dict[str, list[tuple[float, float]]] = {label: [] for label in SEARCHES}
    for name in some(("pebbles", "bricks", "wood")):
        sample = load(name, sized(128))
        for label, how in SEARCHES.items():
            trials = 1 if label == "full" else len(some(range(3)))
            seconds[label].append(timed(sample, 200, trials, levels=3, **how)[1:])
    full = median(sample for _, sample in seconds["full"])
    rows = []
    for label, pairs in seconds.items():
        fit, sample = (median(column) for column in zip(*pairs, strict=True))
        rows.append([label, f"{fit:.2f} s", f"{sample:.2f} s", f"{full / sample:.0f} x"])
    return notes, ["search", "analysis", "synthesis", "x"], rows


FIGURES = (surfaces, levels, windows, search, constrained, tileable, comparison)
TABLES = (times,)

if __name__ == "__main__":
    run(__doc__, FIGURES, TABLES, name="wei_levoy_{}")
