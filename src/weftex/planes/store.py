"""A picture on disk, written block by block: what all formats have in common."""

from __future__ import annotations

import os
import stat
import zlib
from abc import ABC, abstractmethod
from contextlib import suppress
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from weftex.errors import FileError
from weftex.io.npz import open_regular
from weftex.planes.layout import named

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from weftex.planes.layout import Layout, Place, Window

_MARGIN = 2**16
KEPT = "blocks that are done are kept, and the same command continues"
REPAIR = "'weftex check --repair' makes it again"


class FilePart(NamedTuple):
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

    `about` says in plain values what made the pixels; a format may keep it.
    """

    smallest: ClassVar[int] = 512  #: The last level has at most this number of pixels a side.

    def __init__(self, path: str, layout: Layout, about: Mapping[str, Any]) -> None:
        self.path, self.layout, self.about = path, layout, about
        self.levels = layout.levels(self.smallest)
        self.check()

    @abstractmethod
    def check(self) -> None:
        """Raise `InvalidInputError` unless the format holds such pixels."""

    @abstractmethod
    def frame(self) -> Iterator[FilePart]:
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
    def grid(self) -> list[int]:
        """Number of levels, height and width of level 0, and side of what a file holds."""
        return [self.levels, self.layout.height, self.layout.width, self.layout.block]

    @property
    def most_bytes(self) -> int:
        """Bytes that it may take on the disk."""
        sizes = [self.layout.shape(level) for level in range(self.levels)]
        return sum(height * width for height, width in sizes) * self.layout.pixel_bytes

    @property
    def most_of_file(self) -> int:
        """Bytes that the file of a block may have: all pixels as they are, and a margin."""
        pixels = self.layout.block**2 * self.layout.pixel_bytes
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
        """`put`, with a `FileError` of one line."""
        try:
            self.put(place, pixels)
        except FileError:
            raise
        except OSError as error:
            why = error.strerror or error
            raise FileError(f"{self.path}: cannot write: {why}; {KEPT}") from None

    def read(self, level: int, window: Window) -> NDArray[Any]:
        """Return the pixels of a window, or raise `FileError` if some are missing or damaged."""
        top, left, height, width = window
        side = self.layout.block
        for row in range(top // side, -(-(top + height) // side)):
            for column in range(left // side, -(-(left + width) // side)):
                if self.lacks((level, row, column)):
                    what = named((level, row, column))
                    why = "is missing, or its file is too long"
                    raise FileError(f"{self.path}: {what} {why}; {REPAIR}")
        try:
            return self.get(level, window)
        except (FileError, MemoryError):
            raise
        except Exception as error:  # damaged files raise errors of many kinds
            why = " ".join(str(error).split()) or type(error).__name__
            raise FileError(f"{self.path}: level {level} is damaged: {why}; {REPAIR}") from None

    def reduced(self, place: Place, sums: Mapping[Place, int]) -> NDArray[Any]:
        """Return a block of a level above 0, made of blocks that must have these check sums."""
        window = self.layout.window_below(place)
        pixels = self.read(place[0] - 1, window)
        for below in self.layout.below(place):
            top, left, height, width = self.layout.window(below)
            y, x = top - window[0], left - window[1]
            if check_sum(pixels[y : y + height, x : x + width]) != sums[below]:
                raise FileError(f"{self.path}: {named(below)} is damaged; {REPAIR}")
        halved: NDArray[Any] = self.layout.mixing.halved(pixels)
        return halved

    def sum_of(self, place: Place) -> int:
        """Return the check sum of a block as it is on the disk; -1 if it cannot be read."""
        try:
            return check_sum(self.read(place[0], self.layout.window(place)))
        except FileError:
            return -1


def check_sum(pixels: NDArray[Any]) -> int:
    """Return the check sum of pixels that journals have."""
    return zlib.crc32(np.ascontiguousarray(pixels).data)


def synced(path: str) -> None:
    """Wait until a file or folder, and its name, are on the disk."""
    if os.path.isfile(path):
        _sync(path, os.O_RDWR)
    for folder in filter(os.path.isdir, (path, os.path.dirname(os.path.abspath(path)))):
        with suppress(OSError):  # Windows opens no folders, and some file systems sync none
            _sync(folder, os.O_RDONLY)


def _sync(path: str, flags: int) -> None:
    number = os.open(path, flags)
    try:
        os.fsync(number)
    finally:
        os.close(number)
