"""What the maps of a material show, and what libraries and programs call their files.

ambientCG writes ``Bricks_1K-PNG_NormalGL.png``, Poly Haven ``brick_wall_nor_gl_4k.exr``, Substance
``brick_BaseColor.tif``, Megascans ``tlrkcbjn_4K_Roughness.jpg``, Materialize ``brick_smoothness``,
glTF ``brick_metallicRoughness``; people write ``normal.png``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from weftex.errors import InvalidInputError, did_you_mean, is_number, shown, wrong_value

__all__ = ["COLOR", "ROLES", "Role", "is_preview", "role_of", "words_of"]

#: A channel that nothing is stored in.
UNUSED = "unused"


@dataclass(frozen=True)
class Role:
    """What a map shows.

    Attributes
    ----------
    name : str
        Its key in `Exemplar.maps`.
    kind : str
        "color", "normal", "height", "labels" or "data"; decides how values are blended.
    files : tuple of str
        What files call it: words in small letters.
    channels : tuple of str
        Of a packed map the roles of its channels; never alpha.
    """

    name: str
    kind: str = "data"
    files: tuple[str, ...] = ()
    channels: tuple[str, ...] = ()

    @property
    def srgb(self) -> bool:
        """Whether whole numbers are sRGB; floats are linear, and so is all else."""
        return self.kind == "color"

    def __str__(self) -> str:
        about = {"normal": "direction of y unknown", "normal_gl": "y up", "normal_dx": "y down"}
        more = ", ".join(self.channels) or about.get(self.name)
        return f"{self.name} ({more})" if more else self.name


def _packed(name: str, channels: str, *files: str) -> Role:
    return Role(name, "data", files, tuple(channels.split()))


_HEAVIEST = 100  # weight of a map

#: The role of the picture that a material is known by.
COLOR = Role(
    "color", "color",
    ("albedo", "base color", "basecolor", "base colour", "basecolour", "diffuse", "color",
     "colour", "col", "diff"),
)  # fmt: skip
#: All roles by their names.
ROLES = {role.name: role for role in (
    COLOR,
    Role("normal", "normal", ("normal", "normals", "nor", "nrm", "norm")),
    Role("normal_gl", "normal",
         ("normal gl", "normalgl", "nor gl", "normal opengl", "normal open gl")),
    Role("normal_dx", "normal",
         ("normal dx", "normaldx", "nor dx", "normal directx", "normal direct x")),
    Role("height", "height", ("height", "heightmap", "displacement", "disp")),
    Role("bump", "height", ("bump",)),
    Role("depth", "height", ("depth",)),
    Role("roughness", "data", ("roughness", "rough")),
    Role("gloss", "data", ("gloss", "glossiness", "smoothness")),
    Role("metallic", "data", ("metallic", "metalness", "metal", "metalic")),
    Role("ao", "data", ("ao", "ambient occlusion", "ambientocclusion", "occlusion")),
    Role("specular", "data", ("specular", "spec", "reflection", "specular level")),
    Role("specular_color", "color", ("specular color", "specularcolor")),
    Role("opacity", "data", ("opacity", "alpha", "transparency")),
    Role("transmission", "data", ("transmission",)),
    Role("mask", "data", ("mask",)),
    Role("detail", "data", ("detail", "detail mask")),
    Role("emission", "color", ("emission", "emissive", "emit")),
    Role("cavity", "data", ("cavity",)),
    Role("curvature", "data", ("curvature",)),
    Role("edge", "data", ("edge",)),
    Role("fuzz", "data", ("fuzz",)),
    Role("thickness", "data", ("thickness",)),
    Role("translucency", "color", ("translucency", "translucent")),
    Role("anisotropy", "data", ("anisotropy", "anisotropic", "aniso", "anisotropy strength")),
    Role("anisotropy_rotation", "data", ("anisotropy rotation", "anisotropy angle")),
    Role("clearcoat", "data", ("clearcoat", "clear coat", "coat")),
    Role("sheen", "data", ("sheen",)),
    Role("position", "data", ("position", "pos")),
    Role("id", "labels",
         ("id", "ids", "label", "labels", "idmask", "id mask", "segmentation", "classes")),
    _packed("orm", "ao roughness metallic", "orm", "arm", "occlusion roughness metallic",
            "occlusionroughnessmetallic"),
    _packed("rma", "roughness metallic ao", "rma"),
    _packed("mra", "metallic roughness ao", "mra"),
    _packed("metallic_roughness", "unused roughness metallic", "metallic roughness",
            "metallicroughness"),
    _packed("metallic_smoothness", "metallic unused unused gloss", "metallic smoothness",
            "metallicsmoothness"),
    _packed("metallic_occlusion_smoothness", "metallic ao unused gloss",
            "metallic occlusion smoothness", "metallicocclusionsmoothness"),
    _packed("mask_map", "metallic ao detail gloss", "mask map", "maskmap"),
    Role("roughness_ao", "data", ("rough ao", "roughness ao")),
)}  # fmt: skip

#: Words that say how a map is stored: resolution, depth, file type, level of detail, tile, copy.
_ABOUT_FILE = re.compile(
    r"\d+|\d+k|\d+x\d+|\d+(bit|px)|png|jpe?g|exr|tiff?|webp|lod\d*|srgb|linear|raw|map|texture|tex|v\d+"
)
_PREVIEW = re.compile(r"previews?|thumb|thumbs|thumbnails?|render|renders|icon")


def width_of(role: str) -> int:
    """Return the number of channels of a role in a packed file."""
    return 3 if role != UNUSED and ROLES[role].kind in ("color", "normal") else 1


def as_role(role: Any) -> Role:
    """The role with this name, or the role itself; raises if there is none."""
    if isinstance(role, Role):
        return role
    if not isinstance(role, str) or role not in ROLES:
        near = did_you_mean(role, ROLES) if isinstance(role, str) else "; it must be a text"
        raise InvalidInputError(f"role is {shown(role)}{near}")
    return ROLES[role]


def words_of(stem: str) -> list[str]:
    """The lower-case words of a file name, without those about the file (4k, png, 16bit)."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", stem)
    words = [word.lower() for word in re.split(r"[\W_]+", spaced) if word]
    # "mask map" has a name of its own, "normal map" is a normal.
    pairs = zip(words, ["", *words], strict=False)
    return [w for w, last in pairs if not _ABOUT_FILE.fullmatch(w) or (last, w) == ("mask", "map")]


