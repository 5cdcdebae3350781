"""What a sample is like: its scale, and the curve of the spectrum that it is read from.

python examples/analyze.py -o FOLDER
"""

import argparse
from pathlib import Path

import numpy as np

import weftex
from weftex.analysis.scale import structure_scale

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

print(weftex.analyze("sample:bricks"))

# The curve, fine structure on the right; its background is orange, the scale a red line.
found = structure_scale(weftex.load_exemplar("sample:bricks"))
plot = np.full((200, 400, 3), 255, np.uint8)
octaves = np.log2(found.frequencies / found.frequencies[0])
across = octaves / octaves[-1] * 399
y = np.arange(200)[::-1, None]
at = np.arange(400)
plot[y < 199 * np.interp(at, across, found.power)] = 90
plot[abs(y - 199 * np.interp(at, across, found.background)) < 2] = (255, 150, 0)
scale = np.argmin(abs(1 / found.frequencies - found.scale))
plot[:, round(across[scale])] = (200, 0, 0)
weftex.write_image(folder / "analyze_bricks.png", plot)
