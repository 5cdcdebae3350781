"""A material in light from the side: where normals and heights do not fit together, it shows.

python examples/light.py -o FOLDER
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

import weftex
from weftex.raster.levels import to_light, to_stored


def unit(pixels: np.ndarray) -> np.ndarray:
    """Return pixels as (H, W, C) from 0 to 1."""
    return np.atleast_3d(pixels) / (np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else 1)


def lit(
    color: np.ndarray, normal: np.ndarray | None = None, height: np.ndarray | None = None
) -> np.ndarray:
    """Return a matte surface in light from the upper left, uint8 (H, W, 3) in sRGB.

    Normals have y up; without them they are the slopes of `height`, 16 pixels between 0 and 1.
    """
    if normal is not None:
        vectors = 2 * unit(normal)[..., :3] - 1
    else:
        down, across = np.gradient(16 * unit(height)[..., 0])
        vectors = np.dstack([-across, down, np.ones(down.shape)])
    vectors /= np.maximum(np.linalg.norm(vectors, axis=2, keepdims=True), 1e-6)
    light = np.array([-1, 1, 0.7]) / np.linalg.norm([-1, 1, 0.7])
    shade = np.maximum(vectors @ light, 0)[..., None]
    return np.rint(255 * to_stored(to_light(unit(color)) * shade)).astype(np.uint8)


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path(), metavar="FOLDER")
folder = parser.parse_args().output
folder.mkdir(parents=True, exist_ok=True)

stone = weftex.load_exemplar("sample:stone_wall")
result = weftex.synthesize(stone, (512, 512), method="graphcut", seed=2)
height = stone.maps["height"]
laid, joined = result.render(height), result.maps["height"]  # as an array it shows nothing

plaster = np.full((*result.shape, 3), 190, np.uint8)
weftex.write_image(folder / "light_color.png", lit(result.image, normal=result.maps["normal"]))
weftex.write_image(folder / "light_laid.png", lit(plaster, height=laid))
weftex.write_image(folder / "light_joined.png", lit(plaster, height=joined))
both = [lit(plaster, height=values)[96:416, 41:471] for values in (laid, joined)]
Image.fromarray(np.concatenate(both, axis=1)).save(folder / "light.webp", quality=45, method=6)

# Steps across the border of two pieces, over the mean step of the sample.
across = (np.diff(result.source.astype(int), axis=1) != (0, 1)).any(axis=2)
own = abs(np.diff(height.astype(float), axis=1)).mean()
for name, values in (("laid", laid), ("joined", joined)):
    steps = abs(np.diff(values.reshape(result.shape).astype(float), axis=1)) / own
    print(f"{name}: {steps[across].mean():.2f} at borders, {steps[~across].mean():.2f} elsewhere")
