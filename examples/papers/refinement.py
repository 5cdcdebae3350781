"""The experiments of the paper on texture refinement, run again with weftex.

python examples/papers/refinement.py EXPERIMENT -o FOLDER [--small]

Experiments that draw a picture: fig4 fig5 fig6 fig7 fig8 recipe fig9 fig10 fig11 fig12 fig13
density evenness init; that print a table and write it as Markdown: table1 (takes
minutes) and steps (takes a quarter of an hour); `all` runs every one. Figures are those of the
paper on iterative texture refinement and texture fusion; density is of its section 6, recipe and
steps replace its steps one at a time. Needs Pillow beside weftex: pip install '.[test]'.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from _common import HERE, Table, clouds, load, run, sheet, sized, some
from PIL import Image, ImageDraw

import weftex
from weftex.analysis.scale import structure_scale
from weftex.methods.refinement.start import plant_seeds
from weftex.search.windows import windows_of

#: What the paper does and weftex does not by default.
PAPER: dict[str, Any] = {"search": "nearest", "init": "seeds"}

#: Its recipe, and one step of it at a time replaced by another.
STEPS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("the paper's recipe", PAPER),
    ("one iteration", {**PAPER, "iterations": 1}),
    ("started from quilting", {**PAPER, "init": "quilting"}),
    ("coherent search", {**PAPER, "search": "coherent"}),
    ("both: the default", {}),
)


def make(pixels: np.ndarray, size: int = 200, **parameters: Any) -> weftex.Synthesis:
    return weftex.synthesize(pixels, sized(size), method="refinement", seed=1, **parameters)


def curve(
    lines: Sequence[tuple[str, Sequence[float]]], size: tuple[int, int], top: float | None = None
) -> np.ndarray:
    """Draw curves from 0 to `top`, or to their own largest values, with those as labels."""
    colors = ("black", "firebrick", "royalblue")
    width, height = size
    picture = Image.new("RGB", size, "white")
    pen = ImageDraw.Draw(picture)
    pen.line([(8, 8), (8, height - 8), (width - 8, height - 8)], "gray")
    for number, (label, values) in enumerate(lines):
        most = max(values)
        across = (width - 20) / max(len(values) - 1, 1)
        points = [
            (10 + k * across, height - 10 - v / (top or most or 1) * (height - 30))
            for k, v in enumerate(values)
        ]
        pen.line(points, colors[number], 2)
        pen.text((60, 12 + 14 * number), f"{label}, at most {most:.3g}", colors[number])
    return np.asarray(picture)


# ------------------------------------------------------------------------------------- pictures


def fig4(folder: Path, suffix: str) -> None:
    """Scale estimation: the power of rings, and the scale of the highest."""
    rows = []
    for name in some(("pebbles", "weave", "grass")):
        sample = load(name, 192)
        found = structure_scale(weftex.Exemplar(sample))
        shown = sample.copy()
        side = round(found.scale)
        shown[8 : 8 + side, 8], shown[8 : 8 + side, 8 + side] = 255, 255
        shown[8, 8 : 8 + side], shown[8 + side, 8 : 8 + side] = 255, 255
        label = f"scale {found.scale:.1f}, confidence {found.confidence:.2f}"
        lines = [("P(r)", found.power.tolist()), ("background", found.background.tolist())]
        rows.append([(label, shown), ("power of rings", curve(lines, (320, 192), 1.0))])
    sheet(folder / f"fig4_refinement{suffix}", rows)


def fig5(folder: Path, suffix: str) -> None:
    """Seed points: their colors as squares, and what the first iteration makes of them."""
    rows = []
    for name in some(("pebbles", "weave")):
        sample = load(name, 192)
        exemplar = weftex.Exemplar(sample)
        scale = max(1, round(structure_scale(exemplar).scale))
        plain = windows_of(exemplar, (0, 0, 0, 0))
        places, *_ = plant_seeds(plain, (192, 192), (False, False), scale, 5, seed=1)
        colors = sample.reshape(-1, *sample.shape[2:])[places]
        seeds = colors.repeat(scale, 0).repeat(scale, 1)[:192, :192]
        made = make(sample, 192, **PAPER, iterations=1).image
        rows.append([("sample", sample), (f"seeds, {scale} px", seeds), ("one iteration", made)])
    sheet(folder / f"fig5_refinement{suffix}", rows)


def painted(colors: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """A map in one color for each label."""
    return np.asarray(colors, np.uint8)[labels]


def fig6(folder: Path, suffix: str) -> None:
    """Texture fusion: two samples, a map of two colors, and the output."""
    rows = []
    side = sized(256)
    y, x = np.indices((side, side))
    labels = ((y / side - 0.5) ** 2 + (x / side - 0.5) ** 2 < 0.09).astype(np.int32)
    shown = painted(np.array([(160, 60, 50), (70, 90, 160)]), labels)
    for pair in some((("leaves", "pebbles"), ("stone_wall", "leaves"))):
        samples = [load(name, 192) for name in pair]
        made = weftex.fuse(samples, labels, seed=1, method="refinement").image
        rows.append([*(("sample", s) for s in samples), ("map", shown), ("output", made)])
    sheet(folder / f"fig6_refinement{suffix}", rows)


def fig7(folder: Path, suffix: str) -> None:
    """Convergence: mean squared error and pixels changed, iteration by iteration."""
    rows = []
    cases: list[tuple[str, int, dict[str, Any]]]
    cases = [("nearest", 20, PAPER), ("coherent", 10, {"init": "seeds"})]
    for label, iterations, how in cases:
        iterations = len(some(range(iterations), least=3))
        result = make(load("pebbles", sized(128)), 128, iterations=iterations, threshold=0.0, **how)
        points = result.provenance["convergence"]
        lines = [
            ("MSE", [p["mse"] for p in points[1:]]),
            ("share of pixels changed", [p["changed"] for p in points[1:]]),
        ]
        rows.append([(label, result.image), ("from the 2nd iteration", curve(lines, (360, 180)))])
    sheet(folder / f"fig7_refinement{suffix}", rows)


def fig8(folder: Path, suffix: str) -> None:
    """Iterations side by side: the paper's recipe, and in the last row the coherent search."""
    rows = []
    cases: list[tuple[str, dict[str, Any]]] = [
        ("pebbles", PAPER),
        ("weave", PAPER),
        ("grass", PAPER),
        ("grass", {"init": "seeds"}),
    ]
    for name, how in some(cases):
        sample = load(name, sized(128))
        row = [("sample", sample)]
        for iterations in some((1, 2, 5, 10), least=2):
            made = make(sample, 128, **how, iterations=iterations, threshold=0.0)
            row.append((f"iteration {iterations}", made.image))
        rows.append(row)
    sheet(folder / f"fig8_refinement{suffix}", rows)


