"""The pictures that a command reads and writes, and the lines that it prints about them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError
from weftex.exemplar.material import Material, read_material
from weftex.recipe.command_line import described_material, path_of
from weftex.recipe.opening import (
    OpenedRecipe,
    PreparedMaterial,
    open_recipe,
    pictures_like,
    prepare_material,
)

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from weftex.cli.terminal import Outputs
    from weftex.exemplar import Exemplar
    from weftex.io.pictures import Picture
    from weftex.recipe import Recipe
    from weftex.results.synthesis import Synthesis

    OpenMaterial = Callable[[dict[str, Any]], PreparedMaterial]
    OpenPicture = Callable[[str], Picture]


def read_input(path: str, args: argparse.Namespace, maps: dict[str, str] | None = None) -> Material:
    """Read a picture, or a folder of maps."""
    from weftex.io.pictures import MAX_PIXELS

    _refuse_plane(path)
    return read_material(path, maps, max_pixels=None if args.allow_huge else MAX_PIXELS)


def _refuse_plane(path: str) -> None:
    """Raise `InvalidInputError` where a picture is read whole, and a plane is given."""
    if path.endswith(".zarr") or os.path.lexists(f"{path}.run"):
        from weftex.planes.files import ALWAYS
        from weftex.planes.record import Record

        if Record(path).begun() or path.endswith(ALWAYS):
            raise InvalidInputError(
                f"{path} is written block by block, and may be larger than memory: only "
                "check works on it. Use a window of it: weftex synth --window"
            )


def _readers(args: argparse.Namespace) -> tuple[OpenMaterial, OpenPicture]:
    """Return what opens materials and images of a recipe, which are files, within the limits."""
    from weftex.io.pictures import MAX_PIXELS, read_image

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
) -> tuple[OpenedRecipe, Plan]:
    """Open materials, and say where each picture goes; all is checked before any work."""
    from weftex.io.pictures import check_output

    if args.save_source is not None:
        check_output(args.save_source, suffixes=(".npz",))
    paths = [path_of(spec, {}) for spec in recipe.materials]
    make_room(paths[:1] if recipe.task == "fill" else paths, args, outputs)
    job = open_materials(recipe, args)
    notes = [f"map: {note}" for note in job.notes] if recipe.task == "synth" else []
    made = plan(job.materials, job.like, args, notes)
    job.check()
    return job, made


def make_room(paths: list[str], args: argparse.Namespace, outputs: Outputs) -> None:
    """Make the folder of a set, if one of the paths is a folder; or check the file to write."""
    from weftex.io.pictures import check_output, is_folder

    if any(map(is_folder, paths)):
        outputs.make_folder(args.output)
    else:
        check_output(args.output)


@dataclass(frozen=True)
class Plan:
    """What will be written."""

    pictures: dict[str, Picture]  # by maps, what files are like; the main one first
    targets: dict[str, str]  # paths by maps
    documents: dict[str, str]  # texts by paths
    told: str  # what was taken for what, a line each

    @property
    def main(self) -> str:
        """The name of the main picture."""
        return next(iter(self.pictures))

    def write(
        self, pixels: Callable[[str], NDArray[Any]], outputs: Outputs, threads: int | None = None
    ) -> None:
        """Write pixels, asked for by the names of maps, as these were stored."""
        from weftex.io.pictures import write_image, write_text
        from weftex.threads import in_turn, thread_count

        pictures, at_once = self.pictures, thread_count(threads)
        temporary = {name: outputs.add(self.targets[name]) for name in pictures}

        def write_one(number: int) -> None:
            name, like = [*pictures.items()][number]
            how: dict[str, Any] = {"alpha": like.alpha, "icc": like.icc, "half": like.half}
            how["threads"] = max(1, at_once // len(pictures))
            write_image(temporary[name], pixels(name), **how)

        for _ in in_turn(write_one, range(len(pictures)), min(at_once, len(pictures))):
            pass  # the first that fails ends it
        for path, text in self.documents.items():
            write_text(outputs.add(path), text)


def plan(
    materials: Sequence[Material],
    made: Exemplar,
    args: argparse.Namespace,
    notes: Sequence[str] = (),
) -> Plan:
    """Return where everything goes, checked before any work; `notes` are further lines to print.

    `made` is a sample with the maps to write; each is stored as the first material that has it.
    """
    from weftex.io.pictures import check_output

    first, documents = materials[0], {}
    pictures = pictures_like(materials, made)
    roles = {first.main: first.roles[first.main], **made.roles}
    folder = any(one.folder for one in materials)
    material = Material(first.name, pictures, roles, folder=folder)
    lines = [
        line.replace("map: ", f"map of {one.name}: ") if len(materials) > 1 else line
        for one in materials
        for line in one.told()
    ]
    if not folder:
        for option, value in (("--names", args.names), ("--mtlx", args.mtlx)):
            if value:
                raise InvalidInputError(f"{option} has no effect: {first.name} is no folder")
        targets = {first.main: args.output}
    else:
        files = _files(material, args)
        targets = {name: os.path.join(args.output, file) for name, file in files.items()}
        if args.names is not None:
            lines += [f"map: {material.roles[name]} goes to {files[name]}" for name in files]
        if args.mtlx:
            path, text, left = _document(material, files, args)
            documents[path] = text
            lines += [f"map: {name} has no place in {os.path.basename(path)}" for name in left]
    for name, picture in pictures.items():
        check_output(targets[name], picture.pixels, alpha=picture.alpha)
    told = "".join(f"{line}\n" for line in (*lines, *notes))
    return Plan(pictures, targets, documents, told)


def _files(material: Material, args: argparse.Namespace) -> dict[str, str]:
    """The names of the files, each of them once."""
    from weftex.io.formats import written_as

    files = {}
    for name, one in material.pictures.items():
        stem = os.path.splitext(os.path.basename(one.path))[0]
        files[name] = stem + written_as(one.path, one.pixels.dtype.kind == "f")
    if args.names is not None:
        from weftex.io.map_files import file_stem

        own = _own_name(args)
        files = {
            name: file_stem(args.names, own, material.roles[name]) + os.path.splitext(file)[1]
            for name, file in files.items()
        }
    for file in files.values():
        twins = [other for other in files if files[other] == file]
        if len(twins) > 1:
            raise InvalidInputError(
                f"{' and '.join(twins)} would both be written to {file}; rename one of them"
            )
    return files


def _document(
    material: Material, files: dict[str, str], args: argparse.Namespace
) -> tuple[str, str, list[str]]:
    from weftex.io.materialx import materialx_document
    from weftex.io.pictures import check_output

    path = os.path.join(args.output, f"{_own_name(args)}.mtlx")
    check_output(path, suffixes=(".mtlx",))
    linear = [k for k, one in material.pictures.items() if one.pixels.dtype.kind == "f"]
    return path, *materialx_document(_own_name(args), files, material.roles, linear)


def _own_name(args: argparse.Namespace) -> str:
    """What the set that is written is called: as its folder."""
    return os.path.basename(os.path.abspath(str(args.output)))


def write(result: Synthesis, planned: Plan, args: argparse.Namespace, outputs: Outputs) -> None:
    """Write the result and, from the same coordinates, each other map of the sample."""
    planned.write(pixels_of(result, planned.main), outputs, args.threads)
    if args.save_source is not None:
        result.save(outputs.add(args.save_source))


def pixels_of(result: Synthesis, main: str) -> Callable[[str], NDArray[Any]]:
    """Return what renders a result by the names of the sample's maps."""
    return lambda name: result.image if name == main else result.render(result.sample.map(name))


