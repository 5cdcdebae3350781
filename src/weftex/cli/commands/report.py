"""Measure how well a result matches its sample.

Prints a line for each measure, or writes a page with images, pictures of the flaws, and all
measures.

examples:
  weftex report brick.png wall.png -o report.html
  weftex report brick.png wall.png --source wall.npz -o report.html
  weftex report brick.png tile.png --tileable --json
  weftex report stone_wall/ big/ -o report.html      a folder of maps and the result from it
"""

from __future__ import annotations

from weftex.cli.files import load_sample
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, print_json
from weftex.cli.terminal import run as run_work
from weftex.io.pictures import check_output
from weftex.pages.reports import Report, report
from weftex.recipe import MATERIAL
from weftex.recipe.declared import TILEABLE


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("report", __doc__)
    add = parser.add_argument
    add("sample", metavar="SAMPLE", help="image, folder of maps, or sample:NAME")
    parser.take(MATERIAL["maps"])
    add("result", metavar="RESULT", help="result from that sample: an image, or a folder of maps")
    text = "file from --save-source; the page then shows the source of every pixel and the "
    add("--source", metavar="F.npz", help=text + "parameters")
    text = "also check the border, along both axes or only x or y; default: as saved in --source"
    parser.take(TILEABLE, help=text, dest="tileable")
    add("-o", "--output", metavar="OUT.html", help="page to write")
    add("--json", action="store_true", help="print the scores as JSON")
    parser.share("--allow-huge")
    args = parser.parse(argv)
    if args.output is not None:
        check_output(args.output, suffixes=(".html",))
    axes = None if args.tileable is None else TILEABLE.read(args.tileable)
    wrap = None if axes is None else (axes in (True, "y"), axes in (True, "x"))

    def work(bar: Bar, outputs: Outputs) -> Report:
        sample, result = load_sample(args.sample, args, "maps"), load_sample(args.result, args)
        return report(sample, result, args.source, tileable=wrap)

    found, _ = run_work(work, False)
    if args.output is not None:
        found.save(args.output)
    if args.json:
        print_json(found.as_dict())
    else:
        print(found.verdict() if args.output is not None else found.told())
