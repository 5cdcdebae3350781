"""The experiments of the patch-based sampling paper, run again with weft.

python examples/paper_patch_sampling.py EXPERIMENT -o FOLDER

Experiments that draw a picture: fig4 fig6 fig7 fig8 fig15 fig16 fig17; that print a table and write
it as Markdown: copying edges table1; `all` runs every one. L. Liang, C. Liu, Y.-Q. Xu, B. Guo and
H.-Y. Shum, Real-time texture synthesis by patch-based sampling, ACM Transactions on Graphics, 2001.
Needs Pillow and SciPy beside weft: pip install 'weft[test]'.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import weft

HERE = Path(__file__).parent
SAMPLES = ("bricks", "grass", "leaves", "pebbles", "stone_wall", "tiles", "weave", "wood")
#: What the paper does and weft does not by default; its zones are "typically four pixels wide".
PAPER: dict[str, Any] = {"repeat_distance": 0, "boundary_width": 4}


def load(name: str, side: int | None = None) -> np.ndarray:
    """Pixels of a sample that ships with weft or lies in examples/samples, or a crop of them."""
    own = HERE / "samples" / f"{name}.png"
    pixels = weft.load_exemplar(own if own.exists() else f"sample:{name}").pixels
    return np.ascontiguousarray(pixels[:side, :side])


def shrunk(pixels: np.ndarray, factor: int) -> np.ndarray:
    """Means over factor x factor pixels."""
    height, width = (n // factor * factor for n in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // factor, factor, width // factor, factor, -1)
    return np.rint(blocks.mean(axis=(1, 3))).astype(np.uint8)


def make(pixels: np.ndarray, size: Any, seed: int = 1, **parameters: Any) -> np.ndarray:
    return weft.synthesize(pixels, size, seed=seed, **parameters).image


# ------------------------------------------------------------------------------------- pictures


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


def fig4(folder: Path, suffix: str) -> None:
    """Constrained synthesis: a 128x128 hole in a 256x256 texture."""
    rows = []
    for name in ("bricks", "stone_wall", "leaves", "tiles"):
        photo = load(name)
        hole = np.zeros(photo.shape[:2], bool)
        hole[64:192, 64:192] = True
        empty = np.where(hole[..., None], 0, photo).astype(np.uint8)
        filled = weft.fill(empty, hole, seed=1).image
        assert (filled[~hole] == photo[~hole]).all()
        rows.append([("(a) texture", photo), ("(b) hole", empty), ("(c) filled", filled)])
    sheet(folder / f"fig4{suffix}", rows)


def fig6(folder: Path, suffix: str) -> None:
    """Tileable synthesis, and its 2x2 tiling."""
    rows = []
    for name in ("pebbles", "grass"):
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
        for sample in samples
    ]
    sheet(folder / f"fig7{suffix}", rows)


def fig8(folder: Path, suffix: str) -> None:
    """Relative error: 0, 0.2, 1 and infinity, over all windows (no shortlist)."""
    rows = []
    for name in ("pebbles", "bricks", "weave"):
        sample = load(name, 128)
        row = [("(a) sample", sample)]
        for epsilon in (0, 0.2, 1, float("inf")):
            picture = make(sample, 200, epsilon=epsilon, search="exhaustive", **PAPER)
            row.append((f"epsilon {epsilon:g}", picture))
        rows.append(row)
    sheet(folder / f"fig8{suffix}", rows)


def fig15(folder: Path, suffix: str) -> None:
    """Patch-based sampling beside patch pasting, which is epsilon = infinity."""
    rows = []
    for name in ("grass", "bricks", "weave"):
        sample = load(name, 192)
        rows.append(
            [
                ("(a) sample", sample),
                ("(b) patch-based sampling", make(sample, 256, **PAPER)),
                ("(c) patch pasting", make(sample, 256, epsilon=float("inf"), **PAPER)),
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
    """Failures: objects, perspective, interrupted outlines; the last with the edge metric too."""
    bottom, edges = [], []
    top = []
    cases = (("(a) objects", "leaves"), ("(b) perspective", "perspective"))
    for label, name in (*cases, ("(c) outlines", "fishscale"), ("(c) outlines", "cobbles")):
        sample = load(name, 192)
        top.append((label, sample))
        bottom.append(("patch-based sampling", make(sample, 256, **PAPER)))
        picture = make(sample, 256, edge_weight=2.0, **PAPER)
        edges.append(("with edge_weight 2", picture))
    sheet(folder / f"fig17{suffix}", [top, bottom, edges])


# --------------------------------------------------------------------------------------- tables


def write_table(path: Path, notes: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    lines = [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]
    text = "\n".join([*notes.strip().splitlines(), "", *lines, ""])
    path.write_text(text, encoding="utf-8")
    print(f"\n{text}\nwrote {path}")


def largest_copy(result: weft.Synthesis) -> float:
    """Area of the largest connected region copied with one offset, over the sample's area."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    height, width = result.shape
    y, x = np.indices(result.shape)
    source = result.source
    offset = (source[..., 0] - y + height) * 100_000 + source[..., 1] - x + width
    number = np.arange(offset.size).reshape(offset.shape)
    right, down = offset[:, 1:] == offset[:, :-1], offset[1:] == offset[:-1]
    a = np.concatenate([number[:, 1:][right], number[1:][down]])
    b = np.concatenate([number[:, :-1][right], number[:-1][down]])
    graph = coo_matrix((np.ones(len(a), bool), (a, b)), (offset.size, offset.size))
    areas = np.bincount(connected_components(graph, directed=False)[1])
    return float(areas.max() / (result.sample_shape[0] * result.sample_shape[1]))


