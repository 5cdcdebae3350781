"""Hole filling: the surroundings continue into the hole, and no other pixel changes.

python examples/fill.py -o FOLDER
"""

import argparse
from pathlib import Path

import numpy as np

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

photo = weftex.read_image("sample:bricks").pixels
y, x = np.indices(photo.shape[:2])
hole = (y - 130) ** 2 + (x - 100) ** 2 < 55**2  # a disc
hole |= (abs(y - x) < 12) & (x > 170)  # and a scratch that runs off the picture

damaged = photo.copy()
damaged[hole] = (255, 0, 255)  # what was there does not matter
result = weftex.fill(damaged, hole, seed=7)

weftex.write_image(folder / "fill_before.png", damaged)
weftex.write_image(folder / "fill_after.png", result.image)
print("known pixels untouched:", bool((result.image[~hole] == photo[~hole]).all()))
