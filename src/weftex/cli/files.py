"""The pictures that a command reads and writes, and the lines that it prints about them."""

from __future__ import annotations

import os
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex.cli.sets import Plan, plan, plan_of_several
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from weftex.cli.terminal import Bar, Outputs
    from weftex.exemplar import Exemplar
    from weftex.material import Material
    from weftex.results.synthesis import Synthesis


def read(path: str, args: argparse.Namespace, maps: dict[str, str] | None = None) -> Material:
    """Read a picture, or a folder of maps."""
    from weftex.io.pictures import MAX_PIXELS
    from weftex.material import read_material

    refuse_plane(path)
    return read_material(path, maps, max_pixels=None if args.allow_huge else MAX_PIXELS)


def refuse_plane(path: str) -> None:
    """Raise `InvalidInputError` where a picture is read whole, and a plane is given."""
    from weftex.planes.files import ALWAYS
    from weftex.planes.record import Record

    if Record(path).begun() or path.endswith(ALWAYS):
        raise InvalidInputError(
            f"{path} is written block by block, and may be larger than memory: only replay, report "
            "and check work on it. One that repeats is made so: weftex synth --tileable"
        )


def load(
    path: str,
    args: argparse.Namespace,
    maps: dict[str, str] | None = None,
    *,
    tileable: bool = False,
) -> Exemplar:
    """Read a picture, or a folder of maps, as a sample."""
    return with_turns(_weighted(read(path, args, maps).exemplar(tileable=tileable), args), args)


def _weighted(exemplar: Exemplar, args: argparse.Namespace) -> Exemplar:
    """The sample with what was said about the weights of its maps."""
    weights = getattr(args, "map_weights", None)
    return exemplar if weights is None else exemplar.changed(weights=weights)


def with_turns(exemplar: Exemplar, args: argparse.Namespace) -> Exemplar:
    """The sample with its mirrored and turned copies, where a command was asked for them."""
    if getattr(args, "turn", None) is None:
        return exemplar
    from weftex.turns import turned

    return turned(exemplar, args.turn)


def open_sample(
    path: str, args: argparse.Namespace, outputs: Outputs, *, tileable: bool = False
) -> tuple[Exemplar, Plan]:
    """Read the sample, and say where each of its pictures goes; all is checked before any work.

    What was asked for is mended, but not turned.
    """
    from weftex.io.pictures import check_output, is_folder

    _check_beside(args)
    if is_folder(path):
        outputs.make_folder(args.output)
    else:
        check_output(args.output)
    exemplar, material = read_sample(path, args, tileable=tileable)
    return exemplar, plan(material, args)


def read_sample(
    path: str, args: argparse.Namespace, *, tileable: bool = False
) -> tuple[Exemplar, Material]:
    """Read the sample and mend it, as was asked for."""
    material = read(path, args, args.maps)
    exemplar = _weighted(material.exemplar(tileable=tileable), args)
    if getattr(args, "sample_mask", None) is not None:
        exemplar = exemplar.changed(mask=_usable(exemplar, args))
    return _mended(exemplar, args), material


def open_several(
    paths: Sequence[str], args: argparse.Namespace, outputs: Outputs
) -> tuple[Exemplar, Plan]:
    """`open_sample` for several samples of one material, each of which is mended by itself."""
    _refuse_several(args)
    materials = open_samples(paths, args, outputs)
    exemplar, first, notes = join_samples(materials, args)
    made = plan_of_several(materials, first, args)
    told = made.told + "".join(f"map: {note}\n" for note in notes)
    return exemplar, replace(made, told=told)


def _refuse_several(args: argparse.Namespace) -> None:
    """Refuse options that say something about one sample."""
    for name in ("maps", "map_weights", "sample_mask", "sample_guide"):
        if getattr(args, name) is not None:
            raise InvalidInputError(f"--{name.replace('_', '-')} needs one sample, not several")
    if args.tileable_sample:
        raise InvalidInputError("--tileable-sample needs one sample, not several")


def join_samples(
    materials: Sequence[Material], args: argparse.Namespace
) -> tuple[Exemplar, Exemplar, list[str]]:
    """Several samples as one, the first of them, and what was left out of them."""
    from weftex.tasks.combined import combined, of_one_kind, paired

    pairs, notes = paired(of_one_kind([_mended(one.exemplar(), args) for one in materials]))
    return combined(pairs, apart=True), pairs[0], list(notes)


