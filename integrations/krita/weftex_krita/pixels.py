"""Krita's pixels as pictures and back: order of channels, 16-bit floats, alpha. No Krita needed."""

from __future__ import annotations

import struct
from array import array

from . import tiff
from .command import Problem

#: Channels by Krita's color models, with alpha.
_CHANNELS = {"RGBA": 4, "GRAYA": 2}
#: Bytes of a channel in Krita, and bits of a channel in files, by Krita's color depths.
_DEPTHS = {"U8": (1, 8), "U16": (2, 16), "F16": (2, 32), "F32": (4, 32)}


def pixel_size(model: str, depth: str) -> int:
    """Return the bytes of a pixel, or raise `Problem` unless it is RGB or gray."""
    if model not in _CHANNELS or depth not in _DEPTHS:
        raise Problem(
            "The layer is neither RGB nor grayscale; convert it: Layer > Convert > "
            "Convert Layer Color Space"
        )
    return _CHANNELS[model] * _DEPTHS[depth][0]


def to_picture(data: bytes, width: int, height: int, model: str, depth: str) -> tiff.Picture:
    """Return a picture of Krita's bytes, without alpha if all pixels are opaque."""
    bits = _DEPTHS[depth][1]
    if depth == "F16":
        data = array("f", struct.unpack(f"={len(data) // 2}e", data)).tobytes()
    picture = tiff.Picture(width, height, _CHANNELS[model], bits, data)
    if model == "RGBA" and bits != 32:
        picture = _swapped(picture)
    return picture.without_alpha() if picture.opaque else picture


def from_picture(picture: tiff.Picture, depth: str) -> bytes:
    """Return Krita's bytes of a picture; there is always alpha."""
    picture = picture.with_alpha()
    if picture.channels == 4 and picture.bits != 32:
        picture = _swapped(picture)
    if depth == "F16":
        values = picture.values()
        return struct.pack(f"={len(values)}e", *values)
    return picture.data


def covered(picture: tiff.Picture, mask: bytes) -> tiff.Picture:
    """Return a picture whose alpha is multiplied by a mask from 0 to 255."""
    picture = picture.with_alpha()
    values, count = picture.values(), picture.channels
    alpha = values[count - 1 :: count]
    if picture.bits == 32:
        mixed = [a * m / 255 for a, m in zip(alpha, mask)]  # noqa: B905, Python 3.8
    else:
        mixed = [(a * m + 127) // 255 for a, m in zip(alpha, mask)]  # noqa: B905
    values[count - 1 :: count] = array(values.typecode, mixed)
    return tiff.Picture(picture.width, picture.height, count, picture.bits, values.tobytes())


def _swapped(picture: tiff.Picture) -> tiff.Picture:
    """Return the picture with red and blue exchanged: integers of Krita are in the order BGRA."""
    values = picture.values()
    values[0::4], values[2::4] = values[2::4], values[0::4]
    return tiff.Picture(picture.width, picture.height, 4, picture.bits, values.tobytes())
