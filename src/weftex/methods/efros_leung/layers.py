"""The layers that a texture grows in, and the order of the pixels of a layer (section III.A)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.methods.efros_leung import wave_kernels as kernels
from weftex.methods.efros_leung.weighted_search import Draw, Drawn
from weftex.random import draw
from weftex.raster.masks import grown
from weftex.search.windows import Windows

_SHARE = 8  # pixels; fewer are not worth another thread


def seed_piece(
    windows: Windows, side: int, shape: tuple[int, int], seed: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return flat indices into the canvas and the windows' pixels: a random piece for the middle.

    The piece is `side` pixels wide, or as the canvas if that is smaller.
    """
    centers = windows.centers
    bits = draw(seed, "efros-leung seed")
    center = centers[(int(bits) >> 32) * len(centers) >> 32]
    height, width = (min(side, n) for n in shape)
    away = np.arange(side) - side // 2
    piece = center + away[:height, None] * windows.pixels.shape[1] + away[:width]
    source = windows.from_sample(windows.to_sample(piece.astype(np.int32)))
    top, left = (shape[0] - height) // 2, (shape[1] - width) // 2
    places = np.arange(shape[0] * shape[1], dtype=np.int32).reshape(shape)
    return places[top : top + height, left : left + width].ravel(), source.ravel()


def unfilled_with_filled_neighbors(
    done: NDArray[np.uint8], wrap: tuple[bool, bool]
) -> NDArray[np.int32]:
    """Return a layer: flat indices of unfilled pixels with a filled pixel beside or diagonal."""
    filled = done > 0
    return np.flatnonzero(grown(filled, 1, wrap) & ~filled).astype(np.int32)


class Waves:
    """Splits a layer into waves: pixels that can be made at the same time.

    No window of a wave's pixels contains another of them, so the result is thread-independent.
    `width` is the side of the window in pixels.
    """

    def __init__(
        self, shape: tuple[int, int], wrap: tuple[bool, bool], width: int, seed: int
    ) -> None:
        runs = np.empty((width * (width // 2 + 1), 3), np.int32)
        self._window = (*wrap, width // 2, runs)
        self._listed, self._numbers = np.zeros(shape, np.uint8), np.empty(shape, np.int32)
        self._seed = seed

    def of(
        self, layer: NDArray[np.int32], done: NDArray[np.uint8]
    ) -> Iterator[tuple[NDArray[np.int32], NDArray[np.uint64]]]:
        """Yield the flat indices of each wave's pixels, and random bits for each.

        Pixels with the most known pixels in their windows come first, ties at random.
        """
        known, waves = (np.empty(len(layer), np.int32) for _ in range(2))
        kernels.count_known(*self._window, done, layer, known)
        at = np.divmod(layer, done.shape[1])
        order = np.lexsort((draw(self._seed, "efros-leung order", *at), -known))
        kernels.wave_numbers(*self._window, layer[order], self._listed, self._numbers, waves)
        order = order[np.argsort(waves, kind="stable")]
        ends = np.cumsum(np.bincount(waves))
        places, bits = layer[order], draw(self._seed, "efros-leung", *at)[order]
        for start, end in zip((0, *ends), ends, strict=False):
            yield places[start:end], bits[start:end]


@contextmanager
def shared(draws: list[Draw]) -> Iterator[Draw]:
    """Give a function that draws windows for a wave, in as many threads as there are functions."""
    if len(draws) == 1:
        yield draws[0]
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(len(draws)) as pool:

        def drawn(places: NDArray[np.int32], bits: NDArray[np.uint64]) -> Drawn:
            count = min(len(draws), -(-len(places) // _SHARE))
            if count == 1:
                return draws[0](places, bits)
            ends = np.linspace(0, len(places), count + 1).astype(int)

            def share(k: int) -> tuple[NDArray[Any], ...]:
                part = slice(ends[k], ends[k + 1])
                return draws[k](places[part], bits[part])

            parts = zip(*pool.map(share, range(count)), strict=True)
            chosen, distances, weights = (np.concatenate(part) for part in parts)
            return chosen, distances, weights

        yield drawn
