"""weftex prepare: straighten a photo and even its lighting."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.files import open_sample
from weftex.cli.options import add_limits, add_mending, add_output, add_sets
from weftex.cli.parser import Parser
from weftex.cli.terminal import finish
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from weftex.cli.terminal import Bar, Outputs

_ABOUT = """\
Straighten a photo and even its lighting, to get a sample for any other command. 'weftex synth' has
the same options.\
"""

_EXAMPLES = """\
examples:
  weftex prepare photo.jpg -o brick.png --straighten --even-light
  weftex prepare photo.jpg -o brick.png --straighten 12,40,801,95,790,620,20,700   by four corners
  weftex prepare photo.jpg -o brick.png --straighten 99,3,49,36.7                  by a lattice
  weftex prepare stone_wall/ -o straight/ --straighten                            a folder of maps
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("prepare", _ABOUT, _EXAMPLES)
    parser.add_argument("sample", metavar="PHOTO", help="image, folder of maps, or sample:NAME")
    add_sets(parser)
    add_output(parser)
    add_mending(parser)
    add_limits(parser)
    args = parser.parse(argv)
    if args.straighten is None and args.even_light is None:
        raise InvalidInputError("nothing to do; give --straighten, --even-light, or both")
    args.save_source = None

    def work(bar: Bar, outputs: Outputs) -> str:
        exemplar, plan = open_sample(args.sample, args, outputs)
        pixels = exemplar.maps | {plan.material.main: exemplar.pixels}
        plan.write(pixels.__getitem__, outputs)
        height, width = exemplar.shape
        took = perf_counter() - start
        return f"{plan.told}prepared {width}x{height} {args.output} in {took:.2f} s"

    finish(work, args.quiet)
