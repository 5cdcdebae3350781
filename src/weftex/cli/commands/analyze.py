"""Measure the scale, the lattice and the evenness of a sample, and recommend window sizes.

examples:
  weftex analyze stones.png
  weftex analyze stone_wall/ --json
  weftex analyze brick.png --overlay lattice.png
  weftex analyze brick.png --overlay lattice.png --lattice 63,42,63,-42
"""

from __future__ import annotations

from weftex.analysis.canvas_lattice import checked_lattice
from weftex.analysis.overlay import draw_lattice
from weftex.cli.files import load_sample
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, print_json
from weftex.cli.terminal import run as run_work
from weftex.exemplar import Exemplar
from weftex.io.pictures import check_output, write_image
from weftex.recipe import MATERIAL
from weftex.tasks.analyze import Analysis, analyze


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("analyze", __doc__)
    add = parser.add_argument
    add("sample", metavar="SAMPLE", help="image, folder of maps, or sample:NAME")
    parser.take(MATERIAL["maps"])
    add("--json", action="store_true", help="print JSON")
    add("--overlay", metavar="FILE", help="write the sample with its lattice drawn over it")
    text = "also rate and draw these lattice vectors; rows P apart: 0,P,1,0"
    add("--lattice", metavar="X1,Y1,X2,Y2", help=text)
    parser.share("--allow-huge")
    args = parser.parse(argv)
    if args.overlay is not None:
        check_output(args.overlay)

    def work(bar: Bar, outputs: Outputs) -> tuple[Exemplar, Analysis]:
        exemplar = load_sample(args.sample, args, "maps")
        return exemplar, analyze(exemplar, lattice=args.lattice)

    (exemplar, found), _ = run_work(work, False)
    if args.overlay is not None:
        lattice = found.lattice if args.lattice is None else checked_lattice(args.lattice, exemplar)
        write_image(args.overlay, draw_lattice(exemplar, lattice))
    if args.json:
        print_json(found.as_dict())
    else:
        print(found)
