"""Tilesets of editors, written from the index of an atlas of corner tiles."""

from __future__ import annotations

from typing import Any
from xml.sax.saxutils import quoteattr

#: Colors by which editors show corner colors.
_SHOWN = ((0xD0, 0x43, 0x3B), (0x3B, 0x7D, 0xD0), (0x4C, 0xA8, 0x4C))


def tiled_tileset(index: dict[str, Any], name: str, image: str) -> str:
    """Return a tileset of Tiled 1.10 and later with a Wang set of corners.

    A Wang ID lists the colors of top, top right, right and so on around; 0 is none.
    """
    tileset = {
        "version": "1.10",
        "tiledversion": "1.10.0",
        "name": name,
        "tilewidth": index["tile_width"],
        "tileheight": index["tile_height"],
        "spacing": 2 * index["gutter"],
        "margin": index["gutter"],
        "tilecount": len(index["tiles"]),
        "columns": index["columns"],
    }
    size = {"width": index["width"], "height": index["height"]}
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f"<tileset{_attributes(tileset)}>",
        f" <image{_attributes({'source': image} | size)}/>",
        " <wangsets>",
        f"  <wangset{_attributes({'name': name, 'type': 'corner', 'tile': -1})}>",
    ]
    for number in range(index["colors"]):
        color = "#{:02x}{:02x}{:02x}".format(*_SHOWN[number])
        lines.append(
            f'   <wangcolor name="Corner {number}" color="{color}" tile="-1" probability="1"/>'
        )
    for tile in sorted(index["tiles"], key=lambda tile: tile["id"]):
        top_left, top_right, bottom_left, bottom_right = (color + 1 for color in tile["corners"])
        wang = f"0,{top_right},0,{bottom_right},0,{bottom_left},0,{top_left}"
        lines.append(f'   <wangtile tileid="{tile["id"]}" wangid="{wang}"/>')
    return "\n".join([*lines, "  </wangset>", " </wangsets>", "</tileset>", ""])


def godot_tileset(index: dict[str, Any], image: str) -> str:
    """Return a TileSet resource of Godot 4 with a terrain set that matches corners.

    A tile's own terrain is the color of its top left corner, so that cells painted with any
    terrains have tiles. The path of the image is relative to the resource.
    """
    gutter, across, down = index["gutter"], index["tile_width"], index["tile_height"]
    lines = [
        '[gd_resource type="TileSet" load_steps=3 format=3]',
        "",
        f'[ext_resource type="Texture2D" path="{_escaped(image)}" id="1"]',
        "",
        '[sub_resource type="TileSetAtlasSource" id="atlas"]',
        'texture = ExtResource("1")',
        f"margins = Vector2i({gutter}, {gutter})",
        f"separation = Vector2i({2 * gutter}, {2 * gutter})",
        f"texture_region_size = Vector2i({across}, {down})",
    ]
    sides = ("top_left", "top_right", "bottom_left", "bottom_right")
    for tile in sorted(index["tiles"], key=lambda tile: tile["id"]):
        row, column = divmod(tile["id"], index["columns"])
        at = f"{column}:{row}/0"
        lines += [f"{at} = 0", f"{at}/terrain_set = 0", f"{at}/terrain = {tile['corners'][0]}"]
        lines += [
            f"{at}/terrains_peering_bit/{side}_corner = {color}"
            for side, color in zip(sides, tile["corners"], strict=True)
        ]
    lines += ["", "[resource]", f"tile_size = Vector2i({across}, {down})", "terrain_set_0/mode = 1"]
    for number in range(index["colors"]):
        red, green, blue = (round(part / 255, 3) for part in _SHOWN[number])
        terrain = f"terrain_set_0/terrain_{number}"
        lines += [f'{terrain}/name = "Corner {number}"']
        lines += [f"{terrain}/color = Color({red}, {green}, {blue}, 1)"]
    return "\n".join([*lines, 'sources/0 = SubResource("atlas")', ""])


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')


def _attributes(values: dict[str, Any]) -> str:
    return "".join(f" {name}={quoteattr(str(value))}" for name, value in values.items())
