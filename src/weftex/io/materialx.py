"""A set of maps as a MaterialX document, which renderers and modelers open."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from weftex.errors import missing_packages

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from weftex.roles import Role

__all__ = ["materialx_document"]

#: Inputs of the Standard Surface 1.0.1 by the roles that they take: numbers and colors.
_NUMBERS = {
    "roughness": "specular_roughness", "gloss": "specular_roughness", "metallic": "metalness",
    "specular": "specular", "transmission": "transmission", "clearcoat": "coat", "sheen": "sheen",
    "anisotropy": "specular_anisotropy", "anisotropy_rotation": "specular_rotation",
}  # fmt: skip
_COLORS = {"color": "base_color", "specular_color": "specular_color", "emission": "emission_color"}
#: How far white lies above black, in units of the scene, which files do not say.
_RELIEF = 0.05


def materialx_document(
    name: str, files: Mapping[str, str], roles: Mapping[str, Role], linear: Collection[str]
) -> tuple[str, list[str]]:
    """A MaterialX document of a Standard Surface with these maps, and the maps it cannot use.

    `files` and `roles` are by map name; `linear` names maps with linear colors. Normals are turned
    to OpenGL, gloss becomes roughness, packed channels are separated unless a map shows the same.
    """
    try:
        import MaterialX as mx
    except ImportError:
        raise missing_packages("--mtlx needs MaterialX", "materialx") from None
    surface = _Surface(mx, name)
    left = []
    # Of two that show the same the first is taken.
    order = {key: (len(roles[key].channels), roles[key].name == "normal_dx") for key in files}
    for key in sorted(files, key=order.__getitem__):
        space = "" if not roles[key].srgb else "lin_rec709" if key in linear else "srgb_texture"
        if not surface.take(roles[key], files[key], space):
            left.append(key)
    return mx.writeToXmlString(surface.document), left


class _Surface:
    """A material of one Standard Surface."""

    def __init__(self, mx: Any, name: str) -> None:
        self._mx, self.document = mx, mx.createDocument()
        self.document.setColorSpace("lin_rec709")
        valid = mx.createValidName(re.sub(r"^(?=\d)", "_", name))
        self._shader = self._node("standard_surface", f"{valid}_surface", "surfaceshader")
        self._material = self.document.addMaterialNode(valid, self._shader)

    def take(self, role: Role, file: str, space: str) -> bool:
        """Connect a map, or as many channels of it as are wanted; whether there are any."""
        if role.channels:
            wanted = [part for part in role.channels if self._free(part)]
            if wanted:
                kind = f"vector{max(3, len(role.channels))}"
                image = self._image(role.name, file, kind)
                for part in wanted:
                    index = role.channels.index(part)
                    node = self._node("extract", f"{role.name}_{part}", "float", index=index)
                    node.setConnectedNode("in", image)
                    self._number(part, node)
            return bool(wanted)
        if not self._free(role.name):
            return False
        if role.name in _COLORS:
            self._connect(_COLORS[role.name], self._image(role.name, file, "color3", space))
            if role.name == "emission":
                self._shader.setInputValue("emission", 1.0)
        elif role.kind == "normal":
            self._normal(role, self._image(role.name, file, "vector3"))
        else:
            self._number(role.name, self._image(role.name, file, "float"))
        return True

    def _free(self, name: str) -> bool:
        """Whether a role has an input that nothing is connected to."""
        if name.startswith("normal"):
            return self._shader.getInput("normal") is None
        if name == "height":
            return self._material.getInput("displacementshader") is None
        to = _COLORS.get(name) or _NUMBERS.get(name) or {"opacity": "opacity"}.get(name)
        return to is not None and self._shader.getInput(to) is None

    def _number(self, name: str, node: Any) -> None:
        if name == "gloss":
            node = self._then("invert", "roughness_of_gloss", node)
        if name == "opacity":
            node = self._then("convert", "opacity_color", node, "color3")
        if name == "height":
            middle = self._then("subtract", "height_from_middle", node, in2=0.5)
            shader = self._node("displacement", "relief", "displacementshader", scale=_RELIEF)
            shader.setConnectedNode("displacement", middle)
            self._material.setConnectedNode("displacementshader", shader)
        else:
            self._connect(_NUMBERS.get(name, name), node)

    def _normal(self, role: Role, node: Any) -> None:
        if role.name == "normal_dx":
            vector = self._mx.Vector3
            node = self._then("multiply", "normal_y", node, "vector3", in2=vector(1, -1, 1))
            node = self._then("add", "normal_y_up", node, "vector3", in2=vector(0, 1, 0))
        self._connect("normal", self._then("normalmap", "normal_map", node, "vector3"))

    def _image(self, name: str, file: str, kind: str, space: str = "") -> Any:
        node = self._node("image", f"{name}_image", kind)
        source = node.addInput("file", "filename")
        source.setValueString(file)
        if space:
            source.setColorSpace(space)
        return node

    def _then(self, what: str, name: str, node: Any, kind: str = "float", **values: Any) -> Any:
        after = self._node(what, name, kind, **values)
        after.setConnectedNode("in1" if values else "in", node)
        return after

    def _node(self, what: str, name: str, kind: str, **values: Any) -> Any:
        node = self.document.addNode(what, name, kind)
        for key, value in values.items():
            node.setInputValue(key, value)
        return node

    def _connect(self, to: str, node: Any) -> None:
        self._shader.setConnectedNode(to, node)
