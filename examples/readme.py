"""The picture at the top of the README: shipped samples, and what the methods make of them."""

import argparse
import os

import numpy as np

import weft

ROWS = [[("pebbles", "patch-sampling"), ("bricks", "quilting")],
        [("leaves", "patch-sampling"), ("stone_wall/albedo", "quilting")]]  # fmt: skip


def beside(name: str, method: str) -> np.ndarray:
    """The sample on white, its output to the right."""
    sample = weft.read_image(f"sample:{name}").pixels[:192, :192]
    result = weft.synthesize(sample, (384, 448), method=method, seed=7).image
    left = np.full((384, 200, 3), 255, np.uint8)
    left[:192, :192] = sample
    gap = np.full((384, 8, 3), 255, np.uint8)
    return np.concatenate([left, result, gap], axis=1)


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", default=".", help="folder to write readme.jpg to")
folder = parser.parse_args().output
rows = [np.concatenate([beside(*cell) for cell in row], axis=1) for row in ROWS]
gap = np.full((8, rows[0].shape[1], 3), 255, np.uint8)
picture = np.concatenate([rows[0], gap, rows[1]], axis=0)
weft.write_image(os.path.join(folder, "readme.jpg"), picture)
