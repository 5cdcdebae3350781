"""weftex fill: fill what a mask covers."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.files import load, open_sample, report, settings, told, write
from weftex.cli.options import Parser, add_maps, parse_task
from weftex.cli.terminal import finish

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Fill holes of a photo; all other pixels stay as they are. Patch size, boundary width and epsilon are
chosen for holes where they are not given.\
"""

_EXAMPLES = """\
examples:
  weftex fill photo.png --mask hole.png -o whole.png
  weftex fill erased.png -o whole.png                 what was erased, to full clearness
  weftex fill photo.png --mask hole.png -o whole.png --sample grass.png
  weftex fill stone_wall/ --mask hole.png -o whole/   a folder of aligned maps
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("fill", _ABOUT, _EXAMPLES)
    parser.add_argument("photo", metavar="PHOTO", help="picture, folder of maps, or sample:NAME")
    add_maps(parser)
    text = "picture, white where to fill; default: where the photo is clear, by its alpha"
    parser.add_argument("--mask", metavar="M", help=text)
    parser.add_argument("--sample", metavar="S", help="learn from this picture, not from the photo")
    args, method, parameters = parse_task(parser, argv, "patch-sampling")
    method(**parameters)  # finds wrong values before anything is read

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.io.pictures import MAX_PIXELS, read_image
        from weftex.tasks.fill import fill, hole_of

        photo, pictures, targets = open_sample(args.photo, args, outputs)
        mask = None
        if args.mask is not None:
            mask = read_image(args.mask, max_pixels=None if args.allow_huge else MAX_PIXELS)
        hole = hole_of(mask, photo)
        sample = None if args.sample is None else load(args.sample, args)[0]
        result = fill(
            photo, hole, sample=sample, method=args.method, **settings(args, bar), **parameters
        )
        write(result, photo, pictures, targets, args, outputs)
        if not hole.any():
            return f"the mask covers nothing; {args.output} is the photo unchanged"
        maps = told(pictures, args.photo, args.maps)
        return report(args, result, f"filled {int(hole.sum())} pixels of", start, maps)

    finish(work, args.quiet)
