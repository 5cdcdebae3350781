"""Images that come in: counted in bytes while they come, in pixels before they are decoded."""

from __future__ import annotations

import hashlib
import os
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from weftex.errors import FileError, InvalidInputError
from weftex.exemplar.material import read_material
from weftex.io.formats import SUFFIXES, kind_of
from weftex.io.pictures import Picture, read_image
from weftex.recipe import checked_material
from weftex.studio.limits import Limits
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import Session, path_of

_LONGEST_NAME = 100


def label_of(given: str | None) -> str:
    """Return what a file is called in words and downloads; it is never where anything is."""
    last = unquote(given or "").replace("\\", "/").rpartition("/")[2]  # never a folder
    kept = "".join(c for c in last if c.isprintable() and c not in '<>:"|?*').strip(" .")
    return kept[-_LONGEST_NAME:] or "picture"


def stem_of(given: str) -> str:
    """Return what a file is called, without its suffix."""
    return os.path.splitext(label_of(given))[0]


def file_in(path: Path, session: Session) -> dict[str, Any]:
    """Return the description of a file of this machine, which the command named."""
    with IncomingUpload(label_of(path.name), session) as coming, path.open("rb") as file:
        while chunk := file.read(2**20):
            coming.write(chunk)
        return coming.finish()


class IncomingUpload:
    """An upload that is coming in; nothing of it is left unless it is finished."""

    def __init__(self, name: str, session: Session) -> None:
        self.name, self.session = name, session
        session.check_room()
        self.path, self.digest = session.new_file(), hashlib.sha256()
        self.count, self.taken = 0, False
        self.out = self.path.open("wb", buffering=0)  # closing it must not write

    def __enter__(self) -> IncomingUpload:
        return self

    def write(self, chunk: bytes) -> None:
        """Append a piece, or raise `Refusal` if the limit is reached."""
        most = self.session.limits.upload_bytes
        if self.count + len(chunk) > most:
            line = f"{self.name} is larger than {most / 2**20:g} MiB, the limit for one file"
            raise Refusal(413, line)
        self.session.store.reserve(len(chunk))
        self.count += len(chunk)
        self.digest.update(chunk)
        self.out.write(chunk)

    def finish(self) -> dict[str, Any]:
        """Decode the file, to know that it can be, and name it after its content."""
        self.out.close()
        about = {"id": self.digest.hexdigest(), "name": self.name, "bytes": self.count}
        found = self.session.uploads.get(str(about["id"]))
        if found is None:
            kind = kind_of(str(self.path), self.name)  # by the first bytes; readers go by suffixes
            suffix = SUFFIXES.get(kind, f".{kind}")
            self.path = self.path.rename(self.path.with_suffix(suffix))
            _read(self.path, self.name, self.session)
            found = about | {"suffix": suffix}
            self.taken = self.session.take(self.path, found)
        return found | {"name": self.name}

    def link(self, source: Path, about: dict[str, Any]) -> None:
        """Take an upload of another session, by a link to its file where the disk allows that."""
        self.session.store.reserve(about["bytes"])
        self.count = about["bytes"]
        self.out.close()
        self.path.unlink()
        try:
            os.link(source, self.path)
        except FileNotFoundError:
            raise Refusal(404, "this work is no longer there") from None
        except OSError:
            shutil.copyfile(source, self.path)
        self.taken = self.session.take(self.path, about)

    def __exit__(self, *error: object) -> None:
        self.out.close()
        if not self.taken:
            self.session.store.release(self.count)
        self.path.unlink(missing_ok=True)


def picture_of(upload: str, session: Session) -> Picture:
    """Return the picture of an upload, under the name that its owner gave it."""
    about = session.upload(upload)
    found = _read(path_of(session.folder, about), about["name"], session)
    return replace(found, path=about["name"])


def _read(path: Path, name: str, session: Session) -> Picture:
    """Return a picture, of all threads one at a time; errors have its owner's name for it."""
    most = session.limits.upload_pixels
    try:
        with session.store.decoding:
            return read_image(path, max_pixels=most)
    except (FileError, InvalidInputError) as error:
        line = str(error).replace(str(path), name).replace(path.name, name)
        if "max_pixels" in line:
            line = f"{name} has more than {most / 2**20:g} megapixels, the limit for one file"
            raise Refusal(413, line) from None
        raise FileError(line) from None


@dataclass(frozen=True)
class StartMaterial:
    """What a page begins with: the description of a material, and the files of its maps."""

    spec: dict[str, Any]
    files: dict[str, Path]

    @classmethod
    def of(cls, path: str, limits: Limits) -> StartMaterial:
        """Look at what the command was given."""
        if path.startswith("sample:") and "/" not in path:
            return cls(checked_material({"sample": path}), {})
        material = read_material(path, max_pixels=limits.upload_pixels)
        pictures = material.pictures.items()
        files = {k if material.folder else "color": Path(one.path) for k, one in pictures}
        return cls({"name": material.name} if len(files) > 1 else {}, files)

    def give(self, session: Session) -> dict[str, Any]:
        """Put the files among a session's uploads; the material's description."""
        if not self.files:
            return self.spec
        maps = {name: file_in(path, session)["id"] for name, path in self.files.items()}
        return {**self.spec, "maps": maps}
