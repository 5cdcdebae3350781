"""weftex compare: every method on one sample."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.files import load, settings
from weftex.cli.options import (
    Parser,
    add_limits,
    add_map_weights,
    add_maps,
    add_tileable_sample,
    add_turn,
    check_numbers,
    parse_names,
    parse_size,
)
from weftex.cli.terminal import finish
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Make the same from one sample with every method: a page with the pictures, where every pixel comes
from, figures, times and parameters. Slow methods get fast options, and the page says so.\
"""

_EXAMPLES = """\
examples:
  weftex compare brick.png -o compare.html
  weftex compare brick.png --methods quilting,graphcut,near-regular -o compare.html --json
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("compare", _ABOUT, _EXAMPLES)
    add = parser.add_argument
    add("sample", metavar="SAMPLE", help="picture, folder of maps, or sample:NAME")
    add_maps(parser)
    add_map_weights(parser)
    add("-o", "--output", metavar="OUT.html", help="the page to write")
    add("--methods", metavar="A,B,...", help="these only; see 'weftex methods'")
    add("--size", metavar="WxH|N", help="in pixels; default: twice the sample's, at most 512")
    add("--seed", type=int, metavar="N", default=1, help="of all methods; default: 1")
    text = "compare tileable outputs; along both axes or one"
    add("--tileable", nargs="?", const="xy", choices=("xy", "x", "y"), metavar="x|y", help=text)
    add("--threads", type=int, metavar="N", help="use at most so many")
    add("--json", action="store_true", help="print the figures as JSON")
    add_tileable_sample(parser)
    add_turn(parser)
    add_limits(parser)
    args = parser.parse(argv)
    if args.output is None and not args.json:
        raise InvalidInputError("nothing to do; give -o compare.html, --json, or both")
    size = None if args.size is None else parse_size(args.size, args.allow_huge)
    names = None if args.methods is None else parse_names(args.methods)
    check_numbers(args)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.io.pictures import check_output
        from weftex.tasks.compare import compare

        if args.output is not None:
            check_output(args.output, suffixes=(".html",))
        exemplar = load(args.sample, args, args.maps, tileable=args.tileable_sample)
        found = compare(exemplar, size, methods=names, **settings(args, bar))
        if args.output is not None:
            found.save(outputs.add(args.output))
        if args.json:
            import json

            print(json.dumps(found.as_dict(), indent=1, default=str))
        best, took = found.entries[0], perf_counter() - start
        said = f"compared {len(found.entries)} methods in {took:.1f} s"
        said += f"; the best score has {best.method}" if best.assessment is not None else ""
        return said + (f"; {args.output} shows all" if args.output is not None else "")

    finish(work, args.quiet)
