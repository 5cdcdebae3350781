"""A sample prepared for near-regular synthesis: windows, borders, rectified pixels."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.exemplar import Exemplar
from weftex.methods.lattices.mean_tile import MeanTile
from weftex.methods.near_regular.defaults import vectors_around
from weftex.methods.near_regular.rows import Courses, axis_of_rows, courses_of
from weftex.random import draw
from weftex.raster.boxes import extended_sums, sums_along
from weftex.search.picture_kernels import Sample
from weftex.search.windows import Windows, windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SOFT = 40  # squared difference of a channel, two pixels apart, that halves the visibility
_ROUNDS = 2  # the mean tile gets sharper by the first
_GRID = 4  # px between the places where the shift is found
_GAIN = (3, 4)  # pixels move only if that leaves at most 3/4 of the difference
_NEAREST, _FARTHEST = 4, 12  # px around a place that are compared


class Border(NamedTuple):
    """The pixels of a gap's window that must match."""

    wedges: NDArray[np.uint8]  # 1 to 4: of the neighbor above, left, below, right; 0 off the border
    runs: NDArray[np.int32]  # (n, 3): the border as runs of pixels, y, x and length, shuffled


@dataclass(frozen=True, eq=False)
class BlockSample:
    """All that outputs of one sample have in common.

    An offset leads from a block's phase to a similar window: a sum of multiples of the lattice
    vectors in 1/65536 pixel. In the unconstrained mode all windows are offsets, from phase 0.
    """

    exemplar: Exemplar
    windows: Windows  # by their upper left corners
    lookup: NDArray[np.int32] | None  # (H, W): the pixel at each place, if the sample is rectified
    pixels: NDArray[np.uint8]  # (H', W', K), the windows' pixels, rectified
    visibility: NDArray[np.uint16]  # (H', W'), of a seam at each of them
    offsets: NDArray[np.int64]  # (n, 2), shuffled
    multiples: NDArray[np.int64]  # (n,), of the first vector in each; empty if unconstrained
    row_axis: int | None  # along which rows change that have a color each, see `axis_of_rows`
    courses: tuple[Courses | None, ...]  # rows that blocks keep to, along both axes
    _borders: dict[tuple[int, ...], Border] = field(default_factory=dict, repr=False)

    def border(self, height: int, width: int, margin: int, reach: int) -> Border:
        """The border of gaps of one size, see `wedges_of`."""
        key = height, width, margin, reach
        if key not in self._borders:
            wedges = wedges_of(*key)
            self._borders[key] = Border(wedges, runs_of(wedges > 0))
        return self._borders[key]

    @property
    def kernel(self) -> Sample:
        """The windows as kernels take them."""
        return Sample(self.pixels, self.windows.usable, self.windows.period)

    def has_window(self, y: NDArray[np.int64], x: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether whole windows begin at these places, which wrap where the sample tiles."""
        usable, (height, width) = self.windows.usable, self.windows.period[2:]
        if height:
            y, x = y % height, x % width
        inside = (y >= 0) & (x >= 0) & (y < usable.shape[0]) & (x < usable.shape[1])
        inside[inside] = usable[y[inside], x[inside]] > 0
        result: NDArray[np.bool_] = inside
        return result


def prepare(method: Any, exemplar: Exemplar) -> BlockSample:
    """Analyze a sample for a resolved method: its windows, rectified pixels, similar windows."""
    vectors, reach = method.lattice, method.window_side - 1
    if exemplar.tileable and vectors_around(vectors, exemplar) is None:
        windows = windows_of(exemplar.changed(tileable=False), (0, reach, 0, reach))
    else:
        windows = windows_of(exemplar, (0, reach, 0, reach))
    pixels, lookup = windows.pixels, None
    if method.rectify:
        lookup = rectified(pixels, vectors, method.rectify, by_rows=method.by_rows)
        pixels = np.ascontiguousarray(pixels.reshape(-1, pixels.shape[2])[lookup])
    row_axis = None
    courses: list[Courses | None] = [None, None]
    if method.unconstrained:
        offsets = np.stack(np.divmod(windows.centers, pixels.shape[1]), axis=1).astype(np.int64)
        offsets, multiples = shuffled(offsets, "steps") << 16, np.zeros(0, np.int64)
    else:
        lattice = CanvasLattice(vectors)
        offsets = shuffled(lattice.steps(*exemplar.shape), "steps")
        multiples = np.rint(offsets @ lattice.inverse[:, 0] / 65536).astype(np.int64)
        if method.by_rows and exemplar.mask is None:
            row_axis = axis_of_rows(pixels, vectors)
        if row_axis is not None:
            courses[row_axis] = courses_of(pixels, vectors, row_axis)
    return BlockSample(
        exemplar=exemplar,
        windows=windows,
        lookup=lookup,
        pixels=pixels,
        visibility=visibility(pixels, method.seam_cost == "gradient"),
        offsets=offsets,
        multiples=multiples,
        row_axis=row_axis,
        courses=tuple(courses),
    )


def wedges_of(height: int, width: int, margin: int, reach: int) -> NDArray[np.uint8]:
    """Wedge-shaped borders (Fig. 4.8b), 2 * `reach` wide, of a block's window, see `Border`.

    >>> wedges_of(4, 4, 1, 1)[:3]
    array([[1, 1, 1, 1, 1, 1],
           [2, 1, 1, 1, 1, 4],
           [2, 2, 0, 0, 4, 4]], dtype=uint8)
    """
    v, u = np.indices((height + 2 * margin, width + 2 * margin))
    away = np.stack([v, u, v[::-1], u[:, ::-1]]) - (margin - reach)
    nearest = away.min(axis=0)
    border = (nearest >= 0) & (nearest < 2 * reach)
    return np.where(border, away.argmin(axis=0) + 1, 0).astype(np.uint8)


def runs_of(border: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Cover a border with runs of pixels in a row, shuffled; see `Border`."""
    change = np.diff(np.pad(border, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    (y, start), stop = np.nonzero(change == 1), np.nonzero(change == -1)[1]
    return shuffled(np.stack([y, start, stop - start], axis=1).astype(np.int32))


def shuffled(values: NDArray[Any], purpose: str = "runs") -> NDArray[Any]:
    """Shuffle rows: the first few then tell about all, such as runs on all sides of a border."""
    order = np.argsort(draw(0, purpose, np.arange(len(values))), kind="stable")
    return np.ascontiguousarray(values[order])


def visibility(pixels: NDArray[np.uint8], gradient: bool) -> NDArray[np.uint16]:
    """How visible a seam is at each pixel, at least 1: less on edges of the sample's own.

    Unless by `gradient` it is the same everywhere.

    >>> step = np.array([[[10], [10], [10], [90], [90]]], np.uint8)
    >>> visibility(step, gradient=True).tolist()
    [[4096, 4096, 25, 25, 4096]]
    """
    if not gradient:
        return np.ones(pixels.shape[:2], np.uint16)
    wide = np.pad(pixels.astype(np.int32), ((1, 1), (1, 1), (0, 0)), mode="edge")
    steep = (wide[2:, 1:-1] - wide[:-2, 1:-1]) ** 2
    steep += (wide[1:-1, 2:] - wide[1:-1, :-2]) ** 2
    soft = _SOFT * pixels.shape[2]
    result: NDArray[np.uint16] = np.maximum(4096 * soft // (soft + steep.sum(axis=2)), 1).astype(
        np.uint16
    )
    return result


def blockiness(method: Any, pixels: NDArray[np.uint8]) -> float:
    """Return the share, 0 to 1, of the variance of similar pixels that whole blocks differ by.

    Where it is high, blocks are visible by their brightness or color (Fig. 5.12).
    """
    side = max(1, method.window_side // 2)
    rest = pixels.astype(np.int64)
    if not method.unconstrained:
        rest -= MeanTile(pixels, method.lattice).at(*np.indices(pixels.shape[:2]))
    rows, columns = (n // side for n in rest.shape[:2])
    parts = rest[: rows * side, : columns * side].reshape(rows, side, columns, side, -1)
    means = parts.mean(axis=(1, 3))
    whole = float(parts.var(axis=(0, 1, 2, 3)).sum())
    return float(means.var(axis=(0, 1)).sum()) / whole if whole > 0 else 0.0


def rectified(
    pixels: NDArray[np.uint8], vectors: tuple[float, ...], reach: int, *, by_rows: bool = False
) -> NDArray[np.int32]:
    """Flat index (H, W) of the pixel that belongs at each place if all tiles had one shape.

    Pixels move at most `reach`, by whole pixels, to agree with the mean tile; those that could be
    anywhere follow the others. With `by_rows`, only the first vector is a period to move along.

    >>> tile = np.random.default_rng(0).integers(0, 255, (12, 10, 1), np.uint8)
    >>> found = rectified(np.tile(tile, (4, 4, 1)), (10, 0, 0, 12), 2)
    >>> bool((found == np.arange(48 * 40).reshape(48, 40)).all())  # it is regular
    True
    """
    x1, y1, x2, y2 = vectors
    height, width = pixels.shape[:2]
    side = round(abs(x1 * y2 - x2 * y1) ** 0.5 / 6)
    radius = min(max(side, _NEAREST), _FARTHEST)
    steps = range(-reach, reach + 1)
    shifts = sorted(
        ((a, b) for a in steps for b in steps), key=lambda s: (s[0] ** 2 + s[1] ** 2, s)
    )
    if by_rows:
        length = float(np.hypot(x1, y1))
        along = [(round(n * y1 / length), round(n * x1 / length)) for n in steps]
        shifts = sorted(set(along), key=lambda s: (s[0] ** 2 + s[1] ** 2, s))
    place = np.indices((height, width))
    moved = np.zeros((2, height, width), np.int64)
    sample = pixels.astype(np.int32)
    for _ in range(_ROUNDS):
        y, x = np.clip(place + moved, 0, np.array([height - 1, width - 1])[:, None, None])
        tile = MeanTile(pixels[y, x], vectors).at(*place).astype(np.int32)
        moved = _moved(sample, tile, shifts, radius)
    y, x = np.clip(place + moved, 0, np.array([height - 1, width - 1])[:, None, None])
    result: NDArray[np.int32] = (y * width + x).astype(np.int32)
    return result


def _moved(
    sample: NDArray[np.int32], tile: NDArray[np.int32], shifts: list[tuple[int, int]], radius: int
) -> NDArray[np.int64]:
    """The best shift of each pixel, smoothed with its advantage over the mean shift as weight."""
    height, width = sample.shape[:2]
    grid = [np.arange(0, n + _GRID - 1, _GRID).clip(max=n - 1) for n in (height, width)]
    area = _sums(np.ones((height, width), np.uint32), grid, radius)
    best = np.full(area.shape, np.iinfo(np.int64).max)
    found = np.zeros((2, *area.shape), np.int64)
    total, still = np.zeros(area.shape, np.int64), area
    rows, columns = np.arange(height), np.arange(width)
    for dy, dx in shifts:
        lines = sample[(rows + dy).clip(0, height - 1)]
        error = lines[:, (columns + dx).clip(0, width - 1)] - tile
        error *= error
        mean = _sums(error.sum(axis=2).astype(np.uint32), grid, radius) // area
        total += mean
        still = mean if (dy, dx) == (0, 0) else still
        better = mean < best
        best[better] = mean[better]
        found[:, better] = np.array([[dy], [dx]])
    found[:, best * _GAIN[1] > still * _GAIN[0]] = 0
    sure = total // len(shifts) - best
    around = max(2, radius // 2)
    weight = _even(sure, around)
    moved = []
    for k in (0, 1):
        evened = _even(sure * found[k], around) / np.maximum(weight, 1)
        for axis, n in enumerate((height, width)):  # linear between the places of the grid
            at = np.arange(n)
            low = at // _GRID
            high = np.minimum(low + 1, evened.shape[axis] - 1)
            part = ((at % _GRID) / _GRID).reshape((-1, 1) if axis == 0 else (1, -1))
            evened = np.take(evened, low, axis) * (1 - part) + np.take(evened, high, axis) * part
        moved.append(np.rint(evened).astype(np.int64))
    return np.stack(moved)


def _sums(
    values: NDArray[np.uint32], grid: list[NDArray[np.int64]], radius: int
) -> NDArray[np.int64]:
    """Sums over the box around each place of the grid, clipped to the picture."""
    for axis, at in enumerate(grid):
        values = sums_along(values, axis, at - radius, at + radius + 1)
    return values.astype(np.int64)


def _even(values: NDArray[np.int64], radius: int) -> NDArray[np.int64]:
    """Sums over boxes, twice; exact, since they are integers."""
    return extended_sums(extended_sums(values, radius), radius)
