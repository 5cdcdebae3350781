"""The figures and the table of exact neighborhood matching, made again with weftex.

python examples/papers/exact_matching.py EXPERIMENT -o FOLDER [--small]

Experiments that draw a picture: fig6 fig7 fig8 fig10 fig11 fig12 fig13 levels; that print a table
and write it as Markdown: table1 fig9 grouping; `all` runs every one. M. Sabha, P. Peers and P.
Dutré, Texture synthesis using exact neighborhood matching, Computer Graphics Forum 26(2), 2007.
Needs Pillow beside weftex: pip install '.[test]'.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from _common import Table, load, run, sheet, shrunk, sized, some
from PIL import Image

import weftex
from weftex.search import window_kernels as kernels
from weftex.search.windows import windows_of

#: What the paper does and weftex does not by default.
PAPER: dict[str, Any] = {"repeat_distance": 0, "tolerance": 0.0, "candidates": 0}


class Clock:
    """A progress callback that notes when each stage was last heard of, in seconds from its making.

    `beginning` is the initialization of section 4.3, `rows` the synthesis of section 4.2.
    """

    def __init__(self) -> None:
        self.start, self.ends = perf_counter(), {"beginning": 0.0, "rows": 0.0}

    def __call__(self, done: int, total: int, stage: str, preview: Any) -> None:
        self.ends[stage] = perf_counter() - self.start

    @property
    def stages(self) -> tuple[float, float]:
        """Seconds of the initialization and of the synthesis."""
        return self.ends["beginning"], self.ends["rows"] - self.ends["beginning"]


def measured(model: Any, side: int, seed: int) -> tuple[float, float, float]:
    """Windows compared for a pixel, and the seconds of the initialization and of the synthesis."""
    clock = Clock()
    facts = model.sample(side, seed=seed, threads=1, progress=clock).provenance
    return facts["windows_compared"] / facts["pixels_chosen"], *clock.stages


def crop(name: str, side: int) -> np.ndarray:
    return np.ascontiguousarray(load(name)[:side, :side])


def reduced(pixels: np.ndarray, colors: int) -> np.ndarray:
    """Reduce the picture to at most this number of colors."""
    quantized = Image.fromarray(pixels).quantize(colors, dither=Image.Dither.NONE)
    return np.asarray(quantized.convert("RGB"))


def samples() -> dict[str, tuple[np.ndarray, int, float]]:
    """Samples of the sizes of Table 1 with their windows, and the paper's seconds in all."""
    return {
        "a": (crop("bricks", 192), 69, 27.00),
        "b": (crop("leaves", 199), 33, 14.91),
        "c": (crop("stone_wall", 150), 5, 3.43),
        "d": (shrunk(load("bricks"), 2)[:100, :100], 7, 3.05),
        "e": (crop("leaves", 100), 7, 3.19),
        "f": (crop("stone_wall", 246), 19, 6.80),
        "g": (crop("pebbles", 192), 11, 4.04),
        "h": (reduced(shrunk(load("bricks"), 2)[:100, :100], 234), 33, 125.25),
    }


def brute_force(pixels: np.ndarray, width: int, count: int) -> float:
    """Seconds of comparing `count` pixels with every whole window, from 16 of them.

    No comparison ends early, and choosing from the distances is not counted.
    """
    half = width // 2
    windows = windows_of(weftex.Exemplar(pixels), (half, 0, half, half))
    runs = np.zeros((width * (half + 2), 3), np.int32)
    canvas = np.resize(pixels, (2 * half + 1, 2 * half + 17, 3))
    query, out = np.zeros(width * width * 3, np.uint8), np.zeros(windows.centers.size, np.int64)
    times = []
    for x in range(half, half + 16):
        start = perf_counter()
        n = kernels.causal_runs(half, x, canvas.shape[1], False, half, half, half, runs)
        kernels.gather_runs(canvas, half, x, runs, n, query)
        kernels.distances(windows.pixels, windows.centers, runs, n, query, out)
        times.append(perf_counter() - start)
    return float(np.median(times)) * count


