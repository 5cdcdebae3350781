"""Graph-cut textures: patches of any shape, and where they were joined.

python examples/graphcut.py -o FOLDER
"""

import argparse
from pathlib import Path

import numpy as np

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

sample = weftex.load_exemplar("sample:stone_wall")
model = weftex.GraphCut(candidates=6).fit(sample)
result = model.sample((384, 512), seed=7)
weftex.write_image(folder / "graphcut.png", result.image)
weftex.write_image(folder / "graphcut_seams.png", result.draw("seams"))

# The same material from one end to the other, and again from there.
tile = model.sample(256, seed=7, tileable=True)
weftex.write_image(folder / "graphcut_tile.png", np.tile(tile.image, (2, 2, 1)))

shift = result.source - np.indices(result.shape).transpose(1, 2, 0)
pieces = len(np.unique(shift.reshape(-1, 2), axis=0))
print(f"{folder / 'graphcut.png'}: {pieces} pieces of the sample, each where it fits")
