"""What the maps of a material are called: the names that libraries and programs give their files.

ambientCG writes ``Bricks_1K-PNG_NormalGL.png``, Poly Haven ``brick_wall_nor_gl_4k.exr``, Substance
``brick_BaseColor.tif``, Megascans ``tlrkcbjn_4K_Roughness.jpg``, glTF ``brick_metallicRoughness``;
people write ``normal.png``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from weftex.errors import InvalidInputError

#: The role of the picture that a material is known by.
COLOR = "color"

#: What a map shows, and how it is called: words of the file's name, in small letters.
ROLES: dict[str, tuple[str, ...]] = {
    COLOR: (
        "albedo", "base color", "basecolor", "base colour", "basecolour", "diffuse", "color",
        "colour", "col", "diff",
    ),
    "normal": ("normal", "normals", "nor", "nrm", "norm"),
    "normal (OpenGL)": ("normal gl", "normalgl", "nor gl", "normal opengl", "normal open gl"),
    "normal (DirectX)": ("normal dx", "normaldx", "nor dx", "normal directx", "normal direct x"),
    "height": ("height", "heightmap", "displacement", "disp"),
    "bump": ("bump",),
    "depth": ("depth",),
    "roughness": ("roughness", "rough"),
    "gloss": ("gloss", "glossiness", "smoothness"),
    "metalness": ("metalness", "metallic", "metal", "metalic"),
    "ambient occlusion": ("ao", "ambient occlusion", "ambientocclusion", "occlusion"),
    "specular": ("specular", "spec", "reflection", "specular level"),
    "specular color": ("specular color", "specularcolor"),
    "opacity": ("opacity", "alpha", "transparency", "transmission"),
    "mask": ("mask",),
    "emission": ("emission", "emissive", "emit"),
    "cavity": ("cavity",),
    "curvature": ("curvature",),
    "fuzz": ("fuzz",),
    "thickness": ("thickness",),
    "translucency": ("translucency", "translucent"),
    "anisotropy": ("anisotropy", "anisotropic", "aniso"),
    "clearcoat": ("clearcoat", "clear coat", "coat"),
    "sheen": ("sheen",),
    "position": ("position", "pos"),
    "labels": ("id", "ids", "label", "labels"),
    "metalness and roughness": ("metallic roughness", "metallicroughness"),
    "occlusion, roughness, metalness": (
        "orm", "arm", "occlusion roughness metallic", "occlusionroughnessmetallic",
    ),
    "roughness, metalness, occlusion": ("rma",),
    "metalness, roughness, occlusion": ("mra",),
}  # fmt: skip
_ROLE_OF = {words: role for role, names in ROLES.items() for words in names}
_LONGEST = max(words.count(" ") + 1 for words in _ROLE_OF)
#: Words that say how a map is stored: resolution, depth, file type, level of detail, tile, copy.
_ABOUT_FILE = re.compile(
    r"\d+|\d+k|\d+x\d+|\d+(bit|px)|png|jpe?g|exr|tiff?|webp|lod\d*|srgb|linear|raw|map|texture|tex|v\d+"
)


def role_of(stem: str) -> str | None:
    """Return what a file's name, without suffix, says that the map shows; None if it does not say.

    Words about the file (``4k``, ``png``, ``16bit``) are passed over; what is left must end, or
    begin, with a name of `ROLES`.

    Examples
    --------
    >>> role_of("Bricks075A_1K-PNG_NormalGL"), role_of("T_brick_BaseColor"), role_of("leaves")
    ('normal (OpenGL)', 'color', None)
    """
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", stem)
    words = [word.lower() for word in re.split(r"[\W_]+", spaced) if word]
    words = [word for word in words if not _ABOUT_FILE.fullmatch(word)]
    for ends in (True, False):
        for count in range(min(_LONGEST, len(words)), 0, -1):
            found = " ".join(words[-count:] if ends else words[:count])
            if found in _ROLE_OF:
                return _ROLE_OF[found]
    return None


def roles_of(stems: Iterable[str], folder: str) -> dict[str, str]:
    """Return the role of each picture of a folder, the maps of one material.

    Raises
    ------
    InvalidInputError
        If names do not say which maps they are, or two say the same.
    """
    found = {stem: role_of(stem) for stem in stems}
    fix = "rename them, or say which are its maps: --maps color=FILE,normal=FILE,..."
    unknown = [stem for stem, role in found.items() if role is None]
    if unknown:
        raise InvalidInputError(
            f"{folder} has pictures whose names are of no map ({_some(unknown)}), and a folder "
            f"is taken for the maps of one material; {fix}"
        )
    roles: dict[str, str] = {}
    for stem, role in found.items():
        same = [other for other, its in roles.items() if its == role]
        if same:
            raise InvalidInputError(
                f"{folder} has two pictures that are named {role} ({same[0]}, {stem}), and a "
                f"folder is taken for the maps of one material; {fix}"
            )
        roles[stem] = str(role)
    return roles


def _some(names: list[str]) -> str:
    return ", ".join(names[:4]) + (", ..." if len(names) > 4 else "")
