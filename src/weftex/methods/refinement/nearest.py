"""The nearest of all windows of a sample, found exactly; principal components leave most out.

The search of the paper on iterative refinement (section 3, Search Tree Construction), which
compares windows by their components alone. Here the distance in these, which is never more than
the distance itself, says which windows are too far to be compared; so nothing is lost by leaving
variance out. Whole windows have components, and so have their L-shaped upper halves, which are
known in the first iteration. Where less is known, that is compared with all windows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.methods.refinement import nearest_kernels
from weftex.raster.arrays import Bytes, Floats
from weftex.search.approximate_nearest import Components, coordinates_of, main_components
from weftex.search.windows import Windows
from weftex.threads import one_blas_thread

_LEARNED_WINDOWS = 512  # windows that the components are learned from
_COMPONENT_LENGTH = 2000


@dataclass(frozen=True, eq=False)
class LowerBound:
    """A lower bound of the distances between windows, from a part of each."""

    components: Components  # of the part's bytes, with all windows' coordinates
    length: float  # windows of squared distance d are at most length * sqrt(d) apart in coordinates


@dataclass(frozen=True, eq=False)
class NearestSearch:
    """The windows of a sample with bounds of their distances; `reach` is in pixels."""

    windows: Windows
    reach: int
    whole: LowerBound  # by all of a window but its center
    above: LowerBound  # by the pixels before the center in scan order

    def bundles(self) -> tuple[Any, Any]:
        """Return the kernels' views by the whole windows and by their parts above, with scratch."""
        apart = np.zeros(len(self.windows.centers), np.int32)
        whole, above = (
            nearest_kernels.NearestWindows(
                self.windows,
                self.reach,
                bound,
                np.zeros(bound.components.basis.shape[1], np.int32),
                np.zeros(len(bound.components.basis), np.int16),
                apart,
            )
            for bound in (self.whole, self.above)
        )
        return whole, above


def nearest_search(windows: Windows, reach: int) -> NearestSearch:
    """BuildSearchTree: prepare a search among windows with `reach` pixels to each side."""
    width, channels = 2 * reach + 1, windows.pixels.shape[2]
    number = np.arange(width * width).reshape(width, width, 1).repeat(channels, axis=2)
    middle = width * width // 2
    bounds = (_lower_bound(windows, reach, part) for part in (number != middle, number < middle))
    return NearestSearch(windows, reach, *bounds)


def _lower_bound(windows: Windows, reach: int, part: NDArray[np.bool_]) -> LowerBound:
    """Return the components of a part (width, width, K) with all windows' coordinates in them.

    Coordinates are the picture's correlations with the components, by Fourier transforms: windows
    are too many and too large to be stored.
    """
    with one_blas_thread():
        vectors = _main_vectors(windows, reach, part)
        filters = np.rint(_COMPONENT_LENGTH * vectors).reshape(-1, *part.shape)
        basis = np.ascontiguousarray(filters[:, part], np.int16)
        # Rounded components are not quite at right angles.
        longest = float(np.linalg.eigvalsh(np.inner(basis, basis.astype(np.float64)))[-1])
    corners = windows.centers - reach * windows.pixels.shape[1] - reach
    offset, shift, coordinates = coordinates_of(_correlations(windows.pixels, filters, corners))
    length = 1.001 * max(longest, 0.0) ** 0.5 / 2**shift
    return LowerBound(Components(basis, offset, shift, coordinates), length)


def _main_vectors(windows: Windows, reach: int, part: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return components learned from some windows, as unit rows that are 0 outside the part.

    There are fewer windows than bytes in one, so eigenvectors are taken of the windows' products.
    """
    centers = windows.centers
    some = np.linspace(0, len(centers) - 1, min(len(centers), _LEARNED_WINDOWS)).astype(np.intp)
    y, x = np.divmod(centers[some], windows.pixels.shape[1])
    around = np.arange(-reach, reach + 1)
    rows, columns = y[:, None, None] + around[:, None], x[:, None, None] + around
    learned = (windows.pixels[rows, columns] * part).reshape(len(some), -1).astype(np.float64)
    learned -= learned.mean(axis=0)
    power, vectors = np.linalg.eigh(learned @ learned.T)
    found = learned.T @ vectors
    lengths = np.sqrt((found * found).sum(axis=0))
    found /= np.maximum(lengths, 1e-3)
    found[:, lengths < 1e-3] = 0  # a constant sample varies by rounding only
    return main_components(power, found, 1.0)


def _correlations(pixels: Bytes, filters: Floats, corners: NDArray[np.int32]) -> NDArray[np.int32]:
    """Product of each filter with the windows whose upper left corners these are."""
    size = pixels.shape[:2]
    picture = np.fft.rfft2(pixels.transpose(2, 0, 1))
    raw = np.empty((len(filters), len(corners)), np.int32)
    for d, component in enumerate(filters):
        transform = np.fft.rfft2(component.transpose(2, 0, 1), size)
        products = np.fft.irfft2((picture * transform.conj()).sum(axis=0), size)
        raw[d] = np.rint(products.ravel()[corners])
    return raw