def table1() -> Table:
    """Table 1: what 400x400 pixels cost, stage by stage, beside brute force."""
    notes = """
Table 1: 400x400 pixels from samples of the paper's sizes and windows, in seconds; as in the paper a
color has to match exactly, all listed windows are compared, and a source may be taken again at
once. Medians of 3 runs on one thread. Brute force compares every pixel with every whole window to
its end; its time is extrapolated from 16 pixels. The paper had an AMD64 4000+ (2.4 GHz).
"""
    rows = []
    for label, (pixels, width, paper) in some(samples().items()):
        runs = []
        for seed in some((1, 2, 3)):
            start = perf_counter()
            model = weftex.ExactMatching(window_width=width, **PAPER).fit(weftex.Exemplar(pixels))
            analysis = perf_counter() - start
            tested, *seconds = measured(model, sized(400), seed)
            runs.append((tested, analysis, *seconds))
        tested, *stages = np.median(runs, axis=0).tolist()
        brute, total = brute_force(pixels, width, 400 * 400), sum(stages)
        colors = len(np.unique(pixels.reshape(-1, 3), axis=0))
        size = f"{pixels.shape[1]}x{pixels.shape[0]}"
        cells = [label, size, colors, width, f"{tested:.2f}", *(f"{s:.2f}" for s in stages)]
        ratio = f"{brute / total:.0f} x"
        rows.append([*map(str, cells), f"{total:.2f}", f"{brute:.0f}", ratio, f"{paper:.2f}"])
    head = ["", "source", "colors", "window", "tested a pixel", "analysis", "initialization"]
    head += ["synthesis", "total", "brute force", "speed-up", "paper's total"]
    return notes, head, rows


def fig6(folder: Path, suffix: str) -> None:
    """Results for the rows of Table 1."""
    rows: list[list[tuple[str, np.ndarray]]] = []
    for n, (label, (pixels, width, _)) in enumerate(some(samples().items())):
        if n % 2 == 0:
            rows.append([])
        method = weftex.ExactMatching(window_width=width, **PAPER)
        made = weftex.synthesize(pixels, sized(256), method=method, seed=1).image
        rows[-1] += [(f"({label}) {pixels.shape[1]} px", pixels), (f"window {width}", made)]
    sheet(folder / f"fig6_exact_matching{suffix}", rows)


def fig7(folder: Path, suffix: str) -> None:
    """Quality against tolerance, from an exact match to all windows."""
    rows = []
    for name, width in some((("pebbles", 15), ("weave", 15))):
        pixels = crop(name, 96)
        row = [("sample", pixels)]
        for tolerance in (0, 0.01, 0.05, 0.2, 1):
            method = weftex.ExactMatching(window_width=width, **PAPER | {"tolerance": tolerance})
            made = method.fit(weftex.Exemplar(pixels)).sample(sized(140), seed=1).image
            row.append((f"tolerance {100 * tolerance:g} %", made))
        rows.append(row)
    sheet(folder / f"fig7_exact_matching{suffix}", rows)


def noisy(pixels: np.ndarray) -> np.ndarray:
    """With grain as of a camera: hardly a color occurs twice."""
    grain = np.random.default_rng(0).integers(-8, 9, pixels.shape)
    return np.clip(pixels.astype(int) + grain, 0, 255).astype(np.uint8)


def fig8(folder: Path, suffix: str) -> None:
    """Exact matches alone are too few where hardly a color occurs twice; a tolerance mends it."""
    rows = []
    cases = (
        (noisy(shrunk(load("bricks"), 2)[:112, :112]), 25),
        (noisy(crop("weave", 96)), 19),
    )
    for pixels, width in some(cases):
        row = [("sample", pixels)]
        for tolerance in (0.0, 0.005, 0.01, 0.02):
            settings = PAPER | {"tolerance": tolerance, "init": "random"}
            method = weftex.ExactMatching(window_width=width, **settings)
            made = method.fit(weftex.Exemplar(pixels)).sample(sized(180), seed=1).image
            row.append((f"tolerance {100 * tolerance:g} %", made))
        rows.append(row)
    sheet(folder / f"fig8_exact_matching{suffix}", rows)


def fig9() -> Table:
    """Time against tolerance."""
    notes = """
Figure 9: time against tolerance, 128x128 pixels of pebbles from 96x96 with a window of 15; one run
each, without a cap on the windows compared. At 100 % they are all that have room below them, or
those that a color beside them leads to; comparisons end early.
"""
    rows = []
    for tolerance in (0, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1):
        method = weftex.ExactMatching(window_width=15, **PAPER | {"tolerance": tolerance})
        model = method.fit(weftex.Exemplar(crop("pebbles", 96)))
        tested, *seconds = measured(model, sized(128), 1)
        rows.append([f"{100 * tolerance:g} %", f"{tested:.1f}", f"{sum(seconds):.2f}"])
    return notes, ["tolerance", "tested a pixel", "seconds"], rows


