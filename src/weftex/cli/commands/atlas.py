"""Make all corner tiles of a material.

Tiles with the same corner colors at a side fit without a seam, so an engine can assemble an endless
texture from them. OUT is an image with a grid of tiles; weftex also writes an index (.json),
tilesets for Tiled (.tsx) and Godot 4 (.tres), and a shader for 3D surfaces of Godot 4 (.gdshader).
For a map set, OUT is a folder. For one image, OUT without a suffix is a folder with a file for each
tile.

examples:
  weftex atlas pebbles.png -o tiles.png
  weftex atlas bricks.png -o tiles.png --colors 3 --tile-size 512 --seed 7
  weftex atlas stone_wall/ -o tiles/                  a folder of aligned maps
  weftex atlas pebbles.png -o tiles.png --gutter 8    for engines that cut tiles out
"""

from __future__ import annotations

import argparse
import json
import os
from typing import Any

from weftex.atlas import Atlas, atlas
from weftex.cli.arguments import parse_task
from weftex.cli.files import open_job
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, run_and_report
from weftex.io.formats import suffix_of, written_as
from weftex.io.outputs import OutputSet
from weftex.io.pictures import is_folder, write_image, write_text
from weftex.recipe.command_line import value_of
from weftex.recipe.declared import ATLAS, MATERIAL, SEED


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("atlas", __doc__)
    text = "image, folder of maps, or sample:NAME; several must show the same material"
    parser.add_argument("materials", metavar="SAMPLE", nargs="+", help=text)
    parser.share("--output", "--preset")
    parser.set_defaults(save_source=None)
    options = [*ATLAS.values(), *MATERIAL.values(), SEED]
    args, recipe = parse_task("synth", parser, argv, options, default="graphcut, entire samples")
    given = {name: value_of(option, vars(args)) for name, option in ATLAS.items()}
    own = {name: value for name, value in given.items() if value is not None}

    def work(bar: Bar, outputs: Outputs) -> str:
        folder = _folder_of_tiles(args, outputs)
        job, files, told = open_job(recipe, args, outputs)
        how: dict[str, Any] = {"seed": recipe.seed, "threads": args.threads, "progress": bar}
        made = atlas(job.sample, method=recipe.method.slug, **own, **how, **recipe.parameters)
        (_write_grids if folder is None else _write_tiles)(made, files, args, outputs)
        used, (height, width) = made.synthesis.provenance, made.tile_size
        notes = "".join(f"note: {note}\n" for note in made.notes)
        return (
            f"{told}{notes}made {made.colors**4} tiles of {width}x{height} in "
            f"{folder or args.output} with {used['method']}, seed {used['seed']}, "
            f"in {bar.took:.2f} s"
        )

    run_and_report(work, args.quiet)


def _folder_of_tiles(args: argparse.Namespace, outputs: Outputs) -> str | None:
    """Make the folder that gets a file for each tile of an image, unless OUT is an image."""
    folder = str(args.output)
    if suffix_of(folder) or any(map(is_folder, args.materials)):
        return None
    outputs.make_folder(folder)
    # Where an image is expected; each tile has its own name.
    floats = written_as(args.materials[0], False).lower() == ".exr"
    args.output = os.path.join(folder, "tile.exr" if floats else "tile.png")
    return folder


def _write_grids(made: Atlas, files: OutputSet, args: argparse.Namespace, outputs: Outputs) -> None:
    """Write a grid for each map, the index, and the tilesets of editors."""
    maps = {one.name: [part.source for part in one.parts if part.source] for one in files.files}
    image = next(name for name, sources in maps.items() if files.main in sources)
    single = files.folder != args.output
    stem = os.path.splitext(args.output)[0] if single else os.path.join(args.output, "atlas")
    texts = made.documents(os.path.basename(stem), image, None if single else maps)
    files.write(
        outputs.staged_path,
        lambda name: made.image if name == files.main else made.maps[name],
        args.threads,
    )
    for suffix, text in texts.items():
        write_text(outputs.staged_path(stem + suffix), text)


def _write_tiles(made: Atlas, files: OutputSet, args: argparse.Namespace, outputs: Outputs) -> None:
    """Write a file for each tile, named by its corner colors, and the index."""
    (one,), index, tiles = files.files, made.index, []
    image, suffix = one.pixels(lambda _: made.image), os.path.splitext(one.name)[1]
    height, width = (side + 2 * made.gutter for side in made.tile_size)
    for tile in index["tiles"]:
        top, left = tile["y"] - made.gutter, tile["x"] - made.gutter
        name = f"tile_{''.join(map(str, tile['corners']))}{suffix}"
        pixels, path = image[top:, left:][:height, :width], os.path.join(files.folder, name)
        how: dict[str, Any] = {"icc": one.icc, "half": one.half, "density": one.density}
        write_image(outputs.staged_path(path), pixels, alpha=one.alpha, **how)
        tiles.append({"file": name, "corners": tile["corners"]})
    kept = {name: index[name] for name in ("colors", "tile_width", "tile_height", "gutter")}
    path = outputs.staged_path(os.path.join(files.folder, "atlas.json"))
    write_text(path, json.dumps({**kept, "tiles": tiles}, indent=1) + "\n")
