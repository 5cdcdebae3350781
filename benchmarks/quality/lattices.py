"""How often lattices and rows are found, and how often each confidence is right.

    python benchmarks/quality/lattices.py [--seeds N] [--more FOLDER] [--jobs N] [--fit] [--small]

Surfaces are drawn whose lattice is known (see drawn.py), N of each kind, 9 by default; real ones
are those of weftex, and with --more the pictures of a folder that lattices.json has the lattices
of: those were measured by eye, before the detector saw them. Each is looked at whole and in crops
of 384 and 256 pixels, real ones in three of each. What shows less than six tiles or three rows
does not count as missed. A lattice is right if it misses no vector by more than 4 % of its length,
rows by 6 %.

--fit prints the weights of confidences, of the surfaces of one half: drawn ones with an even seed,
real ones with a name of even hash. Reliability is that of the other half.
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import process_time

import numpy as np
from drawn import KINDS, Vectors, draw
from numpy.typing import NDArray

import weftex
from weftex.analysis.autocorrelations import autocorrelations
from weftex.analysis.evidence import (
    SUREST,
    WEIGHTS,
    Evidence,
    better_pair,
    pair_candidates,
    row_candidate,
    with_alternation,
)
from weftex.analysis.lattice import Lattice, lattice_in

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "benchmarks" / "data"
TRUTH: dict[str, Vectors] = {
    name: tuple((x, y) for x, y in vectors)
    for name, vectors in json.loads((DATA / "lattices.json").read_text()).items()
    if name != "about"
}
FOLDERS = (DATA / "surfaces", ROOT / "examples" / "samples")
SAMPLES = ("bricks", "tiles", "weave", "pebbles", "grass", "wood", "leaves", "stone_wall")
_TOLERANCE = {1: 0.06, 2: 0.04}
_SIDES = (256, 384)
FITTED = ("pairs", "rows")
_PRIOR = 0.05  # as if a twentieth of a crop said that a weight is 0
_BINS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.001)


@dataclass(frozen=True)
class Case:
    """What was found in a crop, and what it has."""

    kind: str
    real: bool
    fitted: bool  # whether it is of the half that weights are fitted on
    crop: str
    truth: Vectors
    found: Lattice | None
    shown: bool  # whether it shows enough to be found
    seconds: float
    pair: tuple[tuple[float, ...], bool] | None  # figures of the better pair, whether it is right
    rows: tuple[tuple[float, ...], bool] | None

    @property
    def right(self) -> bool:
        return is_right(self.found, self.truth)


def is_right(found: Lattice | None, truth: Vectors) -> bool:
    """Whether that is the lattice; of a surface without one, whether nothing is found."""
    if found is None or not truth:
        return found is None and not truth
    return found.same_as(Lattice(truth), _TOLERANCE[len(truth)])


def crops(pixels: NDArray, number: int) -> Iterator[tuple[str, NDArray]]:
    """The whole, and so many crops: of its corners, or its middle."""
    yield "whole", pixels
    for side in _SIDES:
        if min(pixels.shape[:2]) > side:
            for share in (0.0, 0.5, 1.0) if number == 3 else (0.5,):
                y, x = (round(share * (n - side)) for n in pixels.shape[:2])
                yield str(side), np.ascontiguousarray(pixels[y : y + side, x : x + side])


def look(kind: str, real: bool, fitted: bool, pixels: NDArray, truth: Vectors) -> list[Case]:
    """All crops of a surface."""
    made = []
    for crop, part in crops(pixels, 3 if real else 1):
        exemplar = weftex.Exemplar(part)
        start = process_time()
        fields = autocorrelations(exemplar)
        found = lattice_in(fields)
        seconds = process_time() - start
        height, width = exemplar.shape
        shown = True
        if len(truth) == 2:
            shown = height * width >= 6 * Lattice(truth).area
        elif truth:
            shown = min(height, width) >= 3 * float(np.hypot(*truth[0]))
        pair, rows = better_pair(pair_candidates(fields)), row_candidate(fields)
        pair = pair and with_alternation(fields, pair)
        one_of = (pair, rows)
        if pair is not None and pair.kind != "pairs":  # has other figures; nothing else is asked
            one_of = (None, None)
        figures = [
            one and (one.figures, is_right(_plain(one, fields.flat.step), truth)) for one in one_of
        ]
        made.append(Case(kind, real, fitted, crop, truth, found, shown, seconds, *figures))
    return made


def _plain(one: Evidence, step: int) -> Lattice:
    return Lattice(tuple((float(x), float(y)) for x, y in one.vectors * step)).reduced()


def drawn_case(name: tuple[str, int, int]) -> list[Case]:
    """All crops of a drawn surface, of a kind, a seed and a side."""
    kind, seed, side = name
    pixels, truth = draw(kind, seed, side)
    return look(kind, False, seed % 2 == 0, pixels, truth)


def real_case(name: tuple[str, str]) -> list[Case]:
    """All crops of a real surface, of a name and what to load."""
    surface, source = name
    even = hashlib.md5(surface.encode()).digest()[0] % 2 == 0
    pixels = weftex.load_exemplar(source).pixels
    return look(surface, True, even, pixels, TRUTH[surface])


def real_names(more: Sequence[Path]) -> list[tuple[str, str]]:
    """Names of real surfaces and where they are; each once."""
    found: dict[str, str] = {}
    for folder in (*more, *FOLDERS):
        pictures = (path for path in folder.iterdir() if path.suffix in (".png", ".webp"))
        for path in [*sorted(pictures), *sorted(folder.glob("*/albedo.png"))]:
            name = path.parent.name if path.stem == "albedo" else path.stem
            if name in TRUTH:
                found.setdefault(name, str(path))
    return [*found.items(), *((f"sample:{name}", f"sample:{name}") for name in SAMPLES)]


def fit(cases: Sequence[Case]) -> list[NDArray]:
    """Weights by which figures say how often a lattice is right, and how often rows are.

    Logistic regression over what would be chosen: the surer of the pairs, and rows where no pair is
    right more often than not. That depends on the weights, so pairs are fitted first. Every surface
    counts as much, and drawn ones together as much as real ones.
    """
    crops_of: dict[tuple[bool, str], int] = defaultdict(int)
    for case in cases:
        crops_of[case.real, case.kind] += 1
    weights = [np.array(WEIGHTS[kind]) for kind in FITTED]
    for step in [0] * 8 + [1] * 4:
        chosen = []
        for case in cases:
            one = _chosen(case, weights, step)
            if one is not None and case.shown:
                surfaces = sum(real == case.real for real, _ in crops_of)
                chosen.append((*one, 1 / crops_of[case.real, case.kind] / surfaces))
        if not chosen:  # of a few surfaces alone
            continue
        x = np.array([figures for figures, _, _ in chosen])
        y, w = (np.array([float(one[k]) for one in chosen]) for k in (1, 2))
        x[:, weights[step] == 0] = 0  # figures that this kind does not have
        weights[step] = _logistic(x, y, w * len(w) / w.sum())
    return weights


def _chosen(
    case: Case, weights: Sequence[NDArray], step: int
) -> tuple[tuple[float, ...], bool] | None:
    """Figures of what is chosen of a case by weights, and whether it is right."""
    found = (case.pair, case.rows)
    for one, weight in zip(found[:step], weights, strict=False):
        if one is not None and SUREST / (1 + np.exp(-np.dot(one[0], weight))) >= 0.5:
            return None
    return found[step]


def _logistic(x: NDArray, y: NDArray, w: NDArray) -> NDArray:
    """Logistic regression with a share of lapses, by Fisher's scoring and a weak prior."""
    found = np.array([-1.0] + [0.5] * (x.shape[1] - 1))
    for _ in range(200):
        share = 1 / (1 + np.exp(-np.clip(x @ found, -30, 30)))
        right = np.clip(SUREST * share, 1e-6, 1 - 1e-6)
        change = SUREST * share * (1 - share)
        weight = w * change / (right * (1 - right))
        slope = x.T @ (weight * (y - right)) - _PRIOR * found
        bend = (x * (weight * change)[:, None]).T @ x + _PRIOR * np.eye(len(found))
        found += np.clip(np.linalg.solve(bend, slope), -0.5, 0.5)
    return found


