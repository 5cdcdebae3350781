"""A material with all its maps: matched together, made together, and replayed later.

python examples/maps.py -o FOLDER
"""

import argparse
from pathlib import Path

import numpy as np

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

stone = weftex.load_exemplar("sample:stone_wall")  # albedo, with four aligned maps
result = weftex.synthesize(stone, (384, 512), method="quilting", seed=7)
weftex.write_image(folder / "maps_albedo.png", result.image)
for name, pixels in result.maps.items():
    weftex.write_image(folder / f"maps_{name}.png", pixels)

# The coordinates are kept, so a map that turns up later can be laid in the same way: here a height
# map of 16 bits and twice the resolution.
result.save(folder / "maps.npz")
height = stone.maps["height"].reshape(stone.shape).astype(np.uint16) * 257
finer = height.repeat(2, axis=0).repeat(2, axis=1)
replayed = weftex.Synthesis.load(folder / "maps.npz").render(finer)
weftex.write_image(folder / "maps_height_16bit_2x.png", replayed)
print(replayed.dtype, replayed.shape)
