"""Pictures in and out: the only place that opens picture files.

Pixels keep the type they are stored in: uint8, uint16 or float32. Alpha is always straight, colors
are never converted, and what a format cannot hold is refused instead of squeezed in.

======  =====================  =========================================
suffix  pixel types written    channels
======  =====================  =========================================
.png    uint8, uint16          gray or RGB, with alpha or without
.jpg    uint8, at quality 95   gray or RGB
.tif    uint8, uint16, float   any number, with alpha or without
.webp   uint8, lossless        RGB, RGBA; gray is stored as RGB
.bmp    uint8                  gray or RGB
.exr    float                  any number, with alpha or without
======  =====================  =========================================

JPEG XL, Radiance HDR, TGA and GIF are only read. Reading goes by the content of a file, not by its
name. The path ``sample:NAME`` names a picture, or a folder of maps, that ships with weftex.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import (
    FileError,
    InvalidInputError,
    WeftexError,
    did_you_mean,
    is_number,
    is_whole,
    wrong_value,
)
from weftex.io import temporary as temporaries
from weftex.io.formats import (
    COLOR_SPACES,
    FORMATS,
    READ_AS,
    StrPath,
    check_fit,
    check_spec,
    complaint,
    density_of,
    encode,
    ensure_space,
    file_error,
    fits,
    image_library,
    kind_of,
    path_text,
    show,
    straight,
    suffix_of,
    upright,
    varies,
)
from weftex.io.png import read_density, write_png
from weftex.raster.arrays import as_array
from weftex.threads import thread_count

__all__ = [
    "MAX_PIXELS",
    "Picture",
    "atomic",
    "check_output",
    "read_image",
    "read_mask",
    "sample_names",
    "write_bytes",
    "write_image",
    "write_text",
]

MAX_PIXELS = 2**28
"""The default limit on the width times height of a picture that is read."""

_SAMPLES = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "samples")


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
        The color profile of the file.
    path : str
        The path that it was read from, as given.
    half : bool
        Whether its floats have 16 bits there.
    density : float or None
        Pixels per meter, if the file states the same number for both axes.
    note : str
        What was converted, if anything was.
    """

    pixels: NDArray[Any] = field(repr=False)
    alpha: bool
    icc: bytes | None = field(repr=False)
    path: str
    half: bool = field(default=False, repr=False)
    density: float | None = field(default=None, repr=False)
    note: str = field(default="", repr=False)


