"""Rows of a sample, such as boards: whether they keep a color each, and one map of them.

Joints run through a whole picture, so each of its lines shows one line of the sample. A map says
which: whole rows of the sample, from joint to joint, in an order that is drawn.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import MOST_STRETCHED, CanvasLattice
from weftex.analysis.relief import LOOK
from weftex.canvas import MAX_PIXELS, MOST_WRAPPED, Canvas
from weftex.random import draw
from weftex.raster.arrays import Bytes, Floats, Ints
from weftex.raster.boxes import centered_sums, sums_along

_SLANT = 0.1  # of rows that are still taken for level, or upright
_SHARE = (2, 5)  # 2/5, in integers: least share of the variance of colors; boards 0.5 to 0.8
_JOINT = 12  # of a row's height, over which a joint is looked for
_WIDE = 2  # lines at either side of a joint over which its steps in tone are added up
_HIGHEST, _STEP = 8, 0.35  # of the mean of that many highest steps, that a joint must have
_MOST = 16  # rows of a sample
_BORDER = 3  # lines at a border of the sample, in which no joint is looked for
_ACROSS = 0.5  # least share of a joint along which something changes, as nothing does beside icons
#: Least share of a step that is the same along the whole joint, as stones have up to 0.55; and if
#: rows of one distance are found, as bricks have up to 0.88.
_THROUGH = (0.6, 0.9)
_NEAR = 10  # lines at either side of joints that are compared
_ALIGNED = 4  # lines by which one of two joints is shifted to match the other
_NEVER = 1e9  # a cost
_TRIES, _STEPS = 24, 64  # orders of rows that are compared; rows from which what is drawn repeats
_STRAINED = 2.0  # cost of a map whose size is off by all of the output's
_SAME, _AGAIN, _PAIR, _DRAWN = 0.5, 0.6, 0.5, 0.3  # costs of repeats, and of what is drawn
#: Whole rows up to which those cut by the border count; their least height over the mean, and cost.
_FEW, _PART, _PARTIAL = 2, 0.55, 0.2

Band = tuple[int, int, int]  # lines of an output: from, to (excluded), the first's of the sample


class ColoredRows(NamedTuple):
    """The rows of a sample whose rows keep a color each."""

    axis: int  # along which they change: 0 where they lie, 1 where they stand
    height: float  # pixels
    joint: int  # where the first one ends, along the axis

    def division(self, size: int, height: float | None = None) -> tuple[int, int]:
        """How many rows a block no larger than `size` has, and how many blocks share a row.

        One of the two is 1. On a canvas that wraps rows have another `height`.

        >>> ColoredRows(0, 8.0, 0).division(20), ColoredRows(0, 50.0, 0).division(20)
        ((2, 1), (1, 3))
        """
        height = height or self.height
        return max(1, int(size / height + 1e-9)), math.ceil(height / size - 1e-9)


def find_colored_rows(pixels: Bytes, vectors: tuple[float, ...]) -> ColoredRows | None:
    """Find rows that keep a color each; None if rows are slanted or of mixed colors.

    The first of the vectors x1, y1, x2, y2 leads from row to row.

    >>> boards = np.repeat(np.uint8([90, 120, 100, 140, 95, 130]), 8)
    >>> boards[4::8] = 30
    >>> find_colored_rows(np.tile(boards, (48, 1))[..., None], (8, 0, 0, 7))
    ColoredRows(axis=1, height=8, joint=4)
    """
    x, y = abs(vectors[0]), abs(vectors[1])
    if min(x, y) > _SLANT * max(x, y):
        return None
    axis, period = (0 if y > x else 1), round(max(x, y))
    rest = np.moveaxis(pixels.astype(np.int64) - mean_tiles(pixels, vectors), axis, 0)
    # Colors of boxes as long as rows are high, or half the sample, and half as high.
    high, period = max(1, period // 2), min(period, rest.shape[1] // 2)
    count = rest.shape[1] // max(1, period)
    if count < 2 or len(rest) < high:
        return None
    parts = rest[:, : count * period].reshape(len(rest), count, period, -1).sum(axis=2)
    first = np.arange(len(parts) - high + 1)
    parts = sums_along(parts, 0, first, first + high)
    whole = parts.sum(axis=(0, 1)) ** 2
    rows = (parts.sum(axis=1) ** 2).sum(axis=0) * len(parts) - whole
    total = (parts**2).sum(axis=(0, 1)) * len(parts) * count - whole
    if total.sum() > 0 and _SHARE[1] * int(rows.sum()) >= _SHARE[0] * int(total.sum()):
        return ColoredRows(axis, max(x, y), _first_joint(pixels, max(x, y), axis))
    return None


def mean_tiles(pixels: Bytes, vectors: tuple[float, ...]) -> Bytes:
    """Replace each pixel by the mean of all at its place of the tile, to about a pixel."""
    lattice = CanvasLattice(vectors)
    sides = [max(1, round(float(np.hypot(*v)))) for v in lattice.sample]
    y, x = np.indices(pixels.shape[:2])
    cell = lattice.cell(y, x, sides)
    flat, count = cell.ravel(), np.bincount(cell.ravel())
    total = np.stack([np.bincount(flat, c.ravel()) for c in np.moveaxis(pixels, 2, 0)], axis=1)
    mean: Bytes = np.rint(total / np.maximum(count, 1)[:, None]).astype(np.uint8)
    return mean[cell]


def _first_joint(pixels: Bytes, period: float, axis: int) -> int:
    """Return the line, within one period, where all rows look most alike, as in joints."""
    lines = np.moveaxis(pixels, axis, 0).sum(axis=1, dtype=np.int64)
    at = np.arange(len(lines))
    place = np.floor(at - np.floor(at / period) * period).astype(np.int64)
    count = np.bincount(place)
    variance = np.zeros(len(count), np.int64)
    for line in lines.T:
        total, squares = (np.bincount(place, k).astype(np.int64) for k in (line, line**2))
        variance += (squares * count - total**2) // count**2
    near = max(0, round(period / _JOINT) // 2)
    around = np.stack([np.roll(variance, k) for k in range(-near, near + 1)]).sum(axis=0)
    return int(around.argmin())


class RowMap(NamedTuple):
    """Which line of a sample each line of an output shows."""

    axis: int  # across the rows: 0 where they lie, 1 where they stand
    wraps: bool  # whether the last row leads to the first
    bands: list[Band]
    unit: int  # pixels, see `unit_of`

    def band(self, pixel: tuple[int, int]) -> Band:
        """The band of lines that a pixel of the output lies in."""
        return next(band for band in self.bands if pixel[self.axis] < band[1])

    def sources(self, pixel: tuple[int, int], off: int) -> slice:
        """The lines of the sample that the pixel may show, up to `off` units off its own."""
        start, _, source = self.band(pixel)
        line, off = source + pixel[self.axis] - start, off * self.unit
        return slice(max(line - off, 0), line + off + 1)

    def limits(self, pixel: tuple[int, int], over: int) -> tuple[int, int, bool]:
        """Return start and end, `over` units beyond a pixel's band, and if all lines wrap."""
        (start, end, _), size = self.band(pixel), self.bands[-1][1]
        start, end = start - over * self.unit, end + over * self.unit
        if not self.wraps:
            return max(start, 0), min(end, size), False
        return (start, end, False) if end - start <= MOST_WRAPPED * size else (0, size, True)


