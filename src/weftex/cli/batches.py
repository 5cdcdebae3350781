"""Many outputs from many samples: what there is to make, and making one of them."""

from __future__ import annotations

import argparse
import heapq
import os
import string
import threading
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex.canvas import as_canvas
from weftex.cli.files import axes_of, read, with_turns, write
from weftex.cli.sets import plan
from weftex.cli.terminal import Outputs
from weftex.errors import FileError, InvalidInputError, WeftexError, shown
from weftex.io.folders import map_files
from weftex.io.formats import READABLE, suffix_of
from weftex.io.manifest import appearing, remove
from weftex.quality.assess import assess

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from weftex.io.manifest import Manifest
    from weftex.material import Material
    from weftex.method import Method, Model
    from weftex.results.synthesis import Synthesis

#: Files of these types are written as they came; others, which lose something, as PNG or EXR.
_KEPT = (".png", ".tif", ".tiff", ".exr", ".webp", ".bmp")
_FIELDS = {"name", "seed"}


@dataclass(frozen=True)
class Entry:
    """A sample of a batch: a picture, or a folder of maps.

    Attributes
    ----------
    path, name : str
        Where it is, and what outputs are called after.
    suffix : str
        Of its outputs; empty for a folder of maps.
    """

    path: str
    name: str
    suffix: str


@dataclass(frozen=True)
class Job:
    """Outputs of one sample, by their seeds; the best of them if fewer are kept.

    Attributes
    ----------
    entry : Entry
    outputs : dict of int to str
        Names of files, or folders, by seed.
    keep : int or None
        So many with the best scores are written; all if None.
    """

    entry: Entry
    outputs: dict[int, str]
    keep: int | None = None


def entries_of(folder: str) -> list[Entry]:
    """Return the pictures of a folder, and the folders in it that have pictures.

    Raises
    ------
    FileError
        If the folder cannot be read, or has neither.
    InvalidInputError
        If two have one name.
    """
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise FileError(f"{folder}: cannot read the folder: {error.strerror}") from None
    found: dict[str, Entry] = {}
    for file in names:
        path, stem = os.path.join(folder, file), os.path.splitext(file)[0]
        if file.startswith("."):
            continue
        if os.path.isdir(path):
            try:
                map_files(path)
            except FileError:
                continue
            entry = Entry(path, file, "")
        elif suffix_of(file) in READABLE:
            suffix = suffix_of(file)
            float_only = suffix == ".hdr"
            entry = Entry(
                path, stem, suffix if suffix in _KEPT else ".exr" if float_only else ".png"
            )
        else:
            continue
        if entry.name in found:
            raise InvalidInputError(
                f"{found[entry.name].path} and {path} would both make {entry.name}; rename one"
            )
        found[entry.name] = entry
    if not found:
        raise FileError(f"{folder}: has no pictures, and no folders of maps")
    return list(found.values())


def jobs_of(
    entries: Sequence[Entry], template: str, seeds: Sequence[int], keep: int | None
) -> list[Job]:
    """Return what there is to make: a job a seed, or a job a sample where the best are kept.

    Raises
    ------
    InvalidInputError
        If the template is none, or gives one name to two outputs.
    """
    try:
        fields = {name for _, name, _, _ in string.Formatter().parse(template) if name is not None}
        if not fields <= _FIELDS:
            raise ValueError
        template.format(name="", seed=0)
    except (ValueError, LookupError, AttributeError):
        raise InvalidInputError(
            f"the template is {shown(template)}; it may have {{name}} and {{seed}}, such as "
            "{name}_{seed}"
        ) from None
    taken: set[str] = set()
    jobs = []
    for entry in entries:
        outputs = {seed: template.format(name=entry.name, seed=seed) for seed in seeds}
        for seed, stem in outputs.items():
            if os.path.basename(stem) != stem or stem in ("", ".", ".."):
                raise InvalidInputError(f"the template makes '{stem}', which is no name of a file")
            if stem.casefold() in taken:
                raise InvalidInputError(
                    f"two outputs would be named '{stem}'; use {{name}} and {{seed}} in --template"
                )
            taken.add(stem.casefold())
            outputs[seed] = stem + entry.suffix
        if keep is None:
            jobs += [Job(entry, {seed: output}) for seed, output in outputs.items()]
        else:
            jobs.append(Job(entry, outputs, keep))
    return jobs


