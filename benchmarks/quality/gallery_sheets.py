"""The gallery of the documentation, docs/gallery.md and its sheets, from what gallery.py keeps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import ceil
from pathlib import Path

import numpy as np
from gallery_page import DATA, flat
from PIL import Image

import weftex
from weftex.registry import AUTO

ROOT = DATA.parents[1]
#: Headings, and the classes of surfaces below each.
KINDS = {
    "Patterns that repeat": ("near-regular", "regular"),
    "Stones, leaves, bark and wood": ("irregular",),
    "Fine grain": ("stochastic",),
}
_ROW = 3  # surfaces of a sheet
_SHRINK = 2
_GAP = 6
_QUALITY = 60

PAGE = """\
# Gallery

24 materials: each 256x256 sample on the left, and the 512x512 result of its command on the right.

All results have seed 1: we did not look for a better one. weftex chose every method. All samples
are CC0 ([authors and sources](../benchmarks/data/surfaces/MANIFEST.csv)). Run the commands in the
source folder, or replace the file by your own photo. [What still fails](failures.md).

*Images are shown at half size; blue is transparent. The page is written by
`python benchmarks/quality/gallery.py --methods auto --sheets docs`.*
"""


def rows(surfaces: Mapping[str, Mapping[str, str]]) -> Iterator[tuple[str, list[str]]]:
    """Yield each heading, or nothing, and the surfaces of the sheet below it."""
    for title, classes in KINDS.items():
        names = [name for name, about in surfaces.items() if about["class"] in classes]
        for part in np.array_split(names, ceil(len(names) / _ROW)) if names else ():
            yield title, part.tolist()
            title = ""


def command(about: Mapping[str, str], size: int, seed: int) -> str:
    """Return the command that makes a result of the gallery."""
    file = (DATA / "surfaces" / about["file"]).resolve().relative_to(ROOT)
    own = file.parent == Path("src/weftex/samples")
    sample = f"sample:{file.stem}" if own else file.as_posix()
    return f"weftex synth {sample} -o {about['surface']}.png --size {size} --seed {seed}"


def sheet(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> Image.Image:
    """Return samples and results side by side, at half size."""
    pictures = [Image.fromarray(pixels) for pair in pairs for pixels in pair]
    pictures = [picture.reduce(_SHRINK) for picture in pictures]
    width = sum(picture.width + _GAP for picture in pictures) - _GAP
    whole = Image.new("RGB", (width, max(picture.height for picture in pictures)), "white")
    left = 0
    for picture in pictures:
        whole.paste(picture, (left, 0))
        left += picture.width + _GAP
    return whole


def write(
    docs: Path, surfaces: Mapping[str, Mapping[str, str]], keep: Path, size: int, seed: int
) -> None:
    """Write the page and its sheets into the folder of the documentation."""
    parts = [PAGE]
    (docs / "img").mkdir(parents=True, exist_ok=True)
    for number, (title, names) in enumerate(rows(surfaces), 1):
        pairs = []
        for name in names:
            sample = weftex.load_exemplar((DATA / "surfaces" / surfaces[name]["file"]).resolve())
            made = weftex.read_image(keep / AUTO / f"{name}.png").pixels
            pairs.append((flat(sample, sample.pixels), flat(sample, made)))
        file = f"img/gallery_{number}.webp"
        sheet(pairs).save(docs / file, quality=_QUALITY, method=6)
        subjects = ", ".join(surfaces[name]["subject"].split(" (")[0] for name in names)
        lines = "".join(f"{command(surfaces[name], size, seed)}\n" for name in names)
        head = f"## {title}\n\n" if title else ""
        parts.append(
            f"{head}![{subjects}]({file})\n\n*{subjects.capitalize()}.*\n\n```sh\n{lines}```\n"
        )
    (docs / "gallery.md").write_text("\n".join(parts), encoding="utf-8")
