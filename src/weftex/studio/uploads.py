"""Pictures that come in: counted in bytes while they come, in pixels before they are decoded."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from weftex.errors import FileError, InvalidInputError
from weftex.io.formats import kind_of
from weftex.io.pictures import Picture, read_image
from weftex.roles import role_of
from weftex.studio.refusals import Refusal

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable
    from pathlib import Path
    from threading import Lock

    from weftex.studio.limits import Limits
    from weftex.studio.sessions import Session

#: By what the first bytes say; readers go by suffixes.
_SUFFIXES = {
    "png": ".png", "jpeg": ".jpg", "tiff": ".tif", "webp": ".webp",
    "bmp": ".bmp", "openexr": ".exr", "hdr": ".hdr", "jpegxl": ".jxl",
}  # fmt: skip
_LONGEST_NAME = 100


def label_of(given: str | None) -> str:
    """Return what a file is called in words and downloads; it is never where anything is."""
    last = unquote(given or "").replace("\\", "/").rpartition("/")[2]  # never a folder
    kept = "".join(c for c in last if c.isprintable() and c not in '<>:"|?*').strip(" .")
    return kept[-_LONGEST_NAME:] or "picture"


async def receive(
    chunks: AsyncIterator[bytes],
    name: str,
    session: Session,
    limits: Limits,
    finish: Callable[[Callable[[], dict[str, Any]]], Awaitable[dict[str, Any]]],
) -> dict[str, Any]:
    """Return the description of an upload that comes in; `finish` decodes it in a thread."""
    coming = _Coming(name, session, limits)
    try:
        async for chunk in chunks:
            coming.write(chunk)
        return await finish(coming.finish)
    finally:
        coming.close()


def file_in(path: Path, name: str, session: Session, limits: Limits) -> dict[str, Any]:
    """Return the description of a file of this machine, which the command named."""
    coming = _Coming(name, session, limits)
    try:
        with path.open("rb") as file:
            while chunk := file.read(2**20):
                coming.write(chunk)
        return coming.finish()
    finally:
        coming.close()


class _Coming:
    """A file that is coming in; nothing of it is left unless it is finished."""

    def __init__(self, name: str, session: Session, limits: Limits) -> None:
        self.name, self.shelf, self.limits = name, session.shelf, limits
        self.shelf.check_room(limits.uploads)
        self.path, self.digest = self.shelf.new_file(), hashlib.sha256()
        self.count = self.counted = 0
        self.out = self.path.open("wb", buffering=0)  # closing it must not write

    def write(self, chunk: bytes) -> None:
        """Append a piece, or raise `Refusal` if there is no room."""
        if self.count + len(chunk) > self.limits.upload_bytes:
            most = self.limits.upload_bytes / 2**20
            raise Refusal(413, f"{self.name} has more than {most:g} MiB, the most for one file")
        self.shelf.store.reserve(len(chunk))
        self.count += len(chunk)
        self.counted += len(chunk)
        self.digest.update(chunk)
        self.out.write(chunk)

    def finish(self) -> dict[str, Any]:
        """Decode the file and name it after its content; return its description."""
        self.out.close()
        about = {"id": self.digest.hexdigest(), "name": self.name, "bytes": self.count}
        found = self.shelf.uploads.get(str(about["id"]))
        if found is None:
            store = self.shelf.store
            found = _looked_at(self.path, about, self.limits.upload_pixels, store.decoding)
            if self.shelf.take(self.path, found, self.limits.uploads):
                self.counted = 0
        return found | {"name": self.name}

    def close(self) -> None:
        """Forget what was not finished."""
        self.out.close()
        self.shelf.store.reserve(-self.counted)
        self.path.unlink(missing_ok=True)


def _looked_at(
    file: Path, about: dict[str, Any], most_pixels: int, decoding: Lock
) -> dict[str, Any]:
    """Return the description of a file, which is decoded once, to know that it can be."""
    name = str(about["name"])
    suffix = _SUFFIXES[kind_of(str(file), name)]
    named = file.with_suffix(suffix)
    file.rename(named)
    try:
        pixels = _read(named, name, most_pixels, decoding)
    finally:
        named.rename(file)
    role = role_of(name.rpartition(".")[0])
    return about | {
        "suffix": suffix,
        "width": pixels.pixels.shape[1],
        "height": pixels.pixels.shape[0],
        "channels": pixels.pixels.shape[2] if pixels.pixels.ndim == 3 else 1,
        "dtype": pixels.pixels.dtype.name,
        "alpha": pixels.alpha,
        "role": None if role is None else role.name,
    }


def picture_of(upload: str, session: Session, limits: Limits) -> Picture:
    """Return the picture of an upload, under the name that its owner gave it."""
    about = session.upload(upload)
    path, decoding = session.shelf.path(about), session.shelf.store.decoding
    found = _read(path, about["name"], limits.upload_pixels, decoding)
    return Picture(found.pixels, found.alpha, found.icc, about["name"], found.half)


def _read(path: Path, name: str, most_pixels: int, decoding: Lock) -> Picture:
    """Return a picture, of all threads one at a time; errors have its owner's name for it."""
    try:
        with decoding:
            return read_image(path, max_pixels=most_pixels)
    except (FileError, InvalidInputError) as error:
        line = str(error).replace(str(path), name).replace(path.name, name)
        if "max_pixels" in line:
            line = f"{name} has more than {most_pixels / 2**20:g} megapixels, the most for one file"
            raise Refusal(413, line) from None
        raise FileError(line) from None
