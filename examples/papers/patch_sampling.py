"""The experiments of the patch-based sampling paper, run again with weftex.

python examples/papers/patch_sampling.py EXPERIMENT -o FOLDER

Experiments that draw a picture: fig1 fig4 fig6 fig7 fig8 fig10 fig11 fig12 fig13 fig14 fig15 fig16
fig17; that print a table and write it as Markdown: copying table1; `all` runs every one.
L. Liang, C. Liu, Y.-Q. Xu, B. Guo and H.-Y. Shum, Real-time texture synthesis by patch-based
sampling, ACM Transactions on Graphics, 2001. `--small` makes all of them small.
Needs Pillow and SciPy beside weftex: pip install '.[test]'.
"""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from _common import Table, clouds, load, pieces, run, sheet, shrunk, sized, some
from PIL import Image, ImageDraw, ImageFont

import weftex

SAMPLES = ("bricks", "grass", "leaves", "pebbles", "stone_wall", "tiles", "weave", "wood")
#: What the paper does and weftex does not by default; its zones are "typically four pixels wide".
PAPER: dict[str, Any] = {
    "method": "patch-sampling",
    "repeat_distance": 0,
    "boundary_width": 4,
    "epsilon": 0.2,
}


def make(pixels: np.ndarray, size: int, **parameters: Any) -> np.ndarray:
    settings = {"method": "patch-sampling"} | parameters
    return weftex.synthesize(pixels, sized(size), seed=1, **settings).image


# ------------------------------------------------------------------------------------- pictures


def fig1(folder: Path, suffix: str) -> None:
    """An example: 192x192 to 256x256, and the seconds that it takes."""
    row = []
    for name in some(("leaves", "pebbles")):
        exemplar = weftex.Exemplar(load(name, 192))
        start = perf_counter()
        model = weftex.PatchSampling().fit(exemplar)
        middle = perf_counter()
        picture = model.sample(sized(256), seed=1).image
        took = f"{middle - start:.2f} + {perf_counter() - middle:.3f} s"
        row += [("(a) sample", exemplar.pixels), (f"(b) {took}", picture)]
    sheet(folder / f"fig1{suffix}", [row])


def fig4(folder: Path, suffix: str) -> None:
    """Constrained synthesis: a 128x128 hole in a 256x256 texture."""
    rows = []
    for name in some(("bricks", "stone_wall", "leaves", "tiles")):
        photo = load(name)
        hole = np.zeros(photo.shape[:2], bool)
        hole[64:192, 64:192] = True
        empty = np.where(hole[..., None], 0, photo).astype(np.uint8)
        filled = weftex.fill(empty, hole, method="patch-sampling", seed=1).image
        assert (filled[~hole] == photo[~hole]).all()
        rows.append([("(a) texture", photo), ("(b) hole", empty), ("(c) filled", filled)])
    sheet(folder / f"fig4{suffix}", rows)


def fig6(folder: Path, suffix: str) -> None:
    """Tileable synthesis, and its 2x2 tiling."""
    rows = []
    for name in some(("pebbles", "grass")):
        tile = make(load(name), 192, tileable=True)
        again = np.concatenate([np.concatenate([tile] * 2, axis=0)] * 2, axis=1)
        rows.append([("sample", load(name)), ("(a) tileable", tile), ("(b) 2x2 of it", again)])
    sheet(folder / f"fig6{suffix}", rows)


def fig7(folder: Path, suffix: str) -> None:
    """Patch size: 16, 24 and 32 from samples of 64x64."""
    samples = [load("weave", 64), shrunk(load("bricks"), 4), shrunk(load("pebbles", 128), 2)]
    rows = [
        [("(a) 64x64", sample)]
        + [
            (f"patch size {size}", make(sample, 160, patch_size=size, **PAPER))
            for size in (16, 24, 32)
        ]
        for sample in some(samples)
    ]
    sheet(folder / f"fig7{suffix}", rows)


def fig8(folder: Path, suffix: str) -> None:
    """Relative error: 0, 0.2, 1 and infinity, over all windows (no shortlist)."""
    rows = []
    for name in some(("pebbles", "bricks", "weave")):
        sample = load(name, 128)
        row = [("(a) sample", sample)]
        for epsilon in (0, 0.2, 1, float("inf")):
            settings = PAPER | {"epsilon": epsilon}
            if epsilon < float("inf"):  # of infinity all match, and none is searched for
                settings["search"] = "exhaustive"
            picture = make(sample, 200, **settings)
            row.append((f"epsilon {epsilon:g}", picture))
        rows.append(row)
    sheet(folder / f"fig8{suffix}", rows)


