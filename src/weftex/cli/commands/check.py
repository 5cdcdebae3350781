"""weftex check: check that an image written block by block is complete."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weftex.cli.parser import Parser
from weftex.errors import FileError
from weftex.io.formats import show

if TYPE_CHECKING:
    from weftex.planes.opened import PlaneFile

_MEND = "--repair makes it again"
_SHOWN = 8  # parts

_ABOUT = """\
Check that an image written block by block is complete, and list the parts that are missing. The
exit code is 2 if anything is missing or damaged.\
"""

_EXAMPLES = """\
examples:
  weftex check plane.zarr
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
    from weftex.planes.opened import open_plane

    plane = open_plane(args.plane)
    made = 0
    if args.repair:
        from weftex.planes.writing import write_plane

        made = write_plane(plane.job, repair=True).made
        plane = open_plane(args.plane)
    _refuse(plane, read=args.read or args.repair)
    size, used = f"{plane.recipe.width}x{plane.recipe.height}", plane.recipe
    read = ", as it was written" if args.read or args.repair else ""
    again = f"; {made} blocks were made again" if args.repair else ""
    print(f"{plane.path} is whole{read}: {size} with {used.method.slug}, seed {used.seed}{again}")


def _refuse(plane: PlaneFile, *, read: bool) -> None:
    """Raise `FileError` if anything is missing or damaged."""
    path, job = show(plane.path), plane.job
    if flaws := job.flaws():
        more = f", and {len(flaws) - 1} more files" if flaws[1:] else ""
        raise FileError(f"{path} is not whole: {show(flaws[0])}{more}: missing or damaged; {_MEND}")
    if plane.missing():
        below = job.left_below(plane.done)
        parts = [f"{part} ({count} blocks)" for part, count in plane.parts().items()]
        what = f"{below} blocks are missing"
        if parts:
            more = f" and {len(parts) - _SHOWN} more" if len(parts) > _SHOWN else ""
            what += f"; parts that are not done: {', '.join(parts[:_SHOWN])}{more}"
        if not below:
            what = "only smaller versions are missing; the same command without --part makes them"
        raise FileError(f"{path} is not whole: {what}")
    for places, what in (
        (job.lost(plane.done), "have no file, or one that is too long"),
        (job.damaged(plane.done) if read else (), "are not what was written"),
    ):
        if wrong := [*places]:
            raise FileError(
                f"{path}: {len(wrong)} blocks {what}, the first at level, row, column "
                f"{min(wrong)}; {_MEND}"
            )
