"""PNG files, filtered and compressed a band of rows at a time, beside each other in threads.

The work is zlib's; this cuts it into bands. A band is compressed as if nothing was before it and
ends at a whole byte, so the bands of one picture, one after the other, are one stream.
"""

from __future__ import annotations

import binascii
import io
import struct
import zlib
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from weftex.threads import in_turn

__all__ = ["data_url", "png_bytes"]

SIGNATURE = b"\x89PNG\r\n\x1a\n"
_BAND = 2**20  # bytes, about, of the rows that are compressed together
# One filter, the average, at level 1 takes less than half the time of Paeth's at 3, a third of a
# choice among all five; of stones, 4096x4096, the file is 4 % smaller than the former.
_AVERAGE = 3
_LEVEL, _SMALLER = 1, 6
_TRIED = 2**16  # bytes of a band by which its strategy is chosen
_COLOR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}  # by channels; even ones have alpha


def write_png(
    file: IO[bytes],
    pixels: NDArray[Any],
    threads: int = 1,
    level: int = _LEVEL,
    density: float | None = None,
) -> None:
    """Write uint8 or uint16 pixels (H, W, 1 to 4) as PNG; the bytes do not depend on `threads`."""
    height, width, channels = pixels.shape
    kind = 8 * pixels.itemsize, _COLOR_TYPES[channels]
    rows = max(1, _BAND // (width * channels * pixels.itemsize))
    starts = range(0, height, rows)

    def band(k: int) -> tuple[NDArray[np.uint8], bytes]:
        lines = _filtered(pixels, starts[k], min(starts[k] + rows, height))
        packer = _packer(lines.data.cast("B"), level)
        packed = packer.compress(lines.data)
        last = k == len(starts) - 1
        return lines, packed + packer.flush(zlib.Z_FINISH if last else zlib.Z_SYNC_FLUSH)

    file.write(SIGNATURE)
    _write_chunk(file, b"IHDR", struct.pack(">IIBBBBB", width, height, *kind, 0, 0, 0))
    if density is not None:
        _write_chunk(file, b"pHYs", struct.pack(">IIB", round(density), round(density), 1))
    check, done = 1, in_turn(band, range(len(starts)), min(threads, len(starts)))
    for k, (lines, packed) in enumerate(done):
        check = zlib.adler32(lines, check)
        head = b"" if k else b"\x78\x01"
        tail = b"" if k + 1 < len(starts) else struct.pack(">I", check)
        _write_chunk(file, b"IDAT", head + packed + tail)
    _write_chunk(file, b"IEND", b"")


def read_density(path: str) -> float | None:
    """Return the pixels per meter that a whole PNG file states; OpenImageIO rounds them."""
    with open(path, "rb") as file:
        file.seek(len(SIGNATURE))
        while (head := file.read(8))[4:] not in (b"IDAT", b"IEND", b""):
            body = file.read(int.from_bytes(head[:4], "big") + 4)
            if head[4:] == b"pHYs" and len(body) == 13:
                across, down, unit = struct.unpack(">IIB", body[:9])
                return float(across) if unit == 1 and across == down > 0 else None
    return None


def _packer(data: memoryview, level: int) -> Any:
    """A compressor for a band, without string matching where nothing repeats (16-bit noise)."""
    found = []
    for strategy in (zlib.Z_RLE, zlib.Z_FILTERED):
        packer = zlib.compressobj(level, zlib.DEFLATED, -15, 9, strategy)
        tried = packer.copy()
        size = len(tried.compress(data[:_TRIED])) + len(tried.flush())
        found.append((size, packer))
    return min(found, key=lambda each: each[0])[1]


def png_bytes(pixels: NDArray[Any], level: int = _SMALLER) -> bytes:
    """A PNG file in memory; `level` is zlib's, 1 to 9."""
    file = io.BytesIO()
    write_png(file, np.atleast_3d(pixels), level=level)
    return file.getvalue()


def data_url(pixels: NDArray[Any]) -> str:
    """Return a PNG file as a URL, for pages that contain their images."""
    return "data:image/png;base64," + binascii.b2a_base64(png_bytes(pixels), newline=False).decode()


def _filtered(pixels: NDArray[Any], first: int, last: int) -> NDArray[np.uint8]:
    """Rows less the averages of what is left of and above each byte, after the filter's number."""
    rows = pixels[max(first - 1, 0) : last]
    step = rows.shape[2] * rows.itemsize
    lines = rows.astype(rows.dtype.newbyteorder(">")).view(np.uint8).reshape(len(rows), -1)
    if first == 0:
        lines = np.concatenate([np.zeros_like(lines[:1]), lines])
    above, here, left = lines[:-1], lines[1:], np.zeros_like(lines[1:])
    left[:, step:] = here[:, :-step]
    mean = above ^ left
    mean >>= 1
    left &= above
    mean += left  # which is half of above + left, and needs no ninth bit
    found = np.empty((len(here), 1 + here.shape[1]), np.uint8)
    found[:, 0] = _AVERAGE
    np.subtract(here, mean, out=found[:, 1:])
    return found


def _write_chunk(file: IO[bytes], kind: bytes, data: bytes) -> None:
    file.write(struct.pack(">I", len(data)) + kind)
    file.write(data)
    file.write(struct.pack(">I", zlib.crc32(data, zlib.crc32(kind))))
