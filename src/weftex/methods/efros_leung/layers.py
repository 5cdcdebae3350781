"""The layers that a texture grows in, and the order of the pixels of a layer."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from weftex.methods.efros_leung import wave_kernels as kernels
from weftex.methods.efros_leung.weighted_search import Matcher, Matches
from weftex.random import draw, pick
from weftex.raster.arrays import Bytes, Indices
from weftex.raster.masks import grown
from weftex.search.windows import Windows

_SHARE = 8  # pixels; fewer are not worth another thread


def seed_piece(
    windows: Windows, side: int, shape: tuple[int, int], seed: int
) -> tuple[Indices, Indices]:
    """Return flat indices into the canvas and the windows' pixels: a random piece for the middle.

    The piece is `side` pixels wide, or as the canvas if that is smaller.
    """
    center = pick(windows.centers, seed, "efros-leung seed")
    height, width = (min(side, n) for n in shape)
    away = np.arange(side) - side // 2
    piece = center + away[:height, None] * windows.pixels.shape[1] + away[:width]
    source = windows.from_sample(windows.to_sample(piece.astype(np.int32)))
    top, left = (shape[0] - height) // 2, (shape[1] - width) // 2
    canvas = np.arange(shape[0] * shape[1], dtype=np.int32).reshape(shape)
    return canvas[top : top + height, left : left + width].ravel(), source.ravel()


def unfilled_neighbors(done: Bytes, wrap: tuple[bool, bool]) -> Indices:
    """GetUnfilledNeighbors: flat indices of unfilled pixels beside or diagonal to filled ones."""
    filled = done > 0
    return np.flatnonzero(grown(filled, 1, wrap) & ~filled).astype(np.int32)


class Waves:
    """Splits a layer into waves: pixels that can be made at the same time.

    No window of a wave's pixels contains another of them, and of two pixels of which one sees the
    other, the one that is earlier in order is in an earlier wave. So the result is that of choosing
    one pixel after the other. `width` is the side of the window in pixels.
    """

    def __init__(
        self, shape: tuple[int, int], wrap: tuple[bool, bool], width: int, seed: int
    ) -> None:
        runs = np.empty((width * (width // 2 + 1), 3), np.int32)
        self._window = (*wrap, width // 2, runs)
        self._listed, self._numbers = np.zeros(shape, np.uint8), np.empty(shape, np.int32)
        self._seed = seed

    def of(self, layer: Indices, done: Bytes) -> Iterator[tuple[Indices, NDArray[np.uint64]]]:
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
        pixels, bits = layer[order], draw(self._seed, "efros-leung", *at)[order]
        for start, end in zip((0, *ends), ends, strict=False):
            yield pixels[start:end], bits[start:end]


@contextmanager
def in_threads(matchers: list[Matcher]) -> Iterator[Matcher]:
    """Give a matcher that divides the pixels of a wave among threads, one for each of these."""
    if len(matchers) == 1:
        yield matchers[0]
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(len(matchers)) as pool:

        def find_matches(pixels: Indices, bits: NDArray[np.uint64]) -> Matches:
            count = min(len(matchers), -(-len(pixels) // _SHARE))
            if count == 1:
                return matchers[0](pixels, bits)
            parts = np.array_split(pixels, count), np.array_split(bits, count)
            found = zip(*pool.map(lambda match, *part: match(*part), matchers, *parts), strict=True)
            chosen, distances, weights = (np.concatenate(part) for part in found)
            return chosen, distances, weights

        yield find_matches
