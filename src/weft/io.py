"""Pictures in and out: the only place that touches files.

Pixels keep the type they are stored in: uint8, uint16 or float32. Alpha is always straight, colours
are never converted, and what a format cannot hold is refused instead of squeezed in.

======  =====================  =========================================
suffix  pixel types written    channels
======  =====================  =========================================
.png    uint8, uint16          grey or RGB, with alpha or without
.jpg    uint8, at quality 95   grey or RGB
.tif    uint8, uint16, float   any number, with alpha or without
.webp   uint8, lossless        RGB, RGBA; grey is stored as RGB
.bmp    uint8                  grey or RGB
.exr    float                  any number, with alpha or without
======  =====================  =========================================

JPEG XL and Radiance HDR are only read. Reading goes by the content of a file, not by its name. The
path ``sample:NAME`` names a picture, or a folder of maps, that ships with weft.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from weft.errors import FileError, InvalidInputError, did_you_mean

if TYPE_CHECKING:
    from numpy.typing import NDArray

    StrPath = str | os.PathLike[str]

MAX_PIXELS = 2**28
"""The default limit on the width times height of a picture that is read."""

_SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "samples")
_PNG = b"\x89PNG\r\n\x1a\n"
_SIGNATURES = {
    "png": (_PNG,),
    "jpeg": (b"\xff\xd8\xff",),
    "tiff": (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    "bmp": (b"BM",),
    "openexr": (b"v/1\x01",),
    "hdr": (b"#?RADIANCE", b"#?RGBE"),
    "jpegxl": (b"\xff\x0a", b"\0\0\0\x0cJXL \r\n\x87\n"),
}
_FLOATS = dict.fromkeys(("half", "float", "double"), "float")
_READ_AS = {"uint8": "uint8", "uint16": "uint16"} | _FLOATS


@dataclass(frozen=True)
class _Format:
    """What a format can hold, and how it is written."""

    name: str
    types: tuple[str, ...]
    side: int
    colours: tuple[int, ...] = (1, 3)  # empty: any number
    alpha: bool = True
    widen: tuple[int, ...] = ()  # channel counts whose grey is stored as RGB
    options: tuple[tuple[str, int | str], ...] = ()

    def holds(self, dtype: str, colours: int, alpha: bool) -> bool:
        counts = self.colours or (colours,)
        return dtype in self.types and colours in counts and alpha <= self.alpha


# TIFF and EXR record the present unless told another date, and no two runs would give equal bytes.
_DATE = ("DateTime", "1980:01:01 00:00:00")
_PLAIN = ("oiio:ColorSpace", "unknown")
# One PNG filter takes two thirds of the time of libpng's choice among five, and the files are as
# small. WebP at its own effort takes 30 times as long for 1 % less. A TIFF predictor for floats is
# more than many readers know. An unknown colour space keeps sRGB tags off maps and wide gamuts.
_FORMATS = {
    ".png": _Format("png", ("uint8", "uint16"), 1_000_000,
                    options=(("png:compressionLevel", 3), ("png:filter", 128), _PLAIN)),
    ".jpg": _Format("jpeg", ("uint8",), 65_500, alpha=False, options=(
                    ("compression", "jpeg:95"), ("jpeg:subsampling", "4:4:4"), _PLAIN)),
    ".tif": _Format("tiff", ("uint8", "uint16", "float32"), 2**20, (),
                    options=(("compression", "zip"), ("tiff:predictor", 1), _DATE)),
    ".webp": _Format("webp", ("uint8",), 16_383, widen=(1, 2),
                     options=(("compression", "lossless"), ("webp:method", 0))),
    ".bmp": _Format("bmp", ("uint8",), 65_535, alpha=False),
    ".exr": _Format("openexr", ("float32",), 2**20, (), options=(("compression", "zip"), _DATE)),
}  # fmt: skip
_FORMATS |= {".jpeg": _FORMATS[".jpg"], ".tiff": _FORMATS[".tif"]}
_READABLE = (*_FORMATS, ".jxl", ".hdr")


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture as it was stored.

    Attributes
    ----------
    pixels : ndarray
        ``(H, W)`` for a single channel, else ``(H, W, C)``; uint8, uint16 or float32.
    alpha : bool
        Whether the last channel is alpha, straight (unassociated).
    icc : bytes or None
        The colour profile of the file.
    path : str
        The path that it was read from, as given.
    """

    pixels: NDArray[Any] = field(repr=False)
    alpha: bool
    icc: bytes | None = field(repr=False)
    path: str


