"""What the tests of files have in common: pictures to write, and how errors are looked at."""

import functools
import os
import struct
import textwrap
import zlib

import numpy as np
import pytest

import families
from processes import run
from weftex.errors import FileError
from weftex.io import pictures as io

ImageCms = pytest.importorskip("PIL.ImageCms")

RGB_PROFILE = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
GRAY_PROFILE = RGB_PROFILE[:16] + b"GRAY" + RGB_PROFILE[20:]

#: Random pixels; in files floating-point ones also lie below 0 and above 1.
noise = functools.partial(families.noise, wide=True)


def read_back(path, pixels, **how):
    """Write a picture, and read it."""
    io.write_image(path, pixels, **how)
    return io.read_image(path)


def smooth(height, width, channels=3):
    y, x = np.mgrid[:height, :width]
    waves = [np.sin(y / (7 + k)) + np.cos(x / (5 + k)) for k in range(channels)]
    return np.round(np.stack(waves, 2) * 60 + 128).astype("uint8")


def fails(path, match, call=io.read_image, *more, error=FileError, **how):
    """Assert that a call on a path is an error of one line that begins with the path."""
    with pytest.raises(error, match=match) as info:
        call(path, *more, **how)
    text = str(info.value)
    assert "\n" not in text
    assert text.startswith(f"{path}: ")
    return text


def files_in(folder):
    return sorted(os.listdir(folder))


def kind_of(pixels):
    return {"float32": "float", "float16": "half"}.get(pixels.dtype.name, pixels.dtype.name)


def oiio_write(path, kind, pixels, names=None, alpha=-1, **options):
    import OpenImageIO as oiio

    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind_of(pixels))
    spec.channelnames = names or spec.channelnames
    spec.alpha_channel = alpha
    for key, value in options.items():
        spec[key.replace("__", ":")] = value
    file = oiio.ImageOutput.create(kind)
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(pixels), file.geterror()
    assert file.close()


PREMULTIPLIED, STRAIGHT = 1, 2
PNG = b"\x89PNG\r\n\x1a\n"


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def bomb(width, height):
    """A PNG that says how large it is, and has the pixels of a small picture."""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return PNG + header + chunk(b"IDAT", zlib.compress(b"\0" * 1000)) + chunk(b"IEND", b"")


def run_as_nobody(code, folder, *paths):
    """Run code, in which `said` prints the error of a call, as a user who may not do everything."""
    while str(folder) not in ("/", "/tmp"):  # which lead to this folder of pytest's
        os.chmod(folder, os.stat(folder).st_mode | 0o111)
        folder = os.path.dirname(folder)
    return run(AS_NOBODY + textwrap.dedent(code), *paths)


AS_NOBODY = """
import os, sys
import numpy as np
import OpenImageIO
from weftex.io import pictures as io

if os.getuid() == 0:
    os.setgid(65534)
    os.setuid(65534)

def said(call, *words):
    try:
        call(*words)
    except io.FileError as error:
        print(error)

"""


def store(path, pixels):
    """Write a picture, also in the format that weftex only reads."""
    if path.suffix == ".jxl":
        oiio_write(path, "jpegxl", np.atleast_3d(pixels))
    else:
        io.write_image(path, pixels)


FULL = [".png", ".jpg", ".tif", ".webp", ".bmp", ".exr"]
