"""The pictures that a command reads and writes, and the lines that it prints about them."""

from __future__ import annotations

import os
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from weftex.cli.terminal import Bar, Outputs
    from weftex.exemplar import Exemplar
    from weftex.io.pictures import Picture
    from weftex.results.synthesis import Synthesis


def load(
    path: str,
    args: argparse.Namespace,
    maps: dict[str, str] | None = None,
    *,
    tileable: bool = False,
) -> tuple[Exemplar, dict[str, Picture]]:
    """Read a picture, or a folder of maps, and what each one was stored as."""
    from weftex.io.pictures import MAX_PIXELS
    from weftex.loading import exemplar_of_maps, read_sample

    limit = None if args.allow_huge else MAX_PIXELS
    pictures = read_sample(path, maps, max_pixels=limit)
    return exemplar_of_maps(pictures, path, maps, tileable=tileable), pictures


def told(pictures: dict[str, Picture], path: str, maps: dict[str, str] | None) -> str:
    """A line for each map of a folder: what it was taken for."""
    from weftex.loading import main_picture, roles

    if len(pictures) == 1:
        return ""
    taken = roles(pictures, path, maps)
    main = main_picture(taken)
    lines = []
    for name, role in taken.items():
        use = ", the picture" if name == main else ""
        lines.append(f"map: {os.path.basename(pictures[name].path)} is {role}{use}\n")
    return "".join(lines)


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
    exemplar, pictures = load(path, args, args.maps, tileable=tileable)
    exemplar, pictures = _mended(exemplar, pictures, args)
    targets = {}
    for name, picture in pictures.items():
        file = os.path.basename(picture.path)
        targets[name] = os.path.join(args.output, file) if folder else args.output
        check_output(targets[name], picture.pixels, alpha=picture.alpha)
    return exemplar, pictures, targets


def _mended(
    exemplar: Exemplar, pictures: dict[str, Picture], args: argparse.Namespace
) -> tuple[Exemplar, dict[str, Picture]]:
    """Straighten the sample and its pictures, and even its light, where that was asked for."""
    if getattr(args, "straighten", None) is not None:
        from weftex.tasks.straighten import straighten

        exemplar = straighten(exemplar, **_ways(args.straighten))
    if getattr(args, "even_light", None) is not None:
        from weftex.tasks.even_light import even_light

        exemplar = even_light(exemplar, args.even_light)
    pixels = exemplar.maps | {exemplar.name: exemplar.pixels}
    return exemplar, {name: replace(one, pixels=pixels[name]) for name, one in pictures.items()}


def _ways(text: str) -> dict[str, str]:
    """What `straighten` is told: vectors, corners, or nothing."""
    names = {4: "lattice", 8: "corners"}
    count = text.count(",") + 1
    if text and count not in names:
        raise InvalidInputError(
            f"--straighten is '{text}'; it must be four numbers, a lattice, or eight, corners"
        )
    return {names[count]: text} if text else {}


def write(
    result: Synthesis,
    exemplar: Exemplar,
    pictures: dict[str, Picture],
    targets: dict[str, str],
    args: argparse.Namespace,
    outputs: Outputs,
) -> None:
    """Write the result and, from the same coordinates, each other map of the sample."""
    from weftex.exemplar import Exemplar

    others = {name: one for name, one in pictures.items() if name != exemplar.name}
    laid = {
        name: result.render(Exemplar(one.pixels, alpha=one.alpha, name=name))
        for name, one in others.items()
    }
    write_pictures(laid | {exemplar.name: result.image}, pictures, targets, outputs)
    if args.save_source is not None:
        result.save(outputs.add(args.save_source))


def write_pictures(
    pixels: Mapping[str, NDArray[Any]],
    pictures: dict[str, Picture],
    targets: dict[str, str],
    outputs: Outputs,
) -> None:
    """Write pixels as the pictures of the same names were stored."""
    from weftex.io.pictures import write_image

    for name, picture in pictures.items():
        temporary = outputs.add(targets[name])
        write_image(temporary, pixels[name], alpha=picture.alpha, icc=picture.icc)


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


def report(
    args: argparse.Namespace,
    result: Synthesis,
    what: str,
    start: float,
    maps: str = "",
) -> str:
    """Print what was made, how and how fast, after the maps and the reasons if weftex chose."""
    used, took = result.provenance, perf_counter() - start
    why = maps + (f"auto: {used['reason']}\n" if "reason" in used else "")
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
    """Arguments of all tasks; a seed that is drawn here is short enough to be typed again."""
    seed = int.from_bytes(os.urandom(4), "little") if args.seed is None else args.seed
    tileable = True if args.tileable == "xy" else args.tileable or False
    return {"seed": seed, "tileable": tileable, "threads": args.threads, "progress": bar}
