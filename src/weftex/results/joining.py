"""Remove the steps of tone or height between pasted pieces, by a screened Poisson equation.

The result f minimizes the sum of (f' - g)^2 + ((f - h) / reach)^2: its slopes are close to g, the
slopes of the sample at the source of each pixel, and its values to h, the pasted pieces. A step is
shared by both sides and falls off within a reach. After P. Pérez, M. Gangnet and A. Blake,
Poisson image editing (2003), doi:10.1145/882262.882269, with the screen of P. Bhat et al., Fourier
analysis of the 2D screened Poisson equation (2008), doi:10.1007/978-3-540-88688-4_9.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.raster.arrays import Floats, Mask
from weftex.raster.mixing import Kind
from weftex.results import height_kernels as kernels
from weftex.results.sources import Span, Window
from weftex.threads import thread_map

_FEW = 32  # different colors: a drawing or a map of labels, which has no tones between
_HEIGHTS = 24.0  # sample pixels in which what raises an edge of a height map falls to a third
_MARGIN = 8  # reaches from which on nothing is felt
_BLOCK = 1024  # pixels a side that are solved at once
_LEAST = 1e-9  # pixels of reach, which change nothing; the square of less may be 0
_GRAIN = 64  # of a level, to which shifts are rounded, as machines differ in last digits
_LARGEST = 1e30  # whose squares are numbers


class PastedPieces(NamedTuple):
    """The pasted pieces, read by windows; `pixels` is `scale` times as fine as the output."""

    pixels: Callable[[Window], NDArray[Any]]
    layers: Callable[[Window], tuple[NDArray[np.int32], NDArray[np.float32]]]
    shape: tuple[int, int]
    wrap: tuple[bool, bool]
    scale: int
    threads: int
    parts: NDArray[np.uint16] | None = None  # of the sample (H, W), between which steps stay
    #: See `spans_of`: steps are spread within each cell, and what lies between stays.
    cells: NDArray[np.int64] | None = None


def spans_of(cells: NDArray[np.int64]) -> list[list[Span]]:
    """Rows and columns of cells, stored as axis, first, and the one after the last (n, 3)."""
    return [[(a, b) for k, a, b in cells.tolist() if k == axis] for axis in (0, 1)]


def reach_of(given: Exemplar, tones: float, hole: NDArray[np.bool_] | None) -> float:
    """Pixels over which steps of this map are spread; 0 leaves them as they are.

    Heights are always joined; colors within `tones` pixels if they have continuous tones, those
    with alpha only in a hole.
    """
    if given.role.kind == "height":
        return _HEIGHTS
    kinds = (Kind.MEAN,) if hole is None else (Kind.MEAN, Kind.ALPHA)
    if not tones or given.mixing.kind not in kinds:
        return 0.0
    return 0.0 if has_few_colors(given.pixels.reshape(-1, given.channels)) else tones


def has_few_colors(colors: NDArray[Any]) -> bool:
    """Whether at most 32 of the colors (N, C) differ, as in drawings and label maps."""

    def few(left: NDArray[Any]) -> bool:
        for _ in range(_FEW):
            if not len(left):
                break
            left = left[(left != left[0]).any(axis=1)]  # not np.unique, which loads masked arrays
        return not len(left)

    return few(colors[: _FEW**2]) and few(colors)


def join_steps(laid: PastedPieces, given: Exemplar, reach: float, window: Window) -> NDArray[Any]:
    """Return a window of the pasted pieces, without the steps where pieces of other tones meet.

    `reach` is in pixels of the output; 0 leaves all as it is. Parts are the same bytes as in the
    whole. Values are cut to what an integer type holds (heights), or to the sample's range.
    """
    made = laid.pixels(window)
    if not reach or not has_squares(made, given.pixels):
        return made
    source = given.pixels.reshape(*given.shape, -1)
    result = made.reshape(*made.shape[:2], -1)
    least, most = (np.array(ends, np.float64) for ends in ends_of(source, given.role.kind))
    margin, block = int(_MARGIN * reach), max(1, _BLOCK // laid.scale)
    blocks = ([(at, min(at + block, n)) for at in range(0, n, block)] for n in laid.shape)
    spans = blocks if laid.cells is None else spans_of(laid.cells)
    rows, columns = (
        [(first, last) for first, last in some if first < start + n and start < last]
        for some, start, n in zip(spans, window[:2], window[2:], strict=True)
    )

    def join(cell: tuple[Span, Span]) -> None:
        around, odd = (margin if laid.cells is None else 0), None
        steps, lines, samples = _divergence(laid, source, cell, around)
        if laid.cells is not None:
            lines, odd = _mirrored(lines, margin * laid.scale)
        ends = [
            (max(first, start), min(last, start + n))
            for (first, last), start, n in zip(cell, window[:2], window[2:], strict=True)
        ]
        inside, here = (
            tuple(
                slice((start - at) * laid.scale, (end - at) * laid.scale)
                for (start, end), at in zip(ends, first, strict=True)
            )
            for first in ((cell[0][0] - margin, cell[1][0] - margin), window[:2])
        )
        # A channel at a time, as new memory is slow.
        spread = _spreading((len(lines[0]), len(lines[1])), reach * laid.scale)
        masks = [mask.take(lines[0], 0).take(lines[1], 1) for mask in samples]
        for one, k in ((steps[k], slice(k, k + 1)) for k in range(len(steps))):
            one = one.take(lines[0], 0).take(lines[1], 1)
            if odd is not None:
                one *= odd
            each = [spread(one * mask, *inside) * mask[inside] for mask in masks]
            shifts = np.sum(each, axis=0) if masks else spread(one, *inside)
            kernels.add_shifts(result[here][..., k], shifts[None], least[k], most[k], _GRAIN)

    with thread_map(max(1, min(laid.threads, len(rows) * len(columns)))) as map_:
        for _ in map_(join, product(rows, columns)):
            pass  # the first that fails ends it
    return result.reshape(made.shape)


def has_squares(*pictures: NDArray[Any]) -> bool:
    """Whether no number is so large that its square is none."""
    return all(a.dtype.kind == "u" or float(np.abs(a).max()) <= _LARGEST for a in pictures)


def ends_of(source: NDArray[Any], kind: str) -> tuple[Any, Any]:
    """The least and the largest value that each channel may have."""
    if kind != "height":
        return source.min(axis=(0, 1)), source.max(axis=(0, 1))
    whole = source.dtype.kind == "u"
    ends = (0.0, float(np.iinfo(source.dtype).max)) if whole else (-np.inf, np.inf)
    least, most = ([end] * source.shape[2] for end in ends)
    return least, most


class _Lines(NamedTuple):
    """A block with its margin along one axis."""

    runs: list[tuple[int, int]]  # first and number of the output's lines to read
    around: bool  # whether all lines are read and the first one follows the last
    inside: NDArray[np.int64]  # places among the lines read, at the map's scale; mirrored outside


def _lines(span: Span, n: int | None, wraps: bool, margin: int, scale: int) -> _Lines:
    """Return some of `n` lines, or None if there are always more, and those of a margin."""
    first, last = span
    low, high = first - margin - 1, last + margin + 1  # a line more, for edges that lead there
    inside = np.arange((first - margin) * scale, (last + margin) * scale)
    if n is None:
        return _Lines([(low, high - low)], False, inside - low * scale)
    if wraps and high - low >= n:
        return _Lines([(0, n)], True, inside % (n * scale))
    if wraps:
        start, before = low % n, min(high - low, n - low % n)
        runs = [(start, before), (0, high - low - before)][: 1 + (before < high - low)]
        return _Lines(runs, False, inside - low * scale)
    start = max(low, 0)
    inside %= 2 * n * scale
    inside = np.minimum(inside, 2 * n * scale - 1 - inside) - start * scale
    return _Lines([(start, min(high, n) - start)], False, inside)


def _mirrored(
    lines: list[NDArray[np.int64]], margin: int
) -> tuple[list[NDArray[np.int64]], Floats]:
    """Return the lines of a cell and of a margin, and the signs (H, W) by which steps are mirrored.

    What is odd around the first line beyond a cell is 0 there, so that line does not move.
    """
    found, signs = [], []
    for line in lines:
        last = len(line) + 1
        place = np.arange(1 - margin, last + margin) % (2 * last)
        signs.append(np.sign(last - place) * (place > 0))
        found.append(line[(np.minimum(place, 2 * last - place) - 1) % len(line)])
    return found, np.outer(*signs).astype(np.float64)


def _divergence(
    laid: PastedPieces, sample: NDArray[Any], cell: tuple[Span, Span], margin: int
) -> tuple[Floats, list[NDArray[np.int64]], list[Mask]]:
    """Return the sum of g - h' over the edges into each pixel minus the edges out of it (C, H, W).

    Also returns the rows and columns of it that are a block and its margin, or a cell, and the
    pixels of each part of the sample if there are several.
    """
    sides = laid.shape if laid.cells is None else (None, None)
    rows, columns = (
        _lines(span, n, wraps, margin, laid.scale)
        for span, n, wraps in zip(cell, sides, laid.wrap, strict=True)
    )
    windows = [[(top, left, high, wide) for left, wide in columns.runs] for top, high in rows.runs]
    layers_of = [[laid.layers(window) for window in row] for row in windows]
    made = _as_one([[laid.pixels(window) for window in row] for row in windows])
    made = made.reshape(*made.shape[:2], -1)
    coordinates, shares = (_as_one([[one[k] for one in row] for row in layers_of]) for k in (0, 1))
    layers = int((shares > 0).any(axis=(0, 1)).sum()) or 1  # the heaviest first
    coordinates, shares = finer(coordinates[:, :, :layers], shares[:, :, :layers], laid.scale)
    height = len(made)
    if rows.around:  # the first line again, below the last one
        made, coordinates, shares = (
            np.concatenate([a, a[:1]]) for a in (made, coordinates, shares)
        )
    steps = np.zeros((made.shape[2], *made.shape[:2]))
    about = height, columns.around, laid.scale, np.zeros(made.shape[2])
    part = np.broadcast_to(np.uint16(0), sample.shape[:2]) if laid.parts is None else laid.parts
    if laid.parts is not None and laid.scale > 1:
        part = part.repeat(laid.scale, 0).repeat(laid.scale, 1)
    kernels.compare_slopes(steps, made, sample, coordinates, shares, *about, part)
    if rows.around:
        steps[:, 0] += steps[:, height]
    places = coordinates[:height, :, 0].transpose(2, 0, 1)
    own = part[:0] if laid.parts is None else part[tuple(places)]
    masks = (own == number for number in range(int(own.max(initial=0)) + 1))
    return steps, [rows.inside, columns.inside], [mask for mask in masks if mask.any()]


def _as_one(pieces: list[list[NDArray[Any]]]) -> NDArray[Any]:
    """Return the rows of pieces as one array, copied only if there are several."""
    rows = [row[0] if len(row) == 1 else np.concatenate(row, 1) for row in pieces]
    return rows[0] if len(rows) == 1 else np.concatenate(rows)


def finer(
    coordinates: NDArray[np.int32], shares: NDArray[np.float32], scale: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """The same for pixels `scale` times as fine."""
    if scale == 1:
        return np.ascontiguousarray(coordinates), np.ascontiguousarray(shares)
    for axis in (0, 1):
        coordinates, shares = coordinates.repeat(scale, axis), shares.repeat(scale, axis)
    within = [np.arange(side) % scale for side in shares.shape[:2]]
    fine = coordinates * scale
    fine[..., 0] += within[0][:, None, None]
    fine[..., 1] += within[1][None, :, None]
    return fine, np.ascontiguousarray(shares)


def _spreading(shape: tuple[int, int], reach: float) -> Callable[[Floats, slice, slice], Floats]:
    """A function that solves c / reach^2 - c'' = steps for some rows and columns.

    Borders of the canvas are ignored.
    """
    size = [-(-side // 32) * 32 for side in shape]  # quick to transform
    turns = [2 - 2 * np.cos(2 * np.pi * np.arange(side) / side) for side in size]
    factors = 1 / (np.add.outer(turns[0], turns[1][: size[1] // 2 + 1]) + max(reach, _LEAST) ** -2)
    spectrum = np.empty(factors.shape, np.complex128)  # for all channels, as new memory is slow

    def spread(steps: Floats, rows: slice, columns: slice) -> Floats:
        _transform(np.fft.rfft, steps, spectrum[: shape[0]], size[1])
        spectrum[shape[0] :] = 0
        _transform(np.fft.fft, spectrum, spectrum, axis=0)
        np.multiply(spectrum, factors, out=spectrum)
        _transform(np.fft.ifft, spectrum, spectrum, axis=0)
        return np.fft.irfft(spectrum[rows], size[1])[:, columns]

    return spread


def _transform(fft: Callable[..., Any], values: Any, out: Any, *args: int, **named: int) -> None:
    """Write the transform of `values` to `out`, without other memory from NumPy 2.0 on."""
    if np.lib.NumpyVersion(np.__version__) >= "2.0.0":
        fft(values, *args, out=out, **named)
    else:
        out[...] = fft(values, *args, **named)
