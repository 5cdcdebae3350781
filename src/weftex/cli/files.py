"""The pictures that a command reads and writes, and what it says of them."""

from __future__ import annotations

import os
from time import perf_counter
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import argparse

    from weftex.cli.terminal import Bar, Outputs
    from weftex.exemplar import Exemplar
    from weftex.io.pictures import Picture
    from weftex.results.synthesis import Synthesis


def load(
    path: str, args: argparse.Namespace, *, tileable: bool = False
) -> tuple[Exemplar, dict[str, Picture]]:
    """Read a picture, or a folder of maps, and what each one was stored as.

    `tileable` says that it repeats without a seam.
    """
    from weftex.io.pictures import MAX_PIXELS, is_folder, read_image, read_maps
    from weftex.tasks.synthesize import exemplar_of_maps

    limit = None if args.allow_huge else MAX_PIXELS
    if is_folder(path):
        pictures = read_maps(path, max_pixels=limit)
    else:
        pictures = {os.path.basename(path): read_image(path, max_pixels=limit)}
    return exemplar_of_maps(pictures, tileable=tileable), pictures


def open_sample(
    path: str, args: argparse.Namespace, outputs: Outputs, *, tileable: bool = False
) -> tuple[Exemplar, dict[str, Picture], dict[str, str]]:
    """Read the sample, and say where each of its pictures goes; all is checked before any work."""
    from weftex.io.pictures import check_output, is_folder

    folder = is_folder(path)
    if args.save_source is not None:
        check_output(args.save_source, suffixes=(".npz",))
    if folder:
        outputs.make_folder(args.output)
    else:
        check_output(args.output)
    exemplar, pictures = load(path, args, tileable=tileable)
    targets = {}
    for name, picture in pictures.items():
        file = os.path.basename(picture.path)
        targets[name] = os.path.join(args.output, file) if folder else args.output
        check_output(targets[name], picture.pixels, alpha=picture.alpha)
    return exemplar, pictures, targets


def write(
    result: Synthesis,
    exemplar: Exemplar,
    pictures: dict[str, Picture],
    targets: dict[str, str],
    args: argparse.Namespace,
    outputs: Outputs,
) -> None:
    """Write the result, and each other map of the sample as it follows from it."""
    from weftex.exemplar import Exemplar
    from weftex.io.pictures import write_image

    for name, picture in pictures.items():
        if name == exemplar.name:
            pixels = result.image
        else:
            pixels = result.render(Exemplar(picture.pixels, alpha=picture.alpha, name=name))
        temporary = outputs.add(targets[name])
        write_image(temporary, pixels, alpha=picture.alpha, icc=picture.icc)
    if args.save_source is not None:
        result.save(outputs.add(args.save_source))


#: The pictures of --debug, by what `Synthesis.draw` calls them.
DEBUG = {
    "coordinates": "sources",
    "patches": "patches",
    "seams": "seams",
    "uncertainty": "uncertainty",
}


def write_debug(result: Synthesis, folder: str, outputs: Outputs) -> None:
    """Write how a result was put together."""
    from weftex.io.pictures import write_image

    for name, what in DEBUG.items():
        write_image(outputs.add(os.path.join(folder, f"{name}.png")), result.draw(what))


def report(args: argparse.Namespace, result: Synthesis, what: str, start: float) -> str:
    """Say in a line what was made, how and how fast; if weftex chose, lines above say why."""
    used, took = result.provenance, perf_counter() - start
    why = f"auto: {used['reason']}\n" if "reason" in used else ""
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


def settings(args: argparse.Namespace, bar: Bar) -> dict[str, Any]:
    """What all tasks take; a seed that is drawn here is short enough to be typed again."""
    seed = int.from_bytes(os.urandom(4), "little") if args.seed is None else args.seed
    tileable = True if args.tileable == "xy" else args.tileable or False
    return {"seed": seed, "tileable": tileable, "threads": args.threads, "progress": bar}