def fig10(folder: Path, suffix: str) -> None:
    """Results: 200x200 to 256x256, of every sample."""
    pictures = []
    for name in some(SAMPLES):
        sample = load(name, 200)
        pictures += [("sample", sample), (name, make(sample, 256, **PAPER))]
    sheet(folder / f"fig10{suffix}", [pictures[k : k + 4] for k in range(0, len(pictures), 4)])


def fig11(folder: Path, suffix: str) -> None:
    """A large result: 200x200 to 800x800, by the paper's settings and by weftex's."""
    sample = load("pebbles", 200)
    paper, ours = make(sample, 800, **PAPER), make(sample, 800)
    row = [("sample", sample), ("the paper's settings", paper), ("weftex's", ours)]
    sheet(folder / f"fig11{suffix}", [row])


def fig12(folder: Path, suffix: str) -> None:
    """Where non-parametric sampling grows garbage, patches do not."""
    rows = []
    for name, width in some((("pebbles", 23), ("leaves", 15))):
        sample = load(name, 96)
        pixelwise = make(sample, 200, method="efros-leung", window_width=width)
        row = [("(a) sample", sample), ("(b) Efros and Leung", pixelwise)]
        rows.append([*row, ("(c) patch-based sampling", make(sample, 200, **PAPER))])
    sheet(folder / f"fig12{suffix}", rows)


def fig13(folder: Path, suffix: str) -> None:
    """Verbatim copying: 132x110 to 216x216, with the largest share of the sample in one piece."""
    sample = weftex.Exemplar(np.ascontiguousarray(load("leaves")[:110, :132]))
    ways: list[tuple[str, dict[str, Any]]] = [
        ("(b) Efros and Leung", {"method": "efros-leung", "window_width": 25}),
        ("(c) patches of 32", PAPER | {"patch_size": 32}),
        ("(d) patches of 40", PAPER | {"patch_size": 40}),
    ]
    row = [("(a) sample", sample.pixels)]
    for label, settings in ways:
        result = weftex.synthesize(sample, sized(216), seed=3, **settings)
        row.append((f"{label}: {largest_copy(result):.0%}", result.image))
    sheet(folder / f"fig13{suffix}", [row])


def fig14(folder: Path, suffix: str) -> None:
    """Natural textures and a smooth one, beside the methods of Wei and Levoy and of Ashikhmin."""
    samples = [load("leaves", 128), load("pebbles", 128), clouds(128)]
    ways = {
        "(b) patch-based sampling": PAPER,
        "(c) Wei and Levoy": {"method": "wei-levoy"},
        "(d) Ashikhmin": {"method": "ashikhmin"},
    }
    rows = [
        [("(a) sample", s), *((label, make(s, 200, **how)) for label, how in ways.items())]
        for s in some(samples)
    ]
    sheet(folder / f"fig14{suffix}", rows)


def fig15(folder: Path, suffix: str) -> None:
    """Patch-based sampling beside patch pasting, which is epsilon = infinity."""
    rows = []
    for name in some(("grass", "bricks", "weave")):
        sample = load(name, 192)
        rows.append(
            [
                ("(a) sample", sample),
                ("(b) patch-based sampling", make(sample, 256, **PAPER)),
                ("(c) patch pasting", make(sample, 256, **PAPER | {"epsilon": float("inf")})),
            ]
        )
    sheet(folder / f"fig15{suffix}", rows)


def text_sample(side: int = 192) -> np.ndarray:
    """Lines of nonsense words, as the paper's example of where feathering smears."""
    rng = np.random.default_rng(3)
    page = Image.new("L", (side, side), 255)
    pen, font = ImageDraw.Draw(page), ImageFont.load_default(15)
    for y in range(-4, side, 18):
        line = " ".join("".join(rng.choice(list("aeioumnrstlch"), 5)) for _ in range(9))
        pen.text((-6 * (y % 5), y), line, 0, font)
    return np.asarray(page)


def fig16(folder: Path, suffix: str) -> None:
    """Feathering beside the minimum-error boundary cut, and beside no blending."""
    joints = (("(b) feathering", "feather"), ("(c) cut", "cut"), ("no blending", "none"))
    rows = []
    for name in ("stone_wall", "leaves", "pebbles", "text"):
        sample = text_sample() if name == "text" else load(name, 192)
        row = [("(a) sample", sample)]
        for label, blend in joints:
            settings = PAPER | {"patch_size": 48, "boundary_width": 8, "blend": blend}
            row.append((label, make(sample, 256, **settings)))
        rows.append(row)
    sheet(folder / f"fig16{suffix}", rows)


def fig17(folder: Path, suffix: str) -> None:
    """Failures: objects, perspective, interrupted outlines."""
    top, bottom = [], []
    cases = (("(a) objects", "leaves"), ("(b) perspective", "perspective"))
    for label, name in (*cases, ("(c) outlines", "fishscale"), ("(c) outlines", "stone_wall")):
        sample = load(name, 192)
        top.append((label, sample))
        bottom.append(("patch-based sampling", make(sample, 256, **PAPER)))
    sheet(folder / f"fig17{suffix}", [top, bottom])


