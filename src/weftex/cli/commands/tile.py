"""weftex tile: make a photo tileable."""

from __future__ import annotations

from weftex.cli.making import run_task
from weftex.cli.parser import Parser

_ABOUT = """\
Make a photo tileable at its own size. Only a border changes; the middle keeps every byte.\
"""

_EXAMPLES = """\
examples:
  weftex tile photo.jpg -o tile.png
  weftex tile photo.jpg -o strip.png --tileable x --border 40
  weftex tile stone_wall/ -o tile/                    a folder of aligned maps
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("tile", _ABOUT, _EXAMPLES)
    parser.add_argument("materials", metavar="PHOTO", help="image, folder of maps, or sample:NAME")
    run_task("tile", parser, argv, "chosen for the photo")
