"""Boundary zones of patch-based sampling (sections 2.1 and 2.2)."""

from __future__ import annotations

import itertools
import math

import numpy as np


def distance_to_unknown(known):
    """Chebyshev distance of every pixel of a window to the nearest unknown one; inf without."""
    unknown = np.argwhere(~known)
    if not len(unknown):
        return np.full(known.shape, np.inf)
    away = np.abs(np.argwhere(np.ones_like(known))[:, None] - unknown[None])
    return away.max(axis=2).min(axis=1).reshape(known.shape)


def zone_of(known, width):
    """The band of width w_E along the border: known, and that near something unknown."""
    return known & (distance_to_unknown(known) <= width)


def zone_weights(known, width, frozen=None, paste=False):
    """Weights in 1/256: all for the new pixel outside the zone, falling evenly through it."""
    zone, distance = zone_of(known, width), distance_to_unknown(known)
    weights = np.zeros(known.shape, int)
    for v, u in itertools.product(*map(range, known.shape)):
        if not known[v, u]:
            weights[v, u] = 256
        elif zone[v, u]:
            share = (width + 1 - distance[v, u]) / (width + 1)
            weights[v, u] = 256 if paste else max(1, math.floor(256 * share + 1e-9))
        if frozen is not None and frozen[v, u]:
            weights[v, u] = 0
    return weights
