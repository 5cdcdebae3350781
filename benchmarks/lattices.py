"""How often lattices and rows are found, and how often each confidence is right.

    python benchmarks/lattices.py [--seeds N] [--more FOLDER ...] [--jobs N] [--fit] [--update]

Surfaces are drawn whose lattice is known (see drawn.py), N of each kind, 7 by default; real ones
are those of weftex, and with --more the pictures of folders that lattices.json has the lattices
of: those were measured by eye, before the detector saw them. Each is looked at whole and in crops
of 256 pixels, real ones in three. What shows less than six tiles or three rows does not count as
missed. A lattice is right if it misses no vector by more than 4 % of its length, rows by 6 %.

Surfaces are halved by a hash of their names. Whoever changes the detector looks at those of even
hash, and --fit prints the weights of confidences of these; the tables are of the others, and of
all. --update writes them into docs/measured/lattices.md.
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
from weftex.analysis.evidence import SUREST, WEIGHTS, Evidence
from weftex.analysis.lattice import (
    Lattice,
    bond_seen,
    in_turn,
    lattice_in,
    pair_seen,
    rows_seen,
    views,
)
from weftex.analysis.rows import find_rows

HERE = Path(__file__).resolve().parent
TRUTH: dict[str, Vectors] = {
    name: tuple((x, y) for x, y in vectors)
    for name, vectors in json.loads((HERE / "lattices.json").read_text()).items()
    if name != "about"
}
FOLDERS = (HERE / "surfaces", HERE.parent / "examples" / "samples")
SAMPLES = ("bricks", "tiles", "weave", "pebbles", "grass", "wood", "leaves", "stone_wall")
_TOLERANCE = {1: 0.06, 2: 0.04}
_SIDE = 256
PAGE = HERE.parent / "docs" / "measured" / "lattices.md"
_PRIOR = 0.05  # as if a twentieth of a crop said that a weight is 0
_FIRST = 20  # seed; those before are for tests and trials
_BINS = (0.5, 0.7, 0.9, 0.94, 1.001)


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
    seen: dict[str, tuple[tuple[float, ...], bool]]  # figures of each kind, and whether it is right

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
    if min(pixels.shape[:2]) > _SIDE:
        for share in (0.0, 0.5, 1.0) if number == 3 else (0.5,):
            y, x = (round(share * (n - _SIDE)) for n in pixels.shape[:2])
            yield str(_SIDE), np.ascontiguousarray(pixels[y : y + _SIDE, x : x + _SIDE])


def look(kind: str, real: bool, fitted: bool, pixels: NDArray, truth: Vectors) -> list[Case]:
    """All crops of a surface."""
    made = []
    for crop, part in crops(pixels, 3 if real else 1):
        exemplar = weftex.Exemplar(part)
        start = process_time()
        seen = views(exemplar)
        found = lattice_in(seen)
        seconds = process_time() - start
        height, width = exemplar.shape
        shown = True
        if len(truth) == 2:
            shown = height * width >= 6 * Lattice(truth).area
        elif truth:
            shown = min(height, width) >= 3 * float(np.hypot(*truth[0]))
        pair, rows = pair_seen(seen), find_rows(seen.joints)
        bond = rows and bond_seen(seen, rows, pair)
        figures = {
            one.kind: (one.figures, is_right(_plain(one, seen.flat.step), truth))
            for one in (pair and in_turn(seen, pair), rows_seen(rows), bond)
            if one is not None
        }
        made.append(Case(kind, real, fitted, crop, truth, found, shown, seconds, figures))
    return made


def _plain(one: Evidence, step: int) -> Lattice:
    return Lattice(tuple((float(x), float(y)) for x, y in one.vectors * step)).reduced()


def drawn_case(name: tuple[str, int, int]) -> list[Case]:
    """All crops of a drawn surface, of a kind, a seed and a side."""
    kind, seed, side = name
    pixels, truth = draw(kind, seed, side)
    return look(f"{kind} {seed}", False, is_even(f"{kind} {seed}"), pixels, truth)


def real_case(name: tuple[str, str]) -> list[Case]:
    """All crops of a real surface, of a name and what to load."""
    surface, source = name
    pixels = weftex.load_exemplar(source).pixels
    return look(surface, True, is_even(surface), pixels, TRUTH[surface])


def is_even(surface: str) -> bool:
    """Whether a surface is of the half that the detector may be changed by."""
    return hashlib.md5(surface.encode()).digest()[0] % 2 == 0


def real_names(more: Sequence[Path]) -> list[tuple[str, str]]:
    """Names of real surfaces and where they are; each once."""
    found: dict[str, str] = {}
    for folder in (*more, *FOLDERS):
        for path in sorted(folder.glob("*.png")) + sorted(folder.glob("*/albedo.png")):
            name = path.parent.name if path.stem == "albedo" else path.stem
            if name in TRUTH:
                found.setdefault(name, str(path))
    return [*found.items(), *((f"sample:{name}", f"sample:{name}") for name in SAMPLES)]


def fit(cases: Sequence[Case]) -> dict[str, NDArray]:
    """Weights by which figures say how often a lattice is right, and how often rows and bonds are.

    Logistic regression: of pairs over all; of bonds over all with rows that are sure, but for those
    that a sure pair is right of; of rows over what has neither a sure pair nor a sure bond. That
    hangs on the weights, so they are fitted in turn. Every surface counts as much, and drawn ones
    together as much as real ones.
    """
    crops_of: dict[tuple[bool, str], int] = defaultdict(int)
    for case in cases:
        crops_of[case.real, case.kind] += 1
    weights = {kind: np.array(one) for kind, one in WEIGHTS.items()}
    for _ in range(6):
        for kind in weights:
            chosen = []
            for case in cases:
                if case.shown and _counts(case, weights, kind):
                    surfaces = sum(real == case.real for real, _ in crops_of)
                    weight = 1 / crops_of[case.real, case.kind] / surfaces
                    chosen.append((*case.seen[kind], weight))
            x = np.array([figures for figures, _, _ in chosen])
            y, w = (np.array([float(one[k]) for one in chosen]) for k in (1, 2))
            weights[kind] = _logistic(x, y, w * len(w) / w.sum())
    return weights


def _counts(case: Case, weights: dict[str, NDArray], kind: str) -> bool:
    """Whether a kind of evidence of a case is fitted to."""

    def sure(one: str) -> bool:
        known = case.seen.get(one)
        return known is not None and SUREST / (1 + np.exp(-np.dot(known[0], weights[one]))) >= 0.5

    if kind not in case.seen or kind == "pairs":
        return kind in case.seen
    if kind == "rows":
        return not sure("pairs") and not (sure("rows") and sure("bonds"))
    return sure("rows") and (case.seen["bonds"][1] or not (sure("pairs") and case.seen["pairs"][1]))


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
            name = ("lattices", "rows")[vectors == 1]
            table.append([name, f"{low:.2f} to {min(high, 1):.2f}", str(len(own)), *means])
    return table


def shares(cases: Sequence[Case]) -> list[list[str]]:
    """By crop: how often it is right with a lattice, with rows, and with neither."""
    table = []
    for real, crop in itertools.product((False, True), (str(_SIDE), "whole")):
        line = [("drawn", "real")[real], crop]
        seen = [case for case in cases if case.real == real and case.crop == crop]
        for vectors in (2, 1, 0):
            own = [case for case in seen if len(case.truth) == vectors and case.shown]
            line.append(f"{sum(case.right for case in own)} of {len(own)}" if own else "-")
        times = [1000 * case.seconds for case in seen]
        table.append([*line, f"{np.median(times):.0f} ms" if times else "-"])
    return table


def missed(cases: Sequence[Case]) -> list[list[str]]:
    """Of each kind that was drawn, and of each real surface, how many were wrong."""
    counts: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    for case in cases:
        if case.shown:
            own = counts[case.kind if case.real else case.kind.rsplit(" ", 1)[0]]
            own[0], own[1] = own[0] + (not case.right), own[1] + 1
    return [[kind, f"{wrong} of {all_}"] for kind, (wrong, all_) in sorted(counts.items()) if wrong]


def measured(cases: Sequence[Case]) -> list[list[str]]:
    """What was found in each whole real surface that repeats."""

    def words(vectors: Vectors) -> str:
        return ", ".join(f"[{x:g}, {y:g}]" for x, y in vectors)

    return [
        [
            case.kind,
            words(case.truth),
            "none" if case.found is None else words(case.found.vectors),
            "-" if case.found is None else f"{case.found.confidence:.2f}",
            "yes" if case.right else "**no**",
        ]
        for case in cases
        if case.real and case.crop == "whole" and case.truth
    ]


def as_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """In Markdown."""
    lines = (head, ["---"] * len(head), *rows)
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def page(cases: Sequence[Case]) -> str:
    """All tables."""
    other = [case for case in cases if not case.fitted]
    number, real = (len({c.kind for c in cases if c.real == own}) for own in (False, True))
    head = ["surfaces", "pixels", "with a lattice", "with rows", "with neither", "processor time"]
    return "\n\n".join(
        (
            "# Lattices that are found",
            "`python benchmarks/lattices.py --update` writes this page; edits are lost.",
            f"{number} drawn surfaces and {real} real ones, halved by a hash of their names.",
            "## Right, of the half that nothing was fitted to or looked at",
            as_table(head, shares(other)),
            "## Right, of all",
            as_table(head, shares(cases)),
            "## Confidences, of the half that nothing was fitted to or looked at",
            as_table(
                ["found", "confidence", "number", "mean", "right"],
                reliability(other, 2) + reliability(other, 1),
            ),
            "## Confidences, of all",
            as_table(
                ["found", "confidence", "number", "mean", "right"],
                reliability(cases, 2) + reliability(cases, 1),
            ),
            "## Wrong, by kind of surface",
            as_table(["surface", "wrong"], missed(cases)),
            "## Whole real surfaces that repeat",
            as_table(["surface", "measured", "found", "confidence", "right"], measured(cases)),
        )
    )


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--seeds", type=int, default=7, help="surfaces of each kind")
    parser.add_argument("--more", type=Path, nargs="*", default=[], help="folders of real surfaces")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--fit", action="store_true", help="print weights of confidences")
    parser.add_argument("--update", type=Path, nargs="?", const=PAGE, help="write the page")
    parser.add_argument("--small", action="store_true", help="a few surfaces, to see that it runs")
    args = parser.parse_args(words)
    kinds = list(KINDS)[::8] if args.small else list(KINDS)
    seeds, side = (2, 128) if args.small else (args.seeds, 512)
    names = [(kind, seed, side) for seed in range(_FIRST, _FIRST + seeds) for kind in kinds]
    real = real_names(args.more)[: 1 if args.small else None]
    cases: list[Case] = []
    with ProcessPoolExecutor(args.jobs) as pool:
        run = map if args.jobs == 1 else partial(pool.map, chunksize=4)
        for made in (*run(drawn_case, names), *run(real_case, real)):
            cases += made
    if args.fit:
        for name, weights in fit([case for case in cases if case.fitted]).items():
            print(f'"{name}":', ", ".join(f"{weight:.2f}" for weight in weights))
        print()
    print(page(cases))
    if args.update:
        args.update.write_text(page(cases) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