class Maker:
    """Makes the outputs of jobs, a sample read and fitted once for the jobs that follow each other.

    Parameters
    ----------
    folder : str
        Where outputs go.
    manifest : Manifest
    method : Method
    size : (int, int), optional
        Twice the sample's by default.
    args : argparse.Namespace
        Options of the command: `tileable`, `turn`, `names`, `mtlx`, `score`, `allow_huge`.
    """

    def __init__(
        self,
        folder: str,
        manifest: Manifest,
        method: Method,
        size: tuple[int, int] | None,
        args: argparse.Namespace,
    ) -> None:
        self.folder, self.manifest, self.method = folder, manifest, method
        self.size, self.args = size, args
        self._lock = threading.Lock()
        self._last: tuple[str, Material, Model] | None = None

    def do(self, job: Job, cancelled: Callable[[], bool]) -> str | None:
        """Make the outputs of a job; what went wrong, in one line, if anything did."""
        try:
            self._do(job, cancelled)
        except WeftexError as error:
            return f"{job.entry.path}: {error}"
        return None

    def _do(self, job: Job, cancelled: Callable[[], bool]) -> None:
        material, model = self._fitted(job.entry.path)
        height, width = material.pictures[material.main].pixels.shape[:2]
        canvas = as_canvas(self.size or (2 * height, 2 * width), axes_of(self.args))
        best: list[tuple[float, int, Synthesis, dict[str, Any]]] = []
        for seed, output in job.outputs.items():
            if cancelled():
                return
            start = perf_counter()
            result = model.sample(canvas, seed=seed, threads=1)
            record = self._record(job, output, seed, result)
            if job.keep is not None or self.args.score:
                record["score"] = assess(model.exemplar, result).score
            record["seconds"] = round(perf_counter() - start, 3)
            if job.keep is None:
                self._write(result, material, output, record)
                continue
            score = record["score"]
            # The heap's first is the worst that is kept; of equal ones the later seed.
            item = (-(float("inf") if score is None else score), -seed, result, record)
            (heapq.heappush if len(best) < job.keep else heapq.heappushpop)(best, item)
        for _, seed, result, record in sorted(best, key=lambda one: -one[1]):
            self._write(result, material, job.outputs[-seed], record)
        kept = {-seed for _, seed, _, _ in best}
        for seed, output in job.outputs.items():
            if job.keep is not None and seed not in kept and output in self.manifest:
                remove(os.path.join(self.folder, output))

    def _fitted(self, path: str) -> tuple[Material, Model]:
        """A sample and its model: the same one for all outputs of a sample."""
        with self._lock:
            if self._last is None or self._last[0] != path:
                material = read(path, self.args)
                exemplar = with_turns(material.exemplar(), self.args)
                self._last = path, material, self.method.fit(exemplar)
            return self._last[1:]

    def _record(self, job: Job, output: str, seed: int, result: Synthesis) -> dict[str, Any]:
        used = dict(result.provenance)
        about = {name: used.pop(name) for name in ("reason", "warnings") if name in used}
        used.pop("seed", None)
        return {
            "output": output,
            "sample": job.entry.path,
            "seed": seed,
            "size": [result.shape[1], result.shape[0]],
            "method": used.pop("method"),
            "parameters": used,
        } | about

    def _write(
        self, result: Synthesis, material: Material, output: str, record: dict[str, Any]
    ) -> None:
        """Write under another name, then the record, and then the output appears."""
        target = os.path.join(self.folder, output)
        with appearing(target, lambda: self.manifest.add(record)) as path, Outputs() as outputs:
            options = argparse.Namespace(**vars(self.args) | {"output": path, "save_source": None})
            if material.folder:
                outputs.make_folder(path)
            write(result, plan(material, options), options, outputs)
