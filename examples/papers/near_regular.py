"""The experiments of the thesis on near-regular textures, run again with weftex.

python examples/papers/near_regular.py EXPERIMENT -o FOLDER [--small]

Experiments: fig31 (from the correlation to the vectors), fig34 (peaks that mislead), fig35 (pairs
of vectors rated), fig46 (the best and the worst tile), fig410 (both ways of matching), fig411
(after gap filling, and a repeated tile), fig413 (blending), fig52 (5.2 to 5.9: near-regular samples
by repetition, thesis, weftex and quilting), fig510 (where joints broke), fig511 (fractions),
fig512 (wide blending), fig513 (5.13 to 5.17: every other sample, unconstrained), blocks
(section 5.2: block sizes) and figures (what weftex.assess says of fig52 and fig513, not in the
thesis); `all` runs every one. Figures are those of the thesis: 410 is 4.10.
Needs Pillow beside weftex: pip install '.[test]'.
"""

from __future__ import annotations

from bisect import bisect_left
from pathlib import Path
from typing import Any

import numpy as np
from _common import Table, load, run, sheet, shrunk, sized, some
from PIL import Image, ImageDraw

import weftex
from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.analysis.correlation import correlate
from weftex.analysis.lattice import Lattice, find_lattice, rate_lattices
from weftex.analysis.overlay import draw_lattice
from weftex.analysis.pairs import SIGNIFICANT, tile_shares
from weftex.analysis.relief import relief
from weftex.methods.best_tile import tile_errors

REGULAR = ("bricks", "tiles", "weave")
LATTICES = ("gingham", "tiles", "mosaic")
ALL_REGULAR = (
    *("bricks", "tiles", "weave", "fishscale", "fence", "mosaic"),
    *("gingham", "boards", "shingles", "perspective"),
)
IRREGULAR = ("pebbles", "stone_wall", "cobbles", "leaves", "wood", "grass")


def small(name: str) -> np.ndarray:
    """A sample of 128 pixels or less, as in the thesis: half the resolution."""
    return shrunk(opaque(load(name, 256)), 2)


def opaque(pixels: np.ndarray) -> np.ndarray:
    """What is seen before a sky, where there is alpha."""
    if pixels.ndim < 3 or pixels.shape[2] != 4:
        return pixels
    share = pixels[..., 3:] / 255
    return np.rint(pixels[..., :3] * share + (1 - share) * (170, 190, 210)).astype(np.uint8)


def make(pixels: np.ndarray, size: int = 256, **parameters: Any) -> np.ndarray:
    method = parameters.pop("method", "near-regular")
    return weftex.synthesize(pixels, sized(size), method=method, seed=1, **parameters).image


def paper(pixels: np.ndarray, **parameters: Any) -> np.ndarray:
    return make(pixels, defaults="paper", **parameters)


def rows(path: Path, labels: str, lines: list[list[np.ndarray]]) -> None:
    """Write a picture of lines that have the same labels, separated by commas."""
    named = [list(zip(labels.split(", "), line, strict=True)) for line in lines]
    sheet(path, named)


def enlarged(pixels: np.ndarray, times: int = 2) -> Image.Image:
    """Pixels as a picture that lines can be drawn on."""
    return (
        Image.fromarray(pixels)
        .convert("RGB")
        .resize((pixels.shape[1] * times, pixels.shape[0] * times), Image.Resampling.NEAREST)
    )


def gncc(sample: weftex.Exemplar) -> np.ndarray:
    """The correlation of a sample with itself (3.2), without slow lighting."""
    flat = relief(sample)
    return correlate(flat.levels, flat.usable >= 0.5)


def draw_correlation(correlation: np.ndarray) -> np.ndarray:
    """White is 1, the gray in the middle 0, black -1."""
    return np.rint((correlation + 1) * 127.5).astype(np.uint8)


def lattice_of(pixels: np.ndarray) -> Lattice:
    """The lattice of a sample that has two vectors."""
    lattice = find_lattice(weftex.Exemplar(pixels), goodness="height")
    assert lattice is not None and len(lattice.vectors) == 2
    return lattice


