"""Estimate the maps that a photo lacks, and write all of them as a map set.

Height is estimated from brightness: dark pixels are deep, so stains and paint become relief too.
Normals and ambient occlusion are computed from height. Roughness is a guess. A map set keeps its
own height or normals, and the other maps are computed from these.

examples:
  weftex estimate photo.png -o material/
  weftex estimate bricks.png -o material/ --relief 12 --invert      light joints between dark bricks
  weftex estimate photos/ -o materials/ --maps height,normal_dx     a folder of photos
  weftex estimate normal.png -o material/ --maps height             height from normals
"""

from __future__ import annotations

from dataclasses import replace

from weftex.cli.files import plan, read_input
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, run_and_report
from weftex.cli.tiling import each_output
from weftex.exemplar import Exemplar
from weftex.exemplar.material import Material
from weftex.io.formats import written_as
from weftex.io.pictures import Picture
from weftex.prepare.estimating import estimate_maps, light_joints


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("estimate", __doc__)
    add = parser.add_argument
    text = "images, folders of maps or of separate images, or sample:NAME"
    add("photos", metavar="PHOTO", nargs="+", help=text)
    text = "folder to write; for several photos, a folder of folders"
    add("-o", "--output", metavar="OUT", required=True, help=text)
    text = "maps to estimate: height, normal_gl (y up), normal_dx (y down), ao, roughness; "
    text += "default: all missing maps, with normal_gl"
    add("--maps", metavar="NAME,...", help=text)
    text = "height from the lowest to the highest point, in pixels; higher makes normals steeper; "
    add("--relief", type=float, default=6.0, metavar="PX", help=text + "default: 6")
    text = "bright pixels are deep, such as light joints between dark bricks"
    add("--invert", action="store_true", help=text)
    text = "distance, in pixels, up to which a surface occludes; default: 16"
    add("--ao-radius", type=int, default=16, metavar="PX", help=text)
    add("--tileable", action="store_true", help="the photo is tileable; makes its maps tileable")
    parser.share("--preset", "--quiet", "--allow-huge")
    args = parser.parse(argv)
    maps = None if args.maps is None else [name.strip() for name in args.maps.split(",")]

    def work(bar: Bar, outputs: Outputs) -> str:
        lines = []
        for path, own in each_output(args.photos, args, outputs, folders=True):
            material = read_input(path, args)
            photo = material.exemplar(tileable=args.tileable)
            how = {"relief": args.relief, "invert": args.invert, "radius": args.ao_radius}
            whole, new = _with_maps(material, estimate_maps(photo, maps=maps, **how))
            files, _ = plan([whole], whole.exemplar(), own)
            files.write(outputs.staged_path)
            by_color = not {"height", "normal"} & {one.kind for one in material.roles.values()}
            if by_color and not args.invert and {*new} - {"roughness"} and light_joints(photo):
                lines.append("note: thin bright lines divide the pattern and became ridges; if "
                             "they are joints, use --invert")  # fmt: skip
            if "roughness" in new:
                lines.append("note: roughness is a guess; a photo does not show it")
            listed = ", ".join(new)
            lines.append(f"estimated {listed} of {path}, in {own.output}, in {bar.took:.2f} s")
        return "\n".join(lines)

    run_and_report(work, args.quiet)


def _with_maps(material: Material, made: Exemplar) -> tuple[Material, list[str]]:
    """Return a material as a set with its new maps, and their names."""
    pictures, roles = dict(material.pictures), dict(material.roles)
    if not material.folder:
        (name, picture), role = next(iter(pictures.items())), roles[material.main]
        suffix = written_as(picture.path, picture.pixels.dtype.kind == "f")
        suffix = ".png" if suffix.lower() in (".jpg", ".jpeg") else suffix
        pictures = {role.name: replace(picture, path=role.name + suffix)}
        roles = {role.name: role}
    main = material.pictures[material.main]
    new = [name for name in made.maps if name not in pictures and name not in material.pictures]
    for name in new:
        pixels, path = made.maps[name], f"{name}_estimated.png"
        density = main.density and main.density * pixels.shape[1] / main.pixels.shape[1]
        pictures[name] = Picture(pixels, False, None, path, density=density)
        roles[name] = made.roles[name]
    return Material(material.name, pictures, roles, folder=True), new
