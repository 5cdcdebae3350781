"""Write and read TIFF files with 8-bit, 16-bit and float pixels, byte for byte.

Hosts convert colors when they load and save; this does not. Standard library only, Python 3.8.
"""

from __future__ import annotations

import struct
import sys
import zlib
from array import array
from dataclasses import dataclass
from pathlib import Path

#: Array type codes and TIFF sample formats (1 is unsigned, 3 is float) by bits of a channel.
CODES = {8: "B", 16: "H", 32: "f"}
_FORMATS = {8: 1, 16: 1, 32: 3}
_STRIP = 2**20  # bytes


@dataclass
class Picture:
    """Pixels in rows from the top, channels interleaved, bytes in the machine's order.

    Attributes
    ----------
    width, height : int
    channels : int
        1 gray, 2 gray and alpha, 3 RGB, 4 RGB and alpha; alpha is straight.
    bits : int
        8 or 16 for integers, 32 for floats.
    data : bytes
    """

    width: int
    height: int
    channels: int
    bits: int
    data: bytes

    @property
    def opaque(self) -> bool:
        """Whether there is no alpha, or all of it is 1."""
        if self.channels in (1, 3):
            return True
        alpha = self.values()[self.channels - 1 :: self.channels]
        return alpha.count(full(self.bits)) == len(alpha)

    def values(self) -> array[float]:
        """Return all values as an array."""
        return array(CODES[self.bits], self.data)

    def without_alpha(self) -> Picture:
        """Return the colors alone."""
        return self._with(self.channels - 1) if self.channels in (2, 4) else self

    def with_alpha(self) -> Picture:
        """Return the picture with alpha, which is 1 if there was none."""
        return self._with(self.channels + 1) if self.channels in (1, 3) else self

    def cropped(self, x: int, y: int, width: int, height: int) -> Picture:
        """Return a rectangle of the picture."""
        pixel = self.channels * self.bits // 8
        starts = (((y + row) * self.width + x) * pixel for row in range(height))
        data = b"".join(self.data[start : start + width * pixel] for start in starts)
        return Picture(width, height, self.channels, self.bits, data)

    def _with(self, channels: int) -> Picture:
        old, count = self.values(), self.width * self.height
        new = array(CODES[self.bits], [full(self.bits)]) * (count * channels)
        for channel in range(min(channels, self.channels)):
            new[channel::channels] = old[channel :: self.channels]
        return Picture(self.width, self.height, channels, self.bits, new.tobytes())


def full(bits: int) -> float:
    """Return the value that stands for 1."""
    return 1.0 if bits == 32 else 2**bits - 1


def write(path: Path, picture: Picture) -> None:
    """Write a picture as an uncompressed BigTIFF file."""
    width, height, channels, bits = picture.width, picture.height, picture.channels, picture.bits
    row = width * channels * bits // 8
    if len(picture.data) != row * height:
        raise ValueError(f"{len(picture.data)} bytes for {width} x {height} pixels")
    rows = max(1, _STRIP // row)
    starts = range(0, height, rows)
    sizes = [row * min(rows, height - start) for start in starts]
    alpha = channels in (2, 4)
    tags = [
        (256, "I", [width]),
        (257, "I", [height]),
        (258, "H", [bits] * channels),
        (259, "H", [1]),  # no compression
        (262, "H", [1 if channels < 3 else 2]),  # gray or RGB
        (273, "Q", [16 + row * start for start in starts]),
        (277, "H", [channels]),
        (278, "I", [rows]),
        (279, "Q", sizes),
        (284, "H", [1]),  # channels interleaved
        *([(338, "H", [2])] if alpha else []),  # straight alpha
        (339, "H", [_FORMATS[bits]] * channels),
    ]
    with open(path, "wb") as file:
        order, mark = ("<", b"II") if sys.byteorder == "little" else (">", b"MM")
        at = 16 + len(picture.data)
        file.write(mark + struct.pack(order + "HHHQ", 43, 8, 0, at))
        file.write(picture.data)
        values, beyond = [], at + 8 + 20 * len(tags) + 8
        tail = b""
        for number, code, numbers in tags:
            packed = struct.pack(f"{order}{len(numbers)}{code}", *numbers)
            kind = {"H": 3, "I": 4, "Q": 16}[code]
            if len(packed) > 8:
                place = struct.pack(order + "Q", beyond + len(tail))
                tail += packed
            else:
                place = packed.ljust(8, b"\0")
            values.append(struct.pack(order + "HHQ", number, kind, len(numbers)) + place)
        file.write(struct.pack(order + "Q", len(tags)) + b"".join(values))
        file.write(struct.pack(order + "Q", 0) + tail)


def read(path: Path) -> Picture:
    """Read a picture that weftex wrote: strips, plain or deflated, without a predictor."""
    content = path.read_bytes()
    order = {b"II": "<", b"MM": ">"}[content[:2]]
    (version,) = struct.unpack_from(order + "H", content, 2)
    large = version == 43
    (at,) = struct.unpack_from(order + ("Q" if large else "I"), content, 8 if large else 4)
    (count,) = struct.unpack_from(order + ("Q" if large else "H"), content, at)
    tags = {}
    for k in range(count):
        entry = at + (8 + 20 * k if large else 2 + 12 * k)
        number, kind = struct.unpack_from(order + "HH", content, entry)
        (length,) = struct.unpack_from(order + ("Q" if large else "I"), content, entry + 4)
        code = {3: "H", 4: "I", 16: "Q"}.get(kind)
        if code:
            place = entry + (12 if large else 8)
            if struct.calcsize(code) * length > (8 if large else 4):
                (place,) = struct.unpack_from(order + ("Q" if large else "I"), content, place)
            tags[number] = struct.unpack_from(f"{order}{length}{code}", content, place)
    bits = tags[258][0]
    known = tags[259][0] in (1, 8) and tags.get(317, (1,))[0] == 1 and tags.get(284, (1,))[0] == 1
    if not known or bits not in CODES or tags.get(339, (1,))[0] != _FORMATS[bits]:
        raise ValueError(f"{path} is not a TIFF file that weftex writes")
    strips = [content[a : a + n] for a, n in zip(tags[273], tags[279])]  # noqa: B905, Python 3.8
    if tags[259][0] == 8:
        strips = [zlib.decompress(one) for one in strips]
    data = array(CODES[bits], b"".join(strips))
    if (order == "<") != (sys.byteorder == "little"):
        data.byteswap()
    return Picture(tags[256][0], tags[257][0], tags[277][0], bits, data.tobytes())