def with_vectors(picture: Image.Image, vectors: np.ndarray) -> np.ndarray:
    """Two vectors from the middle, and the grid of their multiples."""
    pen = ImageDraw.Draw(picture)
    middle = np.array(picture.size) / 2
    steps = np.stack(np.meshgrid(np.arange(-9, 10), np.arange(-9, 10)), axis=-1).reshape(-1, 2)
    for x, y in (steps @ vectors + middle).tolist():
        pen.ellipse([x - 2, y - 2, x + 2, y + 2], outline=(255, 0, 255))
    for vector, color in zip(vectors, ((255, 60, 60), (60, 120, 255)), strict=True):
        pen.line([tuple(middle), tuple(middle + vector)], color, 3)
    return np.asarray(picture)


def fig31(folder: Path, suffix: str) -> None:
    """A sample, its correlation with itself, the vectors at its peaks, and the tiles they span."""
    lines = []
    for name in some(LATTICES):
        pixels = small(name)
        sample, lattice = weftex.Exemplar(pixels), lattice_of(pixels)
        gray = draw_correlation(gncc(sample))
        peaks = with_vectors(enlarged(gray, 1), np.array(lattice.vectors))
        tiles = enlarged(draw_lattice(sample, lattice))
        lines.append([np.asarray(enlarged(pixels)), gray, peaks, np.asarray(tiles)])
    rows(folder / f"fig31{suffix}", "sample, correlation, translation vectors, tiles", lines)


