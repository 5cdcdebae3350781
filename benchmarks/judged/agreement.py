"""How well do two judges agree on pairs of pictures of one surface that both put in an order?

python benchmarks/judged/agreement.py
"""

from __future__ import annotations

import argparse
import csv
import itertools
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Pair:
    """Two pictures of a surface, the second worse in the eyes of a judge; ranks and marks apart."""

    surface: str
    judge: str
    better: str
    worse: str
    ranks: int
    marks: int


def pairs() -> list[Pair]:
    """Every pair that a judge put in an order."""
    given: dict[tuple[str, str], dict[str, tuple[int, int]]] = defaultdict(dict)
    with (HERE / "judgements.csv").open(newline="", encoding="utf-8") as file:
        for line in csv.DictReader(file):
            of = given[line["surface"], line["judge"]]
            of[line["picture"]] = int(line["rank"]), int(line["mark"])
    found = []
    for (surface, judge), of in given.items():
        for first, second in itertools.combinations(sorted(of), 2):
            better, worse = sorted((first, second), key=lambda picture: of[picture][0])
            ranks, marks = (int(b) - int(a) for a, b in zip(of[better], of[worse], strict=True))
            if ranks:
                found.append(Pair(surface, judge, better, worse, ranks, -marks))
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


def main() -> None:
    argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0]).parse_args()
    print("two judges, by the lesser difference of their marks")
    for name, agrees, count in judges(pairs()):
        print(f"  {name:4} {agrees:.3f} of {count}")


if __name__ == "__main__":
    main()
