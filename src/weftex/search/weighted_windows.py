"""The windows of a sample with Gaussian weights, as searches compare half-known ones with them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from weftex.search import weighted_kernels as kernels

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from weftex.search.windows import Windows

    #: For each pixel the window drawn, a flat index into the windows' pixels; its distance; and the
    #: sum of the weights of the known pixels: int32, int64 and int64 (n,).
    Drawn = tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]]
    #: Draws windows for unknown pixels: flat indices into the canvas and random bits, int32 and
    #: uint64 (n,). For one thread at a time.
    Draw = Callable[[NDArray[np.int32], NDArray[np.uint64]], Drawn]

_LARGEST_WEIGHT = 127  # times a difference it fits 16 bits
_VECTOR = 16  # bytes; rows of windows are whole vectors


class WindowSearch(Protocol):
    """Draws windows that match what is known around a pixel."""

    sample: WeightedWindows

    def on(
        self,
        pixels: NDArray[np.uint8],
        done: NDArray[np.uint8],
        source: NDArray[np.int32],
        wrap: tuple[bool, bool],
        tolerance: float,
    ) -> Draw:
        """Return a function that draws windows for pixels of a canvas; one for each thread.

        It draws one of the windows within (1 + tolerance) of the best distance, each as likely.

        Parameters
        ----------
        pixels : uint8 array (H, W, K)
            The canvas. It, `done` and `source` may change between calls.
        done : uint8 array (H, W)
            1 where it is known.
        source : int32 array (H, W)
            Where known pixels come from, flat indices into the windows' pixels; or -1.
        wrap : (bool, bool)
            Axes that go around.
        tolerance : float
            0 or more.
        """


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
    weights: NDArray[np.int16] = np.maximum(np.rint(_LARGEST_WEIGHT * bell), 1).astype(np.int16)
    return weights


@dataclass(frozen=True, eq=False)
class WeightedWindows:
    """The windows of a sample as kernels read them; from `weighted_windows`.

    Attributes
    ----------
    windows : Windows
        Square ones.
    weights : int16 array (width, width)
        From 1 to 127. A distance is the sum of w d**2 over the known pixels.
    stride : int
        Bytes of a row of a query: a row of a window, filled up to whole vectors.
    flat : uint8 array
        The windows' pixels row by row, and a stride more, as the last row may be read past its end.
    """

    windows: Windows
    weights: NDArray[np.int16]
    stride: int
    flat: NDArray[np.uint8]

    @property
    def width(self) -> int:
        """Side of a window in pixels."""
        return len(self.weights)

    @property
    def channels(self) -> int:
        """Bytes of a pixel."""
        return int(self.windows.pixels.shape[2])

    def bundle(self) -> Any:
        """Return the kernels' view of the sample."""
        return kernels.Sample(self.flat, self.windows, self.weights, self.stride)

    def query(self) -> Any:
        """Return scratch for what is known around a pixel."""
        return kernels.Query(
            np.empty((self.width * (self.width // 2 + 1), 3), np.int32),
            np.zeros(self.width * self.stride, np.uint8),
            np.zeros(self.width * self.stride, np.int16),
            np.empty(self.width + 1, np.int32),
        )


def weighted_windows(windows: Windows, weights: NDArray[np.int16]) -> WeightedWindows:
    """Lay out a sample's windows, which are as wide as the weights."""
    stride = -(-len(weights) * windows.pixels.shape[2] // _VECTOR) * _VECTOR
    return WeightedWindows(windows, weights, stride, np.pad(windows.pixels.ravel(), (0, stride)))


def found_windows(count: int) -> Any:
    """Return scratch for so many windows and the coherent ones."""
    count += 9  # 8 neighbors and -1 for no window
    return kernels.Found(np.empty(count, np.int32), np.empty(count, np.int64))


def drawing(search: Callable[[Any], None], tolerance: float) -> Draw:
    """Make a `Draw` of a kernel that fills `Choices`."""

    def draw(places: NDArray[np.int32], bits: NDArray[np.uint64]) -> Drawn:
        n = len(places)
        out = np.empty(n, np.int32), np.empty(n, np.int64), np.empty(n, np.int64)
        search(kernels.Choices(places, bits, tolerance, *out))
        return out

    return draw
