"""How well do the judges agree with each other, and the figures with the judges?

    python benchmarks/quality/judged/agreement.py           # tables
    python benchmarks/quality/judged/agreement.py FOLDER  # write figures.csv of draw.py's output

A figure agrees on a pair of pictures of one surface if it puts them in the judge's order; a tie
counts half. Pairs that the judge holds to be equal are left out. The weights of the score are
fitted to five sixths of the surfaces and tried on the last, six times; those in
`weftex.quality.score` are fitted to all.

Judges saw only outputs of programs. So the fit also has pairs that need no judge: the lower half of
a sample, as if it had been made from the upper one, before that half spoiled.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from draw import table
from PIL import Image

import weftex
from weftex.quality.figures import FIGURES
from weftex.quality.score import WEIGHTS, Scorer, terms
from weftex.random import draw

HERE = Path(__file__).resolve().parent
MEASURED = dict.fromkeys([*WEIGHTS, *(name for name, one in FIGURES.items() if one.agrees)])
REAL = "real"
FOLDS = 6
_RIDGE = 3.0  # on the weights of terms in units of their spread
_SURE = 4.0  # ranks apart that a pair without a judge stands for
_BLOCK = 32  # pixels

Known = dict[tuple[str, str], dict[str, float]]


@dataclass(frozen=True)
class Pair:
    """Two pictures of a surface, the second worse to a judge; ranks and marks apart."""

    surface: str
    judge: str
    better: str
    worse: str
    ranks: float
    marks: int  # whole ones


def pairs(given: list[dict[str, str]] | None = None) -> list[Pair]:
    """Every pair that a judge put in an order; by default those of judgements.csv.

    Pictures that were looked at together have names that are the same but for their last word.
    """
    sets: dict[tuple[str, ...], dict[str, tuple[int, float]]] = defaultdict(dict)
    for line in table("judgements.csv") if given is None else given:
        together = line["picture"].rpartition(" ")[0]
        of = sets[line["surface"], line["judge"], together]
        of[line["picture"]] = int(line["rank"]), float(line["mark"])
    found = []
    for (surface, judge, _), of in sets.items():
        for first, second in itertools.combinations(sorted(of), 2):
            better, worse = sorted((first, second), key=lambda picture: of[picture][0])
            ranks, marks = (b - a for a, b in zip(of[better], of[worse], strict=True))
            if ranks:
                found.append(Pair(surface, judge, better, worse, ranks, math.floor(-marks)))
    return found


def judges(ordered: list[Pair]) -> list[tuple[str, float, int]]:
    """How often two judges agree: on all pairs that both put in an order, and by their marks."""
    each: dict[tuple[str, frozenset[str]], list[Pair]] = defaultdict(list)
    for pair in ordered:
        each[pair.surface, frozenset((pair.better, pair.worse))].append(pair)
    both = [found for found in each.values() if len(found) == 2]
    rows = [("all", both)]
    for apart in (0, 1, 2, 3):
        rows.append((f"{apart}", [two for two in both if min(two[0].marks, 3) == apart]))
    return [
        (name, float(np.mean([a.better == b.better for a, b in two])), len(two))
        for name, two in rows
    ]


def spoiled(real: np.ndarray, sample: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Pictures of the size of a real one that are worse than it to any viewer."""
    height, width = real.shape[:2]
    blurred = np.pad(real.astype(np.float64), ((2, 2), (2, 2), (0, 0)), mode="edge")
    for axis in (0, 1):
        blurred = np.lib.stride_tricks.sliding_window_view(blurred, 5, axis).mean(-1)
    yield "blurred", np.rint(blurred).astype(np.uint8)
    pixels = real.reshape(-1, 3)
    yield "noise", pixels[np.argsort(draw(0, "pixels", np.arange(len(pixels))))].reshape(real.shape)
    side = min(sample.shape[:2]) // 2
    yield (
        "tiled",
        np.tile(sample[:side, :side], (-(-height // side), -(-width // side), 1))[:height, :width],
    )
    rows, columns = height // _BLOCK, width // _BLOCK
    bits = draw(0, "blocks", np.arange(rows * columns)[:, None], np.arange(3))
    places = [divmod(int(k), columns) for k in np.argsort(bits[:, 0])]
    room = np.array(sample.shape[:2]) - _BLOCK + 1
    for name, whole, corners in (
        ("shuffled", real, np.array(places) * _BLOCK),
        ("patched", sample, (bits[:, 1:] % room.astype(np.uint64)).astype(int)),
    ):
        blocks = np.stack([whole[y : y + _BLOCK, x : x + _BLOCK] for y, x in corners])
        blocks = blocks.reshape(rows, columns, _BLOCK, _BLOCK, 3).swapaxes(1, 2)
        yield name, blocks.reshape(rows * _BLOCK, columns * _BLOCK, 3)


def sure(figures: Known) -> list[Pair]:
    """Pairs that need no judge: a real picture before what is spoiled of it."""
    return [
        Pair(surface, "", REAL, name, _SURE, 4)
        for surface, name in figures
        if not name.isdigit() and name != REAL
    ]


def measure(folder: Path) -> None:
    """Write figures.csv: what `weftex.assess` finds in each picture, without a source."""
    with (HERE / "figures.csv").open("w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(("surface", "picture", *MEASURED))
        for surface in sorted({pair.surface for pair in pairs()}):
            for name, sample, picture in pictures(folder / surface):
                scorer = Scorer(sample)
                terms_of = scorer.figures(scorer.view(picture))
                found = weftex.assess(sample, picture).as_dict()
                values = (_text(found.get(name, terms_of.get(name))) for name in MEASURED)
                lines.writerow((surface, name, *values))
            print(surface, flush=True)


def _text(value: float | None) -> str:
    return "" if value is None else f"{round(value, 3)}"


def pictures(folder: Path) -> Iterator[tuple[str, weftex.Exemplar, np.ndarray]]:
    """What was made of a sample, and of its upper half."""
    sample = weftex.load_exemplar(folder / "sample.png")
    names = [line["picture"] for line in table("recipes.csv") if line["surface"] == folder.name]
    for name in names:
        yield name, sample, np.array(Image.open(folder / f"{name}.png"))
    upper, lower = np.split(sample.pixels, 2)
    half = weftex.Exemplar(upper)
    yield REAL, half, lower
    for name, worse in spoiled(lower, upper):
        yield name, half, worse


def known(name: str = "figures.csv") -> Known:
    """The figures of each picture; those that could not be measured are left out."""
    return {
        (line["surface"], line["picture"]): {
            figure: float(line[figure]) for figure in MEASURED if line.get(figure)
        }
        for line in table(name)
    }


def off(name: str, value: float) -> float:
    """How far a figure is from perfect; terms that are no figures are perfect at 0."""
    return FIGURES[name].off(value) if name in FIGURES else value


def share(differences: np.ndarray) -> float:
    """How many are above 0; ties count half."""
    return float(((differences > 0) + 0.5 * (differences == 0)).mean())


def agreement(figure: str, figures: Known, ordered: list[Pair]) -> tuple[float, int]:
    """The share of pairs that a figure orders as the judge did, and how many have it."""
    differences = []
    for pair in ordered:
        better, worse = (figures[pair.surface, name] for name in (pair.better, pair.worse))
        if figure in better and figure in worse:
            differences.append(off(figure, worse[figure]) - off(figure, better[figure]))
    return share(np.array(differences)), len(differences)


def steps(figures: Known, ordered: list[Pair]) -> np.ndarray:
    """By how much the terms of the worse picture are above those of the better, (pairs, terms)."""
    made = {at: terms(found) for at, found in figures.items()}
    return np.array(
        [
            [
                made[pair.surface, pair.worse].get(name, 0)
                - made[pair.surface, pair.better].get(name, 0)
                for name in WEIGHTS
            ]
            for pair in ordered
        ]
    )


def fit(apart: np.ndarray, heavy: np.ndarray) -> np.ndarray:
    """Weights of at least 0 of a logistic regression without intercept, (terms,).

    Projected Newton steps: a weight that would fall below 0 stays there.
    """
    spread = np.sqrt((apart**2).mean(axis=0))
    unit, weights = apart / spread, np.full(apart.shape[1], 0.1)
    for _ in range(100):
        miss = 1 / (1 + np.exp(unit @ weights))
        slope = 2 * _RIDGE * weights - (heavy * miss) @ unit
        free = (weights > 0) | (slope < 0)
        curve = (unit * (heavy * miss * (1 - miss))[:, None]).T @ unit
        curve += 2 * _RIDGE * np.eye(len(weights))
        step = np.zeros_like(weights)
        step[free] = np.linalg.solve(curve[np.ix_(free, free)], slope[free])
        weights = np.maximum(weights - step, 0)
    return weights / spread


def fitted(figures: Known, ordered: list[Pair]) -> np.ndarray:
    """Weights for all of these pairs; each judge is half of what is known of a pair."""
    heavy = np.array([pair.ranks for pair in ordered])
    return fit(steps(figures, ordered), heavy / 2 / heavy.mean())


def left_out(
    figures: Known, ordered: list[Pair], more: list[Pair], tried: list[Pair] | None = None
) -> np.ndarray:
    """By how much the worse picture's score is above, by weights fitted to other surfaces.

    Of the ordered pairs themselves, or of others, which nothing is fitted to.
    """
    names = sorted({pair.surface for pair in ordered})
    turn = np.argsort(draw(0, "folds of surfaces", np.arange(len(names))))
    fold = {name: int(turn[k]) % FOLDS for k, name in enumerate(names)}
    tried = ordered if tried is None else tried
    apart, said = steps(figures, tried), np.zeros(len(tried))
    for k in range(FOLDS):
        part = np.array([fold.get(pair.surface, 0) == k for pair in tried])
        others = [pair for pair in ordered + more if fold[pair.surface] != k]
        said[part] = apart[part] @ fitted(figures, others)
    return said


def by_marks(said: np.ndarray, of: list[Pair]) -> None:
    """Print the share of pairs that a score orders as a judge, by how far their marks are apart."""
    print(f"  {'all':16} {share(said):.3f} of {len(of)}")
    for least in (0, 1, 2, 3):
        part = np.array([min(max(pair.marks, 0), 3) == least for pair in of])
        print(f"  {f'{least} marks apart':16} {share(said[part]):.3f} of {part.sum()}")
    part = np.array([pair.marks >= 1 for pair in of])
    print(f"  {'1 and more':16} {share(said[part]):.3f} of {part.sum()}")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?")
    given = parser.parse_args()
    if given.folder:
        measure(given.folder)
    ordered, figures = pairs(), known()
    more = sure(figures)
    print("two judges, by the lesser difference of their marks")
    for name, agrees, count in judges(ordered):
        print(f"  {name:16} {agrees:.3f} of {count}")
    print("figures with a judge")
    for name in (name for name in MEASURED if name != "broken"):
        agrees, count = agreement(name, figures, ordered)
        print(f"  {name:16} {agrees:.3f} of {count}")
    print("broken with a judge, on pictures of several programs")
    agrees, count = agreement("broken", known("programs.csv"), pairs(table("programs.csv")))
    print(f"  {agrees:.3f} of {count}")
    print("score with a judge, on surfaces that were not fitted")
    by_marks(left_out(figures, ordered, more), ordered)
    print("and on the pictures of other looks, which nothing was fitted to")
    other = pairs(table("looks.csv"))
    by_marks(left_out(figures | known("looks.csv"), ordered, more, other), other)
    found = fitted(figures, ordered + more)
    print(f"real before spoiled: {share(steps(figures, more) @ found):.3f} of {len(more)}")
    print("weights:", {name: round(float(w), 2) for name, w in zip(WEIGHTS, found, strict=True)})


if __name__ == "__main__":
    main()
