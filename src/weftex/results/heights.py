"""Heights that join without cliffs: a height map as its slopes, from which it is built again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.results import height_kernels as kernels

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    #: Coordinates and shares of what shows in a window, as `Synthesis.layers` returns them.
    Layers = Callable[[tuple[int, int, int, int]], tuple[NDArray[Any], NDArray[Any]]]

_REACH = 24  # sample pixels in which what raises an edge falls to a third
_MARGIN = 8  # reaches from which on nothing is felt
_BLOCK = 1024  # pixels a side that are solved at once
_BAND = 1 << 19  # pixels whose slopes are looked up at once
_GRAIN = 64  # of a level, to which shifts are rounded, as machines differ in last digits
_LARGEST = 1e30  # whose squares are numbers


def join_heights(
    made: NDArray[Any],
    sample: NDArray[Any],
    layers: Layers,
    wrap: tuple[bool, bool] = (False, False),
    scale: int = 1,
) -> NDArray[Any]:
    """Take away the steps where pieces of other heights meet.

    Of all heights f those are chosen whose slopes are most like g, the sample's where each pixel
    comes from, and which are near to h, what was laid: with the least sum of
    (f' - g)^2 + ((f - h) / reach)^2. A step is shared by both sides and falls off in a reach.

    Parameters
    ----------
    made : array (H, W) or (H, W, C)
        A height map as it was laid.
    sample : array (h, w) or (h, w, C)
        The map that it was laid from.
    layers : callable
        `Synthesis.layers`.
    wrap : (bool, bool)
        Axes along which the output goes around.
    scale : int
        How many of `made`'s pixels one of the result is wide.

    Returns
    -------
    array
        Like `made`; whole numbers are cut to what their type holds.

    Notes
    -----
    After P. Pérez, M. Gangnet and A. Blake, Poisson image editing (2003),
    doi:10.1145/882262.882269, with the screen of P. Bhat et al., Fourier analysis of the 2D
    screened Poisson equation (2008), doi:10.1007/978-3-540-88688-4_9.

    Examples
    --------
    >>> import weftex
    >>> slope = np.arange(64, dtype=np.float32) * np.ones((64, 1), np.float32)
    >>> result = weftex.synthesize(slope, (64, 128), method="quilting", seed=1)
    >>> laid, joined = result.render(), result.render(slope, role="height")
    >>> bool(abs(np.diff(joined)).max() < 0.2 * abs(np.diff(laid)).max())
    True
    """
    planes = made.reshape(*made.shape[:2], -1)
    source = sample.reshape(*sample.shape[:2], -1)
    if max(float(np.abs(values).max()) for values in (planes, source)) > _LARGEST:
        return made
    steps = _divergence(planes, source, layers, wrap, scale)
    result = np.empty_like(planes)
    for channel in range(planes.shape[2]):
        shift = _spread(steps[..., channel], wrap, _REACH * scale)
        if made.dtype.kind == "u":
            shift = np.rint(planes[..., channel] + np.rint(shift * _GRAIN) / _GRAIN)
            shift = np.clip(shift, 0, np.iinfo(made.dtype).max)
        else:
            shift += planes[..., channel]
        result[..., channel] = shift
    return result.reshape(made.shape)


def _divergence(
    made: NDArray[Any], sample: NDArray[Any], layers: Layers, wrap: tuple[bool, bool], scale: int
) -> Floats:
    """At each pixel the sum of g - h' over the edges that lead to it, less that over the others."""
    height, width = made.shape[0] // scale, made.shape[1] // scale
    total, numbers = np.zeros(made.shape), sample.astype(np.float64)
    band = max(1, _BAND // width)
    for top in range(0, height, band):
        count = min(band, height - top)
        shown = [layers((top, 0, count, width))]
        if top + count < height or wrap[0]:
            shown.append(layers(((top + count) % height, 0, 1, width)))
        coordinates, shares = (np.concatenate(part) for part in zip(*shown, strict=True))
        coordinates, shares = _finer(coordinates, shares, scale)
        rows = np.arange(top * scale, top * scale + len(shares)) % len(made)
        steps = np.zeros((len(rows), *made.shape[1:]))
        kernels.compare_slopes(
            steps,
            made[rows].astype(np.float64),
            numbers,
            coordinates,
            shares,
            count * scale,
            wrap[1],
            np.zeros(made.shape[2]),
        )
        own = count * scale
        total[rows[:own]] += steps[:own]
        total[rows[own:]] += steps[own:]  # which may be the first ones again
    return total


def _finer(
    coordinates: NDArray[np.int32], shares: NDArray[np.float32], scale: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """The same for pixels `scale` times as fine, heaviest layers that are there."""
    there = int((shares > 0).any(axis=(0, 1)).sum()) or 1
    coordinates, shares = coordinates[:, :, :there], shares[:, :, :there]
    if scale == 1:
        return np.ascontiguousarray(coordinates), np.ascontiguousarray(shares)
    for axis in (0, 1):
        coordinates, shares = coordinates.repeat(scale, axis), shares.repeat(scale, axis)
    within = [np.arange(side) % scale for side in shares.shape[:2]]
    fine = coordinates * scale
    fine[..., 0] += within[0][:, None, None]
    fine[..., 1] += within[1][None, :, None]
    return fine, np.ascontiguousarray(shares)


def _spread(steps: Floats, wrap: tuple[bool, bool], reach: float) -> Floats:
    """Solve c / reach^2 - c'' = steps, with no slope at borders, by blocks that overlap."""
    margin = int(_MARGIN * reach)
    found = np.empty(steps.shape)
    padded = steps
    for axis in (0, 1):
        pad = [(0, 0), (0, 0)]
        pad[axis] = (margin, margin)
        padded = np.pad(padded, pad, "wrap" if wrap[axis] else "symmetric")
    for top in range(0, steps.shape[0], _BLOCK):
        for left in range(0, steps.shape[1], _BLOCK):
            block = padded[top : top + _BLOCK + 2 * margin, left : left + _BLOCK + 2 * margin]
            size = [-(-side // 32) * 32 for side in block.shape]  # quick to transform
            turns = [2 - 2 * np.cos(2 * np.pi * np.arange(side) / side) for side in size]
            spectrum = np.fft.rfft2(block, size)
            spectrum /= np.add.outer(turns[0], turns[1][: spectrum.shape[1]]) + reach**-2
            solved = np.fft.irfft2(spectrum, size)
            rows, columns = (side - 2 * margin for side in block.shape)
            found[top : top + rows, left : left + columns] = solved[
                margin : margin + rows, margin : margin + columns
            ]
    return found
