"""The exact search of the windows that match what is known around a pixel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.search import exhaustive_kernels as kernels
from weftex.search.weighted_kernels import Picture
from weftex.search.weighted_windows import drawing, found_windows, weighted_windows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.search.weighted_windows import Draw
    from weftex.search.windows import Windows

#: Windows that the kernels take lower bounds of at a time.
BLOCK: int = kernels.block_windows
_STEP: int = kernels.step_terms
_MOST_TERMS = 168  # bytes that lower bounds are made of, a multiple of the step


class ExhaustiveSearch:
    """Compares with every window of the sample; see `WindowSearch`.

    The heaviest known pixels give all windows a lower bound, 64 windows at a time. Only those are
    compared in full whose bound is not past the best distance so far, which starts from the
    windows where the neighbors' sources go on.

    Parameters
    ----------
    windows : Windows
        Of the sample, square.
    weights : int16 array (width, width)
        From 1 to 127. A distance is the sum of w d**2 over the known pixels.
    """

    def __init__(self, windows: Windows, weights: NDArray[np.int16]) -> None:
        self.sample = weighted_windows(windows, weights)
        width, channels = self.sample.width, self.sample.channels
        self.starts = _block_starts(windows.centers)
        self.allowed = np.pad(windows.usable.ravel(), (0, BLOCK))
        lead = width // 2 * (windows.pixels.shape[1] + 1)
        planes = np.ascontiguousarray(windows.pixels.reshape(-1, channels).T)
        self.planes = np.pad(planes, ((0, 0), (lead, lead + BLOCK)))
        heaviest = np.argsort(-weights.ravel(), kind="stable")
        self.order = np.stack(np.divmod(heaviest, width), axis=1).astype(np.int32) - width // 2
        size = width * width * channels
        self.terms = whole_groups(size) if size < _STEP else min(_MOST_TERMS, size // _STEP * _STEP)

    def on(
        self,
        pixels: NDArray[np.uint8],
        done: NDArray[np.uint8],
        source: NDArray[np.int32],
        wrap: tuple[bool, bool],
        tolerance: float,
    ) -> Draw:
        """See `WindowSearch.on`."""
        sample, query = self.sample.bundle(), self.sample.query()
        picture = Picture(pixels, done, source, wrap)
        found = found_windows(self.sample.windows.centers.size)
        lower = np.empty((len(self.starts), BLOCK), np.uint16)
        least = np.empty(len(self.starts), np.uint16)
        blocks = kernels.Blocks(self.planes, self.starts, self.allowed, self.order, lower, least)
        types = np.intp, np.int16, np.uint16, np.uint16
        terms = kernels.Terms(*(np.empty(self.terms, kind) for kind in types))
        return drawing(
            lambda choices: kernels.search_full(
                sample, blocks, picture, choices, query, terms, found
            ),
            tolerance,
        )


def whole_groups(terms: int) -> int:
    """Round up to the number of terms that the kernels take at a time."""
    return -(-terms // 4) * 4


def _block_starts(centers: NDArray[np.int32]) -> NDArray[np.int32]:
    """Starts of the fewest stretches of 64 flat indices that hold all centers."""
    starts, at = [], 0
    while at < len(centers):
        starts.append(centers[at])
        at = int(np.searchsorted(centers, centers[at] + BLOCK))
    return np.array(starts, np.int32)
