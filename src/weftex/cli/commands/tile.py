"""weftex tile: make a photo tileable."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.files import open_sample, report, settings, write
from weftex.cli.options import add_map_weights, add_sets, parse_task
from weftex.cli.parser import Parser
from weftex.cli.terminal import finish

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Make a photo tileable at its own size. Only a border changes; the middle keeps every byte.\
"""

_EXAMPLES = """\
examples:
  weftex tile photo.jpg -o tile.png
  weftex tile photo.jpg -o strip.png --tileable x --border 40
  weftex tile stone_wall/ -o tile/                    a folder of aligned maps
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("tile", _ABOUT, _EXAMPLES)
    parser.add_argument("photo", metavar="PHOTO", help="image, folder of maps, or sample:NAME")
    add_sets(parser)
    add_map_weights(parser)
    text = "width of the border that may change; default: an eighth of the photo's shorter side"
    parser.add_argument("--border", type=int, metavar="PX", help=text)
    text = "make the photo tileable along both axes (default), or only along x or y"
    args, method, parameters = parse_task(
        parser, argv, "patch-sampling", usual="chosen for the photo", tileable=text
    )
    method(**parameters)  # finds wrong values before anything is read

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.tasks.method_names import AUTO
        from weftex.tasks.tile import tile

        photo, made = open_sample(args.photo, args, outputs)
        how = {"method": AUTO if args.by_default else args.method, "border": args.border}
        how |= settings(args, bar)
        axes = how.pop("tileable") or True
        result = tile(photo, axes=axes, **how, **parameters)
        write(result, made, args, outputs)
        return report(args, result, "made tileable:", start, made.told)

    finish(work, args.quiet, preview=args.preview, verbose=args.verbose)
