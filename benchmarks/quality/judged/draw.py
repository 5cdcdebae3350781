"""Draw the pictures that were judged: every line of recipes.csv that FOLDER has not yet.

    python benchmarks/quality/judged/draw.py SURFACES FOLDER [--surface NAME] [--program NAME]

SURFACES holds the pictures of surfaces.csv (which says where they are from); FOLDER gets
SURFACE/sample.png, the middle 256x256, and SURFACE/PICTURE.png. Pictures of weftex are the same
bytes on every machine at the commit that README.md names. The others need `gmic` (one thread and
`srand`, else it draws another picture each time) and `gimp` with gimp-texturize.
"""

from __future__ import annotations

import argparse
import csv
import os
import subprocess
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from PIL import Image

import weftex
from weftex.naming import parse_method

HERE = Path(__file__).resolve().parent
SIDE = 256  # pixels of the crop

_GIMP = """
(let* ((image (car (gimp-file-load RUN-NONINTERACTIVE "{sample}" "{sample}")))
       (layer (car (gimp-image-get-active-drawable image))))
  (gimp-plugin-texturize RUN-NONINTERACTIVE image layer {size} {size} 100 0)
  (let* ((new (vector-ref (cadr (gimp-image-list)) 0)))
    (gimp-image-flatten new)
    (gimp-file-save RUN-NONINTERACTIVE new (car (gimp-image-get-active-drawable new))
                    "{made}" "{made}")))
"""


def table(name: str) -> list[dict[str, str]]:
    """The lines of a table of this folder."""
    with (HERE / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def crop(path: Path) -> np.ndarray:
    """The middle of a surface, as RGB bytes."""
    picture = Image.open(path).convert("RGB")
    x, y = (picture.width - SIDE) // 2, (picture.height - SIDE) // 2
    return np.array(picture.crop((x, y, x + SIDE, y + SIDE)))


def draw(recipe: dict[str, str], sample: np.ndarray) -> np.ndarray:
    """The picture of a recipe, (size, size, 3)."""
    size, seed, text = int(recipe["size"]), int(recipe["seed"]), recipe["method"]
    if recipe["program"] != "weftex":
        return foreign(recipe["program"], sample, size, seed)
    if text == "tiled":  # the sample side by side, which no method is asked for
        times = -(-size // SIDE)
        return np.tile(sample, (times, times, 1))[:size, :size]
    method = text if text == "auto" else parse_method(text)
    return weftex.synthesize(sample, size, method=method, seed=seed).image


def foreign(program: str, sample: np.ndarray, size: int, seed: int) -> np.ndarray:
    """What another program makes."""
    with tempfile.TemporaryDirectory() as folder:
        given, made = f"{folder}/sample.png", f"{folder}/made.png"
        Image.fromarray(sample).save(given)
        commands = {
            "gmic": ["gmic", "srand", str(seed), given]
            + ["syntexturize_matchpatch", f"{size},{size}", "-o", made],
            "gimp": ["gimp", "-i", "-b", _GIMP.format(sample=given, made=made, size=size)]
            + ["-b", "(gimp-quit 0)"],
        }
        environment = os.environ | {"OMP_NUM_THREADS": "1"}
        subprocess.run(
            commands[program], check=True, env=environment, capture_output=True, timeout=300
        )
        return np.array(Image.open(made).convert("RGB"))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("surfaces", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--surface", nargs="*", default=[])
    parser.add_argument("--program", nargs="*", default=["weftex", "gmic", "gimp"])
    given = parser.parse_args()
    files = {line["surface"]: given.surfaces / line["file"] for line in table("surfaces.csv")}
    for recipe in table("recipes.csv"):
        name = recipe["surface"]
        path = given.folder / name / f"{recipe['picture']}.png"
        if given.surface and name not in given.surface:
            continue
        if path.exists() or recipe["program"] not in given.program:
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        sample = crop(files[name])
        Image.fromarray(sample).save(path.parent / "sample.png")
        start = perf_counter()
        try:
            made = draw(recipe, sample)
        except (weftex.WeftexError, subprocess.SubprocessError, OSError) as error:
            print(f"{name} {recipe['picture']} {recipe['method']}: {error}", flush=True)
            continue
        Image.fromarray(made).save(path)
        print(f"{name} {recipe['picture']} {perf_counter() - start:.1f} s", flush=True)


if __name__ == "__main__":
    main()