class Boards:
    """The rows of a sample uint8 (H, W, K), from joint to joint, that lie across an axis."""

    def __init__(self, pixels: Bytes, axis: int) -> None:
        self.axis, height, unit = axis, pixels.shape[axis], unit_of(pixels)
        lines = np.ascontiguousarray(np.moveaxis(pixels, 2, 0)).swapaxes(1, axis + 1)
        tones, at = lines.sum(axis=2, dtype=np.int64).T, np.arange(height - unit + 1)
        self.unit, self._tones = unit, centered_sums(tones, unit // 2, (0,)).astype(np.int64)
        # Joints: lines with the largest steps in tone that all columns have in `common`.
        blocks = lines[:, :, lines.shape[2] % unit :].reshape(len(lines), height, -1, unit)
        means = sums_along(blocks.sum(axis=3, dtype=np.int64), 1, at, at + unit)
        steps = means[:, unit:] - means[:, :-unit]
        parts = [abs(steps.sum(axis=2)).T, abs(steps).sum(axis=2).T]
        both = np.pad(parts, ((0, 0), (unit, unit), (0, 0)))
        common, every = centered_sums(both.sum(axis=2), _WIDE * unit, (1,))
        least, found = _STEP * np.sort(common)[-_HIGHEST * unit :].mean(), list[int]()
        for k in np.argsort(-common, kind="stable").tolist():
            if common[k] >= least and all(abs(k - one) * _MOST >= height for one in found):
                found.append(k)
        found = [k for k in found if _BORDER * unit <= k <= height - _BORDER * unit]
        moved, near = np.pad((steps != 0).any(axis=0), ((unit, unit), (0, 0))), _WIDE * unit
        found = [k for k in found if moved[k - near : k + near].any(axis=0).mean() >= _ACROSS]
        self._steps, self.edges = both[1, 1:], np.array([0, *sorted(found), height])
        #: The share of the steps at joints that all columns have.
        share = common[found].sum() / max(every[found].sum(), 1)
        self.through = float(share) if len(found) > 1 else 0.0

    def _jumps(self) -> tuple[Floats, Ints]:
        """Return the costs of showing row b after the joint a, and by how much b is shifted.

        The tones of lines, less slow changes, and their steps are compared around both joints.
        """
        height, tones = len(self._tones), self._tones
        near, most = _NEAR * self.unit, _ALIGNED * self.unit
        slow, count = (centered_sums(a, near, (0,)) for a in (tones, np.ones_like(tones)))
        looks = np.concatenate([tones - (slow // count).astype(np.int64), self._steps], axis=1)
        away, shifts = np.arange(-near, near, self.unit), np.arange(-most, most + 1)
        starts = self.edges[:, None] + shifts
        first, second = self.edges[:, None, None, None] + away, starts[..., None] + away
        known = (np.minimum(first, second) >= 0) & (np.maximum(first, second) < height)
        first, second = (np.clip(one, 0, height - 1) for one in (first, second))
        weights = known * (2 * near - abs(2 * away + self.unit))
        apart = (np.square(looks[first] - looks[second]).sum(axis=-1) * weights).sum(axis=-1)
        usual = np.square(looks - looks.sum(axis=0) // height).sum() / height
        cost = apart / np.maximum(weights.sum(axis=-1), 1) / max(usual, 1)
        outside = (starts < 0) | (starts >= np.append(self.edges[1:], 0)[:, None])
        cost[outside | (known.sum(axis=-1) < _NEAR)] = _NEVER
        cost[-1, :, 1:] = _NEVER  # after a row that the border cuts, all of the next joint
        best = cost.argmin(axis=-1)
        cost, shift = np.take_along_axis(cost, best[..., None], -1)[..., 0], shifts[best]
        cost[-1, 0] = _NEVER  # without a joint
        np.fill_diagonal(cost, 0.0)  # as in the sample
        np.fill_diagonal(shift, 0)
        return cost, shift

    def fitted(self, canvas: Canvas, seed: int) -> Canvas:
        """Return a canvas of nearly this size that whole rows close around, if there is one."""
        wraps = canvas.kinds == ("wrap",)
        found = self.row_map(canvas, seed, MOST_STRETCHED / 2) if wraps else None
        if found is None:
            return canvas
        sides = [found.bands[-1][1] if k == self.axis else n for k, n in enumerate(canvas.shape)]
        return Canvas(sides[0], sides[1], canvas.wrap)

    def row_map(self, canvas: Canvas, seed: int, strain: float = 0.0) -> RowMap | None:
        """Return a map of rows for an output, the cheapest of several that are drawn.

        If it wraps the last row leads to the first, in its size or one that differs by a share,
        `strain`; None if that is so in no map.
        """
        size, jumps, count = canvas.shape[self.axis], self._jumps(), len(self.edges) - 1
        off = strain * size if canvas.wrap[self.axis] else None
        drawn = draw(seed, "rows", *np.ogrid[:_TRIES, :_STEPS, :count]) >> np.uint64(32)
        found = [x for one in drawn.astype(np.int64) for x in self._maps(size, off, one, *jumps)]
        return RowMap(self.axis, off is not None, min(found)[1], self.unit) if found else None

    def _maps(
        self, size: int, off: float | None, drawn: Ints, costs: Floats, shifts: Ints
    ) -> Iterator[tuple[float, list[Band]]]:
        """Yield what each row of a map costs on average, and the map.

        There is one map or, if a size that is `off` by this much closes, one for each such size.
        """
        edges, heights = self.edges.tolist(), np.diff(self.edges)
        # The sample's border cuts the first and the last row.
        few = len(heights) <= _FEW + 2
        own = np.where(few & (heights >= _PART * heights[1:-1].mean()), _PARTIAL, _NEVER)
        own[1:-1] = 0.0
        jumps, costs, total, bands = costs, costs.copy(), 0.0, list[Band]()
        shown: list[tuple[int, int]] = []
        y, source = 0, int(drawn[0, 0]) % min(edges[-1] // 3, edges[-2])
        row = int(np.searchsorted(edges, source, side="right")) - 1
        if off is not None:
            row = int((own + _DRAWN * (drawn[0] / 2**32)).argmin())
            source = edges[row]
        first, most = row, size if off is None else size + off + _ALIGNED * self.unit + 1
        while (end := y + edges[row + 1] - source) < most:
            bands.append((y, end, source))
            shown.append((row, y))
            y, before = end, row + 1
            if off is not None:
                # The first row is shifted to match the last, and all others with it.
                begin = max(0, edges[first] + int(shifts[before, first]))
                shift = edges[first] - begin
                joint = jumps[before, first] + (_SAME if row == first else 0.0)
                if (over := abs(y + shift - size)) <= off and joint < _NEVER:
                    closed = [(a + shift, b + shift, c) for a, b, c in bands]
                    closed[0] = (0, closed[0][1], begin)
                    yield float(total + joint) / len(bands) + _STRAINED * over / size, closed
            options = costs[before, :-1] + own
            options[row] += _SAME
            for one, at in shown:
                options[one] += max(0.0, _AGAIN * (1 - (y - at) / (2 * edges[-1])))
            row = int((options + _DRAWN * (drawn[len(bands) % _STEPS] / 2**32)).argmin())
            total += float(options[row])
            costs[before, row] += _PAIR
            source = max(0, edges[row] + int(shifts[before, row]))
        if off is None:
            yield total / (len(bands) + 1), [*bands, (y, size, source)]


def unit_of(pixels: Bytes) -> int:
    """Return how many times larger than what `auto` analyzes a sample is; lengths here grow so."""
    height, width = pixels.shape[:2]
    return int(max(1, min(-(-max(height, width) // LOOK), min(height, width) // (2 * _NEAR))))


def find_boards(pixels: Bytes, even: bool = False) -> Boards | None:
    """Find rows whose joints run through a sample uint8 (H, W, K); `even`: rows of one height."""
    found = max((Boards(pixels, axis) for axis in (0, 1)), key=lambda one: one.through)
    return found if found.through >= _THROUGH[even] else None


def rows_around(
    pixels: Bytes, usable: NDArray[Any], canvas: Canvas, even: bool = False
) -> RowMap | None:
    """Return a map that continues rows across holes, if joints run through the photo one way."""
    if canvas.known_from is None or any(canvas.wrap):
        return None
    through, unit = [], unit_of(pixels)
    border = min(_BORDER * unit, min(usable.shape) // 4)  # which may be a frame
    inner = tuple(slice(border, n - border) for n in usable.shape)
    pixels, usable = pixels[inner], usable[inner]
    for axis in (0, 1):
        whole = np.asarray(usable.all(axis=axis))  # lines across the rows that miss all holes
        through.append(0.0)
        if 2 * whole.sum() >= len(whole):
            rows = Boards(np.compress(whole, pixels, axis=1 - axis), axis)
            through[axis] = rows.through if len(rows.edges) > _FEW + 2 else 0.0
    axis = through.index(max(through))
    found = RowMap(axis, False, [(0, MAX_PIXELS, canvas.known_from[axis])], unit)
    return found if min(through) < _THROUGH[0] and max(through) >= _THROUGH[even] else None
