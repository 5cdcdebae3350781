"""The exact search of the windows that match the known pixels around a pixel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.methods.efros_leung import weighted_kernels as kernels
from weftex.search.picture_kernels import Picture
from weftex.search.windows import Windows, new_query

#: For each pixel the window picked, a flat index into the windows' pixels; its distance; and the
#: sum of the weights of the known pixels: int64 (n,).
Matches = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]
#: Picks windows for unknown pixels: flat indices into the canvas and random bits, int32 and
#: uint64 (n,). For one thread at a time.
Matcher = Callable[[NDArray[np.int32], NDArray[np.uint64]], Matches]

_LARGEST_WEIGHT = 127  # times a difference it fits 16 bits
_VECTOR = 16  # bytes; rows of windows are whole vectors
_BLOCK: int = kernels.block_windows
_STEP: int = kernels.step_terms
_MOST_TERMS = 168  # bytes that lower bounds are made of, a multiple of the step


def gaussian_weights(width: int, sigma: float) -> NDArray[np.int16]:
    """Return (width, width) integers from 1 to 127: a Gaussian around the middle of a window.

    `width` and `sigma`, the standard deviation, are in pixels.
    """
    away = np.arange(width) - width // 2
    bell = np.exp(-(away[:, None] ** 2 + away**2) / (2 * sigma * sigma))
    weights: NDArray[np.int16] = np.maximum(np.rint(_LARGEST_WEIGHT * bell), 1).astype(np.int16)
    return weights


class ExactSearch:
    """Compares the known pixels around a pixel with every window of a sample, exactly.

    Lower bounds from the heaviest pixels rule out most windows. `weights` are int16 (width, width),
    from 1 to 127; a distance is the sum of w d**2 over the known pixels.
    """

    def __init__(self, windows: Windows, weights: NDArray[np.int16]) -> None:
        self.windows, self.weights = windows, weights
        width, channels = len(weights), windows.pixels.shape[2]
        self.stride = -(-width * channels // _VECTOR) * _VECTOR
        self.flat = np.pad(windows.pixels.ravel(), (0, self.stride))  # rows are read past their end
        self.starts = _block_starts(windows.centers)
        self.allowed = np.pad(windows.usable.ravel(), (0, _BLOCK))
        lead = width // 2 * (windows.pixels.shape[1] + 1)
        planes = np.ascontiguousarray(windows.pixels.reshape(-1, channels).T)
        self.planes = np.pad(planes, ((0, 0), (lead, lead + _BLOCK)))
        heaviest = np.argsort(-weights.ravel(), kind="stable")
        self.order = np.stack(np.divmod(heaviest, width), axis=1).astype(np.int32) - width // 2
        size = width * width * channels
        self.terms = -(-size // 4) * 4 if size < _STEP else min(_MOST_TERMS, size // _STEP * _STEP)

    def on(self, picture: Picture, tolerance: float) -> Matcher:
        """Return a function that picks windows for pixels of a canvas; each thread needs its own.

        It picks evenly among the windows within (1 + tolerance) of the best distance. The canvas
        and its known pixels may change between calls.
        """
        sample = self.windows.kernel
        windows = kernels.WeightedWindows(
            self.flat, self.weights, self.stride, self.windows.pixels.shape,
            self.planes, self.starts, self.allowed, self.order,
        )  # fmt: skip
        template = self._template()

        def find_matches(pixels: NDArray[np.int32], bits: NDArray[np.uint64]) -> Matches:
            out = np.empty((3, len(pixels)), np.int64)
            kernels.find_matches(sample, windows, picture, template, pixels, bits, tolerance, out)
            chosen, distances, weights = out
            return chosen, distances, weights

        return find_matches

    def _template(self) -> Any:
        """Return the scratch of one thread."""
        width, blocks = len(self.weights), len(self.starts)
        most = self.windows.centers.size + 9  # where 8 neighbors' sources continue, and -1
        types = np.intp, np.int16, np.uint16, np.uint16
        return kernels.Template(
            new_query(width // 2, 1),
            np.zeros(width * self.stride, np.uint8),
            np.zeros(width * self.stride, np.int16),
            np.empty(width + 1, np.int32),
            [np.empty(self.terms, kind) for kind in types],
            np.empty((blocks, _BLOCK), np.uint16),
            np.empty(blocks, np.uint16),
            np.empty(most, np.int32),
            np.empty(most, np.int64),
        )


def _block_starts(centers: NDArray[np.int32]) -> NDArray[np.int32]:
    """Starts of the fewest blocks of flat indices that hold all centers."""
    starts, at = [], 0
    while at < len(centers):
        starts.append(centers[at])
        at = int(np.searchsorted(centers, centers[at] + _BLOCK))
    return np.array(starts, np.int32)
