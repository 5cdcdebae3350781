"""Render a saved result with other maps of its sample.

examples:
  weftex replay wall.npz normal_16bit.png -o wall_normal.png
  weftex replay wall.npz stone_wall/ -o wall/          a folder of maps
  weftex replay filled.npz height.exr -o filled_height.exr --background photo_height.exr
  weftex replay field.npz clover_height.png grape_height.png plum_height.png -o field_height.png
"""

from __future__ import annotations

import os
from dataclasses import replace

from weftex.cli.files import plan, prepare_targets, read_input
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, run_and_report
from weftex.exemplar import Exemplar
from weftex.exemplar.material import Material
from weftex.prepare.combining import combined, of_one_kind, paired
from weftex.raster.levels import scale_between
from weftex.results.synthesis import Synthesis
from weftex.roles import role_of


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("replay", __doc__)
    add = parser.add_argument
    add("source", metavar="F.npz", help="file from --save-source")
    text = "image of the sample's size, or 2, 3, ... times as large or small; or a folder of such "
    text += "images; for a result of 'weftex fuse', one for each sample"
    add("maps", metavar="MAP", nargs="+", help=text)
    text = "the same map of the photo, if its hole was filled from another sample"
    add("--background", metavar="PHOTO", help=text)
    parser.share("--output", "--preset", "--quiet", "--allow-huge")
    args = parser.parse(argv)

    def work(bar: Bar, outputs: Outputs) -> str:
        prepare_targets(args.maps, args, outputs)
        materials = [_as_map(read_input(one, args)) for one in args.maps]
        result = Synthesis.load(args.source)
        pairs, _ = paired(of_one_kind([one.exemplar() for one in materials]))
        (files, told), maps = plan(materials, pairs[0], args), materials[0].maps
        if len(materials) > 1:
            whole = combined(pairs)
            if scale_between(whole.shape, result.sample_shape) is None:  # of one material
                whole = combined(pairs, apart=True)
            maps = {name: whole.map(name) for name in whole.maps} | {files.main: whole}
        around: dict[str, Exemplar] = {}
        if args.background is not None:
            given = read_input(args.background, args)
            around = given.maps if given.folder else {files.main: given.exemplar()}
        kept = {name: around[name].pixels if name in around else None for name in maps}
        files.write(outputs.staged_path, lambda key: result.render(maps[key], background=kept[key]))
        size = f"{result.shape[1]}x{result.shape[0]}"
        return f"{told}made {size} {args.output} in {bar.took:.2f} s"

    run_and_report(work, args.quiet)


def _as_map(material: Material) -> Material:
    """A picture alone is here what its name says."""
    stem = os.path.splitext(os.path.basename(material.pictures[material.main].path))[0]
    role = None if material.folder else role_of(stem)
    return material if role is None else replace(material, roles={material.main: role})
