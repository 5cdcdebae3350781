"""The quickest way: a bigger picture of a material in one call.

python examples/synthesize.py -o FOLDER
"""

import argparse
from pathlib import Path

import numpy as np

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

# A path or a sample that ships with weftex ...
wall = weftex.synthesize("sample:bricks", (480, 640), seed=7)
weftex.write_image(folder / "synthesize.png", wall.image)

# ... or an array of any channel count, 8 or 16 bit or float; the result has the same kind.
gray = weftex.read_image("sample:grass").pixels.astype(np.float32) / 255
lawn = weftex.synthesize(gray, (300, 400), method="quilting", seed=7)
print(lawn.image.dtype, lawn.image.shape)

# The same seed gives the same bytes, whatever the number of threads.
again = weftex.synthesize("sample:bricks", (480, 640), seed=7, threads=1)
print("the same bytes again:", bool((wall.image == again.image).all()))
