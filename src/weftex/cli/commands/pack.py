"""Write a map set for an engine or a program.

A preset names files, packs channels, inverts values, and sets bits and formats. Other commands,
such as 'weftex synth', have the same --preset. 'weftex unpack' is the reverse.

examples:
  weftex pack stone_wall/ -o stones/ --preset godot
  weftex pack stone_wall/ -o stones/ --preset unity-hdrp
  weftex pack stone_wall/ -o stones/ --preset mine.toml     a preset of your own
"""

from __future__ import annotations

import os
from dataclasses import replace

from weftex.cli.files import plan, read_input
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, run_and_report
from weftex.errors import FileError, InvalidInputError
from weftex.io.map_files import map_files
from weftex.io.outputs import OutputSet, kept_file
from weftex.io.packing import unpack_set
from weftex.io.pictures import MAX_PIXELS, is_folder, locate
from weftex.io.presets import presets, read_preset
from weftex.recipe import MATERIAL
from weftex.recipe.command_line import described_material


def run(argv: list[str]) -> None:
    """Run `weftex pack`; `argv` is what follows its name."""
    width = max(map(len, presets()))
    listed = "".join(f"  {name:{width}}  {about}\n" for name, about in presets().items())
    parser = Parser("pack", f"{__doc__}\npresets:\n{listed}")
    parser.add_argument("sample", metavar="FOLDER", help="folder of maps, or sample:NAME")
    parser.share("--output", "--preset", "--quiet", "--allow-huge")
    parser.take(MATERIAL["maps"])
    args = parser.parse(argv)
    spec = described_material(args.sample, vars(args), ("maps",))
    _check_preset(args.preset)

    def work(bar: Bar, outputs: Outputs) -> str:
        material = read_input(args.sample, args, spec.get("maps"))
        outputs.make_folder(args.output)
        files, told = plan([material], material.exemplar(), args)
        files.write(outputs.staged_path)
        return f"{told}packed {args.output} for {args.preset} in {bar.took:.2f} s"

    run_and_report(work, args.quiet)


def run_unpack(argv: list[str]) -> None:
    """Separate the packed maps of an engine into a map set with one file for each map.

    Smoothness becomes roughness, and y of normals points up (OpenGL). This is the reverse of
    'weftex pack'.

    examples:
      weftex unpack stones/ -o maps/ --preset unity-hdrp
      weftex unpack T_stones_ORM.png T_stones_Normal.png -o maps/ --preset unreal
    """
    parser = Parser("unpack", run_unpack.__doc__)
    text = "a folder, or files, named as the preset names them"
    parser.add_argument("files", metavar="FILE", nargs="+", help=text)
    parser.share("--output", "--preset", "--quiet", "--allow-huge")
    args = parser.parse(argv)
    _check_preset(args.preset)

    def work(bar: Bar, outputs: Outputs) -> str:
        notes: list[str] = []
        if len(args.files) == 1 and is_folder(args.files[0]):
            paths, notes = map_files(args.files[0])
        else:
            paths = {os.path.splitext(os.path.basename(one))[0]: one for one in args.files}
            if len(paths) < len(args.files):
                raise InvalidInputError("two files have the same name; give the files of one set")
            for one in args.files:
                if not os.path.exists(locate(one)[0]):
                    raise FileError(f"{one}: cannot read: No such file or directory")
        limits = {"max_pixels": None if args.allow_huge else MAX_PIXELS}
        maps, more = unpack_set(read_preset(args.preset), paths, **limits)
        maps = {role: replace(one, path="") for role, one in maps.items()}  # as PNG, or EXR
        files = tuple(kept_file(role, role, one) for role, one in maps.items())
        outputs.make_folder(args.output)
        OutputSet(args.output, maps, files).write(outputs.staged_path)
        told = "".join(f"map: {note}\n" for note in (*notes, *more))
        found = ", ".join(maps)
        return f"{told}unpacked {found} of {args.preset} to {args.output} in {bar.took:.2f} s"

    run_and_report(work, args.quiet)


def _check_preset(preset: str | None) -> None:
    if preset is None:
        raise InvalidInputError(f"--preset is missing; known: {', '.join(presets())}, or a .toml")
