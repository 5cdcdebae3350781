"""Where materials meet: how much of a boundary a ruler could draw, and how it steps.

    python benchmarks/quality/fusion.py                     # six pairs of materials, four maps
    python benchmarks/quality/fusion.py --pictures FOLDER   # and every picture
    python benchmarks/quality/fusion.py --sheet FILE        # only docs/img/fuse_pairs.webp

For each picture three figures. `edge`: the share of rows in which the boundary of the materials
lies within a pixel of a belt's edge. `line`: the share of the boundary that lies within a pixel of
one line parallel to the map's boundary, the worst of all. `step`: the mean difference of neighbors
across the boundary, divided by that of all other neighbors. Needs weftex[test].
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

import weftex
from weftex.analysis.scale import structure_scale
from weftex.raster.masks import squared_distance_to
from weftex.tasks.fusion import BELT

PAIRS = (
    ("pebbles", "leaves"),
    ("stone_wall", "leaves"),
    ("bricks", "stone_wall"),
    ("pebbles", "stone_wall"),
    ("grass", "leaves"),
    ("pebbles", "bricks"),
)
_GAP, _SHEET, _QUALITY = 4, 700, 46  # pixels between pictures of the sheet, and its width
MAPS = ("straight", "diagonal", "circular", "painted")


def label_map(kind: str, size: tuple[int, int]) -> np.ndarray:
    """A map of two materials, one of `MAPS`."""
    height, width = size
    y, x = (np.indices(size) + 0.5) / np.reshape(size, (2, 1, 1))
    if kind == "straight":
        inside = x >= 0.5
    elif kind == "diagonal":
        inside = x + y >= 1
    elif kind == "circular":
        inside = ((y - 0.5) * height) ** 2 + ((x - 0.5) * width) ** 2 < (0.3 * min(size)) ** 2
    else:  # as if by hand: a blob with a bay
        angle = np.arctan2(y - 0.52, x - 0.48)
        radius = 0.29 + 0.06 * np.sin(2 * angle + 1) + 0.03 * np.sin(5 * angle)
        inside = np.hypot(y - 0.52, x - 0.48) < radius
    return inside.astype(np.int32)


def boundary(made: np.ndarray) -> list[np.ndarray]:
    """Where neighbors are of different materials: below each other, and beside each other."""
    return [made[1:] != made[:-1], made[:, 1:] != made[:, :-1]]


def places(labels: np.ndarray) -> np.ndarray:
    """Distance in pixels to the map's boundary: negative in the first region."""
    far = max(labels.shape)
    away = [np.sqrt(squared_distance_to(labels == k, far)) - 0.5 for k in (0, 1)]
    return np.where(labels == 0, -away[1], away[0])


def at_edges(made: np.ndarray, labels: np.ndarray, reach: int) -> float:
    """Share of the rows with a boundary in which it lies within a pixel of a belt's edge."""
    place = places(labels)
    crossed = boundary(made)[1]
    middle = (place[:, 1:] + place[:, :-1]) / 2
    near = crossed & (np.abs(np.abs(middle) - reach) <= 1)
    return float(near.any(axis=1).sum() / max(1, crossed.any(axis=1).sum()))


def on_one_line(made: np.ndarray, labels: np.ndarray) -> float:
    """Share of the boundary within a pixel of the parallel of the map's that has most of it."""
    place = places(labels)
    found = []
    for axis, crossed in enumerate(boundary(made)):
        a, b = (np.moveaxis(place, axis, 0)[s] for s in (slice(1, None), slice(None, -1)))
        found.append((np.moveaxis((a + b) / 2, 0, axis))[crossed])
    at = np.sort(np.concatenate(found))
    if not len(at):
        return 1.0
    together = np.searchsorted(at, at + 2, side="right") - np.arange(len(at))
    return float(together.max() / len(at))


def step(image: np.ndarray, made: np.ndarray) -> float:
    """Mean difference of neighbors across the boundary, as a multiple of all others'."""
    pixels = image.reshape(*image.shape[:2], -1).astype(np.float64)
    across, within = [], []
    for axis, crossed in enumerate(boundary(made)):
        steps = np.abs(np.diff(pixels, axis=axis)).mean(axis=2)
        across.append(steps[crossed])
        within.append(steps[~crossed])
    return float(np.concatenate(across).mean() / max(np.concatenate(within).mean(), 1e-9))


def materials(result: weftex.Synthesis, heights: list[int]) -> np.ndarray:
    """The number of the sample that each pixel is from."""
    return np.searchsorted(np.cumsum(heights), result.source[..., 0], side="right")


def row(pair: tuple[str, str], kind: str, size: tuple[int, int], **how: object) -> tuple:
    """The picture of two packaged samples and a map, and its three figures."""
    samples = [weftex.load_exemplar(f"sample:{name}") for name in pair]
    labels = label_map(kind, size)
    result = weftex.fuse(samples, labels, seed=1, **how)
    made = materials(result, [sample.shape[0] for sample in samples])
    reach = round(BELT * max(structure_scale(sample).window_width for sample in samples))
    figures = at_edges(made, labels, reach), on_one_line(made, labels), step(result.image, made)
    return result.image, figures


def sheet(size: tuple[int, int]) -> Image.Image:
    """Six pairs, two in a row: along the map's boundary, in the narrowest belts, and by default."""
    kinds = ("straight", "circular", "diagonal", "circular", "straight", "painted")
    height, width = size
    whole = Image.new("RGB", (4 * width + 3 * _GAP, 3 * height + 2 * _GAP), "white")
    for number, (pair, kind) in enumerate(zip(PAIRS, kinds, strict=False)):
        for right, how in enumerate(({"belt_width": 2}, {})):
            image, _ = row(pair, kind, size, **how)
            x = (number % 2 * 2 + right) * (width + _GAP)
            whole.paste(Image.fromarray(image), (x, number // 2 * (height + _GAP)))
    whole.thumbnail((_SHEET, whole.height), Image.Resampling.LANCZOS)
    return whole


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pictures", type=Path, metavar="FOLDER")
    parser.add_argument("--sheet", type=Path, metavar="FILE")
    parser.add_argument("--boundary", default="cut", metavar="HOW", help="as of weftex fuse")
    parser.add_argument("--size", type=int, nargs=2, default=(200, 240), metavar=("H", "W"))
    args = parser.parse_args()
    if args.sheet:
        sheet(tuple(args.size)).save(args.sheet, quality=_QUALITY, method=6)
        return
    if args.pictures:
        args.pictures.mkdir(parents=True, exist_ok=True)
    print("| materials | map | edge | line | step |\n|---|---|---|---|---|")
    for pair in PAIRS:
        for kind in MAPS:
            image, (edge, line, ratio) = row(pair, kind, tuple(args.size), boundary=args.boundary)
            print(f"| {', '.join(pair)} | {kind} | {edge:.0%} | {line:.0%} | {ratio:.2f} |")
            if args.pictures:
                weftex.write_image(args.pictures / f"{'_'.join(pair)}_{kind}.png", image)


if __name__ == "__main__":
    main()
