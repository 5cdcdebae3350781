"""Pictures that are written block by block, by weftex synth, and weftex check for them."""

from __future__ import annotations

import argparse
import os
from contextlib import ExitStack
from functools import partial
from typing import Any

from weftex import planes
from weftex.cli.files import open_materials
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, run_and_report, say
from weftex.errors import InvalidInputError
from weftex.exemplar.material import Material
from weftex.io.formats import TIFF
from weftex.io.pictures import check_output
from weftex.io.presets import read_preset
from weftex.planes.beginning import done_before
from weftex.planes.definition import BLOCK, Definition, define
from weftex.planes.layout import check_block
from weftex.planes.plane_file import PlaneFile
from weftex.planes.record import MOST_PARTS
from weftex.planes.writing import (
    block_maker,
    in_processes,
    in_words,
    most_bytes,
    seed_of_run,
    write_plane,
)
from weftex.processes import Workers
from weftex.recipe import Recipe

#: Options of synth that need the whole image.
_NOT_BY_BLOCKS = ("guide", "sample_guide", "debug", "save_source")


def check_options(args: argparse.Namespace) -> None:
    """Refuse options that make no sense for a plane, before anything is read."""
    for name in _NOT_BY_BLOCKS:
        if getattr(args, name, None):
            option = name.replace("_", "-")
            raise InvalidInputError(
                f"--{option} needs the whole image, and {args.output} is written block by block"
            )
    if args.best_of not in (None, "1"):
        raise InvalidInputError("--best-of needs the whole image; name a method and a seed")
    given = [name for name in ("part", "workers") if getattr(args, name) is not None]
    if len(given) > 1:
        raise InvalidInputError(f"give --{given[0]} or --{given[1]}, not both")
    if args.part is not None:
        args.part = parse_part(args.part)
        if args.restart:
            raise InvalidInputError("--restart has no effect with --part; restart without it")
        if args.seed is None:
            raise InvalidInputError("--part needs --seed, the same for all parts")
    if args.workers is not None and args.workers < 1:
        raise InvalidInputError(f"--workers is {args.workers}; it must be 1 or more")
    if given and given[0] != "part" and args.threads is not None:
        raise InvalidInputError("--threads has no effect: a worker makes one block at a time")
    if args.block is not None:
        check_block(args.block)
    check_output(args.output, suffixes=TIFF)


def parse_part(text: str) -> tuple[int, int]:
    """Return number and count of 'K/N'."""
    number, slash, count = text.partition("/")
    if slash and number.isdecimal() and count.isdecimal():
        if 1 <= int(number) <= int(count) <= MOST_PARTS:
            return int(number), int(count)
    raise InvalidInputError(
        f"--part is '{text}'; it must be K/N with K from 1 to N, N up to {MOST_PARTS}"
    )


def stems_of(args: argparse.Namespace, material: Material) -> dict[str, str]:
    """What the files of a set's maps are called, where --preset says so."""
    if args.preset is None:
        return {}
    if not material.folder:
        raise InvalidInputError(f"--preset needs a folder of maps; {material.name} is an image")
    preset = read_preset(args.preset)
    if not preset.others:
        raise InvalidInputError(
            f"preset {preset.name} packs whole images, and {args.output} is written block by "
            "block; only presets that rename work there, such as ambientcg"
        )
    own = os.path.splitext(os.path.basename(args.output))[0]
    return {name: preset.stem(own, role) for name, role in material.roles.items()}


def synthesize(recipe: Recipe, args: argparse.Namespace) -> None:
    """Do what `weftex synth` does where it writes block by block."""
    check_options(args)

    def work(bar: Bar, outputs: Outputs) -> str:
        job, seed = open_materials(recipe, args), recipe.seed
        if args.seed is None and not args.restart:
            begun = seed_of_run(args.output)
            seed = seed if begun is None else begun
        how: dict[str, Any] = {"seed": seed, "tileable": recipe.options["tileable"]}
        how |= {"block": args.block or BLOCK, "stems": stems_of(args, job.materials[0])}
        how["density"] = next(iter(job.pictures.values())).density
        plane = define(job.sample, job.shape, recipe.method, {}, **how)
        return _write(args, plane, bar)

    run_and_report(work, args.quiet, verbose=args.verbose)


def _write(args: argparse.Namespace, definition: Definition, bar: Bar) -> str:
    """Write a plane, and return the line about it."""
    plane = PlaneFile(definition, args.output, args.part)
    left = plane.missing(done_before(plane, restart=args.restart))
    part = "part {}/{} of ".format(*args.part) if args.part else ""
    if not args.quiet:
        say(
            f"{part}{args.output} is written block by block: {left} of {plane.count} blocks "
            f"are left, up to {in_words(most_bytes(plane, left))}"
        )
    bar.left = "finished blocks are kept; repeat the command to continue"
    how: dict[str, Any] = {"restart": args.restart, "progress": bar}
    how |= {"threads": args.threads, "check_disk": not args.allow_huge}
    with ExitStack() as stack:
        if args.workers is not None:
            workers = stack.enter_context(Workers(block_maker, plane))
            how["runner"] = partial(in_processes, workers, args.workers)
            bar.at_stop(workers.end)
        written = write_plane(plane, **how)
    took = bar.took
    speed = f" ({written.pixels / took / 1e6:.3g} megapixels/s)" if written.pixels else ""
    line = (
        f"made {part}{definition.width}x{definition.height} {args.output} with "
        f"{definition.method.slug}, seed {definition.seed}, {written.made} blocks in "
        f"{took:.2f} s{speed}"
    )
    if args.part:
        line += "\nafter all parts, run the command without --part: it writes the overviews"
    return (f"auto: {definition.reason}\n" if definition.reason else "") + line


def run_check(argv: list[str]) -> None:
    """Check that an image written block by block is complete, and list the parts that are missing.

    The exit code is 2 if anything is missing or damaged.

    examples:
      weftex check plane.tif
      weftex check plane.tif --read
      weftex check plane.tif --repair
    """
    parser = Parser("check", run_check.__doc__)
    add = parser.add_argument
    add("plane", metavar="PLANE", help="image that 'weftex synth' wrote block by block")
    text = "also read all pixels and compare them with their checksums"
    add("--read", action="store_true", help=text)
    text = "read all pixels, and make damaged or missing blocks and files again"
    add("--repair", action="store_true", help=text)
    args = parser.parse(argv)
    made = planes.repair(args.plane).made if args.repair else 0
    plane = planes.check(args.plane, read=args.read or args.repair)
    used = plane.definition
    read = ", all checksums match" if args.read or args.repair else ""
    again = f"; {made} blocks were made again" if args.repair else ""
    print(
        f"{plane.path} is complete{read}: {used.width}x{used.height} with {used.method.slug}, "
        f"seed {used.seed}{again}"
    )
