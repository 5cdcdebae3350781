"""A sample prepared for near-regular synthesis: whole windows, similar places, borders."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.methods.lattices.canvas_lattice import CanvasLattice
from weftex.methods.lattices.mean_tile import MeanTile
from weftex.methods.near_regular.rectification import rectified
from weftex.methods.near_regular.rows import axis_of_rows, pitch_of_rows
from weftex.random import draw
from weftex.search.boundary_zone import boundary_zone
from weftex.search.pca import fit_pca
from weftex.search.quadtree_pyramid import QuadtreePyramid
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.near_regular import NearRegular
    from weftex.search.windows import Windows

_STRAIN = 0.02  # of a sample that tiles; past it the border is not gone over
_FREE = 4.0  # pixels of a tile so small that any place is similar
_BLOCK_SIDE = 16  # of the low resolution that unconstrained gaps are looked for by
_NUMBERS = 288  # that describe a border there, at most
_WINDOWS = 16384  # that the unconstrained search looks at; more are thinned out
_BLOCKY = 0.15  # share of brightness in what similar places differ by, from which blocks show
_CELL = 1.5  # pixels; a tile is cut into such parts to see whether all of them are there
_SOFT = 40  # squared difference of a channel, two pixels apart, that hides half of a seam
_WIDE = 0.7  # of a block that is feathered then


@dataclass(frozen=True, eq=False)
class Border:
    """The pixels of a gap's window that must match.

    Attributes
    ----------
    wedges : uint8 array (rows, columns)
        From which neighbour: 1 to 4 for above, left, below and right, 0 off the border.
    runs : int32 array (n, 4)
        The border as runs of pixels, as in `BoundaryZone`.
    """

    wedges: NDArray[np.uint8]
    runs: NDArray[np.int32]


def wedges_of(height: int, width: int, margin: int, reach: int) -> NDArray[np.uint8]:
    """Wedge-shaped borders (Fig. 4.8b) of a block's window, see `Border`.

    Parameters
    ----------
    height, width : int
        Of the block.
    margin : int
        How far the window reaches beyond it.
    reach : int
        Half the width of the border.

    Examples
    --------
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