# --------------------------------------------------------------------------------------- tables


def largest_copy(result: weftex.Synthesis) -> float:
    """Area of the largest connected region copied with one offset, over the sample's area."""
    return float(pieces(result).max() / (result.sample_shape[0] * result.sample_shape[1]))


def copying() -> Table:
    """Verbatim copying over 200 outputs with slightly different patch sizes (section 4)."""
    notes = """
Verbatim copying at large scale, section 4 of the paper: 200 outputs of 216x216 from 128x128 crops
of eight samples, 25 each, with patch sizes from 32 to 44. The largest connected region of an output
that is copied with one offset is measured in shares of the sample's area; one patch alone is 6 to
12 %. The table gives the outputs without a copy larger than a share; "at large scale" is taken to
mean half of the sample. The paper names no share and found 93 % without.
"""
    settings: dict[str, dict[str, Any]] = {
        "paper's (repeat_distance 0)": PAPER,
        "weftex's": {"method": "patch-sampling"},
        "quilting": {"method": "quilting"},
    }
    limits = (0.25, 1 / 3, 0.5, 0.75)
    rows = []
    for label, parameters in settings.items():
        copies = []
        for name in some(SAMPLES):
            sample = weftex.Exemplar(load(name, 128))
            for k in some(range(25)):
                result = weftex.synthesize(
                    sample, sized(216), seed=k, patch_size=32 + k // 2, **parameters
                )
                copies.append(largest_copy(result))
        at = np.array(copies)
        shares = [f"{100 * (at <= limit).mean():.0f} %" for limit in limits]
        rows.append([label, *shares, f"{100 * np.median(at):.0f} %"])
    head = ["settings", *(f"none above {100 * k:.0f} %" for k in limits), "largest, median"]
    return notes, head, rows


#: Analysis and synthesis in seconds on a 667 MHz PC, Table I.
TABLE_1 = {
    "exhaustive": (0.000, 1.415),
    "quadtree": (0.017, 0.256),
    "kdtree": (0.338, 0.044),
    "kdtree-pca": (0.678, 0.020),
}


def table1(trials: int = 5) -> Table:
    """Table I: analysis and synthesis time of each search, 128x128 to 200x200."""
    notes = f"""
Table I: 200x200 from 128x128, patches of 32 px, zones of 4 px; means of {trials} trials with each
of {len(SAMPLES)} samples, all searches of a trial in turn. The paper's times are of a 667 MHz PC
and means of 500 trials. "x" is how many times shorter synthesis is than with the exhaustive search.
"""
    searches = ("exhaustive", "quadtree", "kdtree", "kdtree-pca", "pca")
    trials = len(some(range(trials)))
    settings = {"patch_size": 32, "repeat_distance": 0, "boundary_width": 4}
    method = {s: weftex.PatchSampling(search=s, **settings) for s in searches}
    method["pca, weftex's defaults"] = weftex.PatchSampling()
    times: dict[str, list[tuple[float, float]]] = {label: [] for label in method}
    for name in some(SAMPLES):
        sample = load(name, 128)
        for trial in range(trials + 1):
            for label, chosen in method.items():
                start = perf_counter()
                model = chosen.fit(weftex.Exemplar(sample))
                middle = perf_counter()
                _ = model.sample(sized(200), seed=trial).image
                if trial:  # the first warms caches up
                    times[label].append((middle - start, perf_counter() - middle))
    ours = {label: np.array(values).mean(axis=0) * 1e3 for label, values in times.items()}
    rows = []
    for label, (fit, sample_time) in ours.items():
        paper = TABLE_1.get(label)
        cells = ["", "", ""]
        if paper:
            ratio = TABLE_1["exhaustive"][1] / paper[1]
            cells = [f"{1e3 * paper[0]:.0f} ms", f"{1e3 * paper[1]:.0f} ms", f"{ratio:.1f} x"]
        ratio = ours["exhaustive"][1] / sample_time
        rows.append([label, *cells, f"{fit:.1f} ms", f"{sample_time:.2f} ms", f"{ratio:.1f} x"])
    head = ["search", "paper: analysis", "synthesis", "x", "weftex: analysis", "synthesis", "x"]
    return notes, head, rows


FIGURES = (
    fig1, fig4, fig6, fig7, fig8, fig10, fig11, fig12, fig13, fig14, fig15, fig16, fig17
)  # fmt: skip
TABLES = (copying, table1)

if __name__ == "__main__":
    run(__doc__, FIGURES, TABLES)
