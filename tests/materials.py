"""Made-up samples and canvases of which more than one test file makes use."""

import numpy as np


def wall(height, width, tile=(12, 16), offset=8, seed=1, spread=40):
    """Bricks in running bond: mortar, and bricks of their own colors."""
    rng = np.random.default_rng(seed)
    pixels = np.empty((height, width, 3), np.uint8)
    tones = rng.integers(90, 90 + spread, (height // tile[0] + 2, width // tile[1] + 3, 3))
    y, x = np.indices((height, width))
    row = y // tile[0]
    column = (x + offset * (row % 2)) // tile[1]
    pixels[:] = tones[row, column]
    pixels += rng.integers(0, 9, pixels.shape).astype(np.uint8)
    pixels[(y % tile[0] < 2) | ((x + offset * (row % 2)) % tile[1] < 2)] = 220
    return pixels


def ellipse(shape, place, radius):
    """True inside of an ellipse: a hole."""
    y, x = np.indices(shape)
    return ((y - place[0]) / radius[0]) ** 2 + ((x - place[1]) / radius[1]) ** 2 < 1


def made_up(rng, shape, kind, channels):
    """Noise of all levels, of "few" or of two "extreme" ones, or a "smooth" ramp."""
    if kind == "extreme":
        return (rng.integers(0, 2, (*shape, channels)) * 255).astype(np.uint8)
    if kind == "smooth":
        y, x = np.indices(shape)
        return ((y[..., None] * 5 + x[..., None] * 3 + np.arange(channels)) % 256).astype(np.uint8)
    return rng.integers(0, 256 if kind == "noise" else 4, (*shape, channels)).astype(np.uint8)


def states(rng, exemplar, windows, shape, wrap):
    """A canvas half known: pieces of the sample where it says so, noise elsewhere."""
    pixels = windows.pixels.reshape(-1, windows.pixels.shape[2])
    source = rng.choice(windows.centers, shape).astype(np.int32)
    for _ in range(3):  # coherent pieces
        place = windows.centers[rng.integers(windows.centers.size)]
        y, x = rng.integers(shape[0]), rng.integers(shape[1])
        piece = source[y : y + 6, x : x + 6]
        across = windows.pixels.shape[1]
        piece[:] = place + np.arange(piece.shape[0])[:, None] * across + np.arange(piece.shape[1])
    source = np.minimum(source, len(pixels) - 1)
    levels = pixels[source]
    odd = rng.random(shape) < 0.1
    levels[odd] = rng.integers(0, 256, (odd.sum(), levels.shape[2]))
    source[odd] = -1
    done = (rng.random(shape) < rng.choice([0.1, 0.5, 0.9])).astype(np.uint8)
    source[done == 0] = -1
    return np.ascontiguousarray(levels * done[..., None]), done, source


def normal_map(rng, shape, steep=0.8):
    """Unit vectors, float64 (H, W, 3), that point up on the whole."""
    vectors = np.dstack([*rng.uniform(-steep, steep, (2, *shape)), np.ones(shape)])
    return vectors / np.linalg.norm(vectors, axis=2, keepdims=True)
