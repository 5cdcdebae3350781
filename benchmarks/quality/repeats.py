"""What pieces show: their seams, what they show again in line and in sight, and how evenly.

    python benchmarks/quality/repeats.py                           # graphcut, both placements
    python benchmarks/quality/repeats.py 1024 "quilting" "quilting repeat_distance=0"
    python benchmarks/quality/repeats.py 512 "graphcut" --surfaces bark pebbles_mixed

Means over surfaces of `benchmarks/data/surfaces`, crops of 256 pixels, one seed. `seam`: difference
along seams, summed, per thousand pixels of the picture, in standard deviations of the sample.
`line`, `sight`: how often a place of the sample, 16 pixels wide, is shown twice within 8 pixels of
one row or column, and within half of the sample both ways; 1 is chance. `use`: standard deviation
over mean of how often the sample's places are shown. `unused`: the share of places shown less than
a tenth as often as the mean. `seconds`: processor time.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import weftex
from weftex.naming import parse_method

DATA = Path(__file__).parents[1] / "data"
SURFACES = ("bark", "cobbles_granite", "floor_boards", "leaves_autumn", "pebbles_mixed",
            "rock_cracked", "roof_slates", "stone_wall")  # fmt: skip
WAYS = ("graphcut", "graphcut placement=entire", "graphcut placement=entire variety=0")
PLACE = 16  # pixels; side of a place
ALIGNED = 8  # pixels; pieces so far off are in line


def seams(source: np.ndarray, sample: np.ndarray) -> float:
    """Difference along seams, per thousand pixels, in standard deviations of the sample."""
    levels, total = sample.astype(float), 0.0
    shape = np.array(sample.shape[:2])
    for step in ((0, 1), (1, 0)):
        first = source[: source.shape[0] - step[0], : source.shape[1] - step[1]]
        second = source[step[0] :, step[1] :]
        seam = (first + step != second).any(axis=2)
        pairs = ((first[seam], second[seam], step), (second[seam], first[seam], np.negative(step)))
        for here, beside, way in pairs:
            there = here + way
            inside = ((there >= 0) & (there < shape)).all(axis=1)
            there, beside = there[inside], beside[inside]
            difference = levels[tuple(there.T)] - levels[tuple(beside.T)]
            total += float(np.abs(difference).mean(axis=1).sum()) / 2
    return 1000 * total / source[..., 0].size / levels.std()


def again(source: np.ndarray, side: int) -> tuple[float, float]:
    """How often places are shown again in line, and in sight; 1 is chance."""
    shape = np.array(source.shape[:2])
    at = np.stack(np.mgrid[4 : shape[0] : 8, 4 : shape[1] : 8], axis=2).reshape(-1, 2)
    place, within = np.divmod(source[at[:, 0], at[:, 1]], PLACE)
    shown = np.unique(np.hstack([place, at - within]), axis=0)
    line = sight = pairs = 0
    for one in np.unique(shown[:, :2], axis=0):
        corners = shown[(shown[:, :2] == one).all(axis=1), 2:]
        i, j = np.triu_indices(len(corners), 1)
        away = np.abs(corners[i] - corners[j])
        apart = (away > ALIGNED).any(axis=1)
        line += int(((away <= ALIGNED).any(axis=1) & apart).sum())
        sight += int(((away <= side // 2).all(axis=1) & apart).sum())
        pairs += len(away)
    lined = 1 - np.prod((1 - (ALIGNED + 0.5) / shape) ** 2)
    seen = np.prod(1 - (1 - np.minimum(1, side / 2 / shape)) ** 2)
    return line / max(1, pairs * lined), sight / max(1, pairs * seen)


def use(source: np.ndarray, shape: tuple[int, ...]) -> tuple[float, float]:
    """How unevenly the sample's places are shown, and the share that hardly is."""
    rows, columns = (n // PLACE for n in shape[:2])
    place = source.reshape(-1, 2) // PLACE
    place = place[(place < (rows, columns)).all(axis=1)]
    counts = np.bincount(place[:, 0] * columns + place[:, 1], minlength=rows * columns)
    return counts.std() / counts.mean(), float((counts < counts.mean() / 10).mean())


def measured(name: str, way: str, size: int, crop: int) -> tuple[float, ...]:
    """All figures of one surface."""
    (path,) = (DATA / "surfaces").glob(f"{name}.*")
    pixels = weftex.load_exemplar(path).pixels
    top, left = ((n - crop) // 2 for n in pixels.shape[:2])
    sample = weftex.Exemplar(np.ascontiguousarray(pixels[top : top + crop, left : left + crop]))
    start = time.process_time()
    source = parse_method(way).fit(sample).sample(size, seed=1, threads=1).source
    seconds = time.process_time() - start
    shape = sample.pixels.shape
    return (
        seams(source, sample.pixels),
        *again(source, min(shape[:2])),
        *use(source, shape),
        seconds,
    )


def main(words: list[str] | None = None) -> None:
    """Print a table, a row for each way."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("size", nargs="?", type=int, default=512)
    parser.add_argument("ways", nargs="*", default=WAYS)
    parser.add_argument("--surfaces", nargs="+", default=SURFACES)
    parser.add_argument("--crop", type=int, default=256)
    given = parser.parse_args(words)
    print("| | seam | line | sight | use | unused | seconds |\n|---|---|---|---|---|---|---|")
    for way in given.ways or WAYS:
        rows = [measured(name, way, given.size, given.crop) for name in given.surfaces]
        print(f"| `{way}` |", " | ".join(f"{mean:.2f}" for mean in np.mean(rows, axis=0)), "|")


if __name__ == "__main__":
    main()
