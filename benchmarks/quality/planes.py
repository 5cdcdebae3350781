"""Planes beside pictures: scores across the borders of blocks, and processor time.

Run ``python benchmarks/quality/planes.py scores`` or ``... times``, with --methods and
--surfaces to do a part. Scores are those of `weftex.quality.score`, less is better: windows with a
node of the grid in the middle (across), those with the middle of a block (inside), and windows of
pictures that the plain method makes (plain); one row a surface, the mean of all windows.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import fmean, stdev
from time import process_time
from typing import Any

import numpy as np

import weftex
from weftex.quality.score import Scorer
from weftex.random import draw

SURFACES = Path(__file__).parents[1] / "data" / "surfaces"
METHODS = "patch-sampling,quilting,graphcut,refinement"
_SIDE, _COUNT, _FAR = 256, 4, 2**30
_ONE: dict[str, Any] = {"seed": 1, "threads": 1}


def scores(method: str, surface: Path, count: int = _COUNT) -> tuple[float, float, float]:
    """Mean scores of windows across borders, inside of blocks, and of plain pictures."""
    exemplar = weftex.load_exemplar(surface)
    eye, model = Scorer(exemplar), weftex.METHODS[method]().fit(exemplar)
    pitch = model.block_sizes().pitch

    def window(k: int, shift: int) -> Any:
        node = (_FAR // pitch + 7 * k) * pitch + shift - _SIDE // 2
        return model.window(node, 3 * pitch * k + shift - _SIDE // 2, _SIDE, _SIDE, seed=k).image

    across = [eye.rate(window(k, 0)).score for k in range(count)]
    inside = [eye.rate(window(k, pitch // 2)).score for k in range(count)]
    side = 2 * _SIDE
    plain = []
    for k in range(count):
        image = model.sample(side, seed=k).image
        plain.append(eye.rate(image[_SIDE // 2 : -_SIDE // 2, _SIDE // 2 : -_SIDE // 2]).score)
    return fmean(across), fmean(inside), fmean(plain)  # type: ignore[arg-type]


def table_of_scores(methods: list[str], surfaces: list[Path]) -> None:
    """Write a table a method, and the paired differences."""
    for method in methods:
        print(f"\n| {method} | across | inside | plain |\n|---|---|---|---|")
        rows = []
        for surface in surfaces:
            rows.append(scores(method, surface))
            print(
                f"| {surface.stem} | " + " | ".join(f"{k:.2f}" for k in rows[-1]) + " |", flush=True
            )
        values = np.array(rows)
        print(_row("mean", values.mean(axis=0).tolist()))
        for name, other in (("inside", 1), ("plain", 2)):
            apart = (values[:, 0] - values[:, other]).tolist()
            error = stdev(apart) / len(apart) ** 0.5 if len(apart) > 1 else 0.0
            print(f"\nacross - {name}: {fmean(apart):+.2f} +- {error:.2f}")


def _row(name: str, values: Sequence[float]) -> str:
    return f"| {name} | " + " | ".join(f"{k:.2f}" for k in values) + " |"


def times(methods: list[str], surfaces: list[Path]) -> None:
    """Write processor time: a far window of 256 pixels, and larger ones beside plain pictures."""
    print("| method | surface | far 256, first | 512 | over plain | 1024 | over plain |")
    print("|---|---|---|---|---|---|---|")
    for method in methods:
        for surface in surfaces:
            model = weftex.METHODS[method]().fit(surface)
            cells = [f"{_seconds(lambda m=model: m.window(*_anywhere(0), 256, 256, **_ONE)):.2f} s"]
            for side in (512, 1024):
                model.sample(side, **_ONE)
                both = np.array([_both(model, side, k) for k in range(_COUNT * 1024 // side)])
                window, plain = both.mean(axis=0)
                cells += [f"{window:.3f} s", f"{window / plain:.2f} x"]
            print(f"| {method} | {surface.stem} | {' | '.join(cells)} |", flush=True)


def _both(model: weftex.Model, side: int, k: int) -> tuple[float, float]:
    """Seconds for a window that nobody asked for before, and for a picture: in turn."""
    place = _anywhere(side + k)
    return (
        _seconds(lambda: model.window(*place, side, side, **_ONE)),
        _seconds(lambda: model.sample(side, **_ONE)),
    )


def _anywhere(number: int) -> tuple[int, int]:
    top, left = (np.uint64(2**39) - draw(number, "place", np.arange(2)) % np.uint64(2**38)).tolist()
    return int(top), -int(left)


def _seconds(make: Callable[[], weftex.Synthesis]) -> float:
    start = process_time()
    make().image  # noqa: B018
    return process_time() - start


def main() -> None:
    """Run what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("scores", "times"))
    parser.add_argument("--methods", default=METHODS)
    parser.add_argument("--surfaces", default="")
    args = parser.parse_args()
    found = sorted(SURFACES.glob("*.webp"))
    if args.surfaces:
        found = [path for path in found if path.stem in args.surfaces.split(",")]
    {"scores": table_of_scores, "times": times}[args.what](args.methods.split(","), found)


if __name__ == "__main__":
    main()
