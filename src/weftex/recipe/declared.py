"""The tasks, their options, and the options that prepare their materials."""

from __future__ import annotations

from typing import NamedTuple

from weftex.recipe.options import (
    AXES,
    COLORS,
    DEGREE,
    DENSITY,
    FILES,
    FLAG,
    LENGTH,
    LEVELS,
    MIXED,
    NUMBER,
    PICTURE,
    SIZE,
    STRAIGHTEN,
    TEXT,
    WEIGHTS,
    WHOLE,
    WINDOW,
    Kind,
    Option,
)
from weftex.registry import AUTO, FOR_FUSION, FOR_HOLES, FOR_TILES

_PREPARATION, _QUALITY, _SETS = "preparation of the sample", "quality", "map sets"


def _by_name(*options: Option) -> dict[str, Option]:
    return {option.name: option for option in options}


#: What is done to a material before anything is made from it, in this order.
MATERIAL = _by_name(
    Option(
        "maps", FILES, "the file of each map in the folder, if weftex does not know its name",
        metavar="NAME=FILE,...", heading=_SETS,
    ),
    Option(
        "repeats", FLAG, "the sample itself is tileable, so patches may cross its borders", False,
        given_flag="--tileable-sample", heading="tiling",
    ),
    Option(
        "map_weights", WEIGHTS, "weights of the maps in matching, such as height=3,normal=2; "
        "higher hides seams in that map; 0 makes the map without comparing it",
        default_text="1 each",
        metavar="NAME=N,...", heading=_SETS,
    ),
    Option(
        "mask", PICTURE, "image that is white where pixels may be copied from; 'alpha' uses the "
        "opaque ones", given_flag="--sample-mask", metavar="FILE", heading=_PREPARATION,
    ),
    Option(
        "straighten", STRAIGHTEN, "straighten the photo by the lattice or rows that weftex finds "
        "(no value), by two lattice vectors (four numbers), or by the corners of a rectangle, "
        "clockwise from the top left (eight numbers)", metavar="X,Y,...", heading=_PREPARATION,
    ),
    Option(
        "even_light", DEGREE, "remove uneven light from the photo; a higher DEGREE, up to 8, "
        "removes smaller bright and dark areas too", default_text="2 if no value is given",
        low=1, high=8, metavar="DEGREE", heading=_PREPARATION,
    ),
    Option(
        "sample_width", LENGTH, "width of the surface that the whole photo shows; outputs store "
        "the density", default_text="the density that the file states", metavar="0.6m",
        heading=_PREPARATION,
    ),
    Option(
        "density", DENSITY, "scale the photo and its maps to this number of pixels per meter",
        default_text="the photo's", metavar="1024px/m", heading=_PREPARATION,
    ),
    Option(
        "turn", TEXT, "also use copies of the sample: mirrored (flip), rotated by 180 degrees "
        "(half), by quarter turns (4), or mirrored and rotated by quarter turns (8)",
        choices=("flip", "half", "4", "8"), metavar="flip|half|4|8", heading=_QUALITY,
    ),
)  # fmt: skip
#: Those of `MATERIAL` that `weftex prepare` does, too.
PREPARATION = ("straighten", "even_light", "sample_width", "density")

SEED = Option(
    "seed", WHOLE, "random seed; the same seed gives the same output", low=0, high=2**64 - 1,
    metavar="N",
)  # fmt: skip
_WRAP = "check, pad and crop"
PAD = Option(
    "pad", WHOLE, "surround a tileable image with N pixels of the opposite sides, for upscalers "
    "and filters; --crop removes them", low=1, metavar="N", heading=_WRAP,
)  # fmt: skip
CROP = Option(
    "crop", WHOLE, "remove N pixels at each side; after an upscaler by 2, N is twice that of "
    "--pad", low=1, metavar="N", heading=_WRAP,
)  # fmt: skip
#: What an atlas of corner tiles takes beside a material.
ATLAS = _by_name(
    Option("colors", WHOLE, "number of corner colors: 2 makes 16 tiles, 3 makes 81, which repeat "
           "less", 2, low=2, high=3, metavar="2|3"),
    Option("tile_size", SIZE, "size of a tile in pixels; with a lattice, the nearest size that "
           "holds whole periods", default_text="512, or the sample's shorter side if less",
           metavar="WxH|N"),
    Option("gutter", WHOLE, "width of a border around each tile that continues it, for filters "
           "that read beyond a tile", 0, low=0, unit="px", metavar="PX"),
)  # fmt: skip
OUTPUT_SIZE = Option("size", SIZE, "output size in pixels", metavar="WxH|N")
TILEABLE = Option(
    "tileable", AXES, "make the output tileable along both axes, or only along x or y", False,
    metavar="x|y",
)  # fmt: skip
FIT = Option(
    "fit", FLAG, "with --tileable: make the nearest size that contains whole bricks, tiles or rows",
    False, heading="tiling",
)  # fmt: skip
LANDMARKS = Option(
    "landmarks", TEXT, "conspicuous features of the sample, such as its only red leaf: keep "
    "repeats them, thin makes them rare, remove replaces them; auto "
    "thins them from 1.25 times the sample's area on; no effect on samples with a lattice", "auto",
    choices=("auto", "keep", "thin", "remove"), metavar="auto|keep|thin|remove", heading=_QUALITY,
)  # fmt: skip