class BlockSample:
    """What all outputs of one sample have in common.

    Attributes
    ----------
    method : NearRegular
        With everything settled.
    vectors : tuple of float
        The lattice; stretched a little if the sample tiles, so that it goes around.
    margin : int
        How far a block's window reaches beyond it.
    windows : Windows
        The sample, and the upper left corners of windows.
    free : bool
        There is no lattice: any place is similar to any other.
    pixels : uint8 array (H', W', K)
        The windows' pixels, moved to where the lattice wants them.
    visibility : uint16 array (H', W')
        How much a seam shows at each of them.
    """

    def __init__(self, method: NearRegular, exemplar: Exemplar, rows: bool) -> None:
        assert method.lattice is not None
        assert method.block_size is not None and method.border_width is not None
        self.exemplar, self.vectors = exemplar, method.lattice
        self.margin = method.border_width // 2
        self.side = method.block_size + 2 * self.margin
        x1, y1, x2, y2 = self.vectors
        self.free = abs(x1 * y2 - x2 * y1) < _FREE
        self.windows = self._windows(exemplar)
        self.pixels = self.windows.pixels
        #: Which pixel of the sample is at each place, if they were moved.
        self.lookup: NDArray[np.int32] | None = None
        if (
            method.rectify
            and not self.free
            and exemplar.mask is None
            and not self.windows.period[2]
        ):
            self.lookup = rectified(self.pixels, self.vectors, method.rectify, rows=rows)
            flat = self.pixels.reshape(-1, self.pixels.shape[2])
            self.pixels = np.ascontiguousarray(flat[self.lookup])
        self.visibility = visibility(self.pixels, method.seam_cost == "gradient")
        self.turned = np.ascontiguousarray(self.pixels.transpose(1, 0, 2))
        if method.blend_width is None and method.blend == "feather":
            wide = method.preset != "paper" and self.blockiness() > _BLOCKY
            method = replace(method, blend_width=round(_WIDE * method.block_size) if wide else 4)
        self.method = method
        self._borders: dict[tuple[int, int, int], Border] = {}
        self.steps = np.zeros((0, 2), np.int64)
        #: Along which axis rows change that have a colour each, see `axis_of_rows`.
        self.row_axis: int | None = None
        #: How blocks are laid along both axes, see `Axis`.
        self.pitch: list[tuple[int, int] | None] = [None, None]
        self.search: Any = NO_SEARCH
        if self.free:
            self.search = self._features()
            return
        lattice = CanvasLattice(self.vectors)
        steps = lattice.steps(*exemplar.shape)
        # In no order, so that the first that will do is any of them.
        order = np.argsort(draw(0, "steps", np.arange(len(steps))), kind="stable")
        self.steps = np.ascontiguousarray(steps[order])
        #: The multiple of the first vector in each of them.
        self.rows = np.rint(self.steps @ lattice.inverse[:, 0] / 65536).astype(np.int64)
        size = self.side - 2 * self.margin
        # Blocks must hold a whole row.
        if rows and exemplar.mask is None and size >= float(np.hypot(x1, y1)):
            self.row_axis = axis_of_rows(self.pixels, self.vectors)
        if self.row_axis is not None:
            about = self.pixels, self.vectors, self.row_axis, size
            self.pitch[self.row_axis] = pitch_of_rows(*about)

    def _windows(self, exemplar: Exemplar) -> Windows:
        if exemplar.tileable:
            from weftex.canvas import Canvas

            canvas = Canvas(*exemplar.shape, (True, True))
            lattice = CanvasLattice(self.vectors, canvas)
            if lattice.strain <= _STRAIN:
                (y1, x1), (y2, x2) = lattice.canvas.tolist()
                self.vectors = (x1, y1, x2, y2)
                return windows_of(exemplar, (0, self.side - 1, 0, self.side - 1))
            from weftex.exemplar import Exemplar as Plain

            exemplar = Plain(
                exemplar.pixels,
                maps=exemplar.maps,
                mask=exemplar.mask,
                alpha=exemplar.alpha,
                name=exemplar.name,
            )
        return windows_of(exemplar, (0, self.side - 1, 0, self.side - 1))

    def mean_tile(self) -> NDArray[np.uint8]:
        """The sample with every pixel replaced by the mean of its similar ones."""
        return MeanTile(self.pixels, self.vectors).at(*np.indices(self.pixels.shape[:2]))

    def blockiness(self) -> float:
        """How much of what similar places differ by is brightness and colour of whole blocks.

        From 0 to 1. Where it is high, blocks beside each other show (Fig. 5.12).
        """
        side = max(1, self.side // 2)
        levels = self.pixels.astype(np.int64)
        rest = levels if self.free else levels - self.mean_tile()
        rows, columns = (n // side for n in rest.shape[:2])
        parts = rest[: rows * side, : columns * side].reshape(rows, side, columns, side, -1)
        means = parts.mean(axis=(1, 3))
        whole = float(parts.var(axis=(0, 1, 2, 3)).sum())
        return float(means.var(axis=(0, 1)).sum()) / whole if whole > 0 else 0.0

    def border(self, height: int, width: int, reach: int) -> Border:
        """The border of gaps of one size, which reaches so far to either side of their edges."""
        key = height, width, reach
        if key not in self._borders:
            wedges = wedges_of(height, width, self.margin, reach)
            self._borders[key] = Border(wedges, in_no_order(self.zone(wedges).runs))
        return self._borders[key]

    def zone(self, wedges: NDArray[np.uint8], block_side: int = 4) -> Any:
        """The border as what a search looks at."""
        most = max(16, _NUMBERS // self.pixels.shape[2])
        return boundary_zone(
            wedges > 0, max(1, 2 * self.margin), block_side=block_side, most_blocks=most
        )

    def _features(self) -> Any:
        """All windows' borders in few numbers, for the unconstrained search (section 5.2)."""
        size = self.side - 2 * self.margin
        zone = self.zone(wedges_of(size, size, self.margin, self.margin), _BLOCK_SIDE)
        height, width = self.pixels.shape[:2]
        rows, columns = height - self.side + 1, width - self.side + 1
        stride = 1
        while stride * 2 <= zone.side and rows * columns > _WINDOWS * stride**2:
            stride *= 2
        usable = self.windows.usable[:rows:stride, :columns:stride]
        take = np.flatnonzero(usable)
        if zone.area == 0 or len(take) == 0:
            return NO_SEARCH
        pyramid = QuadtreePyramid(self.pixels)
        windows = pyramid.windows(zone.blocks, zone.side, stride, *usable.shape)
        pca = fit_pca(np.ascontiguousarray(windows[:, take]), 0.97)
        y, x = np.divmod(take, usable.shape[1])
        places = (y * stride * width + x * stride).astype(np.int32)
        return zone.blocks, zone.side, pca.basis, pca.offset, pca.shift, pca.features, places


def visibility(pixels: NDArray[np.uint8], gradient: bool) -> NDArray[np.uint16]:
    """How much a seam shows at each pixel, for 1 at least; everywhere alike unless by `gradient`.

    Where the sample has an edge of its own, such as a joint, one more does not show.

    Examples
    --------
    >>> step = np.array([[[10], [10], [10], [90], [90]]], np.uint8)
    >>> visibility(step, gradient=True).tolist()
    [[4096, 4096, 25, 25, 4096]]
    """
    if not gradient:
        return np.ones(pixels.shape[:2], np.uint16)
    levels = np.pad(pixels.astype(np.int32), ((1, 1), (1, 1), (0, 0)), mode="edge")
    steep = (levels[2:, 1:-1] - levels[:-2, 1:-1]) ** 2
    steep += (levels[1:-1, 2:] - levels[1:-1, :-2]) ** 2
    soft = _SOFT * pixels.shape[2]
    shown = np.maximum(4096 * soft // (soft + steep.sum(axis=2)), 1)
    result: NDArray[np.uint16] = shown.astype(np.uint16)
    return result


def in_no_order(runs: NDArray[np.int32]) -> NDArray[np.int32]:
    """Put runs in an order in which a few of them are all around, so that bad fits soon show."""
    order = np.argsort(draw(0, "runs", np.arange(len(runs))), kind="stable")
    return np.ascontiguousarray(runs[order])


def has_room(exemplar: Exemplar, side: int, vectors: tuple[float, ...] | None = None) -> bool:
    """Whether a square of this side lies on usable pixels; with vectors, at any place of a tile."""
    if exemplar.mask is None:
        return side <= min(exemplar.shape)
    try:
        windows = windows_of(exemplar, (0, side - 1, 0, side - 1))
    except InvalidInputError:
        return False
    if vectors is None:
        return True
    lattice = CanvasLattice(vectors)
    y, x = np.nonzero(windows.usable)
    cells = [max(1, round(float(np.hypot(*v)) / _CELL)) for v in lattice.sample]
    number = []
    for k in (0, 1):
        along = y * lattice.inverse[0, k] + x * lattice.inverse[1, k]
        number.append(((along - np.floor(along)) * cells[k]).astype(np.int64) % cells[k])
    found = np.unique(number[0] * cells[1] + number[1])
    return len(found) == cells[0] * cells[1]


NO_SEARCH = (
    np.zeros((0, 2), np.int32),
    1,
    np.zeros((1, 1), np.int16),
    np.zeros(1, np.int32),
    0,
    np.zeros((1, 0), np.int16),
    np.zeros(0, np.int32),
)
