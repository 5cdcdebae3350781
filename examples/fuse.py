"""Fusion: three materials that merge where a painted map says.

python examples/fuse.py -o FOLDER
"""

import argparse
from pathlib import Path

import numpy as np

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

y, x = np.indices((400, 400))
label_map = np.zeros((400, 400, 3), np.uint8)
label_map[:] = (200, 120, 40)  # leaves
label_map[(y - 150) ** 2 + (x - 130) ** 2 < 95**2] = (120, 120, 140)  # a heap of pebbles
label_map[y > 285 + 25 * np.sin(x / 50)] = (90, 60, 50)  # a wall at the foot

samples = ["sample:leaves", "sample:pebbles", weftex.load_exemplar("sample:stone_wall").pixels]
result = weftex.fuse(samples, label_map, seed=7)

weftex.write_image(folder / "fuse_map.png", label_map)
weftex.write_image(folder / "fuse.png", result.image)
print(folder / "fuse.png", result.image.shape)
