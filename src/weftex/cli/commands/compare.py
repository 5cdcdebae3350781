"""weftex compare: run every method on one sample."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.files import load, settings
from weftex.cli.options import (
    add_limits,
    add_map_weights,
    add_maps,
    add_threads,
    add_tileable_sample,
    add_turn,
    check_numbers,
    parse_names,
    parse_size,
)
from weftex.cli.parser import Parser
from weftex.cli.terminal import finish
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Run every method on one sample, and write a page with the results, the source of every pixel, the
scores, times and parameters. Slow methods run with faster parameters; the page says which.\
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
    add("sample", metavar="SAMPLE", help="image, folder of maps, or sample:NAME")
    add_maps(parser)
    add_map_weights(parser)
    add("-o", "--output", metavar="OUT.html", help="page to write")
    add("--methods", metavar="A,B,...", help="only these methods; see 'weftex methods'")
    add(
        "--size",
        metavar="WxH|N",
        help="output size in pixels; default: twice the sample's, at most 512",
    )
    add("--seed", type=int, metavar="N", default=1, help="random seed of all methods; default: 1")
    text = "compare tileable outputs: along both axes, or only along x or y"
    add("--tileable", nargs="?", const="xy", choices=("xy", "x", "y"), metavar="x|y", help=text)
    add_threads(parser)
    add("--json", action="store_true", help="print the scores and times as JSON")
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
        from weftex.pages.comparisons import compare

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
