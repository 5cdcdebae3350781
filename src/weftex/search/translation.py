"""The mismatch of two pictures at every translation at once, by FFT."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Spectra:
    """The transforms of a picture and its mask that make a sum of squared differences.

    Parameters
    ----------
    pixels : uint8 array (H, W, K)
        The picture.
    mask : bool or uint8 array (H, W)
        The pixels that count.
    size : (int, int)
        Of the transforms; both pictures of a comparison have the same one. Smaller pictures are
        padded with zeros.
    """

    def __init__(
        self, pixels: NDArray[np.uint8], mask: NDArray[Any], size: tuple[int, ...]
    ) -> None:
        self.size = size
        shown = pixels * (mask != 0)[..., None].astype(np.float64)
        self.energy = int((shown**2).sum())
        parts = [(mask != 0)[None], (shown**2).sum(axis=2)[None], shown.transpose(2, 0, 1)]
        spectra = np.fft.rfft2(np.concatenate(parts), size)
        self.mask, self.square, self.channels = spectra[0], spectra[1], spectra[2:]


def fast_size(length: int) -> int:
    """The least length from this one on whose transform is fast: no factors but 2, 3 and 5.

    Examples
    --------
    >>> [fast_size(n) for n in (1, 7, 251)]
    [1, 8, 256]
    """
    while True:
        rest = length
        for factor in (2, 3, 5):
            while rest % factor == 0:
                rest //= factor
        if rest == 1:
            return length
        length += 1


def window_mismatch(picture: Spectra, window: Spectra) -> NDArray[np.int64]:
    """Sum of squared differences of a window and the picture at each place of its corner.

    Exact, and the same on every machine: these are sums of integers, and the error of transforms is
    some 1e-16 times the pictures' norms, for sides of 8192 pixels at most 2e-3, far below one half.

    Parameters
    ----------
    picture, window : Spectra
        Of the same size. All pixels of the picture count, its mask is ignored.

    Returns
    -------
    int64 array (height, width) of the transforms
        Valid where the window lies in the picture; everywhere if the picture is as large as the
        transforms, it then goes around.

    Examples
    --------
    >>> picture = np.arange(4, dtype=np.uint8).reshape(1, 4, 1)
    >>> window = picture[:, 1:3]
    >>> whole, part = (Spectra(p, np.ones(p.shape[:2]), (1, 4)) for p in (picture, window))
    >>> window_mismatch(whole, part)[0, :3].tolist()
    [2, 0, 2]
    """
    product = picture.square * window.mask.conj()
    product -= 2 * (picture.channels * window.channels.conj()).sum(axis=0)
    return _rounded(product, picture.size) + window.energy


def overlap_mismatch(
    picture: Spectra, other: Spectra
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sum of squared differences where pixels of both pictures count, and the number of these.

    Both for each place of the other picture's corner, arrays as of `window_mismatch`.
    """
    product = picture.square * other.mask.conj() + picture.mask * other.square.conj()
    product -= 2 * (picture.channels * other.channels.conj()).sum(axis=0)
    area = _rounded(picture.mask * other.mask.conj(), picture.size)
    return _rounded(product, picture.size), area


def correlations(
    pictures: NDArray[Any], other: NDArray[Any], size: tuple[int, ...]
) -> NDArray[np.int64]:
    """Sum of products of whole numbers, of each picture and the other at each place of its corner.

    Parameters
    ----------
    pictures : array (n, H, W)
    other : array (h, w)
    size : (int, int)
        Of the transforms; what leaves a picture comes in at its other side.

    Returns
    -------
    int64 array (n, *size)

    Examples
    --------
    >>> correlations(np.array([[[3, 1, 2]]]), np.array([[1, 10]]), (1, 3))[0, 0, :2].tolist()
    [13, 21]
    """
    return _rounded(np.fft.rfft2(pictures, size) * np.fft.rfft2(other, size).conj(), size)


def _rounded(product: NDArray[np.complex128], size: tuple[int, ...]) -> NDArray[np.int64]:
    return np.rint(np.fft.irfft2(product, size)).astype(np.int64)
