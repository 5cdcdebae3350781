"""Whether a plane on disk is whole, and what is made again where it is not."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from typing import TYPE_CHECKING

from weftex.errors import FileError
from weftex.planes.plane_file import open_plane
from weftex.planes.record import Record
from weftex.planes.writing import write_plane

if TYPE_CHECKING:
    import os

    from weftex.planes.plane_file import PlaneFile, Sums
    from weftex.planes.writing import Written
    from weftex.progress import ProgressCallback

_REPAIR = "--repair makes it again"
_SHOWN = 8  # parts


def check(path: str | os.PathLike[str], *, read: bool = False) -> PlaneFile:
    """Return a plane that `weftex.planes.stream` wrote, if it is whole.

    Parameters
    ----------
    path : path
        Its file, or folder.
    read : bool
        Read all pixels, too, and compare them with their check sums.

    Raises
    ------
    FileError
        If a block or a file is missing or damaged, or there is no plane.
    """
    plane = open_plane(path)
    done = plane.done()
    if flaws := plane.flaws():
        more = f", and {len(flaws) - 1} more files" if flaws[1:] else ""
        raise FileError(
            f"{plane.path} is not whole: {flaws[0]}{more}: missing or damaged; {_REPAIR}"
        )
    if plane.missing(done):
        raise FileError(f"{plane.path} is not whole: {_what_is_missing(plane, done)}")
    for places, what in (
        (plane.lost(done), "have no file, or one that is too long"),
        (plane.damaged(done) if read else (), "are not what was written"),
    ):
        if wrong := [*places]:
            raise FileError(
                f"{plane.path}: {len(wrong)} blocks {what}, the first at level, row, column "
                f"{min(wrong)}; {_REPAIR}"
            )
    return plane


def repair(
    path: str | os.PathLike[str],
    *,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Written:
    """Make the blocks and files of a plane again that are missing or damaged; reads all pixels.

    Parameters
    ----------
    path, threads, progress
        As for `weftex.planes.stream`.

    Raises
    ------
    FileError
        If there is no plane, or it cannot be written.
    """
    return write_plane(open_plane(path), repair=True, threads=threads, progress=progress)


def _what_is_missing(plane: PlaneFile, done: Sums) -> str:
    base = plane.definition.base
    columns = base.grid(0)[1]
    made = [row * columns + column for level, row, column in filter(plane.has, done) if level == 0]
    below = base.count(1) - len(made)
    if not below:
        return "only smaller versions are missing; the same command without --part makes them"
    parts = []
    for count in Record(plane.path).parts():
        numbers = [base.part(k, count) for k in range(1, count + 1)]
        there = Counter(bisect_right([one.start for one in numbers], number) for number in made)
        left = {k: len(one) - there[k] for k, one in enumerate(numbers, 1)}
        parts += [f"{k}/{count} ({number} blocks)" for k, number in left.items() if number > 0]
    more = f" and {len(parts) - _SHOWN} more" if len(parts) > _SHOWN else ""
    of_parts = f"; parts that are not done: {', '.join(parts[:_SHOWN])}{more}" if parts else ""
    return f"{below} blocks are missing{of_parts}"
