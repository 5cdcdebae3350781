"""weftex fuse: merge several materials in one image."""

from __future__ import annotations

import argparse
from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex.cli.files import open_samples, report, settings, write
from weftex.cli.options import (
    add_names,
    parse_colors,
    parse_mixed,
    parse_shares,
    parse_size,
    parse_task,
    parse_values,
)
from weftex.cli.parser import Parser
from weftex.cli.sets import plan_of_several
from weftex.cli.terminal import finish
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Synthesize one image from several materials that merge according to a map. The map has one color
for each sample. --colors lists these colors; by default the samples take the colors in the order of
their appearance, row by row from the top left. --map gradient needs no image: it changes from one
sample to the next, along a line or in rings around a center.\
"""

_EXAMPLES = """\
examples:
  weftex fuse clover.png grape.png plum.png --map map.png -o field.png
  weftex fuse clover.png grape.png --map map.png --colors '#ff0000,#0000ff' -o field.png
  weftex fuse purple.png yellow.png --map gradient --size 400x400 -o beans.png
  weftex fuse stone_wall/ bark/ --map map.png --missing metallic=0 -o both/      folders of maps
  weftex fuse sand.png grass.png rock.png --map gradient --center 0.5,0.5 --size 400 -o island.png
"""

#: Options of the map 'gradient', by the names of `weftex.Gradient`.
_GRADIENT = ("direction", "center", "radii", "width", "circles")


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("fuse", _ABOUT, _EXAMPLES)
    text = "two or more images, folders of maps, or sample:NAME"
    parser.add_argument("samples", metavar="SAMPLE", nargs="+", help=text)
    text = "values for maps that some samples lack: 0 to 1, or 'flat' for normals; default: omit "
    text += "such maps"
    add = parser.under["map sets"].add_argument
    add("--missing", metavar="NAME=VALUE,...", type=parse_values, help=text)
    add_names(parser)
    parser.add_argument(
        "--map",
        metavar="MAP",
        required=True,
        help="image with one color for each sample, or 'gradient'",
    )
    text = "map colors of the samples, in their order, as #rrggbb or gray levels"
    parser.add_argument("--colors", metavar="C,C,...", help=text)
    text = "map colors of regions that mix two samples, such as '#00ff00=1+2'"
    parser.add_argument("--mixed", metavar="C=A+B,...", help=text)
    parser.add_argument("--size", metavar="WxH|N", help="output size in pixels; default: the map's")
    add = parser.under["quality"].add_argument
    text = (
        "cut: along the least visible seam; merged: then fill a belt along it from both materials; "
    )
    text += "default: cut"
    add("--boundary", default="cut", metavar="cut|merged", help=text)
    text = "width of the belt in which a boundary may move; default: from the samples' scales"
    add("--belt-width", type=int, metavar="PX", help=text)
    _add_gradient(parser)
    args, method, parameters = parse_task(parser, argv, "refinement")
    size = None if args.size is None else parse_size(args.size, args.allow_huge)
    colors = None if args.colors is None else parse_colors(args.colors)
    mixed = None if args.mixed is None else parse_mixed(args.mixed)
    gradient = _gradient(args)
    chosen = method(**parameters)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.io.pictures import read_image
        from weftex.results.scales import check_size
        from weftex.tasks.combined import of_one_kind, paired
        from weftex.tasks.fuse import fuse

        materials = open_samples(args.samples, args, outputs)
        samples = [one.exemplar() for one in materials]
        pairs = paired(of_one_kind(samples), args.missing)[0]
        made = plan_of_several(materials, pairs[0], args)
        label_map = read_image(args.map).pixels if gradient is None else gradient
        named: dict[str, Any] = {"colors": colors, "mixed": mixed, "boundary": args.boundary}
        named["belt_width"] = args.belt_width
        named["missing"] = args.missing
        if size is not None or gradient is None:
            check_size(pairs[0], size or label_map.shape[:2])
        result = fuse(samples, label_map, size, method=chosen, **named, **settings(args, bar))
        write(result, made, args, outputs)
        return report(args, result, f"fused {len(samples)} samples in", start, made.told)

    finish(work, args.quiet, preview=args.preview, verbose=args.verbose)


def _add_gradient(parser: Parser) -> None:
    group = parser.add_argument_group("--map gradient")
    text = "direction of the last sample, in degrees: 0 is right, 90 is down; default: 90"
    group.add_argument("--direction", type=float, metavar="DEG", help=text)
    text = "center of the first sample, with rings of the others; 0,0 is top left, 1,1 bottom right"
    group.add_argument("--center", metavar="X,Y", help=text)
    text = "middle of each transition, from 0 (first sample) to 1 (last); default: evenly spaced"
    group.add_argument("--radii", metavar="R,R,...", help=text)
    text = "length of each transition, above 0 and at most 1; default: transitions fill the image"
    group.add_argument("--width", type=float, metavar="W", help=text)
    text = "radius of the circles that mix the samples, one or one for each, as a share of the "
    text += "shorter side; default: the samples' scales"
    group.add_argument("--circles", metavar="C,C,...", help=text)


def _gradient(args: argparse.Namespace) -> Any:
    """The gradient that the options describe; None for another map."""
    given = {name: getattr(args, name) for name in _GRADIENT if getattr(args, name) is not None}
    if args.map != "gradient":
        if given:
            raise InvalidInputError(f"--{next(iter(given))} has no effect unless --map is gradient")
        return None
    from weftex.tasks.gradient import Gradient

    for name in ("center", "radii", "circles"):
        if name in given:
            given[name] = parse_shares(f"--{name}", given[name])
    if "center" in given:
        given["center"] = given["center"][::-1]  # rows come first in Python
    if len(given.get("circles", ())) == 1:
        given["circles"] = given["circles"][0]
    return Gradient(**given)
