"""weftex fill: fill the holes in a photo."""

from __future__ import annotations

import argparse
from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.files import load, open_sample, report, settings, write
from weftex.cli.options import add_map_weights, add_sets, add_tileable_sample, parse_task
from weftex.cli.parser import Parser
from weftex.cli.terminal import finish
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Fill the holes in a photo. All other pixels stay unchanged unless --overlap is given. Without
--method and method parameters, weftex chooses a method: graphcut or near-regular for photos with a
lattice or large features, patch-sampling for all others. patch-sampling has other defaults for
holes than those listed below: candidates 400, epsilon 0.02, boundary width 4, and a patch size that
depends on the width of the holes.\
"""

_EXAMPLES = """\
examples:
  weftex fill photo.png --mask hole.png -o whole.png
  weftex fill erased.png -o whole.png                 fill the transparent pixels
  weftex fill photo.png --mask hole.png -o whole.png --sample grass.png
  weftex fill stone_wall/ --mask hole.png -o whole/   a folder of aligned maps
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("fill", _ABOUT, _EXAMPLES)
    parser.add_argument("photo", metavar="PHOTO", help="image, folder of maps, or sample:NAME")
    add_sets(parser)
    add_map_weights(parser)
    text = "image that is white where the photo has holes; default: pixels that are not opaque"
    parser.add_argument("--mask", metavar="FILE", help=text)
    text = "image to fill the holes from, in place of the photo"
    parser.add_argument("--sample", metavar="FILE", help=text)
    add = parser.under["quality"].add_argument
    text = "width of the margin around the holes that may change, to hide the seam; default: 0"
    add("--overlap", type=int, default=0, metavar="PX", help=text)
    text = "match the tone of the filling to its surroundings; default: yes if weftex chooses the "
    text += "method"
    add("--match-tone", action=argparse.BooleanOptionalAction, help=text)
    add_tileable_sample(parser)
    text = "the photo is tileable along both axes, or only x or y, so holes can cross its border"
    args, method, parameters = parse_task(
        parser, argv, "patch-sampling", usual="chosen for the photo", tileable=text
    )
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
