"""Small results of a patch method: whole ones, and a filled photo."""

import numpy as np

import weftex

SAMPLE = np.random.default_rng(5).integers(0, 256, (30, 34, 3)).astype(np.uint8)


def make(blend="feather", wrap=(False, False), patch_size=10, sample=SAMPLE, **more):
    method = weftex.PatchSampling(patch_size=patch_size, boundary_width=3, blend=blend)
    exemplar = weftex.Exemplar(sample, **more)
    return method.fit(exemplar).sample(weftex.Canvas(40, 45, wrap), seed=9)


def filled(known_from=(2, 3), patch_size=8):
    known = SAMPLE[2:28, 3:33].copy()
    hole = np.zeros(known.shape[:2], bool)
    hole[8:15, 10:22] = True
    known[hole] = 0
    mask = np.ones(SAMPLE.shape[:2], bool)
    mask[2:28, 3:33] = ~hole
    method = weftex.PatchSampling(patch_size=patch_size, boundary_width=2)
    canvas = weftex.Canvas(*hole.shape, known=known, hole=hole, known_from=known_from)
    return method.fit(weftex.Exemplar(SAMPLE, mask=mask)).sample(canvas, seed=4)