def read_image(path: StrPath, *, max_pixels: int | None = MAX_PIXELS) -> Picture:
    """Read a picture.

    Half and double floats become float32; palettes and fewer than 8 bits become uint8. The EXIF
    orientation is applied. Of several parts the first is read, of an EXR its data window. Alpha
    that a TIFF or EXR stores premultiplied is divided out, and moved last. Refused are CMYK and
    Lab, signed and 32-bit integers, deep and volume pictures.

    Parameters
    ----------
    path : str or path-like
        The file, or ``sample:NAME``.
    max_pixels : int or None
        The largest width times height to accept, checked before memory is taken; None for any.

    Raises
    ------
    FileError
        If the file is missing, unreadable, damaged, cut short, too large or not a picture.
    """
    name, given = _locate(path)
    kind = _kind(name, given)
    oiio = _oiio()
    # Some readers decode while they open, so the library must know the limit before. Four floats
    # are 16 bytes; the floor is for pictures of few pixels and many channels.
    limit = 0 if max_pixels is None else max(256, -(-max_pixels // 2**16))
    oiio.attribute("limits:imagesize_MB", limit)
    hint = oiio.ImageSpec()
    hint["oiio:UnassociatedAlpha"] = 1
    try:
        source = oiio.ImageInput.open(name, hint)
        if source is None:
            problem = _complaint(oiio)
            large = f"is larger than max_pixels = {max_pixels}"
            raise _error(given, large if "imagesize_MB" in problem else "cannot read", problem)
        # The reader that goes with the suffix is asked first, and some claim any file.
        if source.format_name() != kind:
            raise _error(given, f"is a {kind} picture under the name of another format; rename it")
        spec = source.spec()
        _check_spec(spec, given, max_pixels)
        pixels = source.read_image(0, 0, 0, spec.nchannels, _READ_AS[str(spec.format)])
        problem = _complaint(source)
        source.close()
    except MemoryError:
        raise _error(given, "does not fit in memory") from None
    # Readers hand out what they have of a damaged file, so the message counts, not the pixels.
    if pixels is None or problem:
        raise _error(given, "the file is damaged or cut short", problem)
    pixels, alpha = _straight(pixels, spec, kind)
    pixels = _upright(pixels, spec.get_int_attribute("Orientation", 1))
    icc = spec.getattribute("ICCProfile")
    return Picture(np.ascontiguousarray(pixels), alpha, None if icc is None else bytes(icc), given)


def write_image(
    path: StrPath, pixels: NDArray[Any], *, alpha: bool = False, icc: bytes | None = None
) -> None:
    """Write a picture; the file appears whole or not at all.

    float16 and float64 are written as float32. Nothing else is converted: see the table of this
    module. An EXR gets its alpha premultiplied, as that format asks, and so loses colour under zero
    alpha; so does a WebP. Symbolic links are written through, permissions kept.

    Parameters
    ----------
    path : str or path-like
        The file; its suffix chooses the format.
    pixels : ndarray
        ``(H, W)`` or ``(H, W, C)``.
    alpha : bool
        Whether the last channel is straight alpha.
    icc : bytes or None
        A colour profile. It is left out where the format holds none (BMP, EXR), and where it is
        broken or made for another number of channels, such as an RGB profile for a grey picture.

    Raises
    ------
    InvalidInputError
        If the array is not a picture, or the format cannot hold it.
    FileError
        If the file cannot be written; then what was there before is untouched.
    """
    check_output(path, pixels, alpha=alpha)
    form = _FORMATS[_suffix(os.fsdecode(path))]
    native = np.float32 if pixels.dtype.kind == "f" else pixels.dtype.newbyteorder("=")
    with np.errstate(all="ignore"):  # infinities are as good as any other value
        pixels = np.ascontiguousarray(np.atleast_3d(pixels), native)
        if alpha and form.name == "openexr":
            pixels = np.concatenate([pixels[..., :-1] * pixels[..., -1:], pixels[..., -1:]], axis=2)
    if pixels.shape[2] in form.widen:
        pixels = np.concatenate([pixels[..., :1]] * 2 + [pixels], axis=2)
    with atomic(path) as temporary:
        # On a full disk PNG reports success, JPEG ends the process and WebP crashes, so room is
        # made sure of first. Noise can grow by an eighth.
        _reserve(temporary, pixels.nbytes * 5 // 4 + len(icc or b"") + 2**16)
        profile = icc if _fits(icc, pixels.shape[2] - alpha) else None
        problem = _encode(temporary, form, pixels, alpha, profile)
        if problem and profile is not None:  # libpng is stricter about them than we are
            problem = _encode(temporary, form, pixels, alpha, None)
        if problem:
            raise _error(path, "cannot write", problem)


def check_output(
    path: StrPath,
    like: NDArray[Any] | None = None,
    *,
    alpha: bool = False,
    suffixes: Collection[str] | None = None,
) -> None:
    """Refuse an output path that cannot work, before any work is done for it.

    Parameters
    ----------
    path : str or path-like
        The file to be written.
    like : ndarray or None
        An array with the type and channels of what will be written, such as the sample's pixels;
        then its fit to the format is checked as well.
    alpha : bool
        Whether the last channel of `like` is alpha.
    suffixes : collection of str or None
        Suffixes to accept instead of those of pictures, such as ``(".npz",)``.

    Raises
    ------
    InvalidInputError
        If the format cannot hold `like`.
    FileError
        If the suffix is unknown, the folder missing or read-only, or the path a folder.
    """
    given, known = os.fsdecode(path), _FORMATS if suffixes is None else suffixes
    suffix, target = _suffix(given), _target(given)
    folder = os.path.dirname(target)
    if given.startswith("sample:"):
        raise _error(given, "samples cannot be overwritten; name a file")
    if os.path.isdir(target):
        raise _error(given, "is a folder; name a file in it")
    if suffix not in known:
        near = did_you_mean(suffix, known) if suffix else f"; known: {', '.join(sorted(known))}"
        raise _error(given, f"cannot write {f'{suffix!r}' if suffix else 'without a suffix'}{near}")
    if not os.path.isdir(folder):
        raise _error(given, f"the folder {_show(folder)} does not exist")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise _error(given, f"the folder {_show(folder)} is read-only")
    if os.path.lexists(target) and not (os.path.isfile(target) and os.access(target, os.W_OK)):
        raise _error(given, "exists and cannot be overwritten")
    if like is not None and suffixes is None:
        _check_fit(_show(given), _FORMATS[suffix], like, alpha)


def read_mask(path: StrPath, *, max_pixels: int | None = MAX_PIXELS) -> NDArray[np.bool_]:
    """Read a picture as an ``(H, W)`` mask.

    A pixel is True where any colour channel reaches half of the range: 128, 32768 or 0.5. Alpha is
    ignored, unless the colour is the same everywhere and alpha is not: then alpha is the mask. The
    parameters are those of `read_image`.
    """
    picture = read_image(path, max_pixels=max_pixels)
    pixels = np.atleast_3d(picture.pixels)
    if picture.alpha:
        colour, cover = pixels[..., :-1], pixels[..., -1:]
        pixels = cover if _varies(cover) and not _varies(colour) else colour
    half = 0.5 if pixels.dtype.kind == "f" else np.iinfo(pixels.dtype).max // 2 + 1
    return np.asarray((pixels >= half).any(axis=2))


def read_maps(folder: StrPath, *, max_pixels: int | None = MAX_PIXELS) -> dict[str, Picture]:
    """Read all pictures of a folder, or of ``sample:NAME``: the maps of one material.

    They are sorted by their names without suffix. Hidden files, folders and files of other suffixes
    are passed over. Sizes are not compared; `max_pixels` holds for each (see `read_image`).
    """
    name, given = _locate(folder)
    try:
        files = sorted(os.listdir(name))
    except (OSError, ValueError) as error:
        raise _error(given, "cannot read the folder", error) from None
    maps: dict[str, Picture] = {}
    for file in files:
        stem, full = os.path.splitext(file)[0], os.path.join(name, file)
        if file.startswith(".") or _suffix(file) not in _READABLE or os.path.isdir(full):
            continue
        if stem in maps:
            raise _error(given, f"has two pictures named '{_show(stem)}'; keep one")
        maps[stem] = read_image(full, max_pixels=max_pixels)
    if not maps:
        raise _error(given, f"has no pictures ({', '.join(_READABLE)})")
    return dict(sorted(maps.items()))


@contextmanager
def atomic(path: StrPath) -> Iterator[str]:
    """Give a temporary path beside `path` that replaces it when the block ends well.

    It is an empty file with the same suffix. On any exception it is removed, and `path` is as it
    was. Symbolic links are written through; an existing file keeps its permissions, a new one gets
    the usual ones. An OSError in the block becomes a FileError.
    """
    target = _target(os.fsdecode(path))
    # A name of its own, because the target's with a tail may be too long for the file system.
    name = f".weft-{os.getpid()}-{os.urandom(4).hex()}{os.path.splitext(target)[1]}"
    temporary = os.path.join(os.path.dirname(target), name)
    try:
        # Not the tempfile module: its files can be read by their owner alone.
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporary
        with suppress(FileNotFoundError):
            os.chmod(temporary, os.stat(target).st_mode & 0o777)
        os.replace(temporary, target)
    except BaseException as error:
        with suppress(OSError):
            os.unlink(temporary)
        if isinstance(error, OSError) and not isinstance(error, FileError):
            raise _error(path, "cannot write", error) from None
        raise


def sample_names() -> list[str]:
    """Return the names of the samples that ship with weft, sorted."""
    return sorted(_samples())


def sample_path(name: str) -> str:
    """Return the path of a shipped sample, a picture or a folder, by NAME or ``sample:NAME``."""
    name, samples = name.removeprefix("sample:"), _samples()
    if name not in samples:
        raise FileError(f"no sample is named '{_show(name)}'{did_you_mean(name, samples)}")
    return os.path.join(_SAMPLES, samples[name])


def is_folder(path: StrPath) -> bool:
    """Return whether the path is a folder, or names a sample that is a folder of maps."""
    given = os.fsdecode(path)
    known = not given.startswith("sample:") or given.removeprefix("sample:") in _samples()
    return known and os.path.isdir(_locate(given)[0])


def _samples() -> dict[str, str]:
    names = (file for file in os.listdir(_SAMPLES) if not file.startswith((".", "_", "MANIFEST")))
    return {os.path.splitext(file)[0]: file for file in names}


def _oiio() -> Any:
    import OpenImageIO  # 20 ms, for those who read or write a picture

    return OpenImageIO


def _locate(path: StrPath) -> tuple[str, str]:
    """Return the path on disk, and the path as it was given."""
    given = os.fsdecode(path)
    return (sample_path(given) if given.startswith("sample:") else given), given


def _target(given: str) -> str:
    """Return the path that a write ends at, through symbolic links."""
    try:
        target = os.path.realpath(given)
        target.encode()  # the library takes no other names
        return target
    except (OSError, ValueError) as error:
        raise _error(given, "is not a usable path", error) from None


def _suffix(path: str) -> str:
    return os.path.splitext(path)[1].lower()


def _kind(name: str, given: str) -> str:
    """Return the format that the first bytes of the file show."""
    try:
        if os.path.isdir(name):
            raise _error(given, "is a folder; name a picture in it")
        if os.path.exists(name) and not os.path.isfile(name):
            raise _error(given, "is not a regular file")
        name.encode()  # the library takes no other names
        with open(name, "rb") as file:
            head = file.read(16)
            if head.startswith(_PNG):
                _check_png(file, given)
    except FileError:
        raise
    except (OSError, ValueError) as error:
        raise _error(given, "cannot read", error) from None
    if not head:
        raise _error(given, "the file is empty")
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "webp"
    for kind, signatures in _SIGNATURES.items():
        if head.startswith(signatures):
            return kind
    raise _error(given, f"is not a picture that weft reads ({', '.join(_READABLE)})")


def _check_png(file: IO[bytes], given: str) -> None:
    """Find damage before libpng does, which prints to the terminal before it reports."""
    size, position, kind, seen = os.fstat(file.fileno()).st_size, len(_PNG), b"", set()
    while kind != b"IEND":
        file.seek(position)
        head = file.read(8)
        length, kind = int.from_bytes(head[:4], "big"), head[4:]
        if len(head) < 8 or position + 12 + length > size:
            raise _error(given, "the file is cut short")
        body, check = file.read(length), int.from_bytes(file.read(4), "big")
        sides = [int.from_bytes(body[k : k + 4], "big") for k in (0, 4)]
        header = position > len(_PNG) or (kind == b"IHDR" and 0 < min(sides) <= max(sides) <= 10**6)
        if not header or zlib.crc32(body, zlib.crc32(kind)) != check:
            raise _error(given, "the file is damaged")
        position += 12 + length
        seen.add(kind)
    if b"IDAT" not in seen:
        raise _error(given, "the file is damaged")


def _check_spec(spec: Any, given: str, max_pixels: int | None) -> None:
    """Refuse what is too large or of no use, from the header alone."""
    # A reader takes memory for a whole tile, which a header may claim to be larger than the rest.
    area = max(spec.width * spec.height, spec.tile_width * spec.tile_height)
    if max_pixels is not None and area > max_pixels:
        size = f"{spec.width} x {spec.height} pixels"
        raise _error(given, f"{size} are more than max_pixels = {max_pixels}")
    for space in map(spec.get_string_attribute, ("tiff:ColorSpace", "jpeg:ColorSpace")):
        if space in ("CMYK", "YCCK", "CIELAB", "ICCLAB", "ITULAB"):
            raise _error(given, f"holds {space} colours; convert it to RGB first")
    if spec.deep or spec.depth > 1:
        raise _error(given, "is a deep or volume picture; weft reads flat ones")
    if str(spec.format) not in _READ_AS:
        raise _error(given, f"holds {spec.format} pixels; weft reads uint8, uint16 and float")
    if str(spec.format) == "double" and spec.tile_width:  # OpenImageIO 3.2 reads them wrong
        raise _error(given, "holds tiled float64 pixels; store them as float32 or untiled")


def _straight(pixels: NDArray[Any], spec: Any, kind: str) -> tuple[NDArray[Any], bool]:
    """Return the pixels with straight alpha as the last channel, and whether there is any."""
    place = spec.alpha_channel
    # Many programs leave the fourth byte of a bitmap's pixels at zero and mean nothing by it.
    if kind == "bmp" and place == 3 and not pixels[..., 3].any():
        pixels, place = pixels[..., :3], -1
    if place < 0 or pixels.shape[2] == 1:
        return (pixels[..., 0] if pixels.shape[2] == 1 else pixels), False
    colour, cover = np.delete(pixels, place, axis=2), pixels[..., place : place + 1]
    if kind in ("tiff", "openexr") and not spec.get_int_attribute("oiio:UnassociatedAlpha"):
        if pixels.dtype.kind == "f":
            with np.errstate(all="ignore"):
                np.divide(colour, cover, out=colour, where=cover > 0)
        else:
            top, part = np.uint32(np.iinfo(pixels.dtype).max), np.maximum(cover, 1).astype("u4")
            whole = np.minimum((colour.astype("u4") * top + part // 2) // part, top)
            colour = np.where(cover > 0, whole, colour).astype(pixels.dtype)
    return np.concatenate([colour, cover], axis=2), True


def _upright(pixels: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Undo an EXIF orientation."""
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return pixels


def _varies(pixels: NDArray[Any]) -> bool:
    return bool((pixels != pixels[:1, :1]).any())


def _check_fit(given: str, form: _Format, pixels: NDArray[Any], alpha: bool) -> None:
    """Refuse what is no picture, or what the format cannot hold."""
    shape, suffix = pixels.shape, _suffix(given)
    colours = (shape[2] if len(shape) == 3 else 1) - alpha
    dtype = "float32" if pixels.dtype.kind == "f" else pixels.dtype.name
    if len(shape) not in (2, 3) or 0 in shape:
        problem = f"pixels of shape {shape} are no picture; use (H, W) or (H, W, C), not empty"
    elif colours < 1:
        problem = "alpha needs at least one channel of colour beside it"
    elif dtype not in ("uint8", "uint16", "float32"):
        problem = f"{dtype} pixels are not written; use uint8, uint16 or float32"
    elif not form.holds(dtype, colours, alpha):
        able = [key for key in sorted(_FORMATS) if _FORMATS[key].holds(dtype, colours, alpha)]
        what = f"{dtype} pixels of {colours} channel{'s'[: colours > 1]}{' and alpha' * alpha}"
        problem = f"'{suffix}' cannot hold {what}; use {', '.join(able)}"
    elif max(shape[:2]) > form.side:
        problem = f"'{suffix}' holds at most {form.side} pixels a side, not {max(shape[:2])}"
    else:
        return
    raise InvalidInputError(f"{given}: {problem}")


def _fits(icc: bytes | None, colours: int) -> bool:
    """Return whether this is a whole profile for so many channels."""
    space = {1: b"GRAY", 3: b"RGB "}.get(colours)
    whole = icc is not None and len(icc) > 128 and int.from_bytes(icc[:4], "big") == len(icc)
    return icc is not None and whole and icc[36:40] == b"acsp" and icc[16:20] == space


def _reserve(path: str, size: int) -> None:
    """Fill the file up to this size with noise, which no file system can compress away."""
    block = memoryview(os.urandom(2**18))
    with open(path, "r+b", buffering=0) as file:
        while size > 0:
            size -= file.write(block[:size])


def _encode(path: str, form: _Format, pixels: NDArray[Any], alpha: bool, icc: bytes | None) -> str:
    """Write with OpenImageIO and return what went wrong, or nothing."""
    oiio = _oiio()
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, _READ_AS.get(pixels.dtype.name, "float"))
    colours = channels - alpha
    names = ["Y"] if colours == 1 else ["R", "G", "B"] if colours >= 3 else []
    names += [f"channel{k:04}" for k in range(len(names), colours)]
    spec.channelnames = (*names, *["A"] * alpha)
    spec.alpha_channel = colours if alpha else -1
    for key, value in (("oiio:UnassociatedAlpha", 1), *form.options):
        spec[key] = value
    if icc is not None:
        kind = oiio.TypeDesc(oiio.UINT8, oiio.SCALAR, oiio.NOSEMANTICS, len(icc))
        spec.attribute("ICCProfile", kind, np.frombuffer(icc, np.uint8))
    file = oiio.ImageOutput.create(form.name)
    done = file.open(path, spec) and file.write_image(pixels) and file.close()
    return "" if done else _complaint(file) or "the encoder failed"


def _complaint(source: Any) -> str:
    """Take the library's error, which is printed at the end of the process if nobody does."""
    try:
        return str(source.geterror())
    except UnicodeDecodeError:  # it quotes the damaged file
        return "unknown error"


def _error(path: StrPath, what: str, why: object = "") -> FileError:
    """Return a one-line error, whatever the library had to say."""
    if isinstance(why, OSError) and why.strerror:
        why = why.strerror
    lines = str(why).strip().splitlines()
    return FileError(f"{_show(os.fsdecode(path))}: {what}{': '.join(['', *lines[:1]])}")


def _show(path: str) -> str:
    """Return a path that prints on one line."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in path) or "''"
