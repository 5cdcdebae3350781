"""Every test surface with every method: pictures, measures and the pages of docs/lab/measured.

    python benchmarks/quality/gallery.py --jobs 2             # everything; 15 minutes with one
    python benchmarks/quality/gallery.py --surfaces bark --methods quilting auto --docs FOLDER
    python benchmarks/quality/gallery.py --methods auto --sheets docs    # docs/gallery.md

From each surface of benchmarks/data/surfaces, 256x256, each method makes 512x512 with seed 1 at its
defaults, with one thread; efros-leung, which is slow, 256x256 from the upper left 128x128. Each
also makes a tileable output half as large, of which only the seam at the wrap is measured. The
tables go to --docs (quality.md and quality-figures.md of docs/lab/measured, written whole). A part
of the surfaces or methods needs another folder there.

--keep (build/gallery, which git ignores) gets a page of all pictures, index.html, and the full-size
pictures, sources (.npz) and figures (.json). A run that was interrupted goes on from there, and
later runs make again only outputs that may have changed: pictures after a change of the method's
code, of its imports, of the surface or the size, and figures after a change of the measures.
benchmarks/data/judged.csv has scores of a measure outside weftex; the pages show those of
pictures that are still the same. Needs weftex[test].
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: one job, one core

import argparse
import csv
import dataclasses
import hashlib
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from sources import code_hash

import weftex
from weftex.naming import make_method
from weftex.quality.seams import StepModel, wrap_seam
from weftex.quality.view import view_beside, view_of
from weftex.registry import AUTO, method_class

ROOT = Path(__file__).resolve().parents[2]
SURFACES = ROOT / "benchmarks" / "data" / "surfaces" / "MANIFEST.csv"
PAGES = ROOT / "docs" / "lab" / "measured"
METHODS = (AUTO, *weftex.METHODS)
SEED = 1
SIZE = 512
#: Methods that get a smaller part of the sample, and make as much less: they are slow.
PARTS = {"efros-leung": 2}
#: The slow ones first, so that no core waits for the last one.
_SLOW = ("wei-levoy", "efros-leung", "graphcut", "exact-matching")


@dataclasses.dataclass(frozen=True)
class Job:
    """One surface with one method."""

    surface: str
    file: str
    method: str
    size: int
    keep: str

    @property
    def place(self) -> Path:
        """Where its files lie, without their suffix."""
        return Path(self.keep) / self.method / self.surface

    @property
    def part(self) -> int:
        return PARTS.get(self.method, 1)

    def sample(self) -> weftex.Exemplar:
        whole = weftex.load_exemplar(self.file)
        high, wide = (side // self.part for side in whole.shape)
        pixels = np.ascontiguousarray(whole.pixels[:high, :wide])
        return weftex.Exemplar(pixels, alpha=whole.alpha, name=self.surface)

    def keys(self) -> list[str]:
        """Names of all that its pictures depend on, and its figures."""
        code = code_hash(method_class(self.method).__module__)
        found = hashlib.sha256(Path(self.file).read_bytes())
        found.update(f"{code} {self.method} {self.size} {self.part} {SEED}".encode())
        pictures = found.hexdigest()[:16]
        found.update(code_hash("weftex.quality.assess").encode())
        return [pictures, found.hexdigest()[:16]]

    def kept(self) -> dict[str, Any] | None:
        """The record of an earlier run, if its pictures would come out the same now."""
        if not self.place.with_suffix(".json").exists():
            return None
        found: dict[str, Any] = json.loads(self.place.with_suffix(".json").read_text("utf-8"))
        return found if found["keys"][0] == self.keys()[0] else None

    def done(self) -> dict[str, Any] | None:
        """The same, if its figures would come out the same too."""
        found = self.kept()
        return found if found and found["keys"][1] == self.keys()[1] else None

    def run(self) -> dict[str, Any]:
        """Make it unless it is kept, measure it, and keep it."""
        found = self.kept() or self.make()
        exemplar = self.sample()
        tile = weftex.read_image(self.files()[1]).pixels
        made = weftex.Synthesis.load(self.place.with_suffix(".npz"), exemplar)
        figures = weftex.assess(exemplar, made)
        own = view_of(exemplar)
        wrap = wrap_seam(StepModel(own), view_beside(own, exemplar, tile), (True, True))
        found |= {
            "keys": self.keys(),
            "verdict": figures.verdict(),
            "figures": figures.as_dict() | {"wrap": None if wrap is None else round(wrap, 3)},
        }
        text = json.dumps(found, indent=1)
        self.place.with_suffix(".json").write_text(text, encoding="utf-8")  # last: it is done
        return found

    def files(self) -> tuple[Path, Path]:
        """The picture, and the tileable one."""
        return (
            self.place.with_suffix(".png"),
            self.place.with_name(f"{self.surface}-tile.png"),
        )

    def make(self) -> dict[str, Any]:
        """Make the pictures."""
        exemplar, size = self.sample(), self.size // self.part
        start = process_time()
        model = make_method(self.method, {}).fit(exemplar)
        made = model.sample(size, seed=SEED, threads=1)
        made.image  # rendering is part of the work  # noqa: B018
        seconds = process_time() - start
        self.place.parent.mkdir(parents=True, exist_ok=True)
        made.save(self.place.with_suffix(".npz"))
        for file, pixels in zip(
            self.files(), (made.image, tileable(model, size // 2).image), strict=True
        ):
            weftex.write_image(file, pixels, alpha=exemplar.alpha)
        return {
            "surface": self.surface,
            "method": self.method,
            "seconds": round(seconds, 3),
            "picture": picture_hash(made.image),
            "provenance": made.provenance,
        }


def tileable(model: Any, size: int) -> weftex.Synthesis:
    """A tileable output; a little larger where the lattice of a sample asks for it."""
    for side in range(size, 2 * size, 8):
        try:
            return model.sample(side, seed=SEED, tileable=True, threads=1)
        except weftex.InvalidInputError:
            continue
    return model.sample(2 * size, seed=SEED, tileable=True, threads=1)


def picture_hash(pixels: np.ndarray) -> str:
    """A name for a picture's bytes, the same on every machine."""
    found = hashlib.sha256(f"{pixels.shape} {pixels.dtype.str}".encode())
    found.update(np.ascontiguousarray(pixels).tobytes())
    return found.hexdigest()[:16]


