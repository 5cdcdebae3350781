"""Tiled BigTIFF, whose every tile has its place in the file from the beginning.

Tiles are not compressed, so their offsets follow from the size: any process writes any block, in
any order, without a word to others, and what was written before a run was killed stays. The levels
are further directories of the file, as GDAL, QGIS and libvips expect overviews. OpenImageIO and
libtiff write directories at the end and cannot go on with a file that was cut off.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from fractions import Fraction
from functools import cached_property
from typing import IO, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from weftex.errors import FileError, InvalidInputError
from weftex.io.npz import open_regular
from weftex.io.temporary import write_through
from weftex.planes.layout import Layout, Place, Window, named

_MOST_SIDE = 2**20
_MOST_TILES = 2**22  # tables of tiles, of 12 bytes each, are made in memory
_PAGE = 2**16  # tiles begin at pages, which no two writers share
_SHORT, _LONG, _RATIONAL, _UNDEFINED, _LONG8 = 3, 4, 5, 7, 16
_CODES = {_SHORT: "<u2", _LONG: "<u4", _RATIONAL: "<u8", _UNDEFINED: "u1", _LONG8: "<u8"}
MOST_DENSITY = 2**31  # pixels per meter
_RGB = 3
KEPT = "finished blocks are kept; repeat the command to continue"
REPAIR = "'weftex check --repair' makes it again"


class TiffStore:
    """A tiled BigTIFF with overviews; its blocks are written in any order, each by one writer."""

    smallest: ClassVar[int] = 512  #: The last level has at most this number of pixels a side.

    def __init__(self, path: str, layout: Layout) -> None:
        self.path, self.layout = path, layout
        self.levels = layout.levels(self.smallest)
        longest = max(layout.height, layout.width)
        if longest > _MOST_SIDE:
            raise InvalidInputError(
                f"{path}: '.tif' holds at most {_MOST_SIDE} pixels a side, not {longest}"
            )
        rows, columns = self._tiles(0)
        if rows * columns > _MOST_TILES:  # their tables would be larger than they should be
            raise InvalidInputError(
                f"{path}: '.tif' holds at most {_MOST_TILES} tiles, not {rows * columns} of "
                f"{layout.tile} pixels a side; use a larger --block"
            )

    @property
    def size(self) -> int:
        """Bytes of the file."""
        return self._starts[-1]

    def create(self) -> None:
        """Write everything but the pixels, also where it is damaged; blocks stay as they are."""
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0)
        with open(os.open(self.path, flags, 0o666), "r+b") as file:
            for start, data in self._frame():
                file.seek(start)
                file.write(data)
            file.truncate(self.size)
        synced(self.path)

    def is_sound(self) -> bool:
        """Whether the file has its size, and is undamaged beside its pixels."""
        try:
            with self._opened() as file:
                for start, data in self._frame():
                    file.seek(start)
                    if file.read(len(data)) != data:
                        return False
        except OSError:
            return False
        return True

    def write(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write a block; when this returns it is on the disk."""
        try:
            self.put(place, pixels)
        except OSError as error:
            why = error.strerror or error
            raise FileError(f"{self.path}: cannot write: {why}; {KEPT}") from None

    def put(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write the tiles of a block, a row of them at a time."""
        level, tile = place[0], self.layout.tile
        top, left, height, width = self.layout.window(place)
        across = -(-width // tile)
        with open(self.path, "r+b") as file:
            for line in range(0, height, tile):
                rows = min(tile, height - line)
                strip = np.zeros((tile, across * tile, self._bands), self._dtype)
                strip[:rows, :width] = pixels[line : line + rows].reshape(rows, width, -1)
                tiles = strip.reshape(tile, across, tile, -1).swapaxes(0, 1)
                file.seek(self._offset(level, top + line, left))
                file.write(np.ascontiguousarray(tiles).data)
            file.flush()
            os.fsync(file.fileno())

    def read(self, level: int, window: Window) -> NDArray[Any]:
        """Return the pixels of a window, read a row of tiles at a time; `FileError` if damaged."""
        top, left, height, width = window
        tile, bands = self.layout.tile, self._bands
        out = np.empty((height, width, bands), self.layout.dtype)
        first = left // tile
        across = -(-(left + width) // tile) - first
        try:
            with self._opened() as file:
                for line in range(top // tile * tile, top + height, tile):
                    file.seek(self._offset(level, line, first * tile))
                    data = np.frombuffer(file.read(across * self._tile_bytes), self._dtype)
                    strip = data.reshape(across, tile, tile, bands).swapaxes(0, 1)
                    strip = strip.reshape(tile, -1, bands)[:, left - first * tile :][:, :width]
                    start, end = max(line, top), min(line + tile, top + height)
                    out[start - top : end - top] = strip[start - line : end - line]
        except (OSError, ValueError) as error:  # NumPy raises those where data are missing
            why = " ".join(str(error).split())
            raise FileError(f"{self.path}: level {level} is damaged: {why}; {REPAIR}") from None
        return out if self.layout.channels else out[..., 0]

    def reduced(self, place: Place, sums: Mapping[Place, int]) -> NDArray[Any]:
        """Return a block of a level above 0, made of blocks that must have these check sums."""
        window = self.layout.window_below(place)
        pixels = self.read(place[0] - 1, window)
        for below in self.layout.below(place):
            top, left, height, width = self.layout.window(below)
            y, x = top - window[0], left - window[1]
            if check_sum(pixels[y : y + height, x : x + width]) != sums[below]:
                raise FileError(f"{self.path}: {named(below)} is damaged; {REPAIR}")
        return np.asarray(self.layout.mixing.halved(pixels))

    def sum_of(self, place: Place) -> int:
        """Return the check sum of a block as it is on the disk; -1 if it cannot be read."""
        try:
            return check_sum(self.read(place[0], self.layout.window(place)))
        except FileError:
            return -1

    def _opened(self) -> IO[bytes]:
        """Return the open file; OSError unless it is a regular one of its size."""
        file = open_regular(self.path, self.size)
        if os.fstat(file.fileno()).st_size < self.size:
            file.close()
            raise OSError("it was cut off")
        return file

    def _frame(self) -> Iterator[tuple[int, bytes]]:
        """Give the places and bytes of header and directories; blocks fill the rest."""
        # Little-endian, version 43, offsets of 8 bytes.
        yield 0, struct.pack("<2sHHHQ", b"II", 43, 8, 0, 16)
        for level in range(self.levels):
            yield self._heads[level], self._directory(level)

    @property
    def _bands(self) -> int:
        return max(self.layout.channels, 1)

    @property
    def _dtype(self) -> np.dtype[Any]:
        return np.dtype(self.layout.dtype).newbyteorder("<")

    @property
    def _tile_bytes(self) -> int:
        return self.layout.tile**2 * self.layout.pixel_bytes

    def _tiles(self, level: int) -> tuple[int, int]:
        """Rows and columns of tiles."""
        height, width = self.layout.shape(level)
        return -(-height // self.layout.tile), -(-width // self.layout.tile)

    def _offset(self, level: int, top: int, left: int) -> int:
        """Where the tile that begins at a pixel begins in the file."""
        row, column = top // self.layout.tile, left // self.layout.tile
        return self._starts[level] + (row * self._tiles(level)[1] + column) * self._tile_bytes

    @cached_property
    def _heads(self) -> list[int]:
        """Where directories begin, and where the last one ends."""
        heads = [16]
        for level in range(self.levels):
            sizes = (len(data) for _, _, data in self._tags(level, 0))
            heads.append(heads[-1] + 16 + sum(20 + -(-size // 8) * 8 for size in sizes))
        return heads

    @cached_property
    def _starts(self) -> list[int]:
        """Where the tiles of levels begin, and where the last ones end."""
        starts = [-(-self._heads[-1] // _PAGE) * _PAGE]
        for level in range(self.levels):
            rows, columns = self._tiles(level)
            starts.append(starts[-1] + rows * columns * self._tile_bytes)
        return starts

    def _tags(self, level: int, start: int) -> list[tuple[int, int, bytes]]:
        """Number, type and values of each tag, in the order of their numbers."""
        layout = self.layout
        height, width = layout.shape(level)
        bands, kind = self._bands, np.dtype(layout.dtype)
        colors = _RGB if bands - layout.alpha >= _RGB else 1
        rows, columns = self._tiles(level)
        offsets = start + np.arange(rows * columns, dtype=np.uint64) * self._tile_bytes
        extra = [0] * (bands - colors)
        if layout.alpha:
            extra[-1] = 2  # straight
        density = _rational((layout.density or 0) / 100 / 2**level)
        values: list[tuple[int, int, Any]] = [
            (254, _LONG, [int(level > 0)]),  # a smaller version of another picture
            (256, _LONG, [width]),
            (257, _LONG, [height]),
            (258, _SHORT, [8 * kind.itemsize] * bands),
            (259, _SHORT, [1]),  # not compressed
            (262, _SHORT, [2 if colors == _RGB else 1]),
            (277, _SHORT, [bands]),
            (282, _RATIONAL, density),
            (283, _RATIONAL, density),
            (284, _SHORT, [1]),  # channels of a pixel side by side
            (296, _SHORT, [3] if density else []),  # per centimeter
            (322, _LONG, [layout.tile]),
            (323, _LONG, [layout.tile]),
            (324, _LONG8, offsets),
            (325, _LONG, np.full(rows * columns, self._tile_bytes)),
            (338, _SHORT, extra),
            (339, _SHORT, [3 if kind.kind == "f" else 1] * bands),
            (34675, _UNDEFINED, np.frombuffer(layout.icc or b"", np.uint8)),
        ]
        return [
            (number, code, np.asarray(value).astype(_CODES[code]).tobytes())
            for number, code, value in values
            if len(value)
        ]

    def _directory(self, level: int) -> bytes:
        """A directory and the values of its tags, which follow it."""
        tags = self._tags(level, self._starts[level])
        last = level + 1 == self.levels
        place = self._heads[level] + 16 + 20 * len(tags)
        entries, values = struct.pack("<Q", len(tags)), b""
        for number, code, data in tags:
            count = len(data) // np.dtype(_CODES[code]).itemsize
            entries += struct.pack("<HHQ", number, code, count)
            padded = data + bytes(-len(data) % 8)
            if len(data) <= 8:
                entries += padded
                values += bytes(8)  # so that sizes do not depend on what fits
            else:
                entries += struct.pack("<Q", place + len(values))
                values += padded
        return entries + struct.pack("<Q", 0 if last else self._heads[level + 1]) + values


def _rational(value: float) -> list[int]:
    """Return a positive number as a RATIONAL, whose numerator comes first; nothing for 0."""
    found = Fraction(value).limit_denominator(int(2**31 / max(value, 1)))
    return [found.numerator + (found.denominator << 32)] if value else []


def synced(path: str) -> None:
    """Wait until a file or folder, and its name, are on the disk."""
    if os.path.isfile(path):
        write_through(path)
    for folder in filter(os.path.isdir, (path, os.path.dirname(os.path.abspath(path)))):
        with suppress(OSError):  # Windows opens no folders, and some file systems sync none
            write_through(folder, os.O_RDONLY)


def check_sum(pixels: NDArray[Any]) -> int:
    """Return the check sum of pixels that journals have."""
    return zlib.crc32(np.ascontiguousarray(pixels).data)