def read_samples(args: argparse.Namespace) -> tuple[Exemplar, Material]:
    """The sample, or several as one, where the output is none that is written at once."""
    if len(args.sample) == 1:
        return read_sample(args.sample[0], args, tileable=args.tileable_sample)
    _refuse_several(args)
    materials = [read(path, args) for path in args.sample]
    return join_samples(materials, args)[0], materials[0]


def open_samples(
    paths: Sequence[str], args: argparse.Namespace, outputs: Outputs
) -> list[Material]:
    """Read several samples for one output: a folder if one of them is a folder."""
    from weftex.io.pictures import check_output, is_folder

    _check_beside(args)
    if any(map(is_folder, paths)):
        outputs.make_folder(args.output)
    else:
        check_output(args.output)
    return [read(path, args) for path in paths]


def _check_beside(args: argparse.Namespace) -> None:
    """Refuse paths of files beside the output, before any work is done."""
    import numpy as np

    from weftex.io.pictures import check_output

    if getattr(args, "save_source", None) is not None:
        check_output(args.save_source, suffixes=(".npz",))
    if getattr(args, "preview", None) is not None:
        check_output(args.preview, np.zeros((1, 1, 3), np.uint8))


def _usable(exemplar: Exemplar, args: argparse.Namespace) -> NDArray[np.bool_]:
    """What of the sample may be used: white in a picture, or what is not clear."""
    from weftex.io.pictures import MAX_PIXELS, mask_of, read_image
    from weftex.tasks.fill import hole_of

    if args.sample_mask == "alpha":
        return ~hole_of(None, exemplar)
    picture = read_image(args.sample_mask, max_pixels=None if args.allow_huge else MAX_PIXELS)
    return mask_of(picture.pixels, alpha=picture.alpha)


def _mended(exemplar: Exemplar, args: argparse.Namespace) -> Exemplar:
    """Straighten the sample, and even its light, where that was asked for."""
    if getattr(args, "straighten", None) is not None:
        from weftex.tasks.straighten import straighten

        exemplar = straighten(exemplar, **_ways(args.straighten))
    if getattr(args, "even_light", None) is not None:
        from weftex.tasks.even_light import even_light

        exemplar = even_light(exemplar, args.even_light)
    return exemplar


def _ways(text: str) -> dict[str, str]:
    """What `straighten` is told: vectors, corners, or nothing."""
    names = {4: "lattice", 8: "corners"}
    count = text.count(",") + 1
    if text and count not in names:
        raise InvalidInputError(
            f"--straighten is '{text}'; it must be four numbers, a lattice, or eight, corners"
        )
    return {names[count]: text} if text else {}


def write(result: Synthesis, made: Plan, args: argparse.Namespace, outputs: Outputs) -> None:
    """Write the result and, from the same coordinates, each other map of the sample."""

    def pixels(name: str) -> NDArray[Any]:
        main = name == made.material.main
        return result.image if main else result.render(result.sample.map(name))

    made.write(pixels, outputs, args.threads)
    if args.save_source is not None:
        result.save(outputs.add(args.save_source))
    if getattr(args, "preview", None) is not None:
        from weftex.io.pictures import write_image
        from weftex.io.shown import small_bytes

        shown = small_bytes(result.image, result.sample.alpha)
        write_image(outputs.add(args.preview), shown[..., : 3 if shown.shape[2] > 2 else 1])


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
    told: str = "",
) -> str:
    """Print what was made, how and how fast, after the maps and the reasons if weftex chose."""
    used, took = result.provenance, perf_counter() - start
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


def settings(args: argparse.Namespace, bar: Bar) -> dict[str, Any]:
    """Arguments of all tasks; a seed that is drawn here is short enough to be typed again."""
    seed = int.from_bytes(os.urandom(4), "little") if args.seed is None else args.seed
    return {"seed": seed, "tileable": axes_of(args), "threads": args.threads, "progress": bar}


def axes_of(args: argparse.Namespace) -> bool | str:
    """The axes of --tileable, as tasks take them."""
    return True if args.tileable == "xy" else args.tileable or False