def surfaces() -> dict[str, dict[str, str]]:
    """The rows of the list of surfaces, by name."""
    with open(SURFACES, encoding="utf-8", newline="") as file:
        return {row["surface"]: row for row in csv.DictReader(file)}


def results(todo: Sequence[Job], jobs: int) -> Iterator[dict[str, Any]]:
    """Run them, each as soon as a process is free; with one job in this process."""
    if jobs == 1:
        yield from map(Job.run, todo)
        return
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from multiprocessing import get_context

    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        waiting = [pool.submit(Job.run, job) for job in todo]
        try:
            for future in as_completed(waiting):
                yield future.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def main(words: Sequence[str] | None = None) -> None:
    import gallery_page
    import gallery_sheets

    listed = surfaces()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    some: dict[str, Any] = {"nargs": "+", "metavar": "NAME"}
    parser.add_argument("--surfaces", choices=listed, default=list(listed), **some)
    parser.add_argument("--methods", choices=METHODS, default=list(METHODS), **some)
    parser.add_argument("--size", type=int, default=SIZE, metavar="PIXELS")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes, 1 core each")
    parser.add_argument(
        "--keep", type=Path, default=ROOT / "build" / "gallery", metavar="DIR", help="for pictures"
    )
    parser.add_argument("--docs", type=Path, default=PAGES, metavar="DIR", help="for the tables")
    parser.add_argument(
        "--sheets", type=Path, metavar="DIR", help="write only gallery.md and its sheets there"
    )
    args = parser.parse_args(words)
    names = [name for name in listed if name in args.surfaces]
    methods = [name for name in METHODS if name in args.methods]
    whole = len(names) == len(listed) and len(methods) == len(METHODS) and args.size == SIZE
    if not whole and not args.sheets and args.docs.resolve() == PAGES:
        parser.error("the pages show all surfaces and methods; for a part name another --docs")

    start = perf_counter()
    todo = []
    done: dict[tuple[str, str], dict[str, Any]] = {}
    for name in names:
        file = str((SURFACES.parent / listed[name]["file"]).resolve())
        for method in methods:
            job = Job(name, file, method, args.size, str(args.keep))
            found = job.done()
            if found is None:
                todo.append(job)
            else:
                done[name, method] = found
    todo.sort(key=lambda job: _SLOW.index(job.method) if job.method in _SLOW else len(_SLOW))
    print(f"{len(done)} kept, {len(todo)} to make, {args.jobs} at a time", flush=True)
    for count, found in enumerate(results(todo, args.jobs), 1):
        name, method = found["surface"], found["method"]
        done[name, method] = found
        score, flags = found["figures"]["score"], ", ".join(found["figures"]["flags"])
        seconds = f"{perf_counter() - start:5.0f} s"
        print(f"{seconds} {count}/{len(todo)} {method} {name} {score} {flags}", flush=True)
    shown = {name: listed[name] for name in names}
    if args.sheets:
        gallery_sheets.write(args.sheets, shown, args.keep, args.size, SEED)
        return
    gallery_page.write(args.docs, shown, methods, done, args.keep)
    minutes = (perf_counter() - start) / 60
    print(f"{args.docs / 'quality.md'}, {args.keep / 'index.html'}: {minutes:.1f} minutes")


if __name__ == "__main__":
    main()
