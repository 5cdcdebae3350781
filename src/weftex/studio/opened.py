"""What the command was given: a bundled sample, a picture, or a folder of maps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from weftex.exemplar.material import read_material
from weftex.recipe import checked_material

if TYPE_CHECKING:
    from weftex.studio.limits import Limits
    from weftex.studio.sessions import Session


@dataclass(frozen=True)
class Opened:
    """What a page begins with: the description of a material, and the files of its maps."""

    spec: dict[str, Any]
    files: dict[str, Path]

    @classmethod
    def of(cls, path: str, limits: Limits) -> Opened:
        """Look at what the command was given."""
        if path.startswith("sample:") and "/" not in path:
            return cls(checked_material({"sample": path}), {})
        material = read_material(path, max_pixels=limits.upload_pixels)
        if not material.folder:
            (picture,) = material.pictures.values()
            return cls({}, {"color": Path(picture.path)})
        files = {name: Path(one.path) for name, one in material.pictures.items()}
        return cls({"name": material.name} if len(files) > 1 else {}, files)

    def give(self, session: Session) -> dict[str, Any]:
        """Put the files among a session's uploads; the material's description."""
        if not self.files:
            return self.spec
        from weftex.studio.uploads import file_in

        maps = {name: file_in(path, session)["id"] for name, path in self.files.items()}
        return {**self.spec, "maps": maps}
