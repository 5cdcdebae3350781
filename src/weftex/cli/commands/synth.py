"""weftex synth: synthesize an image of any size from a sample of a material."""

from __future__ import annotations

from weftex.cli.making import run_task
from weftex.cli.parser import Parser
from weftex.cli.shared import BLOCKS

_ABOUT = """\
Synthesize an image of any size from a sample of a material.\
"""

_EXAMPLES = """\
examples:
  weftex synth brick.png -o wall.png --size 1024x768 --save-source wall.npz
  weftex synth brick.png -o tile.png --size 512 --tileable --seed 7
  weftex synth near.jpg far.jpg -o wall.png           several photos of one material
  weftex synth stone_wall/ -o big/ --size 2k          a folder of aligned maps
  weftex synth brick.png -o wall.png --method quilting --patch-size 48
  weftex synth brick.png -o wall.png --best-of 8      the best of eight seeds
  weftex synth brick.png -o wall.png --best-of quilting,graphcut,near-regular
  weftex synth photo.jpg -o wall.png --straighten --even-light
  weftex synth brick.png -o part.png --window 10000,-500,512,512 --seed 7    of an endless plane
  weftex synth brick.png -o wall.zarr --size 100000x100000 --workers 4
  weftex synth moss.png -o face.png --method ashikhmin --guide face.png
  weftex synth photo.png -o new.png --method refinement --sample-guide painted.png --guide other.png
"""


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("synth", _ABOUT, _EXAMPLES)
    text = "image, folder of maps, or sample:NAME; several must show the same material"
    parser.add_argument("materials", metavar="SAMPLE", nargs="+", help=text)
    text = "folder for images that show how the result is put together: sources, patches, seams"
    parser.under["output"].add_argument("--debug", metavar="DIR", help=text)
    parser.share(*BLOCKS)
    run_task("synth", parser, argv, "chosen for the sample")
