"""The figures of non-parametric sampling, made again with weftex.

python examples/papers/efros_leung.py FIGURE -o FOLDER [--small]

Figures: fig1 fig2 fig3, which are those of the comparison of non-parametric sampling and TSVQ
(section III.A), and surfaces; `all` makes every one. The method is that of A. A. Efros and
T. K. Leung, Texture synthesis by non-parametric sampling, ICCV 1999.
Needs Pillow beside weftex: pip install '.[test]'.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from _common import load, pieces, run, sheet, shrunk, sized, some

import weftex


def rings(side: int, seed: int) -> np.ndarray:
    """Dark rings on gray, a few pixels out of their grid."""
    rng = np.random.default_rng(seed)
    y, x = np.indices((side, side))
    picture = np.full((side, side), 200.0)
    for top in range(8, side + 8, 18):
        for left in range(8 + (top // 18 % 2) * 9, side + 8, 18):
            away = np.hypot(y - top - rng.uniform(-2, 2), x - left - rng.uniform(-2, 2))
            picture -= 150 * np.clip(2 - np.abs(away - 6), 0, 1)
    return np.clip(picture, 0, 255).astype(np.uint8)


def grow(pixels: np.ndarray, size: int, width: int, seed: int = 1) -> weftex.Synthesis:
    return weftex.synthesize(
        pixels, sized(size), method="efros-leung", window_width=width, seed=seed
    )


def fig1(folder: Path, suffix: str) -> None:
    """The width of the window is how random the picture may be."""
    rows = []
    cases = (
        (rings(72, 1), (5, 11, 17, 25)),
        (shrunk(load("bricks"), 4), (5, 9, 15, 23)),
    )
    for pixels, widths in some(cases):
        row = [("sample", pixels)]
        row += [(f"width {width}", grow(pixels, 140, width).image) for width in widths]
        rows.append(row)
    sheet(folder / f"fig1_efros_leung{suffix}", rows)


def fig2(folder: Path, suffix: str) -> None:
    """Constrained synthesis: holes are filled from their border inward."""
    y, x = np.indices((160, 160))
    disc = np.hypot(y - 80, x - 80) < 32
    band = np.abs(y - 80 - 20 * np.sin(x / 22)) < 9
    rows = []
    cases = (("pebbles", disc, 11), ("weave", band, 15), ("grass", disc, 11))
    for name, hole, width in some(cases):
        photo = load(name, 160)
        empty = np.where(hole.reshape(160, 160, *(1,) * (photo.ndim - 2)), 0, photo)
        empty = empty.astype(np.uint8)
        filled = weftex.fill(empty, hole, method="efros-leung", window_width=width, seed=2).image
        assert (filled[~hole] == photo[~hole]).all()
        rows.append([("texture", photo), ("hole", empty), (f"filled, width {width}", filled)])
    sheet(folder / f"fig2_efros_leung{suffix}", rows)


def fig3(folder: Path, suffix: str) -> None:
    """Failures: growing garbage, and verbatim copying."""
    rows = []
    cases = (
        ("growing garbage", "pebbles", 96, 23, 1),
        ("verbatim copying", "leaves", 160, 25, 3),
    )
    for title, name, side, width, seed in some(cases):
        pixels = load(name, side)
        result = grow(pixels, 200, width, seed)
        size = pieces(result)
        copied = [float(np.mean(size >= least)) for least in (100, 1000)]
        print(
            f"{title}: {copied[0]:.0%} of the pixels are in pieces of 100 pixels or more that were "
            f"copied as a whole, {copied[1]:.0%} in pieces of 1000; the largest has {size.max()}"
        )
        rows.append(
            [
                ("sample", pixels),
                (f"{title}, width {width}", result.image),
                ("where from", result.draw("sources")),
            ]
        )
    sheet(folder / f"fig3_efros_leung{suffix}", rows)


def surfaces(folder: Path, suffix: str) -> None:
    """Real materials at three widths."""
    rows = []
    for name in some(("pebbles", "grass", "weave")):
        pixels = load(name, 128)
        row = [("sample", pixels)]
        row += [(f"width {width}", grow(pixels, 180, width).image) for width in (9, 15, 23)]
        rows.append(row)
    sheet(folder / f"surfaces_efros_leung{suffix}", rows)


FIGURES = (fig1, fig2, fig3, surfaces)

if __name__ == "__main__":
    run(__doc__, FIGURES)
