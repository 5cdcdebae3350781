"""A map set as one material: a plane in glTF and USD, a document of MaterialX."""

from __future__ import annotations

import io
import json
import struct
import zipfile
from collections.abc import Callable, Collection, Mapping
from itertools import zip_longest
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

from weftex.errors import missing_packages
from weftex.roles import ROLES

__all__ = ["Place", "glb", "materialx_document", "usda", "usdz"]


class Place(NamedTuple):
    """Where a role is: a file, its first channel, and its number of channels, or 0 for all."""

    file: str
    first: int = 0
    width: int = 0


#: How far white lies above black, in units of the scene, which files do not say.
RELIEF = 0.05
#: A plane that faces +z: its corners, in parts of its size.
_CORNERS = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
_PRESETS = Path(__file__).parent.parent / "presets"
#: A document of glTF without its material and pictures; component types are floats and integers.
_GLTF = _PRESETS / "plane.gltf"


def glb(
    name: str,
    where: Mapping[str, Place],
    alphas: Collection[str],
    size: tuple[float, float],
    read: Callable[[str], bytes],
) -> bytes:
    """Return a binary glTF of a plane with the material, which contains the pictures.

    `alphas` are the files whose alpha is opacity, `size` is the plane's in meters, and `read`
    returns the bytes of a file.
    """
    width, height = size
    files = sorted({place.file for place in where.values()})
    texture = {file: {"index": number} for number, file in enumerate(files)}
    surface: dict[str, Any] = {"metallicFactor": 0}
    material: dict[str, Any] = {"name": name, "pbrMetallicRoughness": surface}
    if "color" in where:
        surface["baseColorTexture"] = texture[where["color"].file]
        if where["color"].file in alphas:
            material["alphaMode"] = "BLEND"
    if "roughness" in where:
        surface |= {"metallicRoughnessTexture": texture[where["roughness"].file]}
        surface["metallicFactor"] = 1
    for key, role in (("normal", "normal_gl"), ("occlusion", "ao"), ("emissive", "emission")):
        if role in where:
            material[f"{key}Texture"] = texture[where[role].file]
    if "emission" in where:
        material["emissiveFactor"] = [1, 1, 1]
    parts = [
        b"".join(struct.pack("<3f", x * width, y * height, 0) for x, y in _CORNERS),
        struct.pack("<3f", 0, 0, 1) * 4,
        struct.pack("<4f", 1, 0, 0, 1) * 4,
        b"".join(struct.pack("<2f", x + 0.5, 0.5 - y) for x, y in _CORNERS),
        struct.pack("<6H", 0, 1, 2, 0, 2, 3),
        *map(read, files),
    ]
    document = json.loads(_GLTF.read_text("utf-8"))
    views, body = document["bufferViews"], b""
    for part, target in zip_longest(parts, (*[34962] * 4, 34963)):  # vertices; indices
        view = {"buffer": 0, "byteOffset": len(body), "byteLength": len(part)}
        views.append(view | ({"target": target} if target else {}))
        body += part + bytes(-len(part) % 4)
    document["nodes"][0]["name"], document["materials"] = name, [material]
    document["textures"] = [{"source": number, "sampler": 0} for number in range(len(files))]
    document["images"] = [
        {"bufferView": number, "mimeType": "image/png", "name": file}
        for number, file in enumerate(files, len(parts) - len(files))
    ]
    low, high = (list(struct.unpack_from("<3f", parts[0], offset)) for offset in (0, 24))
    document["accessors"][0] |= {"min": low, "max": high}
    document["buffers"] = [{"byteLength": len(body)}]
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


#: Inputs of a UsdPreviewSurface by role, and their types.
_USD = {
    "color": ("diffuseColor", "color3f"), "normal_gl": ("normal", "normal3f"),
    "roughness": ("roughness", "float"), "metallic": ("metallic", "float"),
    "ao": ("occlusion", "float"), "height": ("displacement", "float"),
    "emission": ("emissiveColor", "color3f"), "opacity": ("opacity", "float"),
}  # fmt: skip
#: A stage without its textures, and a texture.
_STAGE, _TEXTURE = _PRESETS / "plane.usda", _PRESETS / "texture.usda"
#: What becomes of the stored values of a map.
_USD_SCALES = {
    "normal_gl": ((2, 2, 2, 1), (-1, -1, -1, 0)),
    "height": ((RELIEF,) * 4, (-RELIEF / 2,) * 4),
}