def recipe(folder: Path, suffix: str) -> None:
    """The paper's recipe, and one step of it at a time replaced by another."""
    rows = []
    for name in some(("pebbles", "weave", "grass")):
        sample = load(name, sized(128))
        made = [(label, make(sample, 128, **how).image) for label, how in STEPS]
        rows.append([("sample", sample), *made])
    sheet(folder / f"recipe_refinement{suffix}", rows)


def fig9(folder: Path, suffix: str) -> None:
    """Results at the defaults, with their sources."""
    rows = []
    for name in some(("pebbles", "grass", "weave")):
        sample = load(name, 192)
        result = make(sample, 256)
        row = [("sample", sample), ("output", result.image), ("sources", result.draw("sources"))]
        rows.append(row)
    sheet(folder / f"fig9_refinement{suffix}", rows)


def fig10(folder: Path, suffix: str) -> None:
    """Beside the methods of Wei and Levoy and of Ashikhmin."""
    rows = []
    samples = [load("weave", 192), load("pebbles", 192), clouds(192), load("wood", 128)]
    methods = ("wei-levoy", "ashikhmin", "refinement")
    for sample in some(samples):
        row = [("sample", sample)]
        for method in methods:
            made = weftex.synthesize(sample, sized(200), method=method, seed=1)
            row.append((method, made.image))
        rows.append(row)
    sheet(folder / f"fig10_refinement{suffix}", rows)


def fig11(folder: Path, suffix: str) -> None:
    """Two materials by a map of circles, and three by a painted map."""
    side = sized(400)
    two = [load("pebbles"), load("leaves")]
    slope = weftex.fuse(two, "gradient", size=side, seed=1, method="refinement").image
    three = [*two, load("stone_wall")]
    y, x = np.indices((side, side)) / side
    labels = np.where(y > 0.7 + 0.06 * np.sin(8 * x), 2, (y + x > 0.8).astype(int))
    colors = painted(np.array([(70, 90, 160), (160, 60, 50), (90, 120, 60)]), labels)
    made = weftex.fuse(three, labels, seed=1, method="refinement").image
    rows = [
        [*(("sample", sample) for sample in two), ("circles", slope)],
        [*(("sample", sample) for sample in three), ("map", colors), ("output", made)],
    ]
    sheet(folder / f"fig11_refinement{suffix}", rows)


def fig12(folder: Path, suffix: str) -> None:
    """Constrained synthesis in cyclic order."""
    rows = []
    for name in some(("bricks", "pebbles", "grass")):
        photo = load(name, 192)
        y, x = np.indices(photo.shape[:2])
        hole = ((y - 100) / 42) ** 2 + ((x - 90) / 54) ** 2 < 1
        empty = photo.copy()
        empty[hole] = 0
        row = [("hole", empty)]
        for label, how in (("from quilting", {}), ("from seeds", {"init": "seeds"})):
            filled = weftex.fill(empty, hole, method="refinement", seed=1, **how).image
            assert (filled[~hole] == photo[~hole]).all()
            row.append((label, filled))
        rows.append(row)
    sheet(folder / f"fig12_refinement{suffix}", rows)


