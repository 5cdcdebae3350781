"""weftex atlas: what is written, and that errors write nothing."""

import json
import re
from xml.etree import ElementTree as ET

import numpy as np

from commands import weft_run
from weftex.atlas import atlas
from weftex.io.pictures import read_image


def test_grid_index_and_tilesets_agree(here, capsys):
    assert weft_run("atlas", "sample:pebbles", "-o", "out.png", "--tile-size", "64", "--gutter",
                    "2", "--seed", "7") == 0  # fmt: skip
    assert "made 16 tiles of 64x64 in out.png" in capsys.readouterr().err
    made = atlas("sample:pebbles", tile_size=64, gutter=2, seed=7)
    assert np.array_equal(read_image("out.png").pixels, made.image)
    index = json.loads((here / "out.json").read_text())
    assert index == {"image": "out.png", **made.index}
    tileset = ET.parse(here / "out.tsx").getroot()
    wanted = {"tilewidth": "64", "spacing": "4", "margin": "2", "columns": "4", "tilecount": "16"}
    assert wanted.items() <= tileset.attrib.items()
    assert tileset.find("image").attrib == {"source": "out.png", "width": "272", "height": "272"}
    assert tileset.find("wangsets/wangset").get("type") == "corner"
    godot = (here / "out.tres").read_text()
    assert "margins = Vector2i(2, 2)\nseparation = Vector2i(4, 4)" in godot
    assert 'path="out.png"' in godot and "terrain_set_0/mode = 1" in godot
    tiles = {tile["id"]: tile["corners"] for tile in index["tiles"]}
    for one in tileset.iter("wangtile"):
        wang = [int(color) for color in one.get("wangid").split(",")]
        corners = [wang[k] - 1 for k in (7, 1, 5, 3)]  # clockwise from the top
        assert corners == tiles.pop(int(one.get("tileid"))) and not any(wang[::2])
    assert not tiles
    for tile in index["tiles"]:
        at = f"{tile['id'] % 4}:{tile['id'] // 4}/0"
        bits = re.findall(rf"^{at}/terrains_peering_bit/(\w+)_corner = (\d)$", godot, re.M)
        names = ("top_left", "top_right", "bottom_left", "bottom_right")
        assert [(name, int(color)) for name, color in bits] == [
            *zip(names, tile["corners"], strict=True)
        ]


def test_a_set_and_a_folder_of_tiles(here):
    assert weft_run("atlas", "sample:stone_wall", "-o", "set", "--tile-size", "48") == 0
    found = {path.name for path in (here / "set").iterdir()}
    maps = {"albedo.png", "ao.png", "height.png", "normal.png", "roughness.png"}
    assert found == maps | {"atlas.json", "atlas.tsx", "atlas.tres", "atlas.gdshader"}
    assert json.loads((here / "set/atlas.json").read_text())["image"] == "albedo.png"
    words = ("--tile-size", "48", "--colors", "3", "--method", "patch-sampling", "--seed", "7")
    assert weft_run("atlas", "sample.png", "-o", "tiles", *words) == 0
    index = json.loads((here / "tiles/atlas.json").read_text())
    made = atlas("sample.png", tile_size=48, colors=3, method="patch-sampling", seed=7)
    for pixels, tile in zip(made.tiles, index["tiles"], strict=True):
        assert np.array_equal(read_image(here / "tiles" / tile["file"]).pixels, pixels)
