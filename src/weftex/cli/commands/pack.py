"""weftex pack: write a map set as an engine or a program wants it."""

from __future__ import annotations

from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, finish
from weftex.errors import InvalidInputError
from weftex.recipe import MATERIAL
from weftex.recipe.command_line import described_material

_ABOUT = """\
Write a map set as an engine or a program wants it: files named, channels packed, values inverted,
bits and formats set. 'weftex synth', 'tile', 'fill', 'fuse', 'batch', 'replay' and 'prepare' have
the same --preset for what they make. 'weftex unpack' is the reverse.\
"""

_EXAMPLES = """\
examples:
  weftex pack stone_wall/ -o stones/ --preset godot
  weftex pack stone_wall/ -o stones/ --preset unity-hdrp
  weftex pack stone_wall/ -o stones/ --preset mine.toml     a preset of your own
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    from weftex.io.presets import presets

    width = max(map(len, presets()))
    listed = "".join(f"  {name:{width}}  {about}\n" for name, about in presets().items())
    parser = Parser("pack", _ABOUT, f"{_EXAMPLES}\npresets:\n{listed}")
    parser.add_argument("sample", metavar="FOLDER", help="folder of maps, or sample:NAME")
    parser.share("--output", "--preset", "--quiet", "--allow-huge")
    parser.take(MATERIAL["maps"])
    args = parser.parse(argv)
    spec = described_material(args.sample, vars(args), ("maps",))
    if args.preset is None:
        raise InvalidInputError(f"--preset is missing; known: {', '.join(presets())}, or a .toml")

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.cli.files import plan, read_input

        material = read_input(args.sample, args, spec.get("maps"))
        outputs.make_folder(args.output)
        made = plan([material], material.exemplar(), args)
        made.write(lambda name: made.pictures[name].pixels, outputs)
        return f"{made.told}packed {args.output} for {args.preset} in {bar.took:.2f} s"

    finish(work, args.quiet)
