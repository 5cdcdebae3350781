"""What every store of a picture does."""

from __future__ import annotations

import os
import stat
import zlib
from abc import ABC, abstractmethod
from contextlib import suppress
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from weftex.errors import FileError
from weftex.io.formats import show
from weftex.io.regular import open_regular
from weftex.io.temporary import write_through
from weftex.planes.layout import blocks_below, children, halved

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from weftex.planes.layout import Layout, Place, Window

_MARGIN = 2**16
REPAIR = "'weftex check --repair' makes it again"


class Piece(NamedTuple):
    """Bytes of a file that hold no pixels, such as a header; `size` is the size of the file."""

    path: str
    start: int
    data: bytes
    size: int

    def is_there(self) -> bool:
        """Whether the file has the bytes, and the size."""
        try:
            with open_regular(self.path) as file:
                file.seek(self.start)
                good = file.read(len(self.data)) == self.data
                return good and os.fstat(file.fileno()).st_size == self.size
        except OSError:
            return False


class Store(ABC):
    """A picture on disk, of which blocks are written in any order, each by one writer.

    Parameters
    ----------
    path : str
    layout : Layout
    about : mapping
        What made the pixels, in plain values; a format may keep it.

    Raises
    ------
    InvalidInputError
        If the format cannot hold such pixels.
    """

    #: The last level is at most so many pixels high and wide.
    smallest: ClassVar[int] = 512

    def __init__(self, path: str, layout: Layout, about: Mapping[str, Any] | None = None) -> None:
        self.path, self.layout, self.about = path, layout, dict(about or {})
        self.levels = layout.levels(self.smallest)
        self.check()

    def check(self) -> None:  # noqa: B027
        """Raise unless the format holds such pixels."""

    @abstractmethod
    def frame(self) -> Iterator[Piece]:
        """Give everything but the pixels, the outermost file last."""

    @abstractmethod
    def files(self, place: Place) -> Iterable[str]:
        """Give the files that hold a block."""

    @abstractmethod
    def put(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write a block; when this returns it is on the disk."""

    @abstractmethod
    def get(self, level: int, window: Window) -> NDArray[Any]:
        """Return the pixels of a window."""

    @property
    def roots(self) -> tuple[str, ...]:
        """The files and folders that everything is in."""
        return (self.path,)

    @property
    def grid(self) -> tuple[int, int, int, int]:
        """Number of levels, height and width of level 0, and side of what a file holds."""
        return self.levels, self.layout.height, self.layout.width, self.layout.block

    @property
    def most_bytes(self) -> int:
        """That it may take on the disk."""
        sizes = [self.layout.shape(level) for level in range(self.levels)]
        return sum(height * width for height, width in sizes) * self.layout.bytes

    @property
    def most_of_file(self) -> int:
        """Number of bytes that a file of a block may have: all pixels as they are, and a margin."""
        pixels = self.layout.block**2 * self.layout.bytes
        return pixels + pixels // 64 + len(self.layout.icc or b"") + _MARGIN

    def create(self) -> None:
        """Write everything but the pixels, also where it is damaged; blocks stay as they are."""
        for path, start, data, size in self.frame():
            os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
            number = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666)
            with open(number, "r+b") as file:
                file.seek(start)
                file.write(data)
                file.truncate(size)
            synced(path)

    def flaws(self) -> list[str]:
        """Return the files that are missing, or damaged beside their pixels."""
        return list(dict.fromkeys(piece.path for piece in self.frame() if not piece.is_there()))

    def lacks(self, place: Place) -> bool:
        """Whether a file of a block is missing, too long, or empty, which Zarr reads as zeros."""
        try:
            found = [*map(os.stat, self.files(place))]
        except OSError:
            return True
        most = self.most_of_file
        return not all(stat.S_ISREG(one.st_mode) and 0 < one.st_size <= most for one in found)

    def write(self, place: Place, pixels: NDArray[Any]) -> None:
        """`put`, with errors of ours."""
        try:
            self.put(place, pixels)
        except FileError:
            raise
        except OSError as error:
            raise FileError(
                f"{show(self.path)}: cannot write: {error.strerror or error}; blocks that are done "
                "are kept, and the same command continues"
            ) from None

    def read(self, level: int, window: Window) -> NDArray[Any]:
        """Return the pixels of a window.

        Raises
        ------
        FileError
            If some are missing or damaged.
        """
        top, left, height, width = window
        side = self.layout.block
        for row in range(top // side, -(-(top + height) // side)):
            for column in range(left // side, -(-(left + width) // side)):
                if self.lacks((level, row, column)):
                    what = f"level {level}, row {row}, column {column}"
                    why = "is missing, or its file is too long"
                    raise FileError(f"{show(self.path)}: the block {what} {why}; {REPAIR}")
        try:
            return self.get(level, window)
        except (FileError, MemoryError):
            raise
        except Exception as error:  # damaged files raise errors of many kinds
            why = " ".join(str(error).split()) or type(error).__name__
            raise FileError(
                f"{show(self.path)}: level {level} is damaged: {why}; {REPAIR}"
            ) from None

    def reduced(self, place: Place, sums: Mapping[Place, int]) -> NDArray[Any]:
        """Return a block of a level above 0, made from blocks that have these check sums.

        Raises
        ------
        FileError
            If a block of the level below is missing or damaged.
        """
        window = children(self.layout, place)
        pixels = self.read(place[0] - 1, window)
        for below in blocks_below(self.layout, place):
            top, left, height, width = self.layout.window(below)
            y, x = top - window[0], left - window[1]
            if check_sum(pixels[y : y + height, x : x + width]) != sums[below]:
                what = f"level {below[0]}, row {below[1]}, column {below[2]}"
                raise FileError(f"{show(self.path)}: the block {what} is damaged; {REPAIR}")
        return halved(pixels, self.layout.mixing)


def check_sum(pixels: NDArray[Any]) -> int:
    """Return the check sum of pixels that journals have."""
    return zlib.crc32(np.ascontiguousarray(pixels).data)


def synced(path: str) -> None:
    """Wait until a file or folder, and its name, are on the disk."""
    if os.path.isfile(path):
        write_through(path)
    for folder in filter(os.path.isdir, (path, os.path.dirname(os.path.abspath(path)))):
        with suppress(OSError):  # Windows opens no folders, and some file systems sync none
            number = os.open(folder, os.O_RDONLY)
            try:
                os.fsync(number)
            finally:
                os.close(number)
