"""The first picture of every page of docs: the input and output of the page's first commands.

    python benchmarks/pages/pictures.py                # pages whose first picture is img/PAGE.webp
    python benchmarks/pages/pictures.py quilting fuse  # some of them

The weftex commands of a page's first block of shell are run in an empty folder. Their samples,
masks and guides, their outputs and, of --debug, the false colors of places are laid side by side,
each once; of a page written in HTML the pictures in it are. Needs weftex[test].
"""

from __future__ import annotations

import argparse
import base64
import io
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

import weftex
from weftex.planes import open_plane

DOCS = Path(__file__).resolve().parents[2] / "docs"
_ACROSS = 1100  # pixels of a row, in which the next picture finds no place
_SHOWN = 760  # pixels of a page's column
_GAP = 6
_QUALITY = 70
_VIEW = (256, 272)  # pixels of a zoom


def commands(page: str) -> list[list[str]]:
    """Words of the weftex commands of the first block of shell."""
    block = re.search(r"^```sh\n(.*?)^```", page, re.M | re.S)
    lines = block[1].splitlines() if block else []
    split = (shlex.split(line, comments=True) for line in lines)
    return [words[1:] for words in split if words[:1] == ["weftex"]]


def files_of(words: list[str], folder: Path) -> Iterator[str]:
    """What a command takes and makes, in order."""
    yield from (word for word in words if word.startswith("sample:"))
    for option in ("-o", "--overlay"):
        if option in words:
            yield str(folder / words[words.index(option) + 1])
    if "--debug" in words:
        yield str(folder / words[words.index("--debug") + 1] / "coordinates.png")


def pictures_of(file: str) -> Iterator[Image.Image]:
    """The picture in a file; every picture of a page, and of a folder."""
    if Path(file).is_dir():
        for inner in sorted(path for path in Path(file).rglob("*") if path.is_file()):
            yield from pictures_of(str(inner))
    elif file.endswith(".html"):
        for data in re.findall(
            r'src="data:image/png;base64,([^"]+)"', Path(file).read_text("utf-8")
        ):
            yield Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")
    elif file.endswith(".tif"):
        yield from zooms(file)
    elif file.endswith((".png", ".jpg", ".webp")):
        picture = Image.open(file)
        if picture.mode.startswith("I"):  # 16 bits, which Pillow would clip
            picture = Image.fromarray((np.asarray(picture) // 257).astype(np.uint8))
        yield picture.convert("RGB")
    elif file.startswith("sample:"):
        yield Image.fromarray(weftex.load_exemplar(file).pixels.squeeze()).convert("RGB")


def zooms(file: str) -> Iterator[Image.Image]:
    """The middle of a plane, from near, from further away and from far."""
    plane = open_plane(file)
    (store,) = plane.stores.values()
    for level in (0, 2, 3):
        height, width = store.layout.shape(level)
        size = (min(height, _VIEW[0]), min(width, _VIEW[1]))
        corner = ((height - size[0]) // 2, (width - size[1]) // 2)
        yield Image.fromarray(store.read(level, (*corner, *size))).convert("RGB")


def side_by_side(pictures: list[Image.Image]) -> Image.Image:
    """Rows of pictures on white, as wide as a page."""
    places, x, y, high = [], 0, 0, 0
    for picture in pictures:
        if x and x + picture.width > _ACROSS:
            x, y, high = 0, y + high + _GAP, 0
        places.append((x, y))
        x, high = x + picture.width + _GAP, max(high, picture.height)
    wide = max(x + p.width for (x, _), p in zip(places, pictures, strict=True))
    whole = Image.new("RGB", (wide, y + high), "white")
    for place, picture in zip(places, pictures, strict=True):
        whole.paste(picture, place)
    whole.thumbnail((_SHOWN, whole.height), Image.Resampling.LANCZOS)
    return whole


def shows_own(page: Path) -> bool:
    """Whether a page's first picture is the one that is named after it."""
    first = re.search(r"!\[[^]]*\]\((\S+)\)", page.read_text("utf-8"))
    return bool(first) and first[1].endswith(f"/img/{page.stem}.webp")


def draw(source: Path) -> Path | None:
    """Run a page's first commands and write its picture, if they show any."""
    shown: dict[bytes, Image.Image] = {}
    with tempfile.TemporaryDirectory() as folder:
        page = source.read_text("utf-8")
        for made in re.findall(r"^mkdir (\w+)$", page, re.M):
            (Path(folder) / made).mkdir()
        for words in commands(page):
            subprocess.run([sys.executable, "-m", "weftex", *words], cwd=folder, check=True)
            for file in files_of(words, Path(folder)):
                shown |= {picture.tobytes(): picture for picture in pictures_of(file)}
    if not shown:
        return None
    path = DOCS / "img" / f"{source.stem}.webp"
    side_by_side(list(shown.values())).save(path, quality=_QUALITY, method=6)
    return path


def main() -> None:
    known = {page.stem: page for page in sorted(DOCS.rglob("*.md")) if shows_own(page)}
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("pages", nargs="*", metavar="PAGE", help=", ".join(known))
    for name in parser.parse_args().pages or known:
        path = draw(known[name])
        told = (
            f"{path}: {path.stat().st_size} bytes" if path else f"{name}: drawn by another script"
        )
        print(told, flush=True)


if __name__ == "__main__":
    main()