def role_of(stem: str) -> Role | None:
    """The role that a file name without suffix begins or ends with, or None."""
    words, known = words_of(stem), _by_words()
    most = max(map(len, known))
    for ends in (True, False):
        for count in range(min(most, len(words)), 0, -1):
            found = tuple(words[-count:] if ends else words[:count])
            if found in known:
                return known[found]
    return None


def is_preview(stem: str) -> bool:
    """Whether a file name says that the picture is a preview of the material."""
    words = words_of(stem)
    return bool(words) and any(_PREVIEW.fullmatch(word) for word in (words[0], words[-1]))


def is_name_of(stem: str, maps: list[str]) -> bool:
    """Whether a file name is the bare name of the material of these maps."""
    words = words_of(stem)
    same = [words_of(other)[: len(words)] == words for other in maps]
    return bool(words) and role_of(stem) is None and len(same) > 0 and all(same)


def checked_weights(given: Any, maps: Collection[str]) -> dict[str, float]:
    """The weight of each map in matching, 1 by default; raises for unknown maps or bad values."""
    weights = dict.fromkeys(maps, 1.0)
    if given is not None and not isinstance(given, Mapping):
        raise wrong_value("weights", given, "numbers by maps' names")
    for name, value in (given or {}).items():
        if name not in weights:
            raise InvalidInputError(f"weights has {shown(name)}{did_you_mean(str(name), maps)}")
        if not (is_number(value) and 0 <= value <= _HEAVIEST):
            raise wrong_value(f"the weight of {name}", value, f"from 0 to {_HEAVIEST}")
        weights[name] = float(value)
    return weights


@cache
def _by_words() -> dict[tuple[str, ...], Role]:
    named = {tuple(words.split()): role for role in ROLES.values() for words in role.files}
    own = {tuple(name.split("_")): role for name, role in ROLES.items()}
    return own | named
