"""Made-up map sets."""

import numpy as np

from families import noise

DATA = ("roughness", "metallic", "ao", "height", "opacity")


def normals(shape, dtype=np.uint8, seed=0):
    """Unit vectors that point out of the surface, y up."""
    found = np.random.default_rng(seed).normal(size=(*shape, 3))
    found[..., 2] = abs(found[..., 2]) + 1
    found /= np.linalg.norm(found, axis=2, keepdims=True)
    top = np.iinfo(dtype).max
    return np.rint((found + 1) * (top / 2)).astype(dtype)


def whole_set(shape=(6, 9), dtype=np.uint8, seed=0):
    maps = {role: noise(shape, dtype, seed + k) for k, role in enumerate(DATA)}
    return maps | {
        "color": noise((*shape, 3), dtype, seed + 10),
        "emission": noise((*shape, 3), dtype, seed + 11),
        "normal_gl": normals(shape, dtype, seed),
    }
