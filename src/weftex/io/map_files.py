"""The files of a set of maps: which of a folder's they are, and how libraries name them."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from weftex.errors import InvalidInputError, did_you_mean
from weftex.io.formats import READABLE, bits_of, file_error, show, suffix_of
from weftex.io.pictures import locate

if TYPE_CHECKING:
    from weftex.io.formats import StrPath
    from weftex.roles import Role

__all__ = ["SCHEMES", "file_stem"]

#: Where libraries keep the maps beside a scene file.
_INNER = "textures"
#: Pictures that weftex does not read, so that nobody misses one without a word.
_UNREAD = (".tga", ".psd", ".dds", ".gif", ".jp2", ".ktx", ".ktx2", ".sgi", ".pic", ".tx")
_LOSSY = (".jpg", ".jpeg")
#: By scheme what stands after the material's name, by role, where it is not the role's own name.
SCHEMES: dict[str, dict[str, str]] = {
    "ambientcg": {
        "normal_gl": "NormalGL", "normal_dx": "NormalDX", "height": "Displacement",
        "metallic": "Metalness", "ao": "AmbientOcclusion", "orm": "ORM",
    },
    "polyhaven": {
        "color": "diff", "normal_gl": "nor_gl", "normal_dx": "nor_dx", "height": "disp",
        "roughness": "rough", "metallic": "metal", "orm": "arm", "translucency": "translucent",
        "specular": "spec",
    },
    "substance": {
        "color": "BaseColor", "normal_gl": "Normal_OpenGL", "normal_dx": "Normal_DirectX",
        "ao": "AmbientOcclusion", "emission": "Emissive", "gloss": "Glossiness",
        "orm": "OcclusionRoughnessMetallic",
    },
    "gltf": {
        "color": "baseColor", "normal_gl": "normal", "normal": "normal", "ao": "occlusion",
        "emission": "emissive", "orm": "occlusionRoughnessMetallic",
    },
}  # fmt: skip


def map_files(folder: StrPath) -> tuple[dict[str, str], list[str]]:
    """Paths of a folder's pictures by stem, and notes on what was left out.

    Of two with one stem the deeper wins, then the one that is not a JPEG. A folder without pictures
    may have them in `textures`. Raises `FileError` if there are none, or two alike.
    """
    name, given = locate(folder)
    paths, notes = _listed(name, given)
    inner = os.path.join(name, _INNER)
    if not paths and os.path.isdir(inner):
        paths, notes = _listed(inner, given)
        notes.insert(0, f"maps are those in {show(os.path.join(given, _INNER))}")
    if not paths:
        raise file_error(given, f"has no pictures ({', '.join(READABLE)})")
    return paths, notes


def _listed(name: str, given: str) -> tuple[dict[str, str], list[str]]:
    try:
        found = sorted(os.listdir(name))
    except (OSError, ValueError) as error:
        raise file_error(given, "cannot read the folder", error) from None
    paths: dict[str, str] = {}
    notes = []
    for file in found:
        stem, full = os.path.splitext(file)[0], os.path.join(name, file)
        if file.startswith(".") or os.path.isdir(full):
            continue
        if suffix_of(file) in _UNREAD:
            notes.append(f"{show(file)} is ignored: weftex does not read {suffix_of(file)}")
        if suffix_of(file) not in READABLE:
            continue
        if stem in paths:
            pair = sorted((full, paths[stem]), key=_depth)
            if _depth(pair[0]) == _depth(pair[1]):
                raise file_error(given, f"has two pictures named '{show(stem)}'; keep one")
            left, kept = (show(os.path.basename(path)) for path in pair)
            why = "has more bits" if _depth(pair[0])[0] < _depth(pair[1])[0] else "is not a JPEG"
            notes.append(f"{left} is ignored: {kept} {why}")
            full = pair[1]
        paths[stem] = full
    return paths, notes


def _depth(path: str) -> tuple[int, bool]:
    return bits_of(path), suffix_of(path) not in _LOSSY


def file_stem(scheme: str, material: str, role: Role) -> str:
    """The file name without suffix that a naming scheme gives to a map of a material."""
    if scheme not in SCHEMES:
        raise InvalidInputError(f"names is '{scheme}'{did_you_mean(scheme, SCHEMES)}")
    words = role.name.split("_")
    if scheme in ("ambientcg", "substance"):
        own = "".join(word.capitalize() for word in words)
    else:
        own = role.name if scheme == "polyhaven" else words[0] + "".join(map(str.title, words[1:]))
    return f"{material}_{SCHEMES[scheme].get(role.name, own)}"
