"""weftex check: check that an image written block by block is complete."""

from __future__ import annotations

from weftex.cli.parser import Parser

_ABOUT = """\
Check that an image written block by block is complete. The exit code is 2 if anything is missing
or damaged.\
"""

_EXAMPLES = """\
examples:
  weftex check plane.tif
  weftex check plane.tif --read
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("check", _ABOUT, _EXAMPLES)
    parser.add_argument(
        "plane", metavar="PLANE", help="image that 'weftex synth' wrote block by block"
    )
    text = "also read all pixels and compare them with their checksums"
    parser.add_argument("--read", action="store_true", help=text)
    args = parser.parse(argv)
    from weftex import planes

    plane = planes.check(args.plane, read=args.read)
    used = plane.definition
    print(
        f"{plane.path} is whole{', as it was written' if args.read else ''}: "
        f"{used.width}x{used.height} with {used.method.slug}, seed {used.seed}"
    )
