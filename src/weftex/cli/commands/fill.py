"""weftex fill: fill the holes in a photo."""

from __future__ import annotations

from weftex.cli.making import run_task
from weftex.cli.parser import Parser

_ABOUT = """\
Fill the holes in a photo. All other pixels stay unchanged unless --overlap is given. Without
--method and method parameters, weftex chooses a method: graphcut or near-regular for photos with a
lattice or large features, patch-sampling for all others. patch-sampling has other defaults for
holes than those listed below: candidates 400, epsilon 0.02, boundary width 4, and a patch size that
depends on the width of the holes.\
"""

_EXAMPLES = """\
examples:
  weftex fill photo.png --mask hole.png -o whole.png
  weftex fill erased.png -o whole.png                 fill the transparent pixels
  weftex fill photo.png --mask hole.png -o whole.png --sample grass.png
  weftex fill stone_wall/ --mask hole.png -o whole/   a folder of aligned maps
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("fill", _ABOUT, _EXAMPLES)
    parser.add_argument("materials", metavar="PHOTO", help="image, folder of maps, or sample:NAME")
    text = "image to fill the holes from, in place of the photo"
    parser.add_argument("--sample", metavar="FILE", help=text)
    run_task("fill", parser, argv, "chosen for the photo")
