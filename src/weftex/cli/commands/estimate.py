"""weftex estimate: guess height and normals of a photo that has none."""

from __future__ import annotations

import os
from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.files import read
from weftex.cli.options import Parser, add_limits
from weftex.cli.terminal import finish

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Guess height and normals of a photo that has none, by its brightness: what is dark lies deep. Stains
and paint become relief too; a photo does not say more. The folder is a set of maps.\
"""

_EXAMPLES = """\
examples:
  weftex estimate photo.png -o material/
  weftex estimate bricks.png -o material/ --depth 12 --invert      light joints between dark bricks
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("estimate", _ABOUT, _EXAMPLES)
    add = parser.add_argument
    add("photo", metavar="PHOTO", help="picture, or sample:NAME")
    add("-o", "--output", metavar="OUT", required=True, help="folder to write")
    text = "from the deepest place to the highest, in pixels; default: 6"
    add("--depth", type=float, default=6.0, metavar="PX", help=text)
    add("--invert", action="store_true", help="what is bright lies deep")
    text = "the photo repeats without a seam, and so will the maps"
    add("--tileable-sample", action="store_true", help=text)
    add_limits(parser)
    args = parser.parse(argv)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.io.pictures import write_image
        from weftex.tasks.estimate_maps import estimate_maps

        material = read(args.photo, args)
        exemplar = material.exemplar(tileable=args.tileable_sample)
        made = estimate_maps(exemplar, depth=args.depth, invert=args.invert)
        outputs.make_folder(args.output)
        suffix = ".exr" if exemplar.pixels.dtype.kind == "f" else ".png"
        path = outputs.add(os.path.join(args.output, f"color{suffix}"))
        write_image(path, made.pixels, alpha=exemplar.alpha, icc=exemplar.icc)
        for name in ("height", "normal_gl"):
            path = os.path.join(args.output, f"{name}_estimated.png")
            write_image(outputs.add(path), made.maps[name])
        took = perf_counter() - start
        return f"estimated height and normals of {args.photo}, in {args.output}, in {took:.2f} s"

    finish(work, args.quiet)
