"""The passes over a level: in which order pixels are chosen, and by which windows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from weftex.random import draw
from weftex.raster.masks import peeled

_MASKED_FACTOR = 8  # times the leaves: a window known in part says less of where to look
_CLOSING_PASSES = 2  # over the border of a wrapped picture; after one, at one level, much is left
_WHOLE_PASSES = 4  # over a hole by whole windows; the paper has one, but more make stones whole


@dataclass(frozen=True, eq=False)
class Pass:
    """One pass over pixels of a level."""

    places: NDArray[np.int32]  # flat indices of the pixels in their order
    causal: bool  # L-shaped windows, or such that look to all sides
    leaves: int  # to look into


def scan_passes(
    shape: tuple[int, ...], wrap: tuple[bool, bool], reach: int, leaves: int, further: int
) -> list[Pass]:
    """Return the passes over a level without known pixels; `wrap` is the canvas's.

    The first is the paper's, in scan order with causal windows. Where the canvas wraps, a second
    one replaces the border, as the first rows did not depend on the last.
    """
    every = np.arange(shape[0] * shape[1], dtype=np.int32)
    found = [Pass(every, True, leaves)] + [Pass(every, False, leaves)] * further
    border = np.zeros(shape, bool)
    for axis in (0, 1):
        if wrap[axis]:
            lines = border.swapaxes(0, axis)
            lines[:reach] = lines[max(len(lines) - reach, 0) :] = True
    if border.any():
        around = np.flatnonzero(border).astype(np.int32)
        found += [Pass(around, False, leaves)] * _CLOSING_PASSES
    return found


def hole_passes(
    unknown: NDArray[np.bool_], wrap: tuple[bool, bool], seed: int, leaves: int, further: int
) -> list[Pass]:
    """Return the passes of constrained synthesis: by known pixels, then by whole windows."""
    places = inwards(unknown, wrap, seed)
    first = Pass(places, False, leaves * _MASKED_FACTOR)
    return [first] + [Pass(places, False, leaves)] * (_WHOLE_PASSES + further)


def inwards(unknown: NDArray[np.bool_], wrap: tuple[bool, bool], seed: int) -> NDArray[np.int32]:
    """Return flat indices of unknown pixels in layers from the border inward.

    Neighbors of a layer follow each other in lines from a random corner, so that they continue
    coherently.
    """
    layers = [np.empty(0, np.int32)]
    for number, places in enumerate(peeled(unknown, wrap), 1):
        bits = int(draw(seed, "wei-levoy order", number))
        y, x = np.divmod(places, unknown.shape[1])
        keys = [y * (1 - 2 * (bits & 1)), x * (1 - (bits & 2))]
        layers.append(places[np.lexsort(keys[:: 1 - 2 * (bits >> 2 & 1)])])
    return np.concatenate(layers)
