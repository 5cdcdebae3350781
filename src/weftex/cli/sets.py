"""Where the pictures of a material go, by which names, and the lines that are said about them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError
from weftex.exemplar.material import Material
from weftex.recipe.making import pictures_like

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from weftex.cli.terminal import Outputs
    from weftex.exemplar import Exemplar
    from weftex.io.pictures import Picture


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
    """Say where everything goes; whatever can be wrong with it is found here, before any work.

    `made` is a sample with the maps to write; each is stored as the first material that has it.
    `notes` are further lines to print.
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
