"""weftex analyze: say what a sample is like."""

from __future__ import annotations

from weftex.cli.files import load
from weftex.cli.options import Parser, add_huge, add_maps

_EXAMPLES = """\
examples:
  weftex analyze stones.png
  weftex analyze stone_wall/ --json
  weftex analyze brick.png --overlay lattice.png
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("analyze", "Say what a sample is like, and what windows follow.", _EXAMPLES)
    parser.add_argument("sample", metavar="SAMPLE", help="picture, folder of maps, or sample:NAME")
    add_maps(parser)
    parser.add_argument("--json", action="store_true", help="print JSON")
    text = "write the sample with its lattice drawn over it"
    parser.add_argument("--overlay", metavar="FILE", help=text)
    add_huge(parser)
    args = parser.parse(argv)
    from weftex.io.pictures import check_output, write_image
    from weftex.tasks.analyze import analyze

    if args.overlay is not None:
        check_output(args.overlay)
    exemplar = load(args.sample, args, args.maps)[0]
    found = analyze(exemplar)
    if args.overlay is not None:
        from weftex.analysis.overlay import draw_lattice

        write_image(args.overlay, draw_lattice(exemplar, found.lattice))
    if args.json:
        import json

        print(json.dumps(found.as_dict(), indent=1))
    else:
        print(found)