def profile(correlation: np.ndarray) -> np.ndarray:
    """The middle row of a correlation as a curve, 1 at the top and -1 at the bottom."""
    values = correlation[correlation.shape[0] // 2]
    picture = Image.new("RGB", (len(values), 255), "white")
    pen = ImageDraw.Draw(picture)
    pen.line([(0, 127), (len(values), 127)], (200, 200, 200))
    pen.line([(x, 127 - 126 * value) for x, value in enumerate(values.tolist())], "black", 1)
    return np.asarray(picture)


def fig34(folder: Path, suffix: str) -> None:
    """Peaks that mislead: of colors that alternate, of things of any color; and their profiles."""
    lines = []
    for name in some(LATTICES):
        correlation = gncc(weftex.Exemplar(small(name)))
        gray = draw_correlation(correlation)
        lines.append([np.asarray(enlarged(small(name))), gray, profile(correlation)])
    rows(folder / f"fig34{suffix}", "sample, correlation, profile", lines)


def with_multiples(correlation: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Crosses at the significant multiples of two vectors; what is not significant is shaded."""
    high, wide = (side // 2 for side in correlation.shape)
    y, x = np.mgrid[-high : high + 1, -wide : wide + 1]
    height, width = high + 1 - abs(y), wide + 1 - abs(x)
    whole = np.rint(vectors).astype(np.int64)
    least = np.empty(wide + 2)  # height from which an overlap is significant, by its width
    for across in range(wide + 2):
        heights = range(high + 2)
        least[across] = bisect_left(
            heights,
            SIGNIFICANT,
            key=lambda h: tile_shares(whole, np.array([across]), np.array([h]))[0],
        )
    enough = height >= least[width]
    gray = np.repeat(draw_correlation(correlation)[..., None], 3, axis=2)
    gray[~enough] = gray[~enough] // 2 + np.array([110, 60, 60], np.uint8)
    picture = Image.fromarray(gray)
    pen = ImageDraw.Draw(picture)
    steps = np.stack(np.meshgrid(np.arange(-40, 41), np.arange(-40, 41)), axis=-1).reshape(-1, 2)
    for u, v in np.rint(steps @ vectors).astype(int).tolist():
        if abs(u) <= wide and abs(v) <= high and enough[v + high, u + wide] and (u, v) > (0, 0):
            a, b = u + wide, v + high
            pen.line([(a - 3, b), (a + 3, b)], "black", 1)
            pen.line([(a, b - 3), (a, b + 3)], "black", 1)
    return np.asarray(picture)


def fig35(folder: Path, suffix: str) -> None:
    """The lattice that is found, and pairs of vectors that are rated lower, by eq. 3.22."""
    lines = []
    for name in some(LATTICES):
        pixels = small(name)
        sample = weftex.Exemplar(pixels)
        lattice = lattice_of(pixels)
        own, others = rate_lattices(sample, lattice, goodness="height", runners_up=2)
        correlation = gncc(sample)
        line = [(name, np.asarray(enlarged(draw_lattice(sample, lattice))))]
        for rated in (own, *others):
            if rated is not None:
                picture = with_multiples(correlation, np.array(rated.vectors))
                line.append((f"goodness {rated.goodness:.3f}", picture))
        lines.append(line)
    sheet(folder / f"fig35{suffix}", lines)


def outline(
    pixels: np.ndarray, tiles: list[tuple[np.ndarray, str]], sides: np.ndarray
) -> np.ndarray:
    """Parallelograms with these corners (y, x) and sides (y, x) over a picture."""
    picture = enlarged(pixels)
    pen = ImageDraw.Draw(picture)
    for corner, color in tiles:
        at = [corner, corner + sides[0], corner + sides.sum(axis=0), corner + sides[1], corner]
        pen.line([(2 * float(x), 2 * float(y)) for y, x in at], color, 2)
    return np.asarray(picture)


def fig46(folder: Path, suffix: str) -> None:
    """What opposite borders of tiles differ by, the best tile and the worst, and both repeated."""
    lines = []
    for name in some(LATTICES):
        pixels = small(name)
        sample = weftex.Exemplar(pixels)
        model = weftex.BestTile(lattice=tuple(np.ravel(lattice_of(pixels).vectors))).fit(sample)
        errors = tile_errors(sample, model.vectors, model.method.border_width)
        corners = [
            np.array(np.unravel_index(int(place), errors.shape))
            for place in (np.where(errors < 0, errors.max() + 1, errors).argmin(), errors.argmax())
        ]
        shown = np.where(errors < 0, 255, 230 * errors // max(1, int(errors.max())))
        sides = CanvasLattice(model.vectors).sample
        tiles = list(zip(corners, ("lime", "red"), strict=True))
        line = [outline(p, tiles, sides) for p in (shown.astype(np.uint8), pixels)]
        for model.anchor in map(tuple, corners):
            line.append(model.sample(256).image)
        lines.append(line)
    rows(folder / f"fig46{suffix}", "differences, sample, best tile, worst tile", lines)


def fig410(folder: Path, suffix: str) -> None:
    """Borders by correlation, and by differences of colors."""
    samples = [small(name) for name in some(REGULAR)]
    lines = [[s, paper(s, match="gncc"), paper(s, match="difference")] for s in samples]
    rows(folder / f"fig410{suffix}", "sample, gncc, difference", lines)


def fig411(folder: Path, suffix: str) -> None:
    """A repeated tile beside blocks and gaps before they are blended."""
    samples = [small(name) for name in some(REGULAR)]
    rows(
        folder / f"fig411{suffix}",
        "sample, best-tile, gaps filled",
        [[s, make(s, method="best-tile"), paper(s, blend="none")] for s in samples],
    )


def fig413(folder: Path, suffix: str) -> None:
    """Without and with blending, and blended wider."""
    samples = [small(name) for name in some(REGULAR)]
    ways = [{"defaults": "paper", "blend": "none"}, {"defaults": "paper"}, {}]
    rows(
        folder / f"fig413{suffix}",
        "sample, pasted, blended, wider",
        [[s, *(make(s, **way) for way in ways)] for s in samples],
    )


#: What is compared; quilting with the thesis's blocks and overlaps, and with its own.
QUILTING: dict[str, dict[str, Any]] = {
    "quilting of 50": {"method": "quilting", "patch_size": 50, "boundary_width": 10},
    "quilting": {"method": "quilting"},
}
WAYS: dict[str, dict[str, Any]] = {
    "best-tile": {"method": "best-tile"},
    "thesis": {"defaults": "paper"},
    "near-regular": {},
    **QUILTING,
}
FREE: dict[str, dict[str, Any]] = {
    "thesis": {"defaults": "paper", "lattice": (1, 0, 0, 1)},
    "near-regular": {"lattice": (1, 0, 0, 1)},
    **QUILTING,
}


def repeated(pixels: np.ndarray) -> np.ndarray:
    """The sample again and again."""
    source = np.moveaxis(np.indices([sized(256)] * 2), 0, -1) % pixels.shape[:2]
    return pixels[source[..., 0], source[..., 1]]


def compared(pixels: np.ndarray, ways: dict[str, dict[str, Any]]) -> dict[str, np.ndarray]:
    return {"sample": pixels, **{way: make(pixels, **with_) for way, with_ in ways.items()}}


def fig52(folder: Path, suffix: str) -> None:
    """Every near-regular sample: repeated, its best tile, the thesis, weftex, quilting."""
    lines = []
    for name in some(ALL_REGULAR):
        made = compared(small(name), WAYS)
        pictures = list(made.values())
        lines.append([pictures[0], repeated(pictures[0]), *pictures[1:]])
    rows(folder / f"fig52{suffix}", ", ".join(["sample", "repeated", *WAYS]), lines)


def fig510(folder: Path, suffix: str) -> None:
    """Joints that do not meet: as in the thesis, and blended wider."""
    s = load("bricks")[:256, :256]
    ways = [{"defaults": "paper", "block_size": 80}, {}]
    rows(
        folder / f"fig510{suffix}",
        "sample, thesis, weftex",
        [[s, *(make(s, 384, **way) for way in ways)]],
    )


def fig511(folder: Path, suffix: str) -> None:
    """Vectors rounded to pixels and with their fractions."""
    y, x = np.indices((128, 128))
    waves = 127 + 50 * np.sin(x * 2 * np.pi / 12.45) + 50 * np.sin(y * 2 * np.pi / 9.55)
    waves = np.repeat(np.rint(waves).astype(np.uint8)[..., None], 3, axis=2)
    lattices = [(12, 0, 0, 10), (12.45, 0, 0, 9.55)]
    lines = [[waves, *(paper(waves, lattice=lattice) for lattice in lattices)]]
    rows(folder / f"fig511{suffix}", "sample, rounded, with fractions", lines)


def fig512(folder: Path, suffix: str) -> None:
    """Blended over 4 pixels and over 28, borders of 10: uneven light."""
    s = small("bricks").astype(float)
    light = np.linspace(0.6, 1.3, s.shape[1])[None, :, None]
    s = np.clip(s * light, 0, 255).astype(np.uint8)
    lines = [[s, *(paper(s, blend_width=width) for width in (4, 28))]]
    rows(folder / f"fig512{suffix}", "sample, over 4 pixels, over 28", lines)


def fig513(folder: Path, suffix: str) -> None:
    """Every other sample, unconstrained: the thesis's values, weftex's defaults, and quilting."""
    lines = [list(compared(small(name), FREE).values()) for name in some(IRREGULAR)]
    rows(folder / f"fig513{suffix}", ", ".join(["sample", *FREE]), lines)


def figures() -> Table:
    """What weftex.assess says of the pictures of fig52 and fig513."""
    rows = []
    for names, ways in ((ALL_REGULAR, WAYS), (IRREGULAR, FREE)):
        found = []
        for name in some(names):
            sample = small(name)
            scores = {"repeated": weftex.assess(sample, repeated(sample)).score}
            for way, how in ways.items():
                settings = {"method": "near-regular"} | how
                result = weftex.synthesize(sample, sized(256), seed=1, **settings)
                scores[way] = weftex.assess(result.exemplar, result).score
            found.append(scores)
        found.append({way: np.mean([scores[way] for scores in found]) for way in found[0]})
        for name, scores in zip([*some(names), "mean"], found, strict=True):
            cells = (f"{scores[way]:.2f}" if way in scores else "" for way in ("repeated", *WAYS))
            rows.append([name, *cells])
    return "Scores of near-regular samples, then of others.", ["", "repeated", *WAYS], rows


def blocks(folder: Path, suffix: str) -> None:
    """Blocks of 20 to 60 pixels: larger ones have fewer seams and less variety."""
    lines = []
    for name in some(REGULAR):
        s = small(name)
        lines.append([s, *(paper(s, block_size=size) for size in (20, 30, 40, 60))])
    rows(folder / f"blocks{suffix}", "sample, 20, 30, 40, 60", lines)


FIGURES = (
    fig31,
    fig34,
    fig35,
    fig46,
    fig410,
    fig411,
    fig413,
    fig52,
    fig510,
    fig511,
    fig512,
    fig513,
    blocks,
)
TABLES = (figures,)

if __name__ == "__main__":
    run(__doc__, FIGURES, TABLES)
