"""The pictures that a command reads and writes, and the lines that it prints about them."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from numpy.typing import NDArray

from weftex.cli.terminal import Outputs
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.exemplar.material import Material, read_material
from weftex.io.formats import FORMATS
from weftex.io.outputs import OutputSet, fitted_file, kept_file
from weftex.io.pictures import MAX_PIXELS, check_output, is_folder, read_image, write_image
from weftex.recipe import Recipe
from weftex.recipe.command_line import described_material, path_of
from weftex.recipe.opening import (
    OpenedRecipe,
    OpenPicture,
    PreparedMaterial,
    open_recipe,
    pictures_like,
    prepare_material,
)
from weftex.results.synthesis import Synthesis
from weftex.roles import role_of

OpenMaterial = Callable[[dict[str, Any]], PreparedMaterial]


def read_input(path: str, args: argparse.Namespace, maps: dict[str, str] | None = None) -> Material:
    """Read a picture, or a folder of maps; refuse a plane, as pictures are read whole."""
    if os.path.lexists(f"{path}.run"):
        from weftex.planes.record import Record

        if Record(path).begun():
            raise InvalidInputError(
                f"{path} was written block by block, and may be larger than memory: "
                "only 'weftex check' reads it; for a part of it, use 'weftex synth --window'"
            )
    return read_material(path, maps, max_pixels=None if args.allow_huge else MAX_PIXELS)


def _readers(args: argparse.Namespace) -> tuple[OpenMaterial, OpenPicture]:
    """Return what opens materials and images of a recipe, which are files, within the limits."""
    read = partial(read_image, max_pixels=None if args.allow_huge else MAX_PIXELS)

    def prepare(spec: dict[str, Any]) -> PreparedMaterial:
        material = read_input(path_of(spec, {}), args, spec.get("maps"))
        return prepare_material(spec, material, read)

    return prepare, read


def open_materials(recipe: Recipe, args: argparse.Namespace) -> OpenedRecipe:
    """Open the materials of a recipe, in files."""
    return open_recipe(recipe, *_readers(args))


def load_sample(path: str, args: argparse.Namespace, *options: str) -> Exemplar:
    """Read a sample, with what some options of `MATERIAL` say about it."""
    open_material, _ = _readers(args)
    return open_material(described_material(path, vars(args), options)).sample


def open_job(
    recipe: Recipe, args: argparse.Namespace, outputs: Outputs
) -> tuple[OpenedRecipe, OutputSet, str]:
    """Open materials, and say where each picture goes; see `plan`."""
    if args.save_source is not None:
        check_output(args.save_source, suffixes=(".npz",))
    paths = [path_of(spec, {}) for spec in recipe.materials]
    prepare_targets(paths[:1] if recipe.task == "fill" else paths, args, outputs)
    job = open_materials(recipe, args)
    notes = [f"map: {note}" for note in job.notes] if recipe.task == "synth" else []
    return job, *plan(job.materials, job.like, args, notes)


def prepare_targets(paths: list[str], args: argparse.Namespace, outputs: Outputs) -> None:
    """Make the folder of a set, if one of the paths is a folder; or check the file to write."""
    if any(map(is_folder, paths)):
        outputs.make_folder(args.output)
    else:
        check_output(args.output)


def plan(
    materials: Sequence[Material],
    template: Exemplar,
    args: argparse.Namespace,
    notes: Sequence[str] = (),
) -> tuple[OutputSet, str]:
    """Return where everything goes, checked before any work, and what was taken for what.

    `template` is a sample with the maps to write; each is stored as the first material that has it,
    or as a preset wants it. `notes` are further lines to print.
    """
    first = materials[0]
    pictures = pictures_like(materials, template)
    lines = [
        line.replace("map: ", f"map of {one.name}: ") if len(materials) > 1 else line
        for one in materials
        for line in one.told()
    ]
    if not any(one.folder for one in materials):
        if args.preset is not None:
            raise InvalidInputError(f"--preset needs a folder of maps; {first.name} is an image")
        folder, name = os.path.split(args.output)
        main = first.main
        file, said = fitted_file(name, main, pictures[main], first.roles[main].name)
        files, lines = OutputSet(folder, pictures, (file,)), lines + [f"note: {s}" for s in said]
    elif args.preset is None:
        stems = {k: os.path.splitext(os.path.basename(p.path))[0] for k, p in pictures.items()}
        kept = (kept_file(stems[k], k, p) for k, p in pictures.items())
        files = OutputSet(args.output, pictures, tuple(kept))
    else:
        from weftex.io.packing import pack_set  # few runs have a preset
        from weftex.io.presets import read_preset

        own = os.path.basename(os.path.abspath(str(args.output)))
        roles = {first.main: first.roles[first.main], **template.roles}
        files = pack_set(read_preset(args.preset), args.output, own, pictures, roles)
        lines += [f"map: {line}" for line in files.told()]
    files.check()
    if (first.folder or args.preset) and os.path.isdir(files.folder):
        apart = sorted({*os.listdir(files.folder)} - {file.name for file in files.files})
        ends = ((name, *os.path.splitext(name)) for name in apart)
        left = [name for name, stem, suffix in ends if suffix in FORMATS and role_of(stem)]
        if left:
            lines.append(f"note: {files.folder} also has {', '.join(left)}, which stay as they are")
    return files, "".join(f"{line}\n" for line in (*lines, *notes))


def pixels_of(result: Synthesis, main: str) -> Callable[[str], NDArray[Any]]:
    """Return what renders a result and, at the same coordinates, the other maps of its sample."""
    return lambda name: result.image if name == main else result.render(result.sample.map(name))


def write_debug(result: Synthesis, folder: str, outputs: Outputs) -> None:
    """Write how a result was put together."""
    for what, name in (("sources", "coordinates"), ("patches", "patches"), ("seams", "seams")):
        write_image(outputs.staged_path(os.path.join(folder, f"{name}.png")), result.draw(what))


def report(args: argparse.Namespace, result: Synthesis, what: str, took: float, told: str) -> str:
    """Return what was made, how and how fast, after the maps and the reasons if weftex chose."""
    used = result.provenance
    if args.verbose:
        told += f"sample: {result.sample!r}\n"
        told += "".join(f"used: {k} {v}\n" for k, v in used.items() if k != "reason")
    why = told + (f"auto: {used['reason']}\n" if "reason" in used else "")
    why += "".join(f"note: {warning}\n" for warning in used.get("warnings", ()))
    why += f"best of: {used['best_of']['told']}\n" if "best_of" in used else ""
    hole = result.canvas.hole
    area = result.shape[0] * result.shape[1] if hole is None else int(hole.sum())
    by = used.get("method", "several methods")
    return why + (
        f"{what} {args.output} with {by}{_looked_at(result)}, seed {used['seed']}, "
        f"in {took:.2f} s ({area / took / 1e6:.3g} megapixels/s)"
    )


def _looked_at(result: Synthesis) -> str:
    """The size of a window, a patch or a tile, where the method has one."""
    used, arrays = result.provenance, result.arrays()
    if "window_width" in used:
        return f", window width {used['window_width'] or 'by sample'}"
    if "lattice" in used:
        strain = f", stretched by {100 * used['strain']:.2g} %" if used.get("strain") else ""
        return ", lattice " + ",".join(f"{part:g}" for part in used["lattice"]) + strain
    size = used.get("patch_size") or ("weights" in arrays and max(arrays["weights"].shape[1:]))
    return f", patch size {size}" if size else ""