def usda(
    name: str, where: Mapping[str, Place], alphas: Collection[str], size: tuple[float, float]
) -> str:
    """Return a USD stage of a plane with a UsdPreviewSurface, whose pictures lie beside it."""
    material = _identifier(name)
    places = dict(where)
    if "color" in where and where["color"].file in alphas:
        places.setdefault("opacity", Place(where["color"].file, 3, 1))
    points = [f"({x * size[0]:.9g}, {y * size[1]:.9g}, 0)" for x, y in _CORNERS]
    lines, textures = [], ""
    for role, place in places.items():
        if role not in _USD:
            continue
        to, kind = _USD[role]
        output, stored = ("rgba"[place.first], "float") if kind == "float" else ("rgb", "float3")
        path = f"/Root/{material}/{role}.outputs:{output}"
        lines.append(f"            {kind} inputs:{to}.connect = <{path}>\n")
        space = "sRGB" if role in ("color", "emission") else "raw"
        scale, bias = _USD_SCALES.get(role, ((1, 1, 1, 1), (0, 0, 0, 0)))
        textures += Template(_TEXTURE.read_text("utf-8")).substitute(
            role=role, file=place.file, material=material, space=space, scale=scale, bias=bias,
            stored=f"{stored} outputs:{output}",
        )  # fmt: skip
    return Template(_STAGE.read_text("utf-8")).substitute(
        material=material, points=", ".join(points), low=points[0], high=points[2],
        textures=textures, inputs="".join(lines),
    )  # fmt: skip


def usdz(files: Mapping[str, bytes]) -> bytes:
    """Return a USDZ package of files, the stage first: a plain archive, aligned to 64 bytes."""
    body = io.BytesIO()
    with zipfile.ZipFile(body, "w") as archive:
        for name, data in files.items():
            info = zipfile.ZipInfo(name)  # of 1980, so that bytes do not depend on the time
            padding = -(body.tell() + 34 + len(name.encode())) % 64  # after header and name
            info.extra = struct.pack("<HH", 0x1986, padding) + bytes(padding)
            archive.writestr(info, data)
    return body.getvalue()


def _identifier(name: str) -> str:
    """Return a name of letters, digits and underlines that does not begin with a digit."""
    plain = "".join(one if one.isascii() and one.isalnum() else "_" for one in name)
    return f"_{plain}" if not plain or plain[0].isdigit() else plain


#: Inputs of the Standard Surface 1.0.1 by the roles that they take: numbers and colors.
_NUMBERS = {
    "roughness": "specular_roughness", "metallic": "metalness", "specular": "specular",
    "transmission": "transmission", "clearcoat": "coat", "sheen": "sheen",
    "anisotropy": "specular_anisotropy", "anisotropy_rotation": "specular_rotation",
}  # fmt: skip
_COLORS = {"color": "base_color", "specular_color": "specular_color", "emission": "emission_color"}


def materialx_document(name: str, where: Mapping[str, Place], *, hextiled: bool = False) -> str:
    """Return a MaterialX document of a Standard Surface with these maps.

    `where` says by role where its channels are. `hextiled` repeats the maps by random hexagons.
    """
    try:
        import MaterialX as mx
    except ImportError:
        raise missing_packages("preset materialx needs MaterialX", "materialx") from None
    document, own = mx.createDocument(), _identifier(name)
    document.setColorSpace("lin_rec709")

    def add(what: str, name: str, kind: str, inputs: Mapping[str, Any]) -> Any:
        """Add a node whose inputs are values, or what other nodes make."""
        node = document.addNode(what, name, kind)
        for key, value in inputs.items():
            put = node.setConnectedNode if isinstance(value, mx.Node) else node.setInputValue
            put(key, value)
        return node

    def picture(file: str, name: str, kind: str, what: str = "image", space: str = "") -> Any:
        node = add(f"hextiled{what}" if hextiled else what, name, kind, {})
        source = node.addInput("file", "filename")
        source.setValueString(file)
        if space:
            source.setColorSpace(space)
        return node

    def number(role: str, place: Place) -> Any:
        if not hextiled and not place.width:
            return picture(place.file, f"{role}_image", "float")
        whole = picture(place.file, f"{role}_image", "color3" if hextiled else "vector4")
        return add("extract", f"{role}_channel", "float", {"index": place.first, "in": whole})

    shader = add("standard_surface", f"{own}_surface", "surfaceshader", {})
    material = document.addMaterialNode(own, shader)
    for role, place in where.items():
        if role in _COLORS:
            space = "lin_rec709" if place.file.endswith(".exr") else "srgb_texture"
            node = picture(place.file, f"{role}_image", "color3", space=space)
            shader.setConnectedNode(_COLORS[role], node)
            if role == "emission":
                shader.setInputValue("emission", 1.0)
        elif ROLES[role].kind == "normal":
            if hextiled:
                node = picture(place.file, "normal_map", "vector3", "normalmap")
            else:
                node = picture(place.file, f"{role}_image", "vector3")
                node = add("normalmap", "normal_map", "vector3", {"in": node})
            shader.setConnectedNode("normal", node)
        elif role == "height":
            inputs = {"in2": 0.5, "in1": number(role, place)}
            node = add("subtract", "height_from_middle", "float", inputs)
            inputs = {"scale": RELIEF, "displacement": node}
            node = add("displacement", "relief", "displacementshader", inputs)
            material.setConnectedNode("displacementshader", node)
        elif role == "opacity":
            inputs = {"in": number(role, place)}
            shader.setConnectedNode(role, add("convert", "opacity_color", "color3", inputs))
        elif role in _NUMBERS:
            shader.setConnectedNode(_NUMBERS[role], number(role, place))
    return str(mx.writeToXmlString(document))