def reliability(cases: Sequence[Case], vectors: int) -> list[list[str]]:
    """Of lattices with a confidence, the mean confidence, and the share that is right."""
    found = [
        (case.found.confidence, case.right)
        for case in cases
        if case.found is not None and len(case.found.vectors) == vectors
    ]
    table = []
    for low, high in itertools.pairwise(_BINS):
        own = [(c, right) for c, right in found if low <= c < high]
        if own:
            means = [f"{np.mean([one[k] for one in own]):.2f}" for k in (0, 1)]
            table.append([f"{low:.1f} to {min(high, 1):.1f}", str(len(own)), *means])
    return table


def shares(cases: Sequence[Case]) -> list[list[str]]:
    """By crop: how often it is right with a lattice, with rows, and with neither."""
    table = []
    for crop in (*map(str, _SIDES), "whole"):
        line = [crop]
        for vectors in (2, 1, 0):
            own = [c for c in cases if c.crop == crop and len(c.truth) == vectors and c.shown]
            good = sum(c.right for c in own)
            line.append(f"{good} of {len(own)}" if own else "-")
        times = [1000 * c.seconds for c in cases if c.crop == crop]
        table.append([*line, f"{np.median(times):.0f} ms" if times else "-"])
    return table


def show(head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """A table in Markdown."""
    for line in (head, ["---"] * len(head), *rows):
        print("| " + " | ".join(line) + " |")
    print()


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--seeds", type=int, default=9, help="surfaces of each kind")
    parser.add_argument("--more", type=Path, nargs="*", default=[], help="folders of real surfaces")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--fit", action="store_true", help="print weights of confidences")
    parser.add_argument("--small", action="store_true", help="a few surfaces, to see that it runs")
    args = parser.parse_args(words)
    kinds = list(KINDS)[::8] if args.small else list(KINDS)
    seeds, side = (2, 128) if args.small else (args.seeds, 512)
    names = [(kind, seed, side) for seed in range(seeds) for kind in kinds]
    real = real_names(args.more)[: 1 if args.small else None]
    cases: list[Case] = []
    with ProcessPoolExecutor(args.jobs) as pool:
        run = map if args.jobs == 1 else partial(pool.map, chunksize=4)
        for made in (*run(drawn_case, names), *run(real_case, real)):
            cases += made
    if args.fit:
        for name, weights in zip(FITTED, fit([case for case in cases if case.fitted]), strict=True):
            print(name, "=", ", ".join(f"{weight:.2f}" for weight in weights))
        print()
    head = ["pixels", "with a lattice", "with rows", "with neither", "processor time"]
    for title, own in (("drawn", False), ("real", True)):
        print(f"{title}, right:\n")
        show(head, shares([case for case in cases if case.real == own]))
    other = [case for case in cases if not case.fitted]
    for title, vectors in (("lattices", 2), ("rows", 1)):
        print(f"{title} of the half that nothing was fitted to, by confidence:\n")
        show(["confidence", "number", "mean", "right"], reliability(other, vectors))
    print("not right, by kind of surface:\n")
    wrong: dict[str, int] = defaultdict(int)
    for case in cases:
        wrong[case.kind] += case.shown and not case.right
    print(", ".join(f"{kind} {number}" for kind, number in sorted(wrong.items()) if number))


if __name__ == "__main__":
    main()
