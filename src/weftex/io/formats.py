"""What image formats can hold, and how files are checked, decoded and encoded by OpenImageIO."""

from __future__ import annotations

import os
import re
import zlib
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.errors import FileError, InvalidInputError, printable, wrong_value
from weftex.io.png import SIGNATURE

StrPath = str | os.PathLike[str]

__all__ = ["FORMATS", "SUFFIXES", "TIFF", "file_error", "kind_of", "suffix_of", "written_as"]

SIGNATURES = {
    "png": (SIGNATURE,),
    "jpeg": (b"\xff\xd8\xff",),
    "tiff": (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    "bmp": (b"BM",),
    "openexr": (b"v/1\x01",),
    "hdr": (b"#?RADIANCE", b"#?RGBE"),
    "jpegxl": (b"\xff\x0a", b"\0\0\0\x0cJXL \r\n\x87\n"),
    "gif": (b"GIF87a", b"GIF89a"),
}
#: Suffixes of formats that are not called as their suffix.
SUFFIXES = {"jpeg": ".jpg", "tiff": ".tif", "openexr": ".exr", "jpegxl": ".jxl"}
#: Attributes of OpenImageIO, which turns CMYK into RGB while it reads.
COLOR_SPACES = ("tiff:ColorSpace", "jpeg:ColorSpace")
FLOATS = dict.fromkeys(("half", "float", "double"), "float")
READ_AS = {"uint8": "uint8", "uint16": "uint16"} | FLOATS


class Format(NamedTuple):
    """What a format can hold, and how it is written."""

    name: str
    types: tuple[str, ...]
    side: int
    colors: tuple[int, ...] = (1, 3)  # empty: any number
    alpha: bool = True
    widen: tuple[int, ...] = ()  # channel counts whose gray is stored as RGB
    options: tuple[tuple[str, int | str], ...] = ()

    def holds(self, dtype: str, colors: int, alpha: bool) -> bool:
        """Whether pixels of this kind can be written."""
        counts = self.colors or (colors,)
        return dtype in self.types and colors in counts and alpha <= self.alpha


# TIFF and EXR record the present unless told another date, and no two runs would give equal bytes.
DATE = ("DateTime", "1980:01:01 00:00:00")
PLAIN = ("oiio:ColorSpace", "unknown")
# PNG without a profile is written by `weftex.io.png`. WebP at its own effort takes 30 times as long
# for 1 % less. A TIFF predictor for floats is more than many readers know. An unknown color space
# keeps sRGB tags off maps and wide gamuts.
FORMATS = {
    ".png": Format("png", ("uint8", "uint16"), 1_000_000,
                    options=(("png:compressionLevel", 2), ("png:filter", 64), PLAIN)),
    ".jpg": Format("jpeg", ("uint8",), 65_500, alpha=False, options=(
                    ("compression", "jpeg:95"), ("jpeg:subsampling", "4:4:4"), PLAIN)),
    ".tif": Format("tiff", ("uint8", "uint16", "float32"), 2**20, (),
                    options=(("compression", "zip"), ("tiff:predictor", 1), DATE)),
    ".webp": Format("webp", ("uint8",), 16_383, widen=(1, 2),
                     options=(("compression", "lossless"), ("webp:method", 0))),
    ".bmp": Format("bmp", ("uint8",), 65_535, alpha=False),
    ".exr": Format("openexr", ("float32",), 2**20, (), options=(("compression", "zip"), DATE)),
}  # fmt: skip
FORMATS |= {".jpeg": FORMATS[".jpg"], ".tiff": FORMATS[".tif"]}
TIFF = (".tif", ".tiff")  #: What can be written block by block.
READABLE = (*FORMATS, ".jxl", ".hdr", ".tga", ".gif")
_TARGA = re.compile(rb".[\0\1][\1\2\3\x09\x0a\x0b]", re.DOTALL)  # colors, and how they are stored


def image_library() -> Any:
    """Return OpenImageIO, or say that it is not there, as on a free-threaded Python."""
    try:
        import OpenImageIO  # 20 ms, for those who read or write a picture
    except ImportError:
        raise FileError("image files need OpenImageIO, which cannot be loaded here") from None

    return OpenImageIO


def path_text(path: StrPath) -> str:
    """Return a path as text, or raise `InvalidInputError` for what is none."""
    try:
        return os.fsdecode(path)
    except (TypeError, ValueError):
        raise wrong_value("path", path, "a string or a path") from None


def suffix_of(path: str) -> str:
    """Return the suffix in lower case, with its dot."""
    return os.path.splitext(path)[1].lower()


def written_as(path: str, floats: bool | None = None) -> str:
    """The suffix of what is made from a file: its own, or `.png`, or `.exr` for floats.

    The file is opened if its type can only be read and `floats` is not given.
    """
    if suffix_of(path) in FORMATS:
        return os.path.splitext(path)[1]
    if floats is None:
        file = image_library().ImageInput.open(path)
        floats = file is not None and str(file.spec().format) in FLOATS
    return ".exr" if floats else ".png"


def kind_of(name: str, given: str) -> str:
    """Return the format that the first bytes of the file show."""
    try:
        if os.path.isdir(name):
            raise file_error(given, "is a folder; name an image in it")
        if os.path.exists(name) and not os.path.isfile(name):
            raise file_error(given, "is not a regular file")
        name.encode()  # the library takes no other names
        with open(name, "rb") as file:
            head = file.read(16)
            if head.startswith(SIGNATURE):
                check_png(file, given)
    except FileError:
        raise
    except (OSError, ValueError) as error:
        raise file_error(given, "cannot read", error) from None
    if not head:
        raise file_error(given, "the file is empty")
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "webp"
    for kind, signatures in SIGNATURES.items():
        if head.startswith(signatures):
            return kind
    if suffix_of(name) == ".tga" and _TARGA.match(head):
        return "targa"
    if head[4:12] in (b"ftypheic", b"ftypheix", b"ftypmif1", b"ftypavif"):
        raise file_error(given, "is a HEIC or AVIF image; convert it to PNG first (heif-convert)")
    raise file_error(given, f"is not an image that weftex reads ({', '.join(READABLE)})")


def check_png(file: IO[bytes], given: str) -> None:
    """Find damage before libpng does, which prints to the terminal before it reports."""
    size, position, kind, seen = os.fstat(file.fileno()).st_size, len(SIGNATURE), b"", set()
    while kind != b"IEND":
        file.seek(position)
        head = file.read(8)
        length, kind = int.from_bytes(head[:4], "big"), head[4:]
        if len(head) < 8 or position + 12 + length > size:
            raise file_error(given, "the file is cut short")
        body, check = file.read(length), int.from_bytes(file.read(4), "big")
        sides = [int.from_bytes(body[k : k + 4], "big") for k in (0, 4)]
        sized = kind == b"IHDR" and 0 < min(sides) <= max(sides) <= 10**6
        header = position > len(SIGNATURE) or sized
        if not header or zlib.crc32(body, zlib.crc32(kind)) != check:
            raise file_error(given, "the file is damaged")
        position += 12 + length
        seen.add(kind)
    if b"IDAT" not in seen:
        raise file_error(given, "the file is damaged")


def bits_of(path: str) -> int:
    """Return how many bits of a stored number count, by the header; 0 if it cannot be read."""
    oiio = image_library()
    file = oiio.ImageInput.open(path)
    if file is None:
        complaint(oiio)
        return 0
    kind = file.spec().format
    return {"half": 11, "float": 24, "double": 53}.get(str(kind)) or int(8 * kind.size())


def check_spec(spec: Any, given: str, max_pixels: int | None) -> None:
    """Refuse a picture that is too large, or of a kind that weftex does not read, by its header."""
    # A reader takes memory for a whole tile, which a header may claim to be larger than the rest.
    area = max(spec.width * spec.height, spec.tile_width * spec.tile_height)
    if max_pixels is not None and area > max_pixels:
        size = f"{spec.width} x {spec.height} pixels"
        raise file_error(given, f"{size} are more than max_pixels = {max_pixels}")
    for space in map(spec.get_string_attribute, COLOR_SPACES):
        if space in ("CIELAB", "ICCLAB", "ITULAB"):
            raise file_error(given, f"holds {space} colors; convert it to RGB first")
    if spec.deep or spec.depth > 1:
        raise file_error(given, "is a deep or volume image; weftex reads flat images")
    if str(spec.format) not in READ_AS:
        raise file_error(given, f"holds {spec.format} pixels; weftex reads uint8, uint16 and float")
    if str(spec.format) == "double" and spec.tile_width:  # OpenImageIO 3.2 reads them wrong
        raise file_error(given, "holds tiled float64 pixels; store them as float32 or untiled")


def straight(pixels: NDArray[Any], spec: Any, kind: str) -> tuple[NDArray[Any], bool]:
    """Return the pixels with straight alpha as the last channel, and whether there is any."""
    place = spec.alpha_channel
    if kind == "gif" and pixels.shape[2] == 4:  # also of opaque ones, and said to be the fifth
        pixels, place = (pixels, 3) if pixels[..., 3].min() < 255 else (pixels[..., :3], -1)
    # Many programs write zero as the fourth byte of a bitmap's pixels, which is not alpha.
    if kind == "bmp" and place == 3 and not pixels[..., 3].any():
        pixels, place = pixels[..., :3], -1
    if place < 0 or pixels.shape[2] == 1:
        return (pixels[..., 0] if pixels.shape[2] == 1 else pixels), False
    color, cover = np.delete(pixels, place, axis=2), pixels[..., place : place + 1]
    if kind in ("tiff", "openexr") and not spec.get_int_attribute("oiio:UnassociatedAlpha"):
        if pixels.dtype.kind == "f":
            with np.errstate(all="ignore"):
                np.divide(color, cover, out=color, where=cover > 0)
        else:
            top, part = np.uint32(np.iinfo(pixels.dtype).max), np.maximum(cover, 1).astype("u4")
            whole = np.minimum((color.astype("u4") * top + part // 2) // part, top)
            color = np.where(cover > 0, whole, color).astype(pixels.dtype)
    return np.concatenate([color, cover], axis=2), True


def upright(pixels: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Undo an EXIF orientation."""
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return pixels


def varies(pixels: NDArray[Any]) -> bool:
    """Whether any pixel differs from the first."""
    return bool((pixels != pixels[:1, :1]).any())


def check_fit(given: str, form: Format, pixels: NDArray[Any], alpha: bool) -> None:
    """Refuse an array that is no picture, or that the format cannot hold."""
    shape, suffix = pixels.shape, suffix_of(given)
    colors = (shape[2] if len(shape) == 3 else 1) - alpha
    dtype = "float32" if pixels.dtype.kind == "f" else pixels.dtype.name
    if len(shape) not in (2, 3) or 0 in shape:
        problem = f"pixels of shape {shape} are not an image; use (H, W) or (H, W, C), not empty"
    elif colors < 1:
        problem = "alpha needs at least one channel of color beside it"
    elif dtype not in ("uint8", "uint16", "float32"):
        problem = f"{dtype} pixels are not written; use uint8, uint16 or float32"
    elif not form.holds(dtype, colors, alpha):
        able = [key for key in sorted(FORMATS) if FORMATS[key].holds(dtype, colors, alpha)]
        what = f"{dtype} pixels of {colors} channel{'s'[: colors > 1]}{' and alpha' * alpha}"
        what += " (if the last is alpha: alpha=True)" * (colors in (2, 4) and not alpha)
        problem = f"'{suffix}' cannot hold {what}; use {', '.join(able)}"
    elif max(shape[:2]) > form.side:
        problem = f"'{suffix}' holds at most {form.side} pixels a side, not {max(shape[:2])}"
    else:
        return
    raise InvalidInputError(f"{given}: {problem}")


def density_of(spec: Any) -> float | None:
    """Return the pixels per meter that a header states; None if it does not, or two of them."""
    across, down = (spec.getattribute(f"{axis}Resolution") for axis in "XY")
    unit = {"in": 0.0254, "cm": 0.01, "m": 1.0}.get(str(spec.getattribute("ResolutionUnit")))
    if unit is None or not isinstance(across, float) or not 0 < across < np.inf:
        return None
    return across / unit if isinstance(down, float) and abs(down / across - 1) < 0.01 else None


def fits(icc: bytes | None, colors: int) -> bool:
    """Return whether this is a whole profile for this number of channels."""
    space = {1: b"GRAY", 3: b"RGB "}.get(colors)
    whole = icc is not None and len(icc) > 128 and int.from_bytes(icc[:4], "big") == len(icc)
    return icc is not None and whole and icc[36:40] == b"acsp" and icc[16:20] == space


def ensure_space(path: str, size: int) -> None:
    """Fill the file up to this size with noise, which no file system can compress away."""
    block = memoryview(os.urandom(2**18))
    with open(path, "r+b", buffering=0) as file:
        while size > 0:
            size -= file.write(block[:size])


def encode(
    path: str,
    form: Format,
    pixels: NDArray[Any],
    alpha: bool,
    icc: bytes | None,
    half: bool,
    density: float | None = None,
) -> str:
    """Write with OpenImageIO and return what went wrong, or nothing."""
    oiio = image_library()
    height, width, channels = pixels.shape
    kind = READ_AS.get(pixels.dtype.name, "float")
    kind = "half" if half and kind == "float" and form.name == "openexr" else kind
    spec = oiio.ImageSpec(width, height, channels, kind)
    colors = channels - alpha
    names = ["Y"] if colors == 1 else ["R", "G", "B"] if colors >= 3 else []
    names += [f"channel{k:04}" for k in range(len(names), colors)]
    spec.channelnames = (*names, *["A"] * alpha)
    spec.alpha_channel = colors if alpha else -1
    for key, value in (("oiio:UnassociatedAlpha", 1), *form.options):
        spec[key] = value
    if density is not None:
        sizes = {"in": density * 0.0254, "cm": density / 100}
        unit = "in"
        if form.name == "png":
            sizes, unit = {"m": float(round(density))}, "m"
        elif form.name == "jpeg":  # it has whole numbers
            unit = min(sizes, key=lambda unit: abs(sizes[unit] - round(sizes[unit])))
            sizes[unit] = float(max(1, round(sizes[unit])))
        spec["ResolutionUnit"] = unit
        spec["XResolution"] = spec["YResolution"] = sizes[unit]
    if icc is not None:
        bytes_of = oiio.TypeDesc(oiio.UINT8, oiio.SCALAR, oiio.NOSEMANTICS, len(icc))
        spec.attribute("ICCProfile", bytes_of, np.frombuffer(icc, np.uint8))
    file = oiio.ImageOutput.create(form.name)
    done = file.open(path, spec) and file.write_image(pixels) and file.close()
    return "" if done else complaint(file) or "the encoder failed"


def complaint(source: Any) -> str:
    """Take the library's error, which is printed at the end of the process if nobody does."""
    try:
        return str(source.geterror())
    except UnicodeDecodeError:  # it quotes the damaged file
        return "unknown error"


def file_error(path: StrPath, what: str, why: object = "") -> FileError:
    """Return a one-line error, whatever the library had to say."""
    if isinstance(why, OSError) and why.strerror:
        why = why.strerror
    lines = str(why).strip().splitlines()
    return FileError(f"{show(path_text(path))}: {what}{': '.join(['', *lines[:1]])}")


def show(path: str) -> str:
    """Return a path that prints on one line."""
    return printable(path) or "''"
