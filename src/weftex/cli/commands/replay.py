"""weftex replay: lay a saved result again with another map of its sample."""

from __future__ import annotations

import os
from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.options import Parser, add_limits
from weftex.cli.terminal import finish

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_EXAMPLES = """\
examples:
  weftex replay wall.npz normal_16bit.png -o wall_normal.png
  weftex replay filled.npz height.exr -o filled_height.exr --background photo_height.exr
  weftex replay field.npz clover_height.png grape_height.png plum_height.png -o field_height.png
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("replay", "Lay a saved result again with another map of its sample.", _EXAMPLES)
    add = parser.add_argument
    add("source", metavar="F.npz", help="what --save-source saved")
    text = "of the sample's size, or an integer multiple of it; of a fusion one for each sample"
    add("maps", metavar="MAP", nargs="+", help=text)
    add("-o", "--output", metavar="OUT", required=True, help="file to write")
    add("--background", metavar="PHOTO", help="this map of a photo that another sample filled")
    add_limits(parser)
    args = parser.parse(argv)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.exemplar import Exemplar
        from weftex.io.pictures import MAX_PIXELS, check_output, read_image, write_image
        from weftex.results.synthesis import Synthesis

        check_output(args.output)
        result = Synthesis.load(args.source)
        limit = None if args.allow_huge else MAX_PIXELS
        read = [read_image(path, max_pixels=limit) for path in args.maps]
        picture = read[0]
        check_output(args.output, picture.pixels, alpha=picture.alpha)
        given = Exemplar(picture.pixels, alpha=picture.alpha, name=os.path.basename(args.maps[0]))
        if len(read) > 1:
            from weftex.tasks.fuse import combined

            names = [os.path.basename(path) for path in args.maps]
            given = combined(
                [
                    Exemplar(p.pixels, alpha=p.alpha, name=name)
                    for p, name in zip(read, names, strict=True)
                ]
            )
        around = None
        if args.background is not None:
            around = read_image(args.background, max_pixels=limit).pixels
        pixels = result.render(given, background=around)
        write_image(outputs.add(args.output), pixels, alpha=picture.alpha, icc=picture.icc)
        took = perf_counter() - start
        return f"made {pixels.shape[1]}x{pixels.shape[0]} {args.output} in {took:.2f} s"

    finish(work, args.quiet)
