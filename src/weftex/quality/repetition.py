"""Visible repetition: parts of a picture that come back at one shift, found without sources."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.correlation import wrapped_length
from weftex.quality.spectrum import mean_power
from weftex.quality.view import View
from weftex.raster.boxes import centered_sums

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.lattice import Lattice

    Floats = NDArray[np.float64]

_WIDTH = 32  # pixels of the windows whose mean power both pictures are divided by
_NARROWEST = 24  # sides of less are not looked at
_LARGEST_PICTURE = 1024
_NEAR = 6  # pixels; at shorter shifts smooth pictures are like themselves
_ERRORS = 6  # standard errors of a correlation that pass for chance
_SHOWN = 6  # shifts that are told
_FEWEST = 64  # pixels must overlap
_HALF = 0.25  # of the sample must overlap for its own repetition to be subtracted
_CELL = 8  # half the side of a square of the map
_RIM = 8  # pixels that whitening spoils, because transforms go around
_CONFIDENCE = 0.5  # a lattice of less does not excuse repetition
_AT = 3  # pixels; a shift this near to a multiple of the lattice counts as one


@dataclass(frozen=True, eq=False)
class Repetition:
    """What `repetition` finds.

    Attributes
    ----------
    period : float
        Largest share of the result that comes back at one shift.
    repeats : float
        Share of it that comes back within half the sample's side.
    shifts : tuple of (int, int)
        The shifts (y, x) with the largest shares, at most six, largest first.
    """

    period: float
    repeats: float
    shifts: tuple[tuple[int, int], ...]


def repetition(sample: View, result: View, lattice: Lattice | None = None) -> Repetition | None:
    """Find the shifts at which parts of a result come back.

    *Definition.* Both pictures are divided by the root of their mean power at each frequency, in
    windows of 32 pixels, so that pixels are nearly independent of each other. Then the correlation
    of the result with itself at a shift is the share of the overlap that is repeated there. 6
    standard errors are subtracted, and the sample's largest correlation with itself, as a result
    may repeat what the sample repeats. Times the overlap, that is the share of the picture that
    comes back. `period` is the largest at any shift, `repeats` the sum within half the sample's
    side.

    A result that keeps a lattice repeats at multiples of its vectors alone, and must: where the
    sample has n tiles, used evenly, a tile comes back at any multiple with a chance of 1 / n,
    which is subtracted there. (Elsewhere chance is spread over so many shifts that the standard
    errors cover it.)

    *Unit.* Share of the result. *Good.* Low. A sample of a quarter of the result's size must come
    back about four times, so `repeats` is seldom 0 where pixels are copied; one that is laid side
    by side has a period of a half and more. *Blind to* copies that
    are turned, scaled or blended, and to repetition that the eye sees without pixels being equal.

    Parameters
    ----------
    sample, result : View
        From `views`.
    lattice : Lattice, optional
        The sample's, from `weftex.analysis.lattice.find_lattice`.

    Returns
    -------
    Repetition or None
        None for sides below 24 pixels, and where the sample does not vary or is masked too much.
    """
    found = _both(sample, result)
    if found is None:
        return None
    shares = found[1]
    height, width = shares.shape[0] - 1, shares.shape[1] // 2
    share = shares.copy()
    share[0, : width + 1] = 0  # mirrors the rest of the line
    y, x = _local_maxima(share)
    values, shifts = share[y, x], np.stack([y, x - width], axis=1)
    reach = sample.side // 2
    near = abs(shifts).max(axis=1, initial=0) <= reach
    repeats = float(values.sum(where=near))
    if lattice is not None and len(lattice.vectors) == 2 and lattice.confidence >= _CONFIDENCE:
        vectors = np.array(lattice.reduced().vectors)[:, ::-1]
        chance = min(1.0, lattice.area / float(sample.usable.sum()))
        at = _at_multiple(shifts, vectors)
        within = _multiples(vectors, min(reach, height), min(reach, width))
        by_chance, expected = (
            chance * (1 - abs(places) / (height + 1, width + 1)).prod(axis=1)
            for places in (shifts, within)
        )
        beside = float(values.sum(where=near & at)) - float(expected.sum())
        repeats = float(values.sum(where=near & ~at)) + max(0.0, beside)
        values = np.maximum(values - at * by_chance, 0)
    order = np.argsort(-values, kind="stable")
    order = order[values[order] > 0][:_SHOWN]
    period = float(values.max(initial=0.0))
    told = tuple((int(dy), int(dx)) for dy, dx in shifts[order])
    return Repetition(period, min(1.0, repeats), told)


def _at_multiple(shifts: NDArray[Any], vectors: Floats) -> NDArray[np.bool_]:
    """Which shifts (y, x) lie at one of the multiples of half a plane."""
    low = np.floor(shifts @ np.linalg.inv(vectors))
    at = np.zeros(len(shifts), bool)
    for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):  # of the tile that a shift lies in
        places = (low + corner) @ vectors
        at |= (abs(shifts - places).max(axis=1, initial=0) <= _AT) & _in_half(places)
    return at


def _in_half(places: Floats) -> NDArray[np.bool_]:
    """Of each place (y, x) and the one opposite, the one that is looked at."""
    y, x = places.T
    half: NDArray[np.bool_] = (y > 0) | ((y == 0) & (x > 0))
    return half


def _multiples(vectors: Floats, height: int, width: int) -> Floats:
    """Multiples (y, x) of the vectors up to so far in half a plane."""
    corners = np.array([[height, width], [height, -width]]) @ np.linalg.inv(vectors)
    most = np.ceil(abs(corners).max(axis=0)).astype(int)
    times = np.stack(np.meshgrid(*(np.arange(-n, n + 1) for n in most)), axis=-1).reshape(-1, 2)
    places: Floats = times @ vectors
    inside: Floats = places[_in_half(places) & (abs(places) <= (height, width)).all(axis=1)]
    return inside


def repetition_map(
    sample: View, result: View, shifts: tuple[tuple[int, int], ...]
) -> Floats | None:
    """Where a result repeats itself at these shifts, (H, W): 0 not at all, 1 pixel by pixel.

    Of a result of more than 1024 pixels a side only the middle is looked at; the rest is 0.
    """
    found = _both(sample, result)
    if found is None:
        return None
    white = found[0]
    inside = np.zeros(white.shape)
    for dy, dx in shifts:
        height, width = white.shape[0] - dy, white.shape[1] - abs(dx)
        first = white[:height, max(0, -dx) : max(0, -dx) + width]
        second = white[dy:, max(0, dx) : max(0, dx) + width]
        above = centered_sums(first * second, _CELL)
        below = np.sqrt(centered_sums(first**2, _CELL) * centered_sums(second**2, _CELL)) + 1e-9
        alike = np.clip(above / below, 0, 1) ** 2
        for y, x in ((0, max(0, -dx)), (dy, max(0, dx))):
            box = inside[y : y + height, x : x + width]
            np.maximum(box, alike, out=box)
    whole = np.zeros(result.shape)
    top, left = ((h - o) // 2 for h, o in zip(result.shape, white.shape, strict=True))
    whole[top : top + white.shape[0], left : left + white.shape[1]] = inside
    return whole


def _both(sample: View, result: View) -> tuple[Floats, Floats] | None:
    """The middle of the result with a flat spectrum; its share that comes back at each shift."""
    part = result.center(_LARGEST_PICTURE)
    if min(*sample.shape, *part.shape) < _NARROWEST:
        return None
    width = min(_WIDTH, 2 ** int(np.log2(min(sample.shape) // 2)))
    own, white = _whitened(sample, width), _whitened(part, width)
    if own is None or white is None:
        return None
    rim = slice(_RIM, -_RIM), slice(_RIM, -_RIM)
    own, white, usable = own[rim], white[rim], sample.usable[rim]
    if usable.sum() < _NARROWEST:
        return None
    ours, overlap = _alike(own, usable)
    most = float(np.where(overlap >= _HALF, ours, 0).max())
    theirs, overlap = _alike(white, np.ones(white.shape, bool))
    return white, np.maximum(theirs - most, 0) * overlap


def _whitened(view: View, width: int) -> Floats | None:
    """The picture divided by the root of its power; mean 0, variance 1. None if it is flat."""
    power = mean_power(view, width)
    if power is None or not power.max() > 1e-3:
        return None
    height, across = view.shape
    y, x = np.fft.fftfreq(height)[:, None] * width, np.fft.rfftfreq(across)[None] * width
    full = np.concatenate([power, power[:1]]) + 1 / 12  # frequency -0.5 is 0.5
    rows, columns = y % width, x
    top, left = np.floor(rows[:, 0]).astype(int), np.floor(columns[0]).astype(int)
    left = np.minimum(left, full.shape[1] - 2)
    dy, dx = rows - top[:, None], columns - left
    along = (1 - dx) * full[:, left] + dx * full[:, left + 1]
    smooth = (1 - dy) * along[top] + dy * along[top + 1]
    fade = [np.minimum(1, (np.minimum(k, k[::-1]) + 1) / _RIM) for k in map(np.arange, view.shape)]
    waves = np.fft.rfft2(view.flat * np.outer(*fade))
    waves /= np.sqrt(smooth, out=smooth)
    white = np.fft.irfft2(waves, view.shape)

    def inside() -> Floats:
        return white[view.usable] if view.masked else white

    white -= inside().mean()
    spread = float(np.sqrt((inside() ** 2).mean()))
    if not spread > 0:
        return None
    # A few strong edges must not stand for the whole picture.
    white /= spread
    np.clip(white, -3, 3, out=white)
    white /= np.sqrt((inside() ** 2).mean())
    if view.masked:
        white[~view.usable] = 0
    return white


def _alike(white: Floats, usable: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Correlation at every shift downwards, less 6 standard errors, and the share that overlaps.

    Shifts upwards, which mirror those, are left out.
    """
    height, width = white.shape
    size = wrapped_length(2 * height - 1), wrapped_length(2 * width - 1)
    products = _products(white, size)
    if usable.all():
        across = width - abs(np.arange(1 - width, width))
        count = np.outer(np.arange(height, 0, -1), across).astype(np.float64)
    else:
        count = np.rint(_products(usable.astype(float), size))
    some = np.maximum(count, 1)
    alike = np.divide(products, some, out=products)
    alike -= np.divide(_ERRORS, np.sqrt(some, out=some), out=some)
    np.clip(alike, 0, 1, out=alike)
    # At short shifts the correlation says how smooth the picture is.
    alike[: _NEAR + 1, max(0, width - 1 - _NEAR) : width + _NEAR] = 0
    alike[count < _FEWEST] = 0
    count /= usable.sum()
    return alike, count


def _products(values: Floats, size: tuple[int, int]) -> Floats:
    """Sums of products with itself at every shift downwards, those to the left first."""
    height, width = values.shape
    waves = np.fft.rfft2(values, size)
    power = waves.real**2 + waves.imag**2
    wrapped = np.fft.irfft(np.fft.ifft(power, axis=0)[:height], size[1], axis=1)
    return np.concatenate([wrapped[:, size[1] - width + 1 :], wrapped[:, :width]], axis=1)


def _local_maxima(values: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns above 0 of which no neighbor is higher."""
    around = np.pad(values, 1)
    y, x = np.nonzero(values > 0)
    highest, own = np.ones(len(y), bool), values[y, x]
    for dy in range(3):
        for dx in range(3):
            highest &= own >= around[y + dy, x + dx]
    return y[highest], x[highest]
