"""A set of maps as a MaterialX document, which renderers and modelers open."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from weftex.errors import missing_packages
from weftex.io.materials import RELIEF, identifier
from weftex.roles import ROLES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from weftex.io.materials import Place

__all__ = ["materialx_document"]

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
    surface = _Surface(mx, identifier(name), hextiled)
    for role, place in where.items():
        surface.take(role, place)
    return str(mx.writeToXmlString(surface.document))


class _Surface:
    """A material of one Standard Surface."""

    def __init__(self, mx: Any, name: str, hextiled: bool) -> None:
        self._mx, self._hextiled, self.document = mx, hextiled, mx.createDocument()
        self.document.setColorSpace("lin_rec709")
        self._shader = self._node("standard_surface", f"{name}_surface", "surfaceshader")
        self._material = self.document.addMaterialNode(name, self._shader)

    def take(self, role: str, place: Place) -> None:
        """Connect a map."""
        if role in _COLORS:
            space = "lin_rec709" if place.file.endswith(".exr") else "srgb_texture"
            self._connect(_COLORS[role], self._image(role, place, "color3", space))
            if role == "emission":
                self._shader.setInputValue("emission", 1.0)
        elif ROLES[role].kind == "normal":
            self._normal(role, place)
        elif role in _NUMBERS or role in ("opacity", "height"):
            self._number(role, self._value(role, place))

    def _number(self, role: str, node: Any) -> None:
        if role == "opacity":
            node = self._then("convert", "opacity_color", node, "color3")
        if role == "height":
            middle = self._then("subtract", "height_from_middle", node, in2=0.5)
            shader = self._node("displacement", "relief", "displacementshader", scale=RELIEF)
            shader.setConnectedNode("displacement", middle)
            self._material.setConnectedNode("displacementshader", shader)
        else:
            self._connect(_NUMBERS.get(role, role), node)

    def _normal(self, role: str, place: Place) -> None:
        if self._hextiled:
            node = self._node("hextilednormalmap", "normal_map", "vector3")
            self._file(node, place.file)
        else:
            image = self._image(role, place, "vector3")
            node = self._then("normalmap", "normal_map", image, "vector3")
        self._connect("normal", node)

    def _value(self, role: str, place: Place) -> Any:
        """A node with one channel."""
        if not self._hextiled and not place.width:
            return self._image(role, place, "float")
        node = self._image(role, place, "color3" if self._hextiled else "vector4")
        one = self._node("extract", f"{role}_channel", "float", index=place.first)
        one.setConnectedNode("in", node)
        return one

    def _image(self, role: str, place: Place, kind: str, space: str = "") -> Any:
        what = "hextiledimage" if self._hextiled else "image"
        node = self._node(what, f"{role}_image", kind)
        self._file(node, place.file, space)
        return node

    def _file(self, node: Any, file: str, space: str = "") -> None:
        source = node.addInput("file", "filename")
        source.setValueString(file)
        if space:
            source.setColorSpace(space)

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
