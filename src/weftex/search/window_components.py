"""Principal components of square windows that are too many and too large to be laid out.

A coordinate of all windows at once is the correlation of the picture with a component, so it comes
from Fourier transforms. Components are rounded to integers; then the coordinates are integers
below 2**31, which rounding takes out of the transforms exactly, on every machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.search import projection_kernels
from weftex.search.pca import MOST_COMPONENTS, coordinates_of, main_components, one_blas_thread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.search.windows import Windows

_LEARNED_WINDOWS = 512  # windows that the components are learned from
_COMPONENT_LENGTH = 2000


@dataclass(frozen=True, eq=False)
class WindowComponents:
    """Coordinates of all windows of a sample, without their middle pixel.

    Attributes
    ----------
    mean : uint8 array (K,)
        The color that stands for the unknown pixels of a window.
    basis : int16 array (width, D, width * K)
        Components, row by row of the window; 0 at its middle pixel.
    mean_product : int64 array (D,)
        Product of each component with a window of the mean color.
    offset : int32 array (D,)
        Subtracted from a product.
    shift : int
        Right shift, with rounding, that brings coordinates to their range.
    features : int16 array (D, n)
        Of the windows around `Windows.centers`.
    variance : float
        Share of the variance of the windows learned from that the components keep.
    """

    mean: NDArray[np.uint8]
    basis: NDArray[np.int16]
    mean_product: NDArray[np.int64]
    offset: NDArray[np.int32]
    shift: int
    features: NDArray[np.int16]
    variance: float

    def for_kernels(self) -> projection_kernels.Components:
        """Bundle these with the room that a kernel needs; one bundle a thread."""
        _, count, length = self.basis.shape
        room = np.zeros(length, np.int16), np.zeros(count, np.int64), np.zeros(count, np.int16)
        return projection_kernels.Components(self, *room)


def window_components(windows: Windows, reach: int, variance: float) -> WindowComponents:
    """Find the components of a sample's windows, and all windows' coordinates.

    Parameters
    ----------
    windows : Windows
        Windows that reach `reach` pixels to each side.
    reach : int
        From the middle pixel to the side, in pixels.
    variance : float
        Share of the variance to keep, with at most 48 components.
    """
    width, channels = 2 * reach + 1, windows.pixels.shape[2]
    centers = windows.centers
    chosen = centers[
        np.linspace(0, len(centers) - 1, min(len(centers), _LEARNED_WINDOWS)).astype(np.int64)
    ]
    y, x = np.divmod(chosen, windows.pixels.shape[1])
    around = np.arange(-reach, reach + 1)
    rows, columns = y[:, None, None] + around[:, None], x[:, None, None] + around
    learn = windows.pixels[rows, columns].astype(np.float64)
    learn[:, reach, reach] = 0
    learn = learn.reshape(len(chosen), -1)
    vectors, kept = _components(learn, variance)
    basis = (
        np.rint(vectors * _COMPONENT_LENGTH).astype(np.int16).reshape(-1, width, width, channels)
    )
    corners = centers - reach * windows.pixels.shape[1] - reach
    raw = _correlations(windows.pixels, basis, corners)
    mean = windows.pixels.reshape(-1, channels)[centers].mean(axis=0, dtype=np.float64)
    mean_bytes = np.rint(mean).astype(np.uint8)
    return WindowComponents(
        mean_bytes,
        np.ascontiguousarray(basis.transpose(1, 0, 2, 3)).reshape(width, len(basis), -1),
        basis.sum(axis=(1, 2), dtype=np.int64) @ mean_bytes.astype(np.int64),
        *coordinates_of(raw),
        kept,
    )


def _components(learn: NDArray[np.float64], variance: float) -> tuple[NDArray[np.float64], float]:
    """Rows of length 1, and the share of the variance that they keep.

    There are fewer windows than numbers in one, so the eigenvectors are those of their products.
    """
    count = len(learn)
    with one_blas_thread():
        # Integers in float64: products and sums are exact, so every machine gets this matrix.
        total = learn.sum(axis=0)
        gram, along = learn @ learn.T, learn @ total
        gram = count**2 * gram - count * (along[:, None] + along) + total @ total
        power, vectors = np.linalg.eigh(gram)
        kept = learn.T @ vectors - np.outer(total / count, vectors.sum(axis=0))
    lengths = np.sqrt((kept**2).sum(axis=0))
    kept = kept / np.maximum(lengths, 1e-3)  # what a constant sample varies by is rounding
    kept[:, lengths < 1e-3] = 0
    components = main_components(power, kept, variance, MOST_COMPONENTS)
    share = power[::-1][: len(components)].clip(0).sum() / max(float(power.clip(0).sum()), 1e-9)
    return components, round(float(share), 2)


def _correlations(
    pixels: NDArray[np.uint8], basis: NDArray[np.int16], corners: NDArray[np.int32]
) -> NDArray[np.int32]:
    """Product of each component with the windows whose upper left corners these are."""
    size = pixels.shape[:2]
    picture = np.fft.rfft2(pixels.transpose(2, 0, 1))
    raw = np.empty((len(basis), len(corners)), np.int32)
    for d, component in enumerate(basis):
        filters = np.fft.rfft2(component.transpose(2, 0, 1).astype(np.float64), size)
        products = np.fft.irfft2((picture * filters.conj()).sum(axis=0), size)
        raw[d] = np.rint(products.ravel()[corners])
    return raw
