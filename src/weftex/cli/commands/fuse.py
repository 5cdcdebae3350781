"""weftex fuse: merge several materials in one image."""

from __future__ import annotations

from weftex.cli.making import run_task
from weftex.cli.parser import Parser

_ABOUT = """\
Synthesize one image from several materials that merge according to a map. The map has one color
for each sample. --colors lists these colors; by default the samples take the colors in the order of
their appearance, row by row from the top left. --map gradient needs no image: it changes from one
sample to the next, along a line or in rings around a center.\
"""

_EXAMPLES = """\
examples:
  weftex fuse clover.png grape.png plum.png --map map.png -o field.png
  weftex fuse clover.png grape.png --map map.png --colors '#ff0000,#0000ff' -o field.png
  weftex fuse purple.png yellow.png --map gradient --size 400x400 -o beans.png
  weftex fuse stone_wall/ bark/ --map map.png --missing metallic=0 -o both/      folders of maps
  weftex fuse sand.png grass.png rock.png --map gradient --center 0.5,0.5 --size 400 -o island.png
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("fuse", _ABOUT, _EXAMPLES)
    text = "two or more images, folders of maps, or sample:NAME"
    parser.add_argument("materials", metavar="SAMPLE", nargs="+", help=text)
    run_task("fuse", parser, argv, "refinement")