def read_image(path: StrPath, *, max_pixels: int | None = MAX_PIXELS) -> Picture:
    """Read a picture.

    Half and double floats become float32; palettes and fewer than 8 bits become uint8. The EXIF
    orientation is applied. Files of several images give the first, EXR files their data window.
    Premultiplied alpha of TIFF and EXR is divided out; alpha is always the last channel. CMYK
    becomes RGB, (1 - C)(1 - K) and so on, whatever its profile. Lab, signed and 32-bit integers,
    and deep and volume images are refused.

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
    if max_pixels is not None and not is_whole(max_pixels, 1):
        raise wrong_value("max_pixels", max_pixels, "1 or more, or None")
    name, given = locate(path)
    kind = kind_of(name, given)
    oiio = image_library()
    # Some readers decode while they open, so the library must know the limit before. Four floats
    # are 16 bytes; the floor is for pictures of few pixels and many channels.
    limit = 0 if max_pixels is None else min(max(256, -(-max_pixels // 2**16)), 2**31 - 1)
    oiio.attribute("limits:imagesize_MB", limit)
    hint = oiio.ImageSpec()
    hint["oiio:UnassociatedAlpha"] = 1
    try:
        source = oiio.ImageInput.open(name, hint)
        if source is None:
            problem = complaint(oiio)
            large = f"is larger than max_pixels = {max_pixels}"
            raise file_error(given, large if "imagesize_MB" in problem else "cannot read", problem)
        # The reader that goes with the suffix is asked first, and some claim any file.
        if source.format_name() != kind:
            raise file_error(given, f"is a {kind} image with the suffix of another; rename it")
        spec = source.spec()
        check_spec(spec, given, max_pixels)
        pixels = source.read_image(0, 0, 0, spec.nchannels, READ_AS[str(spec.format)])
        problem = complaint(source)
        source.close()
    except MemoryError:
        raise file_error(given, "does not fit in memory") from None
    # Readers hand out what they have of a damaged file, so the message counts, not the pixels.
    if pixels is None or problem:
        raise file_error(given, "the file is damaged or cut short", problem)
    pixels, alpha = straight(pixels, spec, kind)
    pixels = upright(pixels, spec.get_int_attribute("Orientation", 1))
    icc = spec.getattribute("ICCProfile")
    profile = None if icc is None else bytes(icc)
    half = str(spec.format) == "half"
    density = read_density(name) if kind == "png" else density_of(spec)
    note = ""
    if {"CMYK", "YCCK"} & {spec.get_string_attribute(name) for name in COLOR_SPACES}:
        note, profile = "CMYK became RGB, (1 - C)(1 - K) and so on, without its profile", None
    return Picture(np.ascontiguousarray(pixels), alpha, profile, given, half, density, note)


def write_image(
    path: StrPath,
    pixels: NDArray[Any],
    *,
    alpha: bool = False,
    icc: bytes | None = None,
    half: bool = False,
    density: float | None = None,
    threads: int | None = None,
) -> None:
    """Write a picture; the file appears whole or not at all.

    PNG and TIFF hold 8 and 16 bits, TIFF and EXR floats, the others 8 bits. float16 and float64 are
    written as float32; nothing else is converted. EXR stores premultiplied alpha, so it loses color
    under zero alpha, and so does WebP. Symbolic links are followed, permissions kept.

    Parameters
    ----------
    path : str or path-like
        The file; its suffix chooses the format.
    pixels : ndarray
        ``(H, W)`` or ``(H, W, C)``.
    alpha : bool
        Whether the last channel is straight alpha.
    icc : bytes or None
        A color profile. It is left out where the format holds none (BMP, EXR), and where it is
        broken or made for another number of channels, such as an RGB profile for a gray picture.
    half : bool
        Round floats to 16 bits, in EXR only.
    density : float, optional
        Pixels per meter, stored in PNG and JPEG (rounded), TIFF and EXR.
    threads : int, optional
        Maximum number of threads that compress a large PNG; one for each processor by default.

    Raises
    ------
    InvalidInputError
        If the array is not a picture, or the format cannot hold it.
    FileError
        If the file cannot be written; an existing file is then unchanged.
    """
    pixels = as_array(pixels, "pixels")
    check_output(path, pixels, alpha=alpha)
    if icc is not None and not isinstance(icc, bytes):
        raise wrong_value("icc", icc, "bytes")
    if density is not None and not (is_number(density) and 0 < density < 2**31):
        raise wrong_value("density", density, "above 0, below 2**31")
    form = FORMATS[suffix_of(path_text(path))]
    native = np.float32 if pixels.dtype.kind == "f" else pixels.dtype.newbyteorder("=")
    with np.errstate(all="ignore"):  # infinities are as good as any other value
        pixels = np.ascontiguousarray(np.atleast_3d(pixels), native)
        if alpha and form.name == "openexr":
            pixels = np.concatenate([pixels[..., :-1] * pixels[..., -1:], pixels[..., -1:]], axis=2)
    if pixels.shape[2] in form.widen:
        pixels = np.concatenate([pixels[..., :1]] * 2 + [pixels], axis=2)
    profile, at_once = icc if fits(icc, pixels.shape[2] - alpha) else None, thread_count(threads)
    with atomic(path) as temporary:
        if form.name == "png" and profile is None:
            with open(temporary, "wb") as file:
                write_png(file, pixels, at_once, density=density)
            return
        # On a full disk PNG reports success, JPEG ends the process and WebP crashes, so room is
        # made sure of first. Noise can grow by an eighth.
        ensure_space(temporary, pixels.nbytes * 5 // 4 + len(icc or b"") + 2**16)
        problem = encode(temporary, form, pixels, alpha, profile, half, density)
        if problem and profile is not None:  # libpng is stricter about them than we are
            problem = encode(temporary, form, pixels, alpha, None, half, density)
        if problem:
            raise file_error(path, "cannot write", problem)


def check_output(
    path: StrPath,
    like: NDArray[Any] | None = None,
    *,
    alpha: bool = False,
    suffixes: Collection[str] | None = None,
) -> None:
    """Refuse an output path that cannot work, before any work is done for it.

    Checks suffix (of pictures, or of `suffixes`), folder and permissions; with `like`, also that
    the format can hold its type and channels, the last of which is alpha if `alpha`.
    """
    given, known = path_text(path), FORMATS if suffixes is None else suffixes
    suffix, target = suffix_of(given), _target(given)
    folder = os.path.dirname(target)
    if given.startswith("sample:"):
        raise file_error(given, "samples cannot be overwritten; name a file")
    if os.path.isdir(target):
        raise file_error(given, "is a folder; name a file in it")
    if suffix not in known:
        near = did_you_mean(".png" if suffix == ".gif" else suffix, known)
        what = repr(suffix) if suffix else "without a suffix"
        raise file_error(given, f"cannot write {what}{near}")
    if not os.path.isdir(folder):
        raise file_error(given, f"the folder {show(folder)} does not exist")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise file_error(given, f"the folder {show(folder)} is read-only")
    if os.path.lexists(target) and not (os.path.isfile(target) and os.access(target, os.W_OK)):
        raise file_error(given, "exists and cannot be overwritten")
    if like is not None and suffixes is None:
        check_fit(show(given), FORMATS[suffix], like, alpha)


def read_mask(path: StrPath, *, max_pixels: int | None = MAX_PIXELS) -> NDArray[np.bool_]:
    """Read a picture as an ``(H, W)`` mask; see `mask_of`, and for the parameters `read_image`."""
    picture = read_image(path, max_pixels=max_pixels)
    return mask_of(picture.pixels, picture.alpha)


def mask_of(pixels: NDArray[Any], alpha: bool) -> NDArray[np.bool_]:
    """The mask (H, W) of a picture: True where any color channel is at least half of its range.

    Alpha counts only if the color is constant and alpha is not.
    """
    pixels = np.atleast_3d(pixels)
    if alpha:
        color, cover = pixels[..., :-1], pixels[..., -1:]
        pixels = cover if varies(cover) and not varies(color) else color
    half = 0.5 if pixels.dtype.kind == "f" else np.iinfo(pixels.dtype).max // 2 + 1
    if half > 1 and pixels.max(initial=0) == 1:
        raise InvalidInputError(f"the mask has the values 0 and 1; white begins at {half}")
    return np.asarray((pixels >= half).any(axis=2))


@contextmanager
def atomic(path: StrPath) -> Iterator[str]:
    """Yield a temporary path beside `path` that is synced and replaces it when the block succeeds.

    Exceptions remove it; OSError becomes a `FileError` that names `path`. Symbolic links and
    permissions are kept. A path that is already temporary is yielded as it is.
    """
    given = path_text(path)
    target, temporary = _target(given), ""
    try:
        if temporaries.is_mine(target):
            yield target
            return
        # A name of its own, because the target's with a tail may be too long for the file system.
        temporary = temporaries.claim(os.path.dirname(target), os.path.splitext(target)[1])
        yield temporary
        with suppress(FileNotFoundError):
            os.chmod(temporary, os.stat(target).st_mode & 0o777)
        temporaries.write_through(temporary)
        os.replace(temporary, target)
    except WeftexError as error:
        said = str(error)
        if not temporary or show(temporary) not in said:
            raise
        raise type(error)(said.replace(show(temporary), show(given))) from None
    except OSError as error:
        raise file_error(path, "cannot write", error) from None
    finally:
        if temporary:
            temporaries.release(temporary)


def sample_names() -> list[str]:
    """Return the names of the samples that ship with weftex, sorted, a set of maps as one."""
    return sorted(name for name in _samples() if "/" not in name)


def sample_path(name: str) -> str:
    """The path of a packaged sample, a picture or a folder, from NAME or `sample:NAME[/MAP]`."""
    name, samples = name.removeprefix("sample:"), _samples()
    if name not in samples:
        raise FileError(f"no sample is named '{show(name)}'{did_you_mean(name, samples)}")
    return os.path.join(_SAMPLES, samples[name])


def is_folder(path: StrPath) -> bool:
    """Return whether the path is a folder, or names a sample that is a folder of maps."""
    given = path_text(path)
    known = not given.startswith("sample:") or given.removeprefix("sample:") in _samples()
    return known and os.path.isdir(locate(given)[0])


def _samples() -> dict[str, str]:
    names = [file for file in os.listdir(_SAMPLES) if not file.startswith((".", "_", "MANIFEST"))]
    for folder in [name for name in names if "." not in name]:
        names += [f"{folder}/{file}" for file in os.listdir(os.path.join(_SAMPLES, folder))]
    return {os.path.splitext(file)[0]: file for file in names}


def locate(path: StrPath) -> tuple[str, str]:
    """Return the path on disk of a file or of ``sample:NAME``, and the path as it was given."""
    given = path_text(path)
    return (sample_path(given) if given.startswith("sample:") else given), given


def _target(given: str) -> str:
    """Return the path that a write ends at, through symbolic links."""
    try:
        target = os.path.realpath(given)
        target.encode()  # the library takes no other names
        return target
    except (OSError, ValueError) as error:
        raise file_error(given, "is not a usable path", error) from None


def write_text(path: StrPath, text: str) -> None:
    """Write a text in UTF-8; the file appears whole or not at all."""
    write_bytes(path, text.encode())


def write_bytes(path: StrPath, content: bytes) -> None:
    """Write a file; it appears whole or not at all."""
    with atomic(path) as temporary, open(temporary, "wb") as file:
        file.write(content)
