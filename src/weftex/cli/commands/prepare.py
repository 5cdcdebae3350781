"""Straighten a photo, remove uneven light, and remove landmarks (conspicuous features).

The output is a sample for any other command. 'weftex synth' has the same options.

examples:
  weftex prepare photo.jpg                            say what the photo needs
  weftex prepare photo.jpg -o brick.png --straighten --even-light
  weftex prepare photo.jpg -o brick.png --straighten 12,40,801,95,790,620,20,700   by four corners
  weftex prepare photo.jpg -o brick.png --straighten 99,3,49,36.7                  by a lattice
  weftex prepare leaves.jpg -o plain.png --landmarks remove
  weftex prepare stone_wall/ -o straight/ --straighten                            a folder of maps
"""

from __future__ import annotations

import argparse

from weftex.cli.files import load_sample, plan, prepare_targets, read_input
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, run_and_report
from weftex.cli.terminal import run as run_work
from weftex.errors import InvalidInputError
from weftex.io.pictures import read_image
from weftex.prepare.straightening import is_tilted
from weftex.recipe import LANDMARKS, MATERIAL, PREPARATION
from weftex.recipe.command_line import described_material, value_of
from weftex.recipe.opening import prepare_material
from weftex.tasks.auto import Auto, AutoModel
from weftex.tasks.landmarks import remove_landmarks

_LANDMARKS = LANDMARKS._replace(
    default="keep",
    choices=("keep", "remove"),
    metavar="keep|remove",
    help="remove: replace conspicuous features by other parts; no effect on samples with a lattice",
)


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("prepare", __doc__)
    add = parser.add_argument
    add("sample", metavar="PHOTO", help="image, folder of maps, or sample:NAME")
    add("-o", "--output", metavar="OUT", help="file to write; a folder for a map set")
    parser.share("--preset", "--quiet", "--allow-huge")
    names = ("maps", "repeats", *PREPARATION)
    parser.take(*(MATERIAL[name] for name in names))
    parser.take(_LANDMARKS)
    args = parser.parse(argv)
    spec = described_material(args.sample, vars(args), names)
    remove = value_of(_LANDMARKS, vars(args)) == "remove"
    if not remove and not spec.keys() & PREPARATION:
        lines = _advice(args)
        if args.output is not None:
            options = "--straighten, --even-light, --landmarks, --sample-width or --density"
            raise InvalidInputError(f"nothing to do; give {options}. {'; '.join(lines)}")
        print("\n".join(lines))
        return
    if args.output is None:
        raise InvalidInputError("-o OUT is missing; it names the file, or the folder, to write")

    def work(bar: Bar, outputs: Outputs) -> str:
        prepare_targets([args.sample], args, outputs)
        given = read_input(args.sample, args, spec.get("maps"))
        _, material, made = prepare_material(spec, given, read_image)
        if remove:
            made = remove_landmarks(made)
        files, told = plan([material], made, args)
        files.write(outputs.staged_path)
        height, width = made.shape
        return f"{told}prepared {width}x{height} {args.output} in {bar.took:.2f} s"

    run_and_report(work, args.quiet)


def _advice(args: argparse.Namespace) -> list[str]:
    """Say what a photo needs, and the command that does it."""

    def look(bar: Bar, outputs: Outputs) -> tuple[list[str], AutoModel]:
        photo = load_sample(args.sample, args, "maps")
        model = AutoModel(Auto(), photo)
        return list(model.choose(photo.shape).warnings), model

    (found, model), _ = run_work(look, args.quiet)
    tilted = model.lattice is not None and is_tilted(model.lattice)
    if tilted:
        found.append("the rows are not level; add --straighten")
    options = ["--straighten"] * tilted + ["--even-light"] * model.findings.evenness.lit_unevenly
    if options:
        found.append(f"weftex prepare {args.sample} -o OUT {' '.join(options)}")
    rows = "no rows are found; if it was taken at an angle, give four corners to --straighten"
    rows = rows if model.lattice is None else "its rows are level"
    return found or [f"This photo needs no preparation: its light is even, and {rows}"]
