"""Tileable output: a picture that repeats without a seam, along both axes or one.

python examples/tileable.py -o FOLDER
"""

import argparse
from pathlib import Path

import numpy as np

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

model = weftex.PatchSampling().fit(weftex.load_exemplar("sample:pebbles"))
tile = model.sample((256, 256), tileable=True, seed=7).image
weftex.write_image(folder / "tileable.png", tile)
weftex.write_image(folder / "tileable_2x2.png", np.tile(tile, (2, 2, 1)))

# A frieze: it goes round horizontally only.
frieze = model.sample((128, 384), tileable="x", seed=7).image
weftex.write_image(folder / "tileable_x_twice.png", np.tile(frieze, (1, 2, 1)))
print(f"{folder / 'tileable_2x2.png'}: look for the border in the middle")
