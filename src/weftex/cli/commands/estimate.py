"""weftex estimate: estimate height and normals from a photo."""

from __future__ import annotations

import os

from weftex.cli.files import read_input
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, finish

_ABOUT = """\
Estimate height and normals from the brightness of a photo, and write them as a map set. Dark pixels
are taken to lie deeper, so stains and paint become relief too. Heights have 16 bits, normals 8.\
"""

_EXAMPLES = """\
examples:
  weftex estimate photo.png -o material/
  weftex estimate bricks.png -o material/ --relief 12 --invert      light joints between dark bricks
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("estimate", _ABOUT, _EXAMPLES)
    add = parser.add_argument
    add("photo", metavar="PHOTO", help="image, or sample:NAME")
    add("-o", "--output", metavar="OUT", required=True, help="folder to write")
    text = "height of the surface, in pixels; higher makes normals steeper; default: 6"
    add("--relief", type=float, default=6.0, metavar="PX", help=text)
    add("--invert", action="store_true", help="bright pixels lie deeper")
    add("--tileable", action="store_true", help="the photo is tileable, so its maps are too")
    parser.share("--quiet", "--allow-huge")
    args = parser.parse(argv)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.io.pictures import write_image
        from weftex.prepare.estimating import estimate_maps

        material = read_input(args.photo, args)
        exemplar = material.exemplar(tileable=args.tileable)
        made = estimate_maps(exemplar, relief=args.relief, invert=args.invert)
        outputs.make_folder(args.output)
        suffix = ".exr" if exemplar.pixels.dtype.kind == "f" else ".png"
        path = outputs.add(os.path.join(args.output, f"color{suffix}"))
        write_image(path, made.pixels, alpha=exemplar.alpha, icc=exemplar.icc)
        for name in ("height", "normal_gl"):
            path = os.path.join(args.output, f"{name}_estimated.png")
            write_image(outputs.add(path), made.maps[name])
        return (
            f"estimated height and normals of {args.photo}, in {args.output}, in {bar.took:.2f} s"
        )

    finish(work, args.quiet)
