"""Remove the steps of tone or height between pasted pieces, by a screened Poisson equation.

The result f minimizes the sum of (f' - g)^2 + ((f - h) / reach)^2: its slopes are close to g, the
slopes of the sample at the source of each pixel, and its values to h, the pasted pieces. A step is
shared by both sides and falls off within a reach. An output is solved in blocks: squares with a
margin. An endless plane is divided into cells by lines, which cross at nodes: each line is solved
between two nodes, then each cell inside its four lines. After P. Pérez et al., Poisson image
editing (2003), doi:10.1145/882262.882269, with the screen of P. Bhat et al., Fourier analysis of
the 2D screened Poisson equation (2008), doi:10.1007/978-3-540-88688-4_9.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.raster.arrays import Floats, Mask
from weftex.raster.mixing import Kind
from weftex.results import height_kernels as kernels
from weftex.results.sources import Place, Span, Window
from weftex.threads import thread_map

_FEW = 32  # different colors: a drawing or a map of labels, which has no tones between
_FLAT = 0.6  # share of equal neighbors: antialiased drawings 0.68 and more, photos 0.43 at most
_APART = 3  # lines, of which one is looked at
_HEIGHTS = 24.0  # sample pixels in which what raises an edge of a height map falls to a third
_MARGIN = 8  # reaches from which on nothing is felt
_BLOCK = 1024  # pixels a side that are solved at once
_SIZES = 32  # whose multiples are quick to transform
_LEAST = 1e-9  # pixels of reach, which change nothing; the square of less may be 0
_GRAIN = 64  # of a level, to which shifts are rounded, as machines differ in last digits
EXCLUDED = np.uint16(2**16 - 1)  #: The part of a sample that must not be copied.
_LARGEST = 1e30  # whose squares are numbers


Parts = NDArray[np.uint16]


class PastedPieces(NamedTuple):
    """The pasted pieces, read by windows; `pixels` is `scale` times as fine as the output."""

    pixels: Callable[[Window], NDArray[Any]]
    layers: Callable[[Window], tuple[NDArray[np.int32], NDArray[np.float32]]]
    shape: tuple[int, int]
    wrap: tuple[bool, bool]
    scale: int
    threads: int
    parts: Parts | None = None  # of the sample's map (H, W), between which steps stay
    #: See `spans_of`: steps are spread along each line between two nodes, then within each cell.
    cells: NDArray[np.int64] | None = None


def spans_of(cells: NDArray[np.int64]) -> list[list[Span]]:
    """Rows and columns of lines of nodes and of cells in turn, stored as axis and end (n, 2)."""
    return [list(pairwise(cells[cells[:, 0] == axis, 1].tolist())) for axis in (0, 1)]


def reach_of(given: Exemplar, tones: float, hole: NDArray[np.bool_] | None) -> float:
    """Pixels over which steps of this map are spread; 0 leaves them as they are.

    Heights are always joined; colors within `tones` pixels unless they are drawn, those with alpha
    only in a hole.
    """
    if given.role.kind == "height":
        return _HEIGHTS
    kinds = (Kind.MEAN,) if hole is None else (Kind.MEAN, Kind.ALPHA)
    if not tones or given.mixing.kind not in kinds:
        return 0.0
    return 0.0 if _is_flat(given) or has_few_colors(given) else tones


def _is_flat(given: Exemplar) -> bool:
    """Whether most pixels equal the next ones in their row and column, as in drawn pictures."""
    lines = given.pixels.reshape(*given.shape, -1)
    for pixels in (lines[::_APART], lines.swapaxes(0, 1)[::_APART]):
        same = (pixels[:, 1:] == pixels[:, :-1]).all(axis=2)
        if given.alpha:
            same = same[pixels[:, 1:, -1] > 0]
        if not same.size or same.mean() < _FLAT:
            return False
    return True


def has_few_colors(given: Exemplar) -> bool:
    """Whether at most 32 of the colors differ, as in drawings and label maps."""
    colors = given.pixels.reshape(-1, given.channels)
    for left in (colors[: _FEW**2], colors):
        for _ in range(_FEW):
            left = left[(left != left[:1]).any(axis=1)]  # not np.unique, which loads masked arrays
        if len(left):
            return False
    return True


def join_steps(laid: PastedPieces, given: Exemplar, reach: float, window: Window) -> NDArray[Any]:
    """Return a window of the pasted pieces, without the steps where pieces of other tones meet.

    `reach` is in pixels of the output; 0 leaves all as it is. A window has the same bytes as in the
    whole output. Values are cut to what an integer type holds (heights), or to the sample's range.
    """
    made = laid.pixels(window)
    if not reach or not has_squares(made, given.pixels):
        return made
    source = given.pixels.reshape(*given.shape, -1)
    result = made.reshape(*made.shape[:2], -1)
    usable = source if laid.parts is None else source[laid.parts != EXCLUDED]
    least, most = (np.array(ends, np.float64) for ends in ends_of(usable, given.role.kind))
    block = max(1, _BLOCK // laid.scale)
    blocks = ([(at, min(at + block, n)) for at in range(0, n, block)] for n in laid.shape)
    spans = list(blocks) if laid.cells is None else spans_of(laid.cells)
    shown = (
        [k for k, (first, last) in enumerate(some) if first < start + n and start < last]
        for some, start, n in zip(spans, window[:2], window[2:], strict=True)
    )
    places = [(y, x) for y, x in product(*shown) if laid.cells is None or y % 2 or x % 2]

    @cache
    def line(y: int, x: int) -> Floats:
        """The shifts (C, H, W) of a line between two nodes."""
        span = spans[0][y], spans[1][x]
        return np.stack([*_shifts(laid, source, reach, span, span, (y % 2 == 0, x % 2 == 0))])

    def join(place: Place) -> None:
        (y, x), span = place, (spans[0][place[0]], spans[1][place[1]])
        sides = zip(span, window[:2], window[2:], strict=True)
        ends = [tuple(np.clip(side, start, start + n)) for side, start, n in sides]
        found: Iterable[Floats]
        if laid.cells is None:
            found = _shifts(laid, source, reach, span, ends)
        elif y % 2 and x % 2:
            beside = [line(y - 1, x)[:, -1], line(y + 1, x)[:, 0]]
            beside += [line(y, x - 1)[..., -1], line(y, x + 1)[..., 0]]
            found = _shifts(laid, source, reach, span, ends, beside=beside)
        else:
            rows, columns = _slices(ends, (span[0][0], span[1][0]), laid.scale)
            found = line(y, x)[:, rows, columns]
        here = result[_slices(ends, window, laid.scale)]
        for k, shifts in enumerate(found):
            of = slice(k, k + 1)
            kernels.add_shifts(here[..., of], shifts[None], least[of], most[of], _GRAIN)

    with thread_map(max(1, min(laid.threads, len(places)))) as map_:
        for _ in map_(join, places):
            pass  # the first that fails ends it
    return result.reshape(made.shape)


def _slices(ends: Iterable[Span], firsts: Iterable[int], scale: int) -> tuple[slice, ...]:
    """Lines of the output between some ends, in finer pixels after the first ones."""
    pairs = zip(ends, firsts, strict=False)
    return tuple(slice((a - at) * scale, (b - at) * scale) for (a, b), at in pairs)


def _shifts(
    laid: PastedPieces,
    sample: NDArray[Any],
    reach: float,
    span: Sequence[Span],
    ends: Sequence[Span],
    thin: tuple[bool, bool] = (False, False),
    beside: Sequence[Floats] = (),
) -> Iterator[Floats]:
    """The shifts of each channel in a part of a block, of a cell, or of a `thin` line of nodes.

    `beside` are those of the lines above, below, to the left and to the right of a cell.
    """
    steps, sides, samples = _divergence(laid, sample, span, int(_MARGIN * reach), thin)
    for axis, at, shifts in zip((1, 1, 2, 2), (0, -1, 0, -1), beside, strict=False):
        cell = steps[:, laid.scale : -laid.scale, laid.scale : -laid.scale]
        cell.swapaxes(1, axis)[:, at] += shifts
    down, along = (side.places for side in sides)
    part = _slices(ends, (side.first for side in sides), laid.scale)
    spread = _spreading((len(down), len(along)), reach * laid.scale)
    masks = [mask.take(down, 0).take(along, 1) for mask in samples]
    for one in steps:  # a channel at a time, as new memory is slow
        one = one.take(down, 0).take(along, 1)
        if laid.cells is not None:
            one *= np.outer(sides[0].signs, sides[1].signs)
        each = [spread(one * mask, *part) * mask[part] for mask in masks]
        yield np.sum(each, axis=0) if masks else spread(one, *part)


def has_squares(*pictures: NDArray[Any]) -> bool:
    """Whether no number is so large that its square is none."""
    return all(a.dtype.kind == "u" or float(np.abs(a).max()) <= _LARGEST for a in pictures)


def with_mask(parts: Parts | None, mask: NDArray[np.bool_] | None) -> Parts | None:
    """The parts of a sample (H, W), of which the pixels that must not be copied are one more."""
    return parts if mask is None else np.maximum(0 if parts is None else parts, ~mask * EXCLUDED)


def ends_of(source: NDArray[Any], kind: str) -> tuple[Any, Any]:
    """The least and the largest value that each channel may have."""
    if kind != "height":
        values = source.reshape(-1, source.shape[-1])
        return values.min(axis=0), values.max(axis=0)
    whole = source.dtype.kind == "u"
    ends = (0.0, float(np.iinfo(source.dtype).max)) if whole else (-np.inf, np.inf)
    least, most = ([end] * source.shape[-1] for end in ends)
    return least, most


class _Lines(NamedTuple):
    """What is solved along one axis: a block with its margin, a cell, or a line of nodes."""

    runs: list[tuple[int, int]]  # first and number of the output's lines to read
    around: bool  # whether all lines are read and the first one follows the last
    places: NDArray[np.int64]  # among the lines read, at the map's scale; mirrored outside
    first: int  # the output's line at the first place
    signs: Any = 1.0  # of what is mirrored


def _lines(span: Span, n: int, wraps: bool, margin: int, scale: int) -> _Lines:
    """Return some of `n` lines and those of a margin."""
    first, last = span[0] - margin, span[1] + margin
    low, high = first - 1, last + 1  # a line more, for edges that lead there
    places = np.arange(first * scale, last * scale)
    if wraps and high - low >= n:
        return _Lines([(0, n)], True, places % (n * scale), first)
    if wraps:
        start, before = low % n, min(high - low, n - low % n)
        runs = [(start, before), (0, high - low - before)][: 1 + (before < high - low)]
        return _Lines(runs, False, places - low * scale, first)
    start = max(low, 0)
    places %= 2 * n * scale
    places = np.minimum(places, 2 * n * scale - 1 - places) - start * scale
    return _Lines([(start, min(high, n) - start)], False, places, first)


def _mirrored(span: Span, thin: bool, margin: int, scale: int) -> _Lines:
    """Return the lines of a cell and of a margin: odd around those beside the cell, so 0 there.

    Across a `thin` line of nodes all is even: there is no slope at its sides.
    """
    (first, last), n = span, (span[1] - span[0]) * scale
    if thin:
        places = np.arange(math.lcm(2 * n, _SIZES)) % (2 * n)
        places = np.minimum(places, 2 * n - 1 - places)
        return _Lines([(first, last - first)], False, places, first, np.ones(len(places)))
    places = np.arange(1 - margin * scale, n + 1 + margin * scale) % (2 * n + 2)
    signs = np.sign(n + 1 - places) * (places > 0)
    places = (np.minimum(places, 2 * n + 2 - places) - 1) % n + scale
    return _Lines([(first - 1, last - first + 2)], False, places, first - margin, signs)


def _divergence(
    laid: PastedPieces,
    sample: NDArray[Any],
    span: Sequence[Span],
    margin: int,
    thin: tuple[bool, bool],
) -> tuple[Floats, list[_Lines], list[Mask]]:
    """Return the sum of g - h' over the edges into each pixel minus the edges out of it (C, H, W).

    Also returns what is solved along both axes, and the pixels of each part of the sample if there
    are several.
    """
    axes = zip(span, laid.shape, laid.wrap, thin, strict=True)
    rows, columns = sides = [
        _lines(ends, n, wraps, margin, laid.scale)
        if laid.cells is None
        else _mirrored(ends, even, margin, laid.scale)
        for ends, n, wraps, even in axes
    ]
    windows = [[(top, left, high, wide) for left, wide in columns.runs] for top, high in rows.runs]
    layers_of = [[laid.layers(window) for window in row] for row in windows]
    made = _as_one([[laid.pixels(window) for window in row] for row in windows])
    made = made.reshape(*made.shape[:2], -1)
    coordinates, shares = (_as_one([[one[k] for one in row] for row in layers_of]) for k in (0, 1))
    layers = int((shares > 0).any(axis=(0, 1)).sum()) or 1  # the heaviest first
    coordinates, shares = finer(coordinates[:, :, :layers], shares[:, :, :layers], laid.scale)
    height = len(made)
    if rows.around:  # the first line again, below the last one
        again = (np.concatenate([a, a[:1]]) for a in (made, coordinates, shares))
        made, coordinates, shares = again
    steps = np.zeros((made.shape[2], *made.shape[:2]))
    about = height, columns.around, laid.scale, np.zeros(made.shape[2])
    part = np.broadcast_to(np.uint16(0), sample.shape[:2]) if laid.parts is None else laid.parts
    kernels.compare_slopes(steps, made, sample, coordinates, shares, *about, part)
    if rows.around:
        steps[:, 0] += steps[:, height]
    places = coordinates[:height, :, 0].transpose(2, 0, 1)
    own = part[:0] if laid.parts is None else part[tuple(places)]
    masks = (own == number for number in range(int(own.max(initial=0)) + 1))
    return steps, sides, [mask for mask in masks if mask.any()]


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
    size = [-(-side // _SIZES) * _SIZES for side in shape]
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
