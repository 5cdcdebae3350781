"""Pictures as a browser shows them: 8 bits, a part of them, with fewer pixels."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex import Exemplar
from weftex.io.formats import FORMATS
from weftex.io.pictures import Picture
from weftex.io.png import png_bytes
from weftex.studio.refusals import Refusal

Bytes = NDArray[np.uint8]

_MOST_RAW = 2**20  # pixels
_BAND = 2**22  # pixels, about, that are converted together: a large sample would take gigabytes
_QUICK = 1  # zlib's level: on one machine sending costs less than packing


def whole_number(query: Mapping[str, str], name: str, default: int, low: int, high: int) -> int:
    """Return a number of a query, or raise `Refusal`."""
    text = query.get(name) or str(default)
    if not re.fullmatch(r"-?\d{1,19}", text) or not low <= int(text) <= high:
        raise Refusal(400, f"{name} is not a whole number from {low} to {high}", name)
    return int(text)


def times_smaller(query: Mapping[str, str], shape: tuple[int, ...]) -> int:
    """Return by which power of two sides become at most the `most` of a query."""
    most, times = whole_number(query, "most", 0, 0, 2**20), 1
    while most and -(-max(shape[:2]) // times) > most:
        times *= 2
    return times


def shown_smaller(like: Exemplar, times: int) -> Bytes:
    """Return a sample as a screen shows it, with fewer pixels, a band of rows at a time."""
    rows = -(-_BAND // like.shape[1] // times) * times
    bands = range(0, like.shape[0], rows)
    parts = (on_screen(like, like.pixels[top : top + rows]) for top in bands)
    return np.concatenate([smaller(part, times) for part in parts])


def smaller(picture: Bytes, times: int) -> Bytes:
    """Return means of blocks; those at the border may be cut."""
    if times == 1:
        return picture
    rows, columns = (np.arange(0, side, times) for side in picture.shape[:2])
    total = np.add.reduceat(picture, rows, axis=0, dtype=np.uint32)
    total = np.add.reduceat(total, columns, axis=1)
    high, wide = (np.diff([*range(0, side, times), side]) for side in picture.shape[:2])
    count = (high[:, None] * wide)[..., None]
    return np.asarray((total + count // 2) // count, np.uint8)


def on_screen(like: Exemplar, pixels: NDArray[Any]) -> Bytes:
    """Return pixels as a screen shows them."""
    planes = pixels.reshape(*pixels.shape[:2], -1)
    alpha = like.alpha and planes.shape[2] > 1
    colors = planes[..., :-1] if alpha else planes
    colors = colors[..., :3] if colors.shape[2] >= 3 else colors[..., :1]
    if colors.dtype == np.uint8:
        levels = colors
    elif colors.dtype == np.uint16 and like.role.kind != "labels":
        levels = ((colors.astype(np.uint32) + 128) // 257).astype(np.uint8)
    elif colors.dtype.kind == "f" and like.role.kind == "color":
        light = np.clip(colors.astype(np.float64), 0, 1)
        curve = np.where(light < 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
        levels = np.rint(255 * curve).astype(np.uint8)  # sRGB, IEC 61966-2-1
    else:
        levels = like.as_matching(pixels)[..., : colors.shape[2]]
    if not alpha:
        return np.ascontiguousarray(levels)
    top = 1.0 if planes.dtype.kind == "f" else np.iinfo(planes.dtype).max
    clear = planes[..., -1:].astype(np.float64) / top
    cover = np.rint(255 * np.clip(clear, 0, 1)).astype(np.uint8)
    levels = levels if levels.shape[2] == 3 else np.repeat(levels, 3, axis=2)
    return np.concatenate([levels, cover], axis=2)


def preview_of(sample: Exemplar) -> Callable[[NDArray[Any]], Bytes]:
    """Return what makes a preview's pixels fit for a screen: those of a sample's kind."""

    def show(pixels: NDArray[Any]) -> Bytes:
        if pixels.dtype == sample.pixels.dtype and pixels.shape[2:] == sample.pixels.shape[2:]:
            return on_screen(sample, pixels)
        planes = pixels.reshape(*pixels.shape[:2], -1)  # of all maps at once: features in bytes
        levels = planes if planes.dtype == np.uint8 else np.zeros(planes.shape, np.uint8)
        return levels[..., :3] if levels.shape[2] >= 3 else levels[..., :1]

    return show


def formats_of(picture: Picture) -> list[str]:
    """Return the suffixes of the formats that hold such pixels."""
    pixels = picture.pixels
    colors = (pixels.shape[2] if pixels.ndim == 3 else 1) - picture.alpha
    dtype = "float32" if pixels.dtype.kind == "f" else pixels.dtype.name
    return [
        suffix
        for suffix, one in FORMATS.items()
        if suffix not in (".jpeg", ".tiff") and one.holds(dtype, colors, picture.alpha)
    ]


def packed(picture: Bytes, query: Mapping[str, str]) -> tuple[bytes, dict[str, str]]:
    """Return a picture for the screen, and headers that say what it is.

    That is a PNG file; a page that says ``raw`` gets small ones as a canvas has them, RGBA: that
    takes a tenth of the time to pack, and none to unpack.
    """
    height, width, channels = picture.shape
    if "raw" not in query or height * width > _MOST_RAW:
        return png_bytes(picture, _QUICK), {"content-type": "image/png"}
    pixels = np.full((height, width, 4), 255, np.uint8)
    pixels[..., : max(3, channels)] = picture
    raw = {"content-type": "application/octet-stream", "x-weftex-pixels": f"{width}x{height}"}
    return pixels.tobytes(), raw
