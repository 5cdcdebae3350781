"""Maps of a material: found in its nodes, replaced there, and built into new nodes."""

from __future__ import annotations

from typing import Any

import bpy

from weftex.errors import InvalidInputError
from weftex.roles import ROLES, Role, role_of

#: Roles by the sockets that their images lead to.
_SOCKETS = {
    "Base Color": "color",
    "Roughness": "roughness",
    "Metallic": "metallic",
    "Normal": "normal",
    "Height": "height",
    "Alpha": "opacity",
    "Emission Color": "emission",
    "Emission": "emission",
}


def images_of(material: bpy.types.Material) -> dict[str, bpy.types.Image]:
    """Return the images in a material's nodes by their roles, the color first."""
    if not material.node_tree:
        raise InvalidInputError(f"{material.name} has no nodes")
    found: dict[str, bpy.types.Image] = {}
    for node in material.node_tree.nodes:
        if node.type != "TEX_IMAGE" or node.image is None:
            continue
        named = role_of(node.image.name.rsplit(".", 1)[0])
        role = named.name if named else _role_by_links(node)
        if role is None:
            raise InvalidInputError(
                f"cannot tell what {node.image.name} shows; put the map's role in its name, "
                "such as wall_roughness"
            )
        if found.setdefault(role, node.image) != node.image:
            raise InvalidInputError(f"{material.name} has several images for {role}")
    if not found:
        raise InvalidInputError(f"{material.name} has no image textures")
    return dict(sorted(found.items(), key=lambda pair: pair[0] != "color"))


def _role_by_links(node: bpy.types.Node) -> str | None:
    """Return the role of the first known socket that a node's outputs lead to."""
    ahead, seen = [node], set()
    while ahead:
        one = ahead.pop(0)
        for link in (link for output in one.outputs for link in output.links):
            if link.to_socket.name in _SOCKETS:
                return _SOCKETS[link.to_socket.name]
            if link.to_node not in seen:
                seen.add(link.to_node)
                ahead.append(link.to_node)
    return None


def with_images(
    material: bpy.types.Material, images: dict[bpy.types.Image, bpy.types.Image]
) -> bpy.types.Material:
    """Return a copy of a material in which images are replaced."""
    copy = material.copy()
    for node in copy.node_tree.nodes:
        if node.type == "TEX_IMAGE" and node.image in images:
            node.image = images[node.image]
    return copy


def new_material(name: str, images: dict[str, bpy.types.Image]) -> bpy.types.Material:
    """Return a material with a Principled BSDF that uses maps by their roles.

    Color spaces are set by role. Normals with y down are turned to Blender's y up, gloss is
    inverted, occlusion darkens the color, and packed maps are separated.
    """
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    shader.location, output.location = (0, 300), (400, 300)
    builder = _Builder(tree, shader, output)
    for role_name, image in images.items():
        builder.add(ROLES[role_name], image)
    builder.finish()
    return material


class _Builder:
    """Adds maps to a node tree, one after the other."""

    def __init__(self, tree: Any, shader: Any, output: Any) -> None:
        self.tree, self.shader, self.output = tree, shader, output
        self.sockets: dict[str, Any] = {}  # outputs of nodes by the roles of what they give

    def add(self, role: Role, image: bpy.types.Image) -> None:
        """Add the image of a role, and note which outputs give it or its channels."""
        texture = self._node("ShaderNodeTexImage", -900, 900 - 300 * len(self.tree.nodes))
        texture.image, texture.label = image, role.name
        image.colorspace_settings.name = "sRGB" if role.srgb else "Non-Color"
        if image.is_float and role.srgb:
            image.colorspace_settings.name = "Linear Rec.709"
        color = texture.outputs["Color"]
        if role.channels:
            parts = self._node("ShaderNodeSeparateColor", -600, texture.location[1])
            self._link(color, parts.inputs["Color"])
            for channel, part in zip(role.channels, parts.outputs, strict=False):
                self.sockets[channel] = part
            if len(role.channels) > 3:
                self.sockets[role.channels[3]] = texture.outputs["Alpha"]
        else:
            self.sockets[role.name] = color

    def finish(self) -> None:
        """Link what the maps give to the shader and to the output."""
        given, inputs = self.sockets, self.shader.inputs
        if "gloss" in given and "roughness" not in given:
            invert = self._node("ShaderNodeInvert", -300, 0)
            self._link(given["gloss"], invert.inputs["Color"])
            given["roughness"] = invert.outputs["Color"]
        if "color" in given:
            color = given["color"]
            if "ao" in given:
                color = self._multiplied(color, given["ao"])
            self._link(color, inputs["Base Color"])
        for role, socket in (("roughness", "Roughness"), ("metallic", "Metallic"),
                             ("opacity", "Alpha"), ("emission", "Emission Color")):  # fmt: skip
            if role in given:
                self._link(given[role], inputs[socket])
        if "emission" in given:
            inputs["Emission Strength"].default_value = 1.0
        self._add_normal()
        height = next((given[r] for r in ("height", "bump") if r in given), None)
        if height is not None:
            shift = self._node("ShaderNodeDisplacement", 200, -400)
            shift.inputs["Scale"].default_value = 0.05
            self._link(height, shift.inputs["Height"])
            self._link(shift.outputs["Displacement"], self.output.inputs["Displacement"])

    def _add_normal(self) -> None:
        names = ("normal_gl", "normal", "normal_dx")
        name = next((name for name in names if name in self.sockets), None)
        if name is None:
            return
        color = self.sockets[name]
        if name == "normal_dx":  # y points down there, and up in Blender
            curves = self._node("ShaderNodeRGBCurve", -600, -300)
            green = curves.mapping.curves[1]
            green.points[0].location, green.points[1].location = (0, 1), (1, 0)
            curves.mapping.update()
            self._link(color, curves.inputs["Color"])
            color = curves.outputs["Color"]
        bent = self._node("ShaderNodeNormalMap", -300, -300)
        self._link(color, bent.inputs["Color"])
        self._link(bent.outputs["Normal"], self.shader.inputs["Normal"])

    def _multiplied(self, color: Any, factor: Any) -> Any:
        mix = self._node("ShaderNodeMix", -300, 300)
        mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
        mix.inputs["Factor"].default_value = 1.0
        by_name = {(one.name, one.type): one for one in mix.inputs}
        self._link(color, by_name["A", "RGBA"])
        self._link(factor, by_name["B", "RGBA"])
        return next(one for one in mix.outputs if one.type == "RGBA")

    def _node(self, kind: str, x: float, y: float) -> Any:
        node = self.tree.nodes.new(kind)
        node.location = (x, y)
        return node

    def _link(self, source: Any, target: Any) -> None:
        self.tree.links.new(source, target)
