"""weftex atlas: make all corner tiles of a material, for an endless texture in any engine."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

from weftex.cli.options import parse_task
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, finish
from weftex.recipe.command_line import value_of
from weftex.recipe.declared import MATERIAL, SEED
from weftex.recipe.options import SIZE, WHOLE, Option

if TYPE_CHECKING:
    import argparse

    from weftex.atlas import Atlas
    from weftex.cli.files import Plan

_ABOUT = """\
Make all corner tiles of a material. Tiles with the same corner colors at a side fit without a seam,
so an engine can assemble an endless texture from them. OUT is an image with a grid of tiles; weftex
also writes an index (.json) and tilesets for Tiled (.tsx) and Godot 4 (.tres). For a map set, OUT
is a folder. For one image, OUT without a suffix is a folder with a file for each tile.\
"""

_EXAMPLES = """\
examples:
  weftex atlas pebbles.png -o tiles.png
  weftex atlas bricks.png -o tiles.png --colors 3 --tile-size 512 --seed 7
  weftex atlas stone_wall/ -o tiles/                  a folder of aligned maps
  weftex atlas pebbles.png -o tiles.png --gutter 8    for engines that cut tiles out
"""

_OPTIONS = (
    Option("colors", WHOLE, "number of corner colors: 2 makes 16 tiles, 3 makes 81, which repeat "
           "less", 2, low=2, high=3, metavar="2|3"),
    Option("tile_size", SIZE, "size of a tile in pixels; with a lattice, the nearest size that "
           "holds whole periods", default_text="256, or the sample's shorter side if less",
           metavar="WxH|N"),
    Option("gutter", WHOLE, "width of a border around each tile that continues it, for filters "
           "that read beyond a tile", 0, low=0, unit="px", metavar="PX"),
)  # fmt: skip
#: Colors by which editors show corner colors.
_SHOWN = ((0xD0, 0x43, 0x3B), (0x3B, 0x7D, 0xD0), (0x4C, 0xA8, 0x4C))


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("atlas", _ABOUT, _EXAMPLES)
    text = "image, folder of maps, or sample:NAME; several must show the same material"
    parser.add_argument("materials", metavar="SAMPLE", nargs="+", help=text)
    parser.share("--output", "--preset")
    parser.set_defaults(save_source=None)
    options = [*_OPTIONS, *MATERIAL.values(), SEED]
    args, recipe = parse_task("synth", parser, argv, options, usual="graphcut, entire samples")
    given = {option: value_of(option, vars(args)) for option in _OPTIONS}
    own = {o.name: o.checked(value, o.flag) for o, value in given.items() if value is not None}

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.atlas import atlas
        from weftex.cli.files import open_job

        folder = _folder_of_tiles(args, outputs)
        job, plan = open_job(recipe, args, outputs)
        how: dict[str, Any] = {"seed": recipe.seed, "threads": args.threads, "progress": bar}
        made = atlas(job.sample, method=recipe.method.slug, **own, **how, **recipe.parameters)
        (_write_grids if folder is None else _write_tiles)(made, plan, args, outputs)
        used, (height, width) = made.synthesis.provenance, made.tile_size
        notes = "".join(f"note: {note}\n" for note in made.notes)
        return (
            f"{plan.told}{notes}made {made.colors**4} tiles of {width}x{height} in "
            f"{folder or args.output} with {used['method']}, seed {used['seed']}, "
            f"in {bar.took:.2f} s"
        )

    finish(work, args.quiet)


def _folder_of_tiles(args: argparse.Namespace, outputs: Outputs) -> str | None:
    """Make the folder that gets a file for each tile of an image, unless OUT is an image."""
    from weftex.io.formats import suffix_of, written_as
    from weftex.io.pictures import is_folder

    folder = str(args.output)
    if suffix_of(folder) or any(map(is_folder, args.materials)):
        return None
    outputs.make_folder(folder)
    # Where an image is expected; each tile has its own name.
    floats = written_as(args.materials[0], False).lower() == ".exr"
    args.output = os.path.join(folder, "tile.exr" if floats else "tile.png")
    return folder


def _write_grids(made: Atlas, plan: Plan, args: argparse.Namespace, outputs: Outputs) -> None:
    """Write a grid for each map, the index, and the tilesets of editors."""
    from weftex.io.pictures import write_text

    maps = {
        one.name: [part.source for part in one.parts if part.source] for one in plan.files.files
    }
    image = next(name for name, sources in maps.items() if plan.main in sources)
    single = plan.folder != args.output
    stem = os.path.splitext(args.output)[0] if single else os.path.join(args.output, "atlas")
    index = {"image": image} | ({} if single else {"maps": maps}) | made.index
    texts = {
        ".json": json.dumps(index, indent=1) + "\n",
        ".tsx": _tiled_tileset(index, os.path.basename(stem), image),
        ".tres": _godot_tileset(index, image),
    }
    plan.write(
        lambda name: made.image if name == plan.main else made.maps[name], outputs, args.threads
    )
    for suffix, text in texts.items():
        write_text(outputs.add(stem + suffix), text)


def _write_tiles(made: Atlas, plan: Plan, args: argparse.Namespace, outputs: Outputs) -> None:
    """Write a file for each tile, named by its corner colors, and the index."""
    from weftex.io.pictures import write_image, write_text

    (one,), index, tiles = plan.files.files, made.index, []
    image, suffix = one.pixels(lambda _: made.image), os.path.splitext(one.name)[1]
    height, width = (side + 2 * made.gutter for side in made.tile_size)
    for tile in index["tiles"]:
        top, left = tile["y"] - made.gutter, tile["x"] - made.gutter
        name = f"tile_{''.join(map(str, tile['corners']))}{suffix}"
        pixels, path = image[top:, left:][:height, :width], os.path.join(plan.folder, name)
        how: dict[str, Any] = {"icc": one.icc, "half": one.half, "density": one.density}
        write_image(outputs.add(path), pixels, alpha=one.alpha, **how)
        tiles.append({"file": name, "corners": tile["corners"]})
    kept = {name: index[name] for name in ("colors", "tile_width", "tile_height", "gutter")}
    path = outputs.add(os.path.join(plan.folder, "atlas.json"))
    write_text(path, json.dumps({**kept, "tiles": tiles}, indent=1) + "\n")


def _tiled_tileset(index: dict[str, Any], name: str, image: str) -> str:
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


def _godot_tileset(index: dict[str, Any], image: str) -> str:
    """Return a TileSet resource of Godot 4 with a terrain set that matches corners.

    A tile's own terrain is the color of its top left corner, so that cells painted with any
    terrains have tiles. The path of the image is relative to the resource.
    """
    gutter, across, down = index["gutter"], index["tile_width"], index["tile_height"]
    path = image.replace("\\", "\\\\").replace('"', '\\"')
    lines = [
        '[gd_resource type="TileSet" load_steps=3 format=3]',
        "",
        f'[ext_resource type="Texture2D" path="{path}" id="1"]',
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


def _attributes(values: dict[str, Any]) -> str:
    return "".join(f" {name}={quoteattr(str(value))}" for name, value in values.items())
