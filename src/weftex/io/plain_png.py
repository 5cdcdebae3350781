"""Plain PNG files of moderate size, read without OpenImageIO, which takes longer to be loaded."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}  # by color types
_LARGEST = 2**22  # pixels
#: Chunks that change no pixel. Others (palettes, profiles, orientation) are left to the library.
_PLAIN = {b"IHDR", b"IDAT", b"IEND", b"cHRM", b"gAMA", b"oFFs", b"pHYs", b"sRGB", b"tEXt", b"tIME"}


def read_plain_png(name: str, max_pixels: int | None) -> tuple[NDArray[Any], bool] | None:
    """Return the pixels (H, W, C) of a PNG file that was checked, and whether the last are alpha.

    None for what is not plain, too large, or damaged within its data: OpenImageIO reads it, or
    says what is wrong.
    """
    with open(name, "rb") as file:
        data = file.read(9 * _LARGEST)
    packed, position, kind = [], 8, b""
    while kind != b"IEND":
        length, kind = struct.unpack_from(">I4s", data, position)
        body = data[position + 8 : position + 8 + length]
        # Some keep an orientation or a profile in a text.
        if kind not in _PLAIN or (kind == b"tEXt" and body.startswith((b"XML", b"Raw"))):
            return None
        if kind == b"IHDR":
            width, height, depth, color, *ways = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed.append(body)
        position += 12 + length
    most = _LARGEST if max_pixels is None else min(_LARGEST, max_pixels)
    if depth not in (8, 16) or color not in _CHANNELS or any(ways) or width * height > most:
        return None
    step = _CHANNELS[color] * depth // 8
    lines = np.empty((height, 1 + width * step), np.uint8)
    unpacker = zlib.decompressobj()
    try:
        plain = unpacker.decompress(b"".join(packed), lines.size + 1)
    except zlib.error:
        return None
    if len(plain) != lines.size or not unpacker.eof:
        return None
    lines[:] = np.frombuffer(plain, np.uint8).reshape(lines.shape)
    if lines[:, 0].max() > 4:  # no filter
        return None
    from weftex.io.png_kernels import unfilter  # for those who read

    unfilter(lines, step)
    pixels = np.ascontiguousarray(lines[:, 1:]).view(f">u{depth // 8}")
    return pixels.reshape(height, width, -1).astype(f"u{depth // 8}", copy=False), color >= 4
