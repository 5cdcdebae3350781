"""weftex fuse: two or more materials in one picture."""

from __future__ import annotations

import argparse
from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex.cli.files import open_samples, report, settings, write
from weftex.cli.options import (
    Parser,
    add_names,
    parse_colors,
    parse_mixed,
    parse_shares,
    parse_size,
    parse_task,
    parse_values,
)
from weftex.cli.sets import plan_of_several
from weftex.cli.terminal import finish
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Make a picture of several materials that merge where a map says. The map has one color for each
sample: those of --colors, or in the order in which they appear, from the upper left corner row by
row. The map 'gradient' goes over from one sample to the next, along a line or around a center.\
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
    text = "pictures, folders of maps, or sample:NAME"
    parser.add_argument("samples", metavar="SAMPLE", nargs="+", help=text)
    text = "values, 0 to 1, or flat of normals, of maps for samples that lack them; default: maps "
    text += "that not all samples have are left out"
    parser.add_argument("--missing", metavar="NAME=VALUE,...", type=parse_values, help=text)
    add_names(parser)
    parser.add_argument("--map", metavar="M", required=True, help="picture, or 'gradient'")
    text = "the map's color for each sample, as #rrggbb or a gray level"
    parser.add_argument("--colors", metavar="C,C,...", help=text)
    text = "further colors, of regions where two samples are mixed, as #rrggbb=1+2"
    parser.add_argument("--mixed", metavar="C=A+B,...", help=text)
    parser.add_argument("--size", metavar="WxH|N", help="in pixels; default: the map's")
    text = "cut: where it shows least; merged: and belts there from merged samples; default: cut"
    parser.add_argument("--boundary", default="cut", metavar="HOW", help=text)
    text = "within how many pixels a boundary may wander; default: by the samples' scales"
    parser.add_argument("--belt-width", type=int, metavar="PX", help=text)
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
    group = parser.add_argument_group("of --map gradient, in shares of the canvas")
    text = "in degrees, where the last sample lies: 0 right, 90 at the bottom; default: 90"
    group.add_argument("--direction", type=float, metavar="DEG", help=text)
    text = "the first sample lies here, the others in rings around it; 0,0 is the upper left corner"
    group.add_argument("--center", metavar="X,Y", help=text)
    text = "where transitions have their middles, 0 to 1 on the way; default: even"
    group.add_argument("--radii", metavar="R,R,...", help=text)
    text = "how much of the way a transition takes; default: all of it together"
    group.add_argument("--width", type=float, metavar="W", help=text)
    text = "radius of the circles, or of each sample's; default: the samples' scales"
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
