"""The exact search of the windows that match what is known around a pixel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.search import exhaustive_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.search.windows import Windows

    #: Sources as flat indices into the windows' pixels, their distances, the weights of what is
    #: known.
    Drawn = tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]]

_HEAVIEST = 127  # the largest weight: times a difference it fits 16 bits
BLOCK = 64  # as in the kernels
_STEP = 24  # as in the kernels
_TERMS = 168  # bytes that lower bounds are made of, a multiple of the step


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


class WindowSearch:
    """Base of the searches that compare what is known of a window with those of a sample.

    Parameters
    ----------
    windows : Windows
        Of the sample, square.
    weights : int16 array (width, width)
        From 1 to 127. A distance is the sum of w d**2 over the known pixels.
    """

    def __init__(self, windows: Windows, weights: NDArray[np.int16]) -> None:
        self.windows, self.weights = windows, weights
        self.channels = windows.pixels.shape[2]
        # Rows of whole vectors: the last may read past its window, blocks past the last window.
        self.stride = -(-len(weights) * self.channels // 16) * 16
        self.flat = np.pad(windows.pixels.ravel(), (0, self.stride))
        self.allowed = np.pad(windows.usable.ravel(), (0, BLOCK))
        self.blocks = _blocks(windows.centres)

    def scratch(self) -> tuple[NDArray[Any], ...]:
        """Return the arrays that one thread works in."""
        width = len(self.weights)
        return (
            np.empty((width * (width // 2 + 1), 3), np.int32),
            np.zeros(width * self.stride, np.uint8),
            np.zeros(width * self.stride, np.int16),
            np.empty(width + 1, np.int32),
        )

    def _run(self, canvas: tuple[Any, ...], out: Drawn, scratch: tuple[NDArray[Any], ...]) -> None:
        """Fill `out`; `canvas` is what `draw` was given."""
        raise TypeError(f"{type(self).__name__} does not define _run")

    def draw(
        self,
        levels: NDArray[np.uint8],
        done: NDArray[np.uint8],
        source: NDArray[np.int32],
        wrap: tuple[bool, bool],
        places: NDArray[np.int32],
        bits: NDArray[np.uint64],
        tolerance: float,
        scratch: tuple[NDArray[Any], ...],
    ) -> Drawn:
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
            0 or more.
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
        n = len(places)
        out = np.empty(n, np.int32), np.empty(n, np.int64), np.empty(n, np.int64)
        self._run((levels, done, source, *wrap, places, bits, tolerance), out, scratch)
        return out


class ExhaustiveSearch(WindowSearch):
    """Compares with every window of the sample.

    The heaviest known pixels give all windows a lower bound, 64 windows at a time. Only those are
    compared in full whose bound is not past the best distance so far, which starts from where the
    neighbours' sources go on.
    """

    def __init__(self, windows: Windows, weights: NDArray[np.int16]) -> None:
        super().__init__(windows, weights)
        width, across = len(weights), windows.pixels.shape[1]
        lead = width // 2 * (across + 1)
        planes = np.ascontiguousarray(windows.pixels.reshape(-1, self.channels).T)
        self.planes = np.pad(planes, ((0, 0), (lead, lead + BLOCK)))
        heaviest = np.argsort(-weights.ravel(), kind="stable")
        self.order = np.stack(np.divmod(heaviest, width), axis=1).astype(np.int32) - width // 2
        size = width * width * self.channels
        self.terms = whole_groups(size) if size < _STEP else min(_TERMS, size // _STEP * _STEP)

    def scratch(self) -> tuple[NDArray[Any], ...]:
        """See `WindowSearch.scratch`."""
        found = max(self.windows.centres.size, 9)  # 8 neighbours and -1 for no window
        return (
            *super().scratch(),
            np.empty(self.terms, np.intp),
            np.empty(self.terms, np.int16),
            np.empty(self.terms, np.uint16),
            np.empty(self.terms, np.uint16),
            np.empty((len(self.blocks), BLOCK), np.uint16),
            np.empty(len(self.blocks), np.uint16),
            np.empty(found, np.int32),
            np.empty(found, np.int64),
        )

    def _run(self, canvas: tuple[Any, ...], out: Drawn, scratch: tuple[NDArray[Any], ...]) -> None:
        arguments = [
            *canvas, self.weights, self.order, self.flat, self.planes, self.windows.usable,
            self.allowed, self.windows.period, self.blocks, self.stride, *out, *scratch,
        ]  # fmt: skip
        kernels.search_full(*arguments)


def whole_groups(terms: int) -> int:
    """Round up to what the kernels take at a time."""
    return -(-terms // 4) * 4


def _blocks(centres: NDArray[np.int32]) -> NDArray[np.int32]:
    """Starts of the fewest stretches of 64 flat indices that hold all centres."""
    starts, at = [], 0
    while at < len(centres):
        starts.append(centres[at])
        at = int(np.searchsorted(centres, centres[at] + BLOCK))
    return np.array(starts, np.int32)