def write_debug(result: Synthesis, folder: str, outputs: Outputs) -> None:
    """Write how a result was put together."""
    from weftex.io.pictures import write_image

    for what in ("sources", "patches", "seams"):
        name = "coordinates" if what == "sources" else what
        write_image(outputs.add(os.path.join(folder, f"{name}.png")), result.draw(what))


def report(args: argparse.Namespace, result: Synthesis, what: str, took: float, told: str) -> str:
    """Print what was made, how and how fast, after the maps and the reasons if weftex chose."""
    used = result.provenance
    if args.verbose:
        told += f"sample: {result.sample!r}\n"
        told += "".join(f"used: {name} {value}\n" for name, value in used.items())
    why = told + (f"auto: {used['reason']}\n" if "reason" in used else "")
    why += "".join(f"note: {warning}\n" for warning in used.get("warnings", ()))
    why += f"best of: {used['best_of']['told']}\n" if "best_of" in used else ""
    hole = result.canvas.hole
    area = result.shape[0] * result.shape[1] if hole is None else int(hole.sum())
    return why + (
        f"{what} {args.output} with {used['method']}{_looked_at(result)}, seed {used['seed']}, "
        f"in {took:.2f} s ({area / took / 1e6:.3g} megapixels/s)"
    )


def _looked_at(result: Synthesis) -> str:
    """The size of a window, a patch or a tile, where the method has one."""
    used, arrays = result.provenance, result.arrays()
    if "window_width" in used:
        return f", window width {used['window_width'] or 'by sample'}"
    if "lattice" in used:
        strain = f", strained by {100 * used['strain']:.2g} %" if used.get("strain") else ""
        return ", lattice " + ",".join(f"{part:g}" for part in used["lattice"]) + strain
    size = used.get("patch_size") or ("weights" in arrays and max(arrays["weights"].shape[1:]))
    return f", patch size {size}" if size else ""
