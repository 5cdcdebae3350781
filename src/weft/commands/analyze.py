"""weft analyze: say what a sample is like."""

from __future__ import annotations

from weft.options import Parser, add_huge
from weft.pictures import load

_EXAMPLES = """\
examples:
  weft analyze stones.png
  weft analyze stone_wall/ --json
  weft analyze brick.png --overlay lattice.png
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("analyze", "Say what a sample is like, and what windows follow.", _EXAMPLES)
    parser.add_argument("sample", metavar="SAMPLE", help="picture, folder of maps, or sample:NAME")
    parser.add_argument("--json", action="store_true", help="print JSON")
    text = "write the sample with its lattice drawn over it"
    parser.add_argument("--overlay", metavar="FILE", help=text)
    add_huge(parser)
    args = parser.parse(argv)
    from weft import io
    from weft.tasks.analyze import analyze

    if args.overlay is not None:
        io.check_output(args.overlay)
    exemplar = load(args.sample, args)[0]
    found = analyze(exemplar)
    if args.overlay is not None:
        from weft.analysis.overlay import draw_lattice

        io.write_image(args.overlay, draw_lattice(exemplar, found.lattice))
    if args.json:
        import json

        print(json.dumps(found.as_dict(), indent=1))
    else:
        print(found)
