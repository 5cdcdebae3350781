"""What the command was given: a bundled sample, a picture, or a folder of maps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from weftex.io.pictures import is_folder, sample_path

if TYPE_CHECKING:
    from weftex.studio.limits import Limits
    from weftex.studio.sessions import Session


@dataclass(frozen=True)
class Opened:
    """What a page begins with."""

    name: str
    sample: str | None  # of a bundled sample, its name
    files: dict[str, Path]  # else the files by the maps that they are

    @classmethod
    def of(cls, path: str, limits: Limits) -> Opened:
        """Look at what the command was given."""
        if path.startswith("sample:") and "/" not in path:
            sample_path(path)
            return cls(path, path.removeprefix("sample:"), {})
        from weftex.material import read_material

        material = read_material(path, max_pixels=limits.upload_pixels)
        if not is_folder(path):
            (picture,) = material.pictures.values()
            return cls(material.name, None, {"color": Path(picture.path)})
        files = {name: Path(one.path) for name, one in material.pictures.items()}
        return cls(material.name, None, files)

    def give(self, session: Session) -> dict[str, Any]:
        """Put the files among a session's uploads; the material's description."""
        if self.sample is not None:
            return {"sample": self.sample}
        from weftex.studio.uploads import file_in

        maps = {name: file_in(path, session)["id"] for name, path in self.files.items()}
        return {"maps": maps} | ({"name": self.name} if len(maps) > 1 else {})
