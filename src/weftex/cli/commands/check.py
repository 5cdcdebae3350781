"""weftex check: say whether a picture that is written block by block is all there."""

from __future__ import annotations

from weftex.cli.options import Parser
from weftex.errors import FileError

_ABOUT = """\
Say whether a picture that is written block by block is all there, and which parts are not. The exit
code is 2 if anything is missing.\
"""

_EXAMPLES = """\
examples:
  weftex check plane.zarr
  weftex check plane.tif --read
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("check", _ABOUT, _EXAMPLES)
    parser.add_argument("plane", metavar="PLANE", help="what 'weftex synth' writes block by block")
    text = "read all pixels, too, and compare them with the check sums of what was written"
    parser.add_argument("--read", action="store_true", help=text)
    args = parser.parse(argv)
    from weftex.tasks.opened import open_plane

    plane = open_plane(args.plane)
    missing = plane.missing()
    if missing:
        parts = [f"{part} ({count} blocks)" for part, count in plane.parts().items()]
        below = sum(place[0] == 0 for place in missing)
        what = f"{below} blocks are missing"
        if parts:
            what += f"; parts that are not done: {', '.join(parts)}"
        if not below:
            what = "only smaller versions are missing; the same command without --part makes them"
        raise FileError(f"{args.plane} is not whole: {what}")
    wrong = plane.unlike() if args.read else []
    if wrong:
        raise FileError(
            f"{args.plane}: {len(wrong)} blocks are not what was written, the first at level, row, "
            f"column {wrong[0]}; make it again with --restart"
        )
    size, used = f"{plane.recipe.width}x{plane.recipe.height}", plane.recipe
    read = ", as it was written" if args.read else ""
    print(f"{args.plane} is whole{read}: {size} with {used.method.slug}, seed {used.seed}")