def copying(folder: Path, suffix: str) -> None:
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
        "weft's": {},
        "quilting": {"method": "quilting"},
    }
    limits = (0.25, 1 / 3, 0.5, 0.75)
    rows = []
    for label, parameters in settings.items():
        copies = []
        for name in SAMPLES:
            sample = weft.Exemplar(load(name, 128))
            for k in range(25):
                result = weft.synthesize(
                    sample, 216, seed=k, patch_size=32 + k // 2, **parameters
                )
                copies.append(largest_copy(result))
        at = np.array(copies)
        shares = [f"{100 * (at <= limit).mean():.0f} %" for limit in limits]
        rows.append([label, *shares, f"{100 * np.median(at):.0f} %"])
    head = ["settings", *(f"none above {100 * k:.0f} %" for k in limits), "largest, median"]
    write_table(folder / "copying.md", notes, head, rows)


class Outlines:
    """Where outlines run across the columns of a picture: local maxima of the vertical gradient."""

    def __init__(self, pixels: np.ndarray) -> None:
        grey = pixels.reshape(*pixels.shape[:2], -1).mean(axis=2)
        self.dy, self.dx = np.gradient(grey)
        strength = np.abs(self.dy)
        self.peak = np.zeros(grey.shape, bool)
        self.peak[1:-1] = (strength[1:-1] >= strength[:-2]) & (strength[1:-1] > strength[2:])
        self.clear = self.peak & (strength >= np.abs(self.dx)) & (strength > 8)

    def go_on(self, column: int, rows: range, gap: int) -> tuple[int, int]:
        """Count the outlines at a column, and those of them that arrive `gap` columns further.

        One arrives if within two pixels of where its direction leads there is one of the same sign
        and at least half the strength.
        """
        found = arrived = 0
        for v in (np.flatnonzero(self.clear[rows.start : rows.stop, column]) + rows.start).tolist():
            slope = self.dy[v, column]
            to = round(v - gap * self.dx[v, column] / slope)
            if to < 2 or to + 3 > len(self.dy):
                continue
            window = slice(to - 2, to + 3), column + gap
            found += 1
            arrived += bool((self.peak[window] & (self.dy[window] / slope > 0.5)).any())
        return found, arrived


