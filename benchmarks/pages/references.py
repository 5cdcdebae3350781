"""The pictures of docs/background/reference-algorithms.md: samples and results.

    python benchmarks/pages/references.py              # all of them, in about ten minutes
    python benchmarks/pages/references.py lattice      # some of them

Needs weftex[test].
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from PIL import Image

import weftex
from weftex import reference

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / "docs" / "img"
_ENLARGED, _GAP, _QUALITY = 2, 6, 60

Pictures = Sequence[np.ndarray]


def small(name: str, factor: int, side: int) -> np.ndarray:
    """A sample that ships with weftex or lies in examples/samples, reduced and cropped."""
    own = ROOT / "examples" / "samples" / f"{name}.png"
    pixels = weftex.load_exemplar(own if own.exists() else f"sample:{name}").pixels
    height, width = (n // factor * factor for n in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // factor, factor, width // factor, factor, -1)
    return np.rint(blocks.mean(axis=(1, 3))).astype(np.uint8)[:side, :side]


def with_lattice(sample: np.ndarray) -> np.ndarray:
    """The sample with its translation vectors drawn from its middle."""
    drawn, middle = sample.copy(), np.array(sample.shape[:2]) // 2
    for x, y in reference.lattice(sample).vectors:
        for part in np.linspace(0, 1, 65):
            v, u = np.rint(middle + part * np.array([y, x])).astype(int)
            drawn[v % len(drawn), u % drawn.shape[1]] = 255, 0, 0
    return drawn


def of(name: str, factor: int, side: int, make: Callable[[np.ndarray], reference.Made]) -> Pictures:
    """A sample and what is made of it."""
    sample = small(name, factor, side)
    return sample, make(sample).image


def near_regular() -> Pictures:
    """Blocks of a sample by the vectors that are found in it."""
    return of("mosaic", 2, 100, lambda s: reference.near_regular(
        s, (112, 144), reference.lattice(s[:64, :64]).vectors, 24, 10, seed=1))  # fmt: skip


def best_tile() -> Pictures:
    """The best tile of a sample by the vectors that are found in it."""
    return of("mosaic", 2, 100, lambda s: reference.best_tile(
        s, (112, 144), reference.lattice(s[:64, :64]).vectors, 6))  # fmt: skip


def lattice() -> Pictures:
    """A sample, its vectors, and its autocorrelation."""
    sample = small("mosaic", 2, 64)
    gamma = np.clip(reference.lattice(sample).correlation, 0, 1)
    return sample, with_lattice(sample), np.rint(255 * gamma[..., None]).astype(np.uint8)


def fusion() -> Pictures:
    """Two samples, and both of them where a disc says."""
    samples = small("pebbles", 4, 48), small("leaves", 2, 48)
    y, x = np.indices((72, 96))
    labels = (np.hypot(y - 36, x - 48) > 26).astype(int)
    return *samples, reference.fusion(samples, labels, [4, 5], seed=1).image


PICTURES: dict[str, Callable[[], Pictures]] = {
    "efros_leung": lambda: of("pebbles", 2, 56, lambda s: reference.efros_leung(s, (64, 88), 11)),
    "wei_levoy": lambda: of(
        "pebbles", 2, 64, lambda s: reference.wei_levoy(s, (72, 96), 9, levels=3, parent_window=5)
    ),
    "ashikhmin": lambda: of("leaves", 2, 80, lambda s: reference.ashikhmin(s, (112, 144))),
    "exact_matching": lambda: of(
        "bricks", 4, 60, lambda s: reference.exact_matching(s, (72, 96), 11, 0.02, True, seed=1)
    ),
    "patch_based_sampling": lambda: of(
        "pebbles", 2, 100, lambda s: reference.patch_based_sampling(s, (112, 144), 24, 4, seed=1)
    ),
    "image_quilting": lambda: of(
        "pebbles", 2, 100, lambda s: reference.image_quilting(s, (112, 144), 24, 6, seed=1)
    ),
    "graphcut": lambda: of(
        "pebbles", 2, 100, lambda s: reference.graphcut(s, (112, 144), 44, 14, seed=1)
    ),
    "iterative_refinement": lambda: of(
        "pebbles", 3, 40, lambda s: reference.iterative_refinement(s, (40, 56), 4, iterations=2)
    ),
    "fusion": fusion,
    "lattice": lattice,
    "best_tile": best_tile,
    "near_regular": near_regular,
    "heeger_bergen": lambda: of(
        "grass", 2, 100, lambda s: reference.heeger_bergen(s, (112, 144), iterations=8)
    ),
}


def beside(pictures: Pictures) -> Image.Image:
    """Pictures side by side, enlarged."""
    drawn = [Image.fromarray(p.squeeze()).convert("RGB") for p in pictures]
    width = sum(p.width for p in drawn) * _ENLARGED + _GAP * (len(drawn) - 1)
    sheet = Image.new("RGB", (width, max(p.height for p in drawn) * _ENLARGED), "white")
    left = 0
    for picture in drawn:
        size = picture.width * _ENLARGED, picture.height * _ENLARGED
        sheet.paste(picture.resize(size, Image.Resampling.NEAREST), (left, 0))
        left += size[0] + _GAP
    return sheet


def main(arguments: Sequence[str] | None = None) -> None:
    """Draw the pictures that are named, or all."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(PICTURES)}")
    for name in parser.parse_args(arguments).names or PICTURES:
        file = IMAGES / f"reference_{name}.webp"
        beside(PICTURES[name]()).save(file, quality=_QUALITY, method=6)
        print(f"{file}: {file.stat().st_size} bytes", flush=True)


if __name__ == "__main__":
    main()
