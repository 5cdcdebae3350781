"""weftex check: check that an image written block by block is complete."""

from __future__ import annotations

from weftex.cli.parser import Parser

_ABOUT = """\
Check that an image written block by block is complete, and list the parts that are missing. The
exit code is 2 if anything is missing or damaged.\
"""

_EXAMPLES = """\
examples:
  weftex check plane.tif
  weftex check plane.tif --read
  weftex check plane.tif --repair
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("check", _ABOUT, _EXAMPLES)
    parser.add_argument(
        "plane", metavar="PLANE", help="image that 'weftex synth' wrote block by block"
    )
    text = "also read all pixels and compare them with their checksums"
    parser.add_argument("--read", action="store_true", help=text)
    text = "read all pixels, and make damaged or missing blocks and files again"
    parser.add_argument("--repair", action="store_true", help=text)
    args = parser.parse(argv)
    from weftex import planes

    made = planes.repair(args.plane).made if args.repair else 0
    plane = planes.check(args.plane, read=args.read or args.repair)
    used = plane.definition
    read = ", all checksums match" if args.read or args.repair else ""
    again = f"; {made} blocks were made again" if args.repair else ""
    print(
        f"{plane.path} is complete{read}: {used.width}x{used.height} with {used.method.slug}, "
        f"seed {used.seed}{again}"
    )
