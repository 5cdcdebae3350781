"""weftex analyze: measure what matters for synthesis from a sample."""

from __future__ import annotations

from weftex.cli.files import load_sample
from weftex.cli.parser import Parser
from weftex.cli.terminal import print_json
from weftex.recipe import MATERIAL

_ABOUT = """\
Measure the scale, the lattice and the evenness of a sample, and recommend window sizes.\
"""

_EXAMPLES = """\
examples:
  weftex analyze stones.png
  weftex analyze stone_wall/ --json
  weftex analyze brick.png --overlay lattice.png
  weftex analyze brick.png --goodness height --runners-up 3
  weftex analyze brick.png --overlay lattice.png --lattice 63,42,63,-42
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("analyze", _ABOUT, _EXAMPLES)
    add = parser.add_argument
    add("sample", metavar="SAMPLE", help="image, folder of maps, or sample:NAME")
    parser.take(MATERIAL["maps"])
    add("--json", action="store_true", help="print JSON")
    add("--overlay", metavar="FILE", help="write the sample with its lattice drawn over it")
    text = "also rate and draw these lattice vectors; rows P apart: 0,P,1,0"
    add("--lattice", metavar="X1,Y1,X2,Y2", help=text)
    text = "number of alternative lattices to list, up to 24; --lattice draws one; default: 3"
    add("--runners-up", type=int, default=3, metavar="N", help=text)
    text = "ranking of lattices: contrast or height (the paper's); default: contrast"
    add("--goodness", default="contrast", metavar="NAME", help=text)
    text = "exponent of eq. 3.22, from 1 to 4; higher prefers smaller tiles; default: 1.12"
    add("--alpha", type=float, metavar="N", help=text)
    text = "share of a tile that an overlap must contain to count; default: 0.85"
    add("--significant", type=float, metavar="N", help=text)
    text = "write the autocorrelation (GNCC) of the sample; white is 1"
    add("--correlation", metavar="FILE", help=text)
    parser.share("--allow-huge")
    args = parser.parse(argv)
    from weftex.io.pictures import check_output, write_image
    from weftex.tasks.analyze import analyze, given_lattice

    for path in (args.overlay, args.correlation):
        if path is not None:
            check_output(path)
    exemplar = load_sample(args.sample, args, "maps")
    numbers = {name: getattr(args, name) for name in ("alpha", "significant")}
    found = analyze(
        exemplar,
        goodness=args.goodness,
        lattice=args.lattice,
        runners_up=args.runners_up,
        **{name: value for name, value in numbers.items() if value is not None},
    )
    if args.overlay is not None:
        from weftex.analysis.overlay import draw_lattice

        lattice = found.lattice
        if args.lattice is not None:
            lattice = given_lattice(args.lattice, exemplar)
        write_image(args.overlay, draw_lattice(exemplar, lattice))
    if args.correlation is not None:
        from weftex.analysis.overlay import draw_correlation, gncc

        write_image(args.correlation, draw_correlation(gncc(exemplar)))
    if args.json:
        print_json(found.as_dict())
    else:
        print(found)
