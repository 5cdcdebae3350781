"""weftex report: say how good a result is."""

from __future__ import annotations

from weftex.cli.files import load
from weftex.cli.options import Parser, add_huge, add_maps
from weftex.errors import InvalidInputError

_ABOUT = """\
Say how good a result is beside its sample: a page with pictures, maps of where it fails, and every
figure beside that of real pictures of the surface.\
"""

_EXAMPLES = """\
examples:
  weftex report brick.png wall.png -o report.html
  weftex report brick.png wall.png --source wall.npz -o report.html
  weftex report brick.png tile.png --tileable --json
  weftex report stone_wall/ big/ -o report.html      a folder of maps, and what was made from it
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("report", _ABOUT, _EXAMPLES)
    add = parser.add_argument
    add("sample", metavar="SAMPLE", help="picture, folder of maps, or sample:NAME")
    add_maps(parser)
    add("result", metavar="RESULT", help="what was made from it: a picture, or a folder of maps")
    text = "what --save-source saved: says what was copied from where, and the parameters"
    add("--source", metavar="F.npz", help=text)
    text = "look at the border as well; x or y for one axis (default: what the source says)"
    add("--tileable", nargs="?", const="xy", choices=("x", "y", "xy"), help=text)
    add("-o", "--output", metavar="OUT.html", help="the page to write")
    add("--json", action="store_true", help="print the figures as JSON")
    add_huge(parser)
    args = parser.parse(argv)
    if args.output is None and not args.json:
        raise InvalidInputError("nothing to do; give -o report.html, --json, or both")
    from weftex.io.pictures import check_output
    from weftex.tasks.report import report as measure

    if args.output is not None:
        check_output(args.output, suffixes=(".html",))
    sample, result = load(args.sample, args, args.maps), load(args.result, args)
    wrap = None if args.tileable is None else ("y" in args.tileable, "x" in args.tileable)
    found = measure(sample, result, args.source, tileable=wrap)
    if args.output is not None:
        found.save(args.output)
    if args.json:
        import json

        print(json.dumps(found.as_dict(), indent=1))
    else:
        print(found.verdict())
