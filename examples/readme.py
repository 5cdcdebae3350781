"""The picture at the top of the README: samples, and what weftex makes of them by itself."""

import argparse
import os

import numpy as np

import weftex

ROWS = [["wood", "bricks"], ["leaves", "stone_wall/albedo"], ["weave", "tiles"]]


def beside(name: str) -> np.ndarray:
    """The sample on white, its output to the right."""
    sample = weftex.read_image(f"sample:{name}").pixels
    result = weftex.synthesize(sample, (384, 448), seed=7).image
    left = np.full((384, 264, 3), 255, np.uint8)
    left[: len(sample), : len(sample[0])] = sample
    gap = np.full((384, 8, 3), 255, np.uint8)
    return np.concatenate([left, result, gap], axis=1)


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", default=".", help="folder to write readme.webp to")
folder = parser.parse_args().output
rows = [np.concatenate([beside(name) for name in row], axis=1) for row in ROWS]
gap = np.full((8, rows[0].shape[1], 3), 255, np.uint8)
picture = np.concatenate([part for row in rows for part in (row, gap)][:-1], axis=0)
weftex.write_image(os.path.join(folder, "readme.webp"), picture)
