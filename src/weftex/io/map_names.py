"""How libraries and programs call the maps of a set that weftex writes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weftex.errors import InvalidInputError, did_you_mean

if TYPE_CHECKING:
    from weftex.roles import Role

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
