"""The exact search of the windows that match what is known around a pixel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weft.search import _exhaustive_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weft.search.windows import Windows

_HEAVIEST = 127  # the largest weight: times a difference it fits 16 bits
_BLOCK = 64  # as in the kernels
_TERMS = 24  # bytes that lower bounds are made of, a multiple of 4


def gaussian_weights(width: int, sigma: float) -> NDArray[np.int16]:
    """Return a Gaussian around the middle of a square window, in whole numbers from 1 to 127.

    Parameters
    ----------
    width : int
        Of the window in pixels, odd.
    sigma : float
        Standard deviation in pixels.

    Examples
    --------
    >>> gaussian_weights(3, 1.0)
    array([[ 47,  77,  47],
           [ 77, 127,  77],
           [ 47,  77,  47]], dtype=int16)
    """
    away = np.arange(width) - width // 2
    bell = np.exp(-(away[:, None] ** 2 + away**2) / (2 * sigma * sigma))
    weights: NDArray[np.int16] = np.maximum(np.rint(_HEAVIEST * bell), 1).astype(np.int16)
    return weights


class ExhaustiveSearch:
    """Compares what is known of a window with every window of a sample.

    A distance is the sum of w d**2 over the known pixels. The heaviest of them give all windows a
    lower bound, 64 windows at a time; only those whose bound is not past the best distance so far,
    which starts from where the neighbours' sources go on, are compared in full.

    Parameters
    ----------
    windows : Windows
        Of the sample, square.
    weights : int16 array (width, width)
        From 1 to 127.
    """

    def __init__(self, windows: Windows, weights: NDArray[np.int16]) -> None:
        self.windows, self.weights = windows, weights
        width, channels = len(weights), windows.pixels.shape[2]
        reach, across = width // 2, windows.pixels.shape[1]
        lead = reach * across + reach
        # Rows of whole vectors; blocks and rows may read past the last window.
        self.stride = -(-width * channels // 16) * 16
        self.flat = np.pad(windows.pixels.ravel(), (0, self.stride))
        planes = np.ascontiguousarray(windows.pixels.reshape(-1, channels).T)
        self.planes = np.pad(planes, ((0, 0), (lead, lead + _BLOCK)))
        self.allowed = np.pad(windows.usable.ravel(), (0, _BLOCK))
        self.blocks = _blocks(windows.centres)
        heaviest = np.argsort(-weights.ravel(), kind="stable")
        self.order = np.stack(np.divmod(heaviest, width), axis=1).astype(np.int32) - reach
        self.terms = max(4, min(_TERMS, -(-(width * width * channels) // 4) * 4))

    def scratch(self) -> tuple[NDArray[np.generic], ...]:
        """Return the arrays that one thread works in."""
        rows, terms, blocks = len(self.weights), self.terms, len(self.blocks)
        return (
            np.zeros(rows * self.stride, np.uint8),
            np.zeros(rows * self.stride, np.int16),
            np.empty(rows + 1, np.int32),
            np.empty(terms, np.intp),
            np.empty(terms, np.int16),
            np.empty(terms, np.uint16),
            np.empty((blocks, _BLOCK), np.uint16),
            np.empty(blocks, np.uint16),
            np.empty(self.windows.centres.size, np.int32),
            np.empty(self.windows.centres.size, np.int64),
        )

    def draw(
        self,
        levels: NDArray[np.uint8],
        done: NDArray[np.uint8],
        source: NDArray[np.int32],
        wrap: tuple[bool, bool],
        places: NDArray[np.int32],
        bits: NDArray[np.uint64],
        tolerance: float,
        scratch: tuple[NDArray[np.generic], ...],
    ) -> tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]]:
        """Draw for each place one of the windows within (1 + tolerance) of the best distance.

        Parameters
        ----------
        levels : uint8 array (H, W, K)
            The canvas.
        done : uint8 array (H, W)
            1 where it is known.
        source : int32 array (H, W)
            Where known pixels come from, flat indices into the windows' pixels; or -1.
        wrap : (bool, bool)
            Axes that go around.
        places : int32 array (n,)
            Flat indices into the canvas, of pixels that are not known.
        bits : uint64 array (n,)
            Random.
        tolerance : float
        scratch : tuple of arrays
            From `scratch`.

        Returns
        -------
        chosen : int32 array (n,)
            Flat indices into the windows' pixels.
        distances : int64 array (n,)
            Of those chosen.
        weights : int64 array (n,)
            Sum of the weights of the known pixels.
        """
        chosen = np.empty(len(places), np.int32)
        distances, weights = (np.empty(len(places), np.int64) for _ in range(2))
        kernels.search_full(
            levels, done, source, *wrap, places, bits, tolerance, self.weights, self.order,
            self.flat, self.planes, self.windows.usable, self.allowed, self.windows.period,
            self.blocks, self.stride, chosen, distances, weights, *scratch,
        )  # fmt: skip
        return chosen, distances, weights


def _blocks(centres: NDArray[np.int32]) -> NDArray[np.int32]:
    """Starts of the fewest stretches of 64 flat indices that hold all centres."""
    starts, at = [], 0
    while at < len(centres):
        starts.append(centres[at])
        at = int(np.searchsorted(centres, centres[at] + _BLOCK))
    return np.array(starts, np.int32)
