"""weftex unpack: separate the packed maps of an engine or a program."""

from __future__ import annotations

import os
from dataclasses import replace

from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, finish
from weftex.errors import InvalidInputError

_ABOUT = """\
Separate packed maps into a map set with a file for each role, which every command reads. Smoothness
becomes roughness, and normals point up (OpenGL). It is the reverse of 'weftex pack'.\
"""

_EXAMPLES = """\
examples:
  weftex unpack stones/ -o maps/ --preset unity-hdrp
  weftex unpack T_stones_ORM.png T_stones_Normal.png -o maps/ --preset unreal
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("unpack", _ABOUT, _EXAMPLES)
    text = "a folder, or files, named as the preset names them"
    parser.add_argument("files", metavar="FILE", nargs="+", help=text)
    parser.share("--output", "--preset", "--quiet", "--allow-huge")
    args = parser.parse(argv)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.io.map_files import map_files
        from weftex.io.packed import PackedSet, kept_file, write_set
        from weftex.io.pictures import MAX_PIXELS, is_folder
        from weftex.io.presets import presets, read_preset
        from weftex.io.unpacking import unpack_set

        if args.preset is None:
            raise InvalidInputError(f"--preset is missing; known: {', '.join(presets())}")
        notes: list[str] = []
        if len(args.files) == 1 and is_folder(args.files[0]):
            paths, notes = map_files(args.files[0])
        else:
            paths = {os.path.splitext(os.path.basename(one))[0]: one for one in args.files}
            if len(paths) < len(args.files):
                raise InvalidInputError("two files have the same name; give the files of one set")
        limits = {"max_pixels": None if args.allow_huge else MAX_PIXELS}
        maps, more = unpack_set(read_preset(args.preset), paths, **limits)
        maps = {role: replace(one, path="") for role, one in maps.items()}  # as PNG, or EXR
        planned = PackedSet(tuple(kept_file(role, role, one) for role, one in maps.items()))
        outputs.make_folder(args.output)
        write_set(planned, args.output, lambda role: maps[role].pixels, outputs.add)
        told = "".join(f"map: {note}\n" for note in (*notes, *more))
        found = ", ".join(maps)
        return f"{told}unpacked {found} of {args.preset} to {args.output} in {bar.took:.2f} s"

    finish(work, args.quiet)
