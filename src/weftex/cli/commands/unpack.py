"""weftex unpack: separate the packed maps of an engine or a program."""

from __future__ import annotations

import os
from typing import Any

from weftex.cli.commands.pack import refuse_own_folder
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
        from weftex.io.pictures import MAX_PIXELS, is_folder, write_image
        from weftex.io.presets import presets, read_preset
        from weftex.io.unpacking import unpack_set

        if args.preset is None:
            raise InvalidInputError(f"--preset is missing; known: {', '.join(presets())}")
        notes: list[str] = []
        if len(args.files) == 1 and is_folder(args.files[0]):
            paths, notes = map_files(args.files[0])
        else:
            paths = {os.path.splitext(os.path.basename(one))[0]: one for one in args.files}
        refuse_own_folder([*paths.values()], args.output)
        limits = {"max_pixels": None if args.allow_huge else MAX_PIXELS}
        maps, more = unpack_set(read_preset(args.preset), paths, **limits)
        outputs.make_folder(args.output)
        for role, one in maps.items():
            suffix = ".exr" if one.pixels.dtype.kind == "f" else ".png"
            path = outputs.add(os.path.join(args.output, role + suffix))
            how: dict[str, Any] = {
                "alpha": one.alpha,
                "icc": one.icc,
                "half": one.half,
                "density": one.density,
            }
            write_image(path, one.pixels, **how)
        told = "".join(f"map: {note}\n" for note in (*notes, *more))
        found = ", ".join(maps)
        return f"{told}unpacked {found} of {args.preset} to {args.output} in {bar.took:.2f} s"

    finish(work, args.quiet)