def fig13(folder: Path, suffix: str) -> None:
    """Patches placed by matching, and belts along their seams refined."""
    rows = []
    for name in some(("leaves", "tiles")):
        sample = load(name, 192)
        row = [("sample", sample)]
        starts = weftex.Quilting(), weftex.GraphCut(), weftex.GraphCut(placement="entire")
        for start, label in zip(starts, ("quilting", "graphcut", "entire samples"), strict=True):
            made = weftex.synthesize(sample, sized(224), method=start, seed=1).image
            row.append((label, made))
            row.append(("its joints refined", make(sample, 224, init=start, joints=24).image))
        rows.append(row)
    sheet(folder / f"fig13_refinement{suffix}", rows)


def density(folder: Path, suffix: str) -> None:
    """Seed points for each scale: few leave structure to chance, many copy or contradict."""
    rows = []
    for name in some(("pebbles", "bricks")):
        sample = load(name, 192)
        row = [("sample", sample)]
        for points in (0.25, 0.5, 1.0, 2.0):
            made = make(sample, 192, init="seeds", seed_density=points).image
            row.append((f"density {points:g}", made))
        rows.append(row)
    sheet(folder / f"density_refinement{suffix}", rows)


def evenness(folder: Path, suffix: str) -> None:
    """With and without a counterweight to places that are used too often, and their sources."""
    sample = load("leaves", 192)
    row = [("sample", sample)]
    for weight in (0.0, 1.0):
        result = make(sample, 224, init="seeds", evenness=weight)
        row += [(f"evenness {weight:g}", result.image), ("sources", result.draw("sources"))]
    sheet(folder / f"evenness_refinement{suffix}", [row])


def init(folder: Path, suffix: str) -> None:
    """What it starts from."""
    rows = []
    for name in some(("bricks", "leaves")):
        sample = load(name, 192)
        row = [("sample", sample)]
        for start in ("seeds", "quilting", "graphcut", "near-regular"):
            row.append((start, make(sample, 224, init=start).image))
        rows.append(row)
    sheet(folder / f"init_refinement{suffix}", rows)


# --------------------------------------------------------------------------------------- tables


def table1() -> Table:
    """Table 1: seconds of analysis and of synthesis."""
    notes = """
Table 1: 200x200 from 128x128 and 192x192 pebbles, ten iterations, seconds of processor time. The
paper's are of a 3.2 GHz Pentium IV, for samples of that size. "Changed" and "difference" (eq. 1)
are of the last iteration.
"""
    paper = {128: "stone, scale 15: 287 + 1.2 + 222", 192: "rope, scale 18: 392 + 3.8 + 259"}
    rows = []
    make(load("pebbles", 64), 64)  # what is loaded at first use
    for side in some((128, 192)):
        exemplar = weftex.Exemplar(load("pebbles", sized(side)))
        for label, how in (
            ("default", {}),
            ('init="seeds"', {"init": "seeds"}),
            ('search="nearest"', {**PAPER, "threshold": 0.0}),
        ):
            start = process_time()
            model = weftex.Refinement(**how).fit(exemplar)
            middle = process_time()
            result = model.sample(sized(200), seed=1)
            times = f"{middle - start:.2f} s", f"{process_time() - middle:.2f} s"
            last = result.provenance["convergence"][-1]
            shares = f"{last['changed']:.3f}", f"{last['difference']:.3f}"
            width = str(model.method.window_width)
            theirs = paper[side] if "search" in how else ""
            rows.append([str(side), label, width, *times, *shares, theirs])
    head = ["sample", "", "window", "analysis", "synthesis", "changed", "difference"]
    return notes, [*head, "paper: PCA + tree + synthesis"], rows


def steps() -> Table:
    """The recipe in figures: patches, sharpness and seams of each step's picture."""
    notes = """
128x128 from the lower right 128x128 of the samples, seed 1: patches / sharpness / seams of
`weftex.assess`. Good are patches of at most 1.6, sharpness of 0.87 to 1.15, seams of at most 1.75.
"""
    sand = HERE.parents[1] / "benchmarks" / "data" / "surfaces" / "sand_coast.webp"
    crops = {name: load(name) for name in ("pebbles", "leaves", "grass", "weave", "bricks")}
    crops["sand"] = weftex.load_exemplar(sand).pixels
    side = sized(128)
    exemplars = {k: weftex.Exemplar(v[-side:, -side:]) for k, v in some(crops.items())}
    widths = [weftex.Refinement(**PAPER).resolved(e).window_width for e in exemplars.values()]
    rows = [["window of the recipe, px", *map(str, widths)]]
    for label, how in some(STEPS):
        row = [label]
        for exemplar in exemplars.values():
            found = weftex.assess(exemplar, make(exemplar.pixels, 128, **how))
            row.append(f"{found.patches:.2f} / {found.sharpness:.2f} / {found.seams:.2f}")
        rows.append(row)
    return notes, ["", *exemplars], rows


FIGURES = (
    fig4, fig5, fig6, fig7, fig8, recipe, fig9, fig10, fig11, fig12, fig13,
    density, evenness, init,
)  # fmt: skip
TABLES = (table1, steps)

if __name__ == "__main__":
    run(__doc__, FIGURES, TABLES, name="refinement_{}")