#: What `weftex.label_maps.Gradient` takes; a map of a fusion may be such a gradient.
GRADIENT = _by_name(
    Option(
        "direction", NUMBER, "direction from the first sample to the last, in degrees: 0 is "
        "right, 90 is down", default_text="90", metavar="DEG", heading="--map gradient",
    ),
    Option(
        "width", NUMBER, "length of each transition as a share of the image in this direction",
        default_text="transitions fill the image", metavar="W", heading="--map gradient",
    ),
)  # fmt: skip


def _map(value: object) -> object:
    """A picture, or what a gradient takes."""
    if isinstance(value, str):
        return value
    if not isinstance(value, dict) or not all(isinstance(name, str) for name in value):
        raise ValueError
    return {k: GRADIENT[k].checked(v) if k in GRADIENT else v for k, v in value.items()}


class Task(NamedTuple):
    """What can be made of materials."""

    options: dict[str, Option]  # beside materials, a method and a seed
    material: tuple[str, ...]  # those of `MATERIAL` that its command takes; in JSON it takes all
    least: int  # the number of materials
    most: int
    default_method: str  # where none is named
    parameter_method: str  # the method that parameters belong to then


#: The tasks by the names of their commands.
TASKS = {
    "synth": Task(
        _by_name(
            Option("size", SIZE, "output size in pixels, such as 1024x768 or 2k (2048x2048), or in "
                   "meters, such as 2m or 90cmx60cm",
                   default_text="the size of --guide, or twice the sample's", metavar="WxH|N"),
            Option("guide", PICTURE, "image that the output follows; as large as the output",
                   metavar="FILE"),
            TILEABLE,
            FIT,
            Option("best_of", WHOLE, "make N results with successive seeds, and keep the best", 1,
                   low=1, high=1000, metavar="N", heading=_QUALITY),
            LANDMARKS,
            Option("sample_guide", PICTURE, "image that labels regions of the sample, in the "
                   "colors of --guide; as large as the sample", metavar="FILE", heading=_QUALITY),
            Option("window", WINDOW, "compute only this part of an endless texture; parts of the "
                   "same seed fit together", metavar="TOP,LEFT,HEIGHT,WIDTH", heading="tiling",
                   local=True),
            Option("period", SIZE, "with --window: number of pixels after which the endless "
                   "texture repeats", metavar="WxH|N", heading="tiling", local=True),
        ),
        tuple(MATERIAL), 1, 1000, AUTO, AUTO,
    ),
    "tile": Task(
        _by_name(
            Option("border", WHOLE, "width of the border that may change", low=1, unit="px",
                   default_text="an eighth of the photo's shorter side", metavar="PX"),
            Option("axes", AXES, "make the photo tileable along both axes (default), or only along "
                   "x or y", True, given_flag="--tileable", metavar="x|y"),
        ),
        ("maps", "map_weights"), 1, 1, AUTO, FOR_TILES,
    ),
    "fill": Task(
        _by_name(
            Option("mask", PICTURE, "image that is white where the photo has holes", "alpha",
                   default_text="pixels that are not fully opaque", metavar="FILE"),
            Option("tileable", AXES, "the photo is tileable along both axes, or only x or y, so "
                   "holes can cross its border", False, metavar="x|y"),
            Option("overlap", WHOLE, "width of a strip around the holes that may change; wider "
                   "hides the seam better", 0, low=0, unit="px", metavar="PX", heading=_QUALITY),
            Option("match_tone", FLAG, "match the tone of the filling to its surroundings",
                   default_text="yes without --method and its parameters", heading=_QUALITY),
        ),
        ("maps", "repeats", "map_weights", "mask"), 1, 2, AUTO, FOR_HOLES,
    ),
    "fuse": Task(
        _by_name(
            Option("map", Kind("map", "an image, or what a gradient takes", str, _map),
                   "label map: image with one color for each sample, or 'gradient'", metavar="MAP"),
            Option("colors", COLORS, "colors of the samples in the label map, in their order, as "
                   "#rrggbb or gray levels", metavar="C,C,..."),
            Option("mixed", MIXED, "colors in the label map of regions that show spots of two "
                   "samples, such as '#00ff00=1+2'", metavar="C=A+B,..."),
            Option("size", SIZE, "output size in pixels", default_text="the label map's",
                   metavar="WxH|N"),
            TILEABLE,
            Option("boundary", TEXT, "cut: materials meet along the least visible seam; merged: "
                   "a belt along the seam is filled from both", "cut", choices=("cut", "merged"),
                   metavar="cut|merged", heading=_QUALITY),
            Option("belt_width", WHOLE, "width of the belt around a boundary, in which it may move",
                   low=2, unit="px", default_text="about that of the largest features",
                   metavar="PX", heading=_QUALITY),
            Option("missing", LEVELS, "values for missing maps: 0 to 1, or 'flat' for normals",
                   default_text="omit such maps", metavar="NAME=VALUE,...",
                   heading=_SETS),
        ),
        (), 2, 1000, AUTO, FOR_FUSION,
    ),
}  # fmt: skip


def options_of(task: str) -> list[Option]:
    """Return the options of a task's command, but for those of methods and of outputs."""
    own = [*TASKS[task].options.values(), *(MATERIAL[name] for name in TASKS[task].material)]
    return [*own, *GRADIENT.values(), SEED] if task == "fuse" else [*own, SEED]


def tasks_with(flag: str) -> list[str]:
    """Return the tasks whose commands have an option."""
    return [task for task in TASKS if flag in (option.flag for option in options_of(task))]
