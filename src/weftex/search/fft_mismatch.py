"""The mismatch of two pictures at every translation, by FFT (Kwatra et al., 2003, section 5)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.raster.arrays import Bytes, Ints


class Spectra:
    """Transforms of a picture (H, W, K) and its mask (H, W), for sums of squared differences.

    Or of several pictures (n, H, W, K). Both sides of a comparison have transforms of the same
    `size`; smaller ones are padded with 0.
    """

    def __init__(self, pixels: Bytes, mask: NDArray[Any], size: tuple[int, ...]) -> None:
        self.size = size
        shown = pixels * (mask != 0)[..., None].astype(np.float64)
        self.energy = int((shown**2).sum())
        parts = [mask != 0, (shown**2).sum(axis=-1), *np.moveaxis(shown, -1, 0)]
        spectra = np.fft.rfft2(np.stack(parts), size)
        self.mask, self.square, self.channels = spectra[0], spectra[1], spectra[2:]


def window_mismatch(picture: Spectra, window: Spectra) -> Ints:
    """Return sums of squared differences of a window and the picture, by the window's corner.

    Exact on every machine: errors are below 2e-3 for sides up to 8192 pixels. Valid where the
    window lies in the picture, or wraps around one as large as the transforms. The mask is ignored.
    """
    product = picture.square * window.mask.conj()
    product -= 2 * (picture.channels * window.channels.conj()).sum(axis=0)
    return _rounded(product, picture.size) + window.energy


def overlap_mismatch(picture: Spectra, other: Spectra) -> tuple[Ints, Ints]:
    """Return sums of squared differences where both masks are set, and the number of such pixels.

    Both are for each place of the other picture's corner, as in `window_mismatch`. There may be
    several other pictures.
    """
    product = picture.square * other.mask.conj() + picture.mask * other.square.conj()
    for one, another in zip(picture.channels, other.channels, strict=True):
        product -= 2 * one * another.conj()
    area = _rounded(picture.mask * other.mask.conj(), picture.size)
    return _rounded(product, picture.size), area


def correlations(pictures: NDArray[Any], other: NDArray[Any], size: tuple[int, ...]) -> Ints:
    """Return int64 (n, *size): sums of products of each picture and `other`, by its corner's place.

    `pictures` (n, H, W) wrap around at `size`.
    """
    return _rounded(np.fft.rfft2(pictures, size) * np.fft.rfft2(other, size).conj(), size)


def _rounded(product: NDArray[np.complex128], size: tuple[int, ...]) -> Ints:
    return np.rint(np.fft.irfft2(product, size)).astype(np.int64)
