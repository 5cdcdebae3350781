"""Generalised normalized cross-correlation (GNCC) of two pictures.

Sections 3.1 and 3.2 of the paper on near-regular textures: the normalized correlation of what
overlaps, for every shift at which anything overlaps. The correlation itself is a product of
spectra, the sums that normalize it come from running sums (with masks, from spectra too).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis import overlap_kernels as kernels
from weftex.errors import InvalidInputError
from weftex.raster.boxes import touching_sums

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: An overlap that varies less than this beside the whole picture passes for constant: its own
#: correlation is lost in the rounding of the transform.
_FLAT = 1e-11


def correlate(
    first: NDArray[Any],
    second: NDArray[Any] | None = None,
    *,
    first_mask: NDArray[np.bool_] | None = None,
    second_mask: NDArray[np.bool_] | None = None,
    reach: tuple[int, int] | None = None,
) -> Floats:
    """Correlate two pictures of any sizes at every shift, normalized over what overlaps.

    Eqs. 3.2 and 3.10 of the paper: each channel's correlation coefficient counts as much as it
    varies in both overlaps, so a constant channel does not count at all.
    """
    f, f_mask = _checked(first, first_mask, "first")
    if second is None:
        if second_mask is not None:
            raise InvalidInputError("second_mask has no effect without a second picture")
        g, g_mask = f, f_mask
    else:
        g, g_mask = _checked(second, second_mask, "second")
    if f.shape[0] != g.shape[0]:
        raise InvalidInputError(f"first has {f.shape[0]} channels and second {g.shape[0]}")
    alike = g is f
    if alike and f_mask is None:
        f = np.ascontiguousarray(f)
        return _with_itself(f, power_of(f, _wrapped(f.shape[1:], reach)), reach)
    sums = _Sums(f.shape[1:], g.shape[1:], f_mask, g_mask, reach)
    above, below = np.zeros(sums.shape), np.zeros(sums.shape)
    spectrum = np.zeros((), np.complex128)
    for k in range(len(f)):
        at_f = np.fft.rfft2(f[k], sums.padded)
        at_g = at_f if alike else np.fft.rfft2(g[k], sums.padded)
        spectrum = spectrum + at_f * at_g.conj()
        s_f = sums.over_first(f[k])
        spread_f = _spread(sums.count, s_f, sums.over_first(f[k] ** 2))
        if alike:  # the other part is what the opposite shift leaves
            s_g, spread_g = s_f[::-1, ::-1], spread_f[::-1, ::-1]
        else:
            s_g = sums.over_second(g[k])
            spread_g = _spread(sums.count, s_g, sums.over_second(g[k] ** 2))
        above -= s_f * s_g
        below += np.sqrt(spread_f * spread_g)
    above += sums.count * sums.cut(np.fft.irfft2(spectrum, sums.padded))
    result = np.divide(above, below, out=np.zeros(sums.shape), where=below > 0)
    return np.clip(result, -1, 1, out=result)


def correlation_and_power(levels: Floats) -> tuple[Floats, Floats]:
    """Correlate a picture without a mask with itself at every shift."""
    around = levels - levels.mean(axis=(1, 2), keepdims=True)
    power = power_of(around, _wrapped(levels.shape[1:], None))
    return _with_itself(around, power, None), power


def power_of(levels: Floats, size: tuple[int, int]) -> Floats:
    """The power spectrum of a picture of these channels, as `numpy.fft.rfft2` orders it."""
    power = np.zeros((size[0], size[1] // 2 + 1))
    for level in levels:
        waves = np.fft.rfft2(level, size)
        power += waves.real**2 + waves.imag**2
    return power


def _wrapped(shape: tuple[int, ...], reach: tuple[int, int] | None) -> tuple[int, int]:
    """Sides at which nothing wraps around into a shift within reach."""
    far = (side if reach is None else min(side, reach[k] + 1) for k, side in enumerate(shape))
    down, along = (wrapped_length(side + most - 1) for side, most in zip(shape, far, strict=True))
    return down, along


def _with_itself(levels: Floats, power: Floats, reach: tuple[int, int] | None) -> Floats:
    """The correlation of levels around 0, from their power spectrum."""
    _, height, width = levels.shape
    (rows, high), (columns, wide) = (
        _overlaps(side, side - 1 if reach is None else min(side - 1, reach[k]))
        for k, side in enumerate((height, width))
    )
    shape = len(high), len(wide)
    above, below = np.zeros(shape), np.zeros(shape)
    sums, squares = np.empty(shape), np.empty(shape)
    down, along = np.empty((2, height + 1, width)), np.empty((2, width + 1))
    for level in levels:
        most = kernels.overlap_sums(level, rows, columns, down, along, sums, squares)
        kernels.add_channel(sums, squares, high, wide, _FLAT * most, above, below)
    size = power.shape[0], _wrapped((height, width), reach)[1]
    # Eq. 3.13: the sum of the numerators over the sum of the denominators.
    kernels.divide(above, below, high, wide, np.fft.irfft2(power, size))
    return above


def _overlaps(side: int, most: int) -> tuple[NDArray[np.int64], Floats]:
    """First and last of what overlaps at shifts of at most so much, and how much that is."""
    shifts = np.arange(-most, most + 1)
    ends = np.stack([np.maximum(shifts, 0), side + np.minimum(shifts, 0)], axis=1)
    return ends, (side - abs(shifts)).astype(np.float64)


def _checked(
    picture: NDArray[Any], mask: NDArray[np.bool_] | None, name: str
) -> tuple[Floats, NDArray[np.bool_] | None]:
    """Channels first, around their mean, which changes no coefficient and keeps sums small."""
    given = np.asarray(picture)
    if given.ndim not in (2, 3) or 0 in given.shape or given.dtype.kind not in "biuf":
        raise InvalidInputError(
            f"{name} is an array {given.shape} of {given.dtype}; it must be (H, W) or (H, W, K) "
            "of real numbers, and not empty"
        )
    levels = np.moveaxis(given.reshape(*given.shape[:2], -1).astype(np.float64), 2, 0)
    if not np.isfinite(levels).all():
        raise InvalidInputError(f"{name} contains NaN or infinity")
    if mask is None:
        return levels - levels.mean(axis=(1, 2), keepdims=True), None
    mask = np.asarray(mask, bool)
    if mask.shape != given.shape[:2]:
        raise InvalidInputError(f"the mask of {name} is {mask.shape}, not {given.shape[:2]}")
    mean = (levels * mask).sum(axis=(1, 2), keepdims=True) / max(1, int(mask.sum()))
    return (levels - mean) * mask, None if mask.all() else mask


def _spread(count: Floats, sums: Floats, squares: Floats) -> Floats:
    """N S_ff - S_f^2: N^2 times the variance of the overlap, 0 where it is only rounding."""
    least = _FLAT * float(squares.max()) * count
    spread = count * squares - sums * sums
    spread *= spread > least
    return spread


class _Sums:
    """Sums over the overlap of two pictures at every shift, or at those within reach."""

    def __init__(
        self,
        first: tuple[int, ...],
        second: tuple[int, ...],
        first_mask: NDArray[np.bool_] | None,
        second_mask: NDArray[np.bool_] | None,
        reach: tuple[int, int] | None = None,
    ) -> None:
        self.first, self.second, self.reach = first, second, reach or (max(first + second),) * 2
        sides = list(zip(first, second, self.reach, strict=True))
        shifts = [np.arange(max(1 - g, -r), min(f - 1, r) + 1) for f, g, r in sides]
        self.shape = len(shifts[0]), len(shifts[1])
        self.least = -int(shifts[0][0]), -int(shifts[1][0])
        self.padded = tuple(  # nothing wraps around into a shift that is asked for
            wrapped_length(max(f - shift[0], g + shift[-1]))
            for (f, g, _), shift in zip(sides, shifts, strict=True)
        )
        self.masked = first_mask is not None or second_mask is not None
        if self.masked:
            masks = (
                np.ones(size) if mask is None else mask.astype(np.float64)
                for size, mask in ((first, first_mask), (second, second_mask))
            )
            self.f_mask, self.g_mask = (np.fft.rfft2(mask, self.padded) for mask in masks)
            count = self.cut(np.fft.irfft2(self.f_mask * self.g_mask.conj(), self.padded))
            self.count = np.rint(count)
        else:  # eq. 3.9, with the first picture's side inside the minimum
            overlap = (
                np.minimum(min(f, g), np.minimum(shift + g, f - shift))
                for (f, g, _), shift in zip(sides, shifts, strict=True)
            )
            self.count = np.outer(*overlap).astype(np.float64)

    def cut(self, wrapped: Floats) -> Floats:
        """Shifts in rising order, from the wrapped ones of a transform."""
        top, left = self.least
        height, width = self.shape[0] - top, self.shape[1] - left
        result = np.empty(self.shape)
        result[top:, left:] = wrapped[:height, :width]
        if top:
            result[:top, left:] = wrapped[-top:, :width]
        if left:
            result[top:, :left] = wrapped[:height, -left:]
        if top and left:
            result[:top, :left] = wrapped[-top:, -left:]
        return result

    def over_first(self, values: Floats) -> Floats:
        """S_f of eq. 3.6: of the first picture, over what the second covers."""
        if self.masked:
            spectrum = np.fft.rfft2(values, self.padded) * self.g_mask.conj()
            return self.cut(np.fft.irfft2(spectrum, self.padded))
        return touching_sums(values, self.second, self.reach)

    def over_second(self, values: Floats) -> Floats:
        """S_g of eq. 3.8: of the second picture, over what the first covers."""
        if self.masked:
            spectrum = self.f_mask * np.fft.rfft2(values, self.padded).conj()
            return self.cut(np.fft.irfft2(spectrum, self.padded))
        # The second picture turned by 180 degrees (eq. 3.7), as the first one is seen from it.
        return touching_sums(values, self.first, self.reach)[::-1, ::-1]


def wrapped_length(at_least: int) -> int:
    """The next length with no prime factor above 5."""
    length = at_least
    while True:
        rest = length
        for prime in (2, 3, 5):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return length
        length += 1
