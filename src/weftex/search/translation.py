"""How well a sample fits what is there already, for every translation at once, by FFT."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Spectra:
    """The transforms of a picture and its mask that a sum of squared differences is made of.

    Parameters
    ----------
    levels : uint8 array (H, W, K)
        The picture.
    mask : bool or uint8 array (H, W)
        The pixels of it that count.
    size : (int, int)
        Of the transforms; both pictures of a comparison have the same one. Smaller pictures are
        padded with zeros.
    """

    def __init__(
        self, levels: NDArray[np.uint8], mask: NDArray[Any], size: tuple[int, ...]
    ) -> None:
        self.size = size
        shown = levels * (mask != 0)[..., None].astype(np.float64)
        self.energy = int((shown**2).sum())
        self.mask, self.square, *self.levels = (
            np.fft.rfft2(part, size)
            for part in (
                (mask != 0).astype(float),
                (shown**2).sum(axis=2),
                *shown.transpose(2, 0, 1),
            )
        )


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

    Entire where the window lies in the picture, or goes around it if it is as large as the
    transforms; the picture's mask is left out of account.

    Sums of integers, and the error of transforms is far below one half: some 1e-16 times the
    pictures' norms, 2e-3 at most for sides of 8192 pixels. So rounding gives the exact sums, the
    same ones on every machine.
    """
    product = picture.square * window.mask.conj()
    for a, b in zip(picture.levels, window.levels, strict=True):
        product -= 2 * a * b.conj()
    return _rounded(product, picture.size) + window.energy


def overlap_mismatch(
    picture: Spectra, other: Spectra
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sum of squared differences of two pictures where both count, and how many pixels that is.

    For each place in the first picture of the second one's corner, as `window_mismatch`.
    """
    product = picture.square * other.mask.conj() + picture.mask * other.square.conj()
    for a, b in zip(picture.levels, other.levels, strict=True):
        product -= 2 * a * b.conj()
    area = _rounded(picture.mask * other.mask.conj(), picture.size)
    return _rounded(product, picture.size), area


def _rounded(product: NDArray[np.complex128], size: tuple[int, ...]) -> NDArray[np.int64]:
    return np.rint(np.fft.irfft2(product, size)).astype(np.int64)
