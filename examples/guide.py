"""Materials that follow a picture: pebbles with the light of a drawing, and texture by numbers.

python examples/guide.py -o FOLDER
"""

import argparse
from pathlib import Path

import numpy as np

import weftex

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
parser.add_argument("--size", type=int, default=320, help="pixels a side")
folder, size = vars(parser.parse_args()).values()
folder.mkdir(parents=True, exist_ok=True)

sample = weftex.load_exemplar("sample:pebbles")

# A soft light, a disc and a slope, from 0 to 1.
y, x = np.indices((size, size)) / size - 0.5
shape = np.exp(-((x + 0.12) ** 2 + (y + 0.12) ** 2) / 0.03)
shape += 0.5 * (np.hypot(x - 0.2, y - 0.2) < 0.18) + 0.25 * x
shape = (shape - shape.min()) / (shape.max() - shape.min())

# A guide is compared with the sample, so it gets the sample's colors, from the darkest to the
# brightest.
colors = sample.pixels.reshape(-1, 3)
colors = colors[np.argsort(colors.sum(axis=1))]
bands = [band.mean(axis=0) for band in np.array_split(colors, 64)]
guide = np.rint(np.array(bands)[np.rint(shape * 63).astype(int)]).astype(np.uint8)
weftex.write_image(folder / "guide.png", guide)

for method, weights in (("ashikhmin", (0.1, 0.3, 1.0)), ("graphcut", (1.0, 2.0, 8.0))):
    for weight in weights:
        result = weftex.synthesize(
            sample, guide.shape[:2], method=method, guide=guide, guide_weight=weight, seed=7
        )
        weftex.write_image(folder / f"guided_{method}_{weight}.png", result.image)

# Texture by numbers: orange leaves are 1 in the sample, and a wave is to be made of them. The map
# could as well be painted; here it is where there is much more red than blue around.
sample = weftex.load_exemplar("sample:leaves")
red, _, blue = np.moveaxis(sample.pixels.astype(int), 2, 0)
kernel = np.ones(15) / 15
around = (red - blue).astype(float)
for axis in (0, 1):
    around = np.apply_along_axis(np.convolve, axis, around, kernel, mode="same")
orange = (around > 75).astype(np.uint8)
y, x = np.indices((4 * size // 5, 6 * size // 5)) / size
wave = (np.abs(y - 0.4 - 0.1875 * np.sin(8 * x)) < 0.09375).astype(np.uint8)
result = weftex.synthesize(sample, wave.shape, guide=wave, sample_guide=orange, seed=3)
weftex.write_image(folder / "orange.png", 255 * orange)
weftex.write_image(folder / "wave.png", 255 * wave)
weftex.write_image(folder / "leaves_by_numbers.png", result.image)
print(f"{folder}: guide.png and pebbles that follow it a little, more and closely; orange.png, "
      "wave.png and leaves_by_numbers.png")  # fmt: skip