def turned(pixels: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(pixels.swapaxes(0, 1))


def continuity(result: weft.Synthesis, zone: int) -> float:
    """Share of the outlines at one side of the seams that arrive at the other."""
    total = np.zeros(2, int)
    size = result.weights.shape[1]
    for axis, pixels in ((1, result.image), (0, turned(result.image))):
        outlines = Outlines(pixels)
        for place in result.placements[:, :2].tolist():
            along, across = place[1 - axis], place[axis]
            if across > 0:
                rows = range(along + zone, along + size - zone)
                total += outlines.go_on(across - 2, rows, zone + 3)
    return float(total[1] / max(total[0], 1))


def own_continuity(sample: np.ndarray, gap: int) -> float:
    """The same share between columns, and between rows, of the sample itself."""
    total = np.zeros(2, int)
    for pixels in (sample, turned(sample)):
        outlines = Outlines(pixels)
        for column in range(2, pixels.shape[1] - gap - 2, 3):
            total += outlines.go_on(column, range(2, len(pixels) - 2), gap)
    return float(total[1] / max(total[0], 1))


def edges(folder: Path, suffix: str) -> None:
    """The edge metric, the paper's future work for Fig. 17 c, measured."""
    zone = 6
    weights = (0.0, 0.5, 1.0, 2.0, 4.0)
    notes = f"""
Interrupted outlines at seams, by edge_weight: 0 is as continuous as the sample, 1 as broken as
patches pasted at random. Of the outlines (local maxima of the gradient) that run into a seam the
share is counted that go on beyond its blended zone, {zone + 3} px further, within 2 px of where
their direction leads, with the same sign and half the strength; the same share is taken across
{zone + 3} px of the sample (S) and over seams of pasted patches (R), and (S - share) / (S - R) is
given, plus or minus its standard error over 12 outputs. 320x320 from 192x192, patches of 40 px. In
brackets: how much overlapping patches differ, in grey levels, which is what the metric pays with.
"""
    names = ("bricks", "tiles", "weave", "fishscale", "cobbles", "perspective", "leaves", "stone_wall")
    rows = []
    mean = np.zeros(len(weights))
    for name in names:
        sample = load(name, 192)
        exemplar = weft.Exemplar(sample)

        def share(parameters: dict[str, Any], exemplar: weft.Exemplar = exemplar) -> Any:
            method = weft.PatchSampling(
                patch_size=40, boundary_width=zone, repeat_distance=0, **parameters
            )
            model = method.fit(exemplar)
            made = [model.sample(320, seed=k) for k in range(12)]
            each = np.array([continuity(result, zone) for result in made])
            error = [result.draw("error")[..., 0] for result in made]
            return each, float(np.mean([e[e > 0].mean() for e in error]))

        own = own_continuity(sample, zone + 3)
        random = share({"epsilon": float("inf")})[0].mean()
        cells = []
        for k, weight in enumerate(weights):
            each, error = share({"edge_weight": weight})
            broken = (own - each) / (own - random)
            mean[k] += broken.mean() / len(names)
            spread = broken.std(ddof=1) / len(each) ** 0.5
            cells.append(f"{broken.mean():.2f} ± {spread:.2f} ({error:.1f})")
        rows.append([name, f"{own:.2f}", f"{random:.2f}", *cells])
    rows.append(["mean", "", "", *(f"{m:.2f}" for m in mean)])
    head = ["sample", "S", "R", *(f"edge_weight {w:g}" for w in weights)]
    write_table(folder / "edges.md", notes, head, rows)


#: Analysis and synthesis in seconds on a 667 MHz PC, Table I.
TABLE_1 = {
    "exhaustive": (0.000, 1.415),
    "quadtree": (0.017, 0.256),
    "kdtree": (0.338, 0.044),
    "kdtree-pca": (0.678, 0.020),
}


def table1(folder: Path, suffix: str, trials: int = 5) -> None:
    """Table I: analysis and synthesis time of each search, 128x128 to 200x200."""
    notes = f"""
Table I: 200x200 from 128x128, patches of 32 px, zones of 4 px; means of {trials} trials with each
of {len(SAMPLES)} samples, all searches of a trial in turn. The paper's times are of a 667 MHz PC and
means of 500 trials. "x" is how many times shorter synthesis is than with the exhaustive search.
"""
    searches = ("exhaustive", "quadtree", "kdtree", "kdtree-pca", "pca")
    method = {s: weft.PatchSampling(patch_size=32, search=s, **PAPER) for s in searches}
    method["pca, weft's defaults"] = weft.PatchSampling()
    times: dict[str, list[tuple[float, float]]] = {label: [] for label in method}
    for name in SAMPLES:
        sample = load(name, 128)
        for trial in range(trials + 1):
            for label in method:
                start = perf_counter()
                model = method[label].fit(weft.Exemplar(sample))
                middle = perf_counter()
                _ = model.sample(200, seed=trial).image
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
    head = ["search", "paper: analysis", "synthesis", "x", "weft: analysis", "synthesis", "x"]
    write_table(folder / "table1.md", notes, head, rows)


EXPERIMENTS: dict[str, Callable[[Path, str], None]] = {
    f.__name__: f for f in (fig4, fig6, fig7, fig8, fig15, fig16, fig17, copying, edges, table1)
}


def main() -> None:
    lines = "\n".join(f"  {name:9}{f.__doc__}" for name, f in EXPERIMENTS.items())
    parser = argparse.ArgumentParser(
        description=f"{__doc__}\n{lines}", formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("experiment", choices=(*EXPERIMENTS, "all"))
    parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
    parser.add_argument("--format", default="png", choices=("png", "jpg", "webp"))
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    for name in EXPERIMENTS if args.experiment == "all" else (args.experiment,):
        start = perf_counter()
        EXPERIMENTS[name](args.output, f".{args.format}")
        print(f"{name}: {perf_counter() - start:.1f} s")


if __name__ == "__main__":
    main()
