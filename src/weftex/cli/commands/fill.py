"""weftex fill: fill what a mask covers."""

from __future__ import annotations

import argparse
from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.files import load, open_sample, report, settings, write
from weftex.cli.options import Parser, add_map_weights, add_sets, add_tileable_sample, parse_task
from weftex.cli.terminal import finish
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Fill holes of a photo; all other pixels stay as they are, but for those of --overlap. Without a
method and parameters, near-regular fills where the photo surely has a lattice. Patch size, boundary
width and epsilon are chosen for holes where they are not given.\
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
    add_sets(parser)
    add_map_weights(parser)
    text = "picture, white where to fill; default: where the photo is clear, by its alpha"
    parser.add_argument("--mask", metavar="M", help=text)
    parser.add_argument("--sample", metavar="S", help="learn from this picture, not from the photo")
    text = "so many pixels around the holes may change, to hide the seam; default: 0"
    parser.add_argument("--overlap", type=int, default=0, metavar="PX", help=text)
    text = "shift tones inside the holes to those around; default: where no method is named"
    parser.add_argument("--match-tone", action=argparse.BooleanOptionalAction, help=text)
    add_tileable_sample(parser)
    args, method, parameters = parse_task(parser, argv, "patch-sampling")
    if args.tileable_sample and args.sample is None:
        raise InvalidInputError(
            "--tileable-sample has no effect without --sample; --tileable says it of the photo"
        )
    method(**parameters)  # finds wrong values before anything is read

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.io.pictures import MAX_PIXELS, read_image
        from weftex.tasks.fill import fill, hole_of
        from weftex.tasks.method_names import AUTO

        photo, plan = open_sample(args.photo, args, outputs)
        mask = None
        if args.mask is not None:
            mask = read_image(args.mask, max_pixels=None if args.allow_huge else MAX_PIXELS)
        hole = hole_of(mask, photo)
        sample = None
        if args.sample is not None:
            sample = load(args.sample, args, tileable=args.tileable_sample)
        how = {"method": AUTO if args.by_default else args.method, "overlap": args.overlap}
        how["match_tone"] = args.match_tone
        result = fill(photo, hole, sample=sample, **how, **settings(args, bar), **parameters)
        write(result, plan, args, outputs)
        if not hole.any():
            return f"the mask covers nothing; {args.output} is the photo unchanged"
        return report(args, result, f"filled {int(hole.sum())} pixels of", start, plan.told)

    finish(work, args.quiet, preview=args.preview, verbose=args.verbose)
