"""weftex fuse: two or more materials in one picture."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex.cli.files import load, report, settings, write
from weftex.cli.options import Parser, parse_colors, parse_mixed, parse_size, parse_task
from weftex.cli.terminal import finish

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Make a picture of several materials that merge where a map says. The map has one color for each
sample: those of --colors, or in the order in which they appear, from the upper left corner row by
row. The map 'gradient' goes over from the first of two samples to the second, from top to bottom.\
"""

_EXAMPLES = """\
examples:
  weftex fuse clover.png grape.png plum.png --map map.png -o field.png
  weftex fuse clover.png grape.png --map map.png --colors '#ff0000,#0000ff' -o field.png
  weftex fuse purple.png yellow.png --map gradient --size 400x400 -o beans.png
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("fuse", _ABOUT, _EXAMPLES)
    parser.add_argument("samples", metavar="SAMPLE", nargs="+", help="pictures, or sample:NAME")
    parser.add_argument("--map", metavar="M", required=True, help="picture, or 'gradient'")
    text = "the map's color for each sample, as #rrggbb or a gray level"
    parser.add_argument("--colors", metavar="C,C,...", help=text)
    text = "further colors, of regions where two samples are mixed, as #rrggbb=1+2"
    parser.add_argument("--mixed", metavar="C=A+B,...", help=text)
    parser.add_argument("--size", metavar="WxH|N", help="in pixels; default: the map's")
    args, method, parameters = parse_task(parser, argv, "refinement")
    size = None if args.size is None else parse_size(args.size, args.allow_huge)
    colors = None if args.colors is None else parse_colors(args.colors)
    mixed = None if args.mixed is None else parse_mixed(args.mixed)
    chosen = method(**parameters)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.io.pictures import check_output, read_image
        from weftex.tasks.fuse import fuse

        check_output(args.output)
        samples, pictures = zip(*(load(path, args) for path in args.samples), strict=True)
        first = pictures[0][samples[0].name]
        check_output(args.output, first.pixels, alpha=first.alpha)
        label_map = args.map
        if label_map != "gradient":
            label_map = read_image(label_map).pixels
        named: dict[str, Any] = {"colors": colors, "mixed": mixed}
        result = fuse(samples, label_map, size, method=chosen, **named, **settings(args, bar))
        whole = result.sample
        write(result, whole, {whole.name: first}, {whole.name: args.output}, args, outputs)
        return report(args, result, f"fused {len(samples)} samples in", start)

    finish(work, args.quiet)
