"""A sample prepared for near-regular synthesis: whole windows, similar windows, borders."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.exemplar import Exemplar
from weftex.methods.lattices.mean_tile import MeanTile
from weftex.methods.near_regular.defaults import vectors_around
from weftex.methods.near_regular.rectification import rectified
from weftex.methods.near_regular.rows import Courses, axis_of_rows, courses_of
from weftex.random import draw
from weftex.search.picture_kernels import Sample
from weftex.search.windows import Windows, windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SOFT = 40  # squared difference of a channel, two pixels apart, that halves the visibility


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