def grouping() -> Table:
    """How much shorter lists get when alike windows are one entry (section 4.4)."""
    notes = """
Groups of alike windows: 200x200 pixels from 100x100, random beginnings, one run each. Groups are of
windows whose root mean square difference is at most the given share of the range.
"""
    rows = []
    y, x = np.indices((100, 100))
    board = ((y // 5 + x // 5) % 2 * 180 + 30).astype(np.uint8)
    cases = {
        "checkerboard, window 15": (board, 15),
        "weave, window 15": (crop("weave", 100), 15),
        "tiles, window 33": (crop("tiles", 100), 33),
        "bricks in 234 colors, window 33": (samples()["h"][0], 33),
    }
    for label, (pixels, width) in some(cases.items()):
        for limit in (0, 0.02, 0.05):
            start = perf_counter()
            model = weftex.ExactMatching(
                window_width=width, grouping=limit, init="random", **PAPER
            ).fit(weftex.Exemplar(pixels))
            analysis = perf_counter() - start
            tested, *seconds = measured(model, sized(200), 1)
            times = f"{analysis:.2f}", f"{sum(seconds):.2f}"
            rows.append([label, f"{limit:g}", f"{tested:.1f}", *times])
    return notes, ["sample", "grouping", "tested a pixel", "analysis", "synthesis"], rows


def fig10(folder: Path, suffix: str) -> None:
    """Where pixels come from, below the band of the initialization in black."""
    rows = []
    cases = (("pebbles", 31), ("leaves", 31), ("weave", 31), ("bricks", 61))
    for name, width in some(cases, least=2):
        sample = weftex.Exemplar(crop(name, 192))
        model = weftex.ExactMatching(window_width=width, **PAPER).fit(sample)
        result = model.sample(sized(240), seed=1)
        band = np.zeros((width // 2, result.shape[1], 3), np.uint8)
        row = [("sample", sample.pixels), (model.method.init, result.image)]
        row.append(("sources", np.concatenate([band, result.draw("sources")])))
        rows.append(row)
    pairs = [rows[k] + rows[k + 1] for k in range(0, len(rows), 2)]
    sheet(folder / f"fig10_exact_matching{suffix}", pairs)


def beside(
    path: Path, cases: Sequence[tuple[np.ndarray, int]], rivals: dict[str, weftex.Method]
) -> None:
    """Draw what several methods make of some samples; each comes with a window."""
    rows = []
    for pixels, width in some(cases):
        row = [("sample", pixels)]
        exact = weftex.ExactMatching(window_width=width, **PAPER)
        for label, method in (rivals | {"exact-matching": exact}).items():
            made = method.fit(weftex.Exemplar(pixels)).sample(sized(220), seed=1).image
            row.append((label, made))
        rows.append(row)
    sheet(path, rows)


def fig11(folder: Path, suffix: str) -> None:
    """Beside other methods that choose pixels: full search, its tree, coherent candidates."""
    rivals = {
        "wei-levoy": weftex.WeiLevoy(search="full", start="noise"),
        "wei-levoy, tree": weftex.WeiLevoy(leaves=1, start="noise"),
        "ashikhmin": weftex.Ashikhmin(passes=1),
    }
    cases = [(crop(name, 128), 31) for name in ("pebbles", "leaves", "weave")]
    cases.append((shrunk(load("bricks"), 2)[:128, :128], 31))
    beside(folder / f"fig11_exact_matching{suffix}", cases, rivals)


def fig12(folder: Path, suffix: str) -> None:
    """Beside methods that choose patches, on structured samples."""
    rivals = {
        "patch-sampling": weftex.PatchSampling(),
        "graphcut": weftex.GraphCut(),
        "near-regular": weftex.NearRegular(defaults="paper"),
    }
    cases = [(crop("bricks", 192), 61), (crop("tiles", 192), 61)]
    beside(folder / f"fig12_exact_matching{suffix}", cases, rivals)


def fig13(folder: Path, suffix: str) -> None:
    """More results, everything as weftex proposes it."""
    rows: list[list[tuple[str, np.ndarray]]] = []
    names = ("weave", "pebbles", "tiles", "leaves", "stone_wall", "grass")
    for n, name in enumerate(some(names)):
        if n % 3 == 0:
            rows.append([])
        pixels = crop(name, 160)
        made = weftex.synthesize(pixels, sized(240), method="exact-matching", seed=1).image
        rows[-1] += [("sample", pixels), ("exact-matching", made)]
    sheet(folder / f"fig13_exact_matching{suffix}", rows)


def levels(folder: Path, suffix: str) -> None:
    """The paper's future work: multi-resolution, with windows of 15 pixels at each level."""
    rows = []
    for name in some(("bricks", "tiles", "leaves")):
        pixels = crop(name, 192)
        row = [("sample", pixels)]
        for count in (1, 2, 3):
            method = weftex.ExactMatching(window_width=15, levels=count)
            made = method.fit(weftex.Exemplar(pixels)).sample(sized(240), seed=1).image
            row.append((f"levels {count}", made))
        rows.append(row)
    sheet(folder / f"levels_exact_matching{suffix}", rows)


FIGURES = (fig6, fig7, fig8, fig10, fig11, fig12, fig13, levels)
TABLES = (table1, fig9, grouping)

if __name__ == "__main__":
    run(__doc__, FIGURES, TABLES, name="{}_exact_matching")
