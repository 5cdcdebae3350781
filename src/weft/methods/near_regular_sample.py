"""A sample prepared for near-regular synthesis: whole windows, similar places, borders."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from weft.errors import InvalidInputError
from weft.methods.canvas_lattice import CanvasLattice
from weft.methods.mean_tile import MeanTile
from weft.random import draw
from weft.search.boundary_zone import boundary_zone
from weft.search.pca import fit_pca
from weft.search.quadtree_pyramid import QuadtreePyramid
from weft.search.translation import box_sums
from weft.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weft.exemplar import Exemplar
    from weft.methods.near_regular import NearRegular
    from weft.search.windows import Windows

_STRAIN = 0.02  # of a sample that tiles; past it the border is not gone over
_FREE = 4.0  # pixels of a tile so small that any place is similar
_BLOCK_SIDE = 16  # of the low resolution that unconstrained gaps are looked for by
_NUMBERS = 288  # that describe a border there, at most
_WINDOWS = 16384  # that the unconstrained search looks at; more are thinned out
_BLOCKY = 0.5  # share of brightness in what similar places differ by, from which blocks show
_WIDE = 0.7  # of a block that is feathered then


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
    """

    def __init__(self, method: NearRegular, exemplar: Exemplar) -> None:
        assert method.lattice is not None
        assert method.block_size is not None and method.border_width is not None
        self.exemplar, self.vectors = exemplar, method.lattice
        self.margin = method.border_width // 2
        self.side = method.block_size + 2 * self.margin
        x1, y1, x2, y2 = self.vectors
        self.free = abs(x1 * y2 - x2 * y1) < _FREE
        self.windows = self._windows(exemplar)
        self.pixels = self.windows.pixels
        self.turned = np.ascontiguousarray(self.pixels.transpose(1, 0, 2))
        if method.blend_width is None and method.blend == "feather":
            wide = method.preset != "paper" and self.blockiness() > _BLOCKY
            method = replace(method, blend_width=round(_WIDE * method.block_size) if wide else 4)
        self.method = method
        self.steps = np.zeros((0, 2), np.int64)
        self.aligned = np.arange(self.windows.usable.size, dtype=np.int32)
        self.search: Any = _NO_SEARCH
        if self.free:
            self.search = self._features()
            return
        steps = CanvasLattice(self.vectors).steps(*exemplar.shape)
        # In no order, so that the first that will do is any of them.
        order = np.argsort(draw(0, "steps", np.arange(len(steps))), kind="stable")
        self.steps = np.ascontiguousarray(steps[order])
        if method.rectify and exemplar.mask is None:
            self.aligned = self._aligned(method.rectify)

    def _windows(self, exemplar: Exemplar) -> Windows:
        if exemplar.tileable:
            from weft.canvas import Canvas

            canvas = Canvas(*exemplar.shape, (True, True))
            lattice = CanvasLattice(self.vectors, canvas)
            if lattice.strain <= _STRAIN:
                (y1, x1), (y2, x2) = lattice.canvas.tolist()
                self.vectors = (x1, y1, x2, y2)
                return windows_of(exemplar, (0, self.side - 1, 0, self.side - 1))
            from weft.exemplar import Exemplar as Plain

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

    def _aligned(self, reach: int) -> NDArray[np.int32]:
        """For each place the one near by that lies most as the mean tile does there."""
        tile, side = self.mean_tile().astype(np.int32), self.side
        height, width = self.pixels.shape[:2]
        rows, columns = height - side + 1, width - side + 1
        usable = self.windows.usable[:rows, :columns]
        best = np.full((rows, columns), np.iinfo(np.int64).max)
        place = np.arange(self.windows.usable.size, dtype=np.int32).reshape(height, width)
        found = place[:rows, :columns].copy()
        around = range(-reach, reach + 1)
        pixels = self.pixels.astype(np.int32)
        for dy, dx in sorted(((a, b) for a in around for b in around), key=_nearest):
            y, x = max(0, -dy), max(0, -dx)
            h, w = height - abs(dy), width - abs(dx)
            if h < side or w < side:
                continue
            moved = pixels[y + dy : y + dy + h, x + dx : x + dx + w]
            error = ((moved - tile[y : y + h, x : x + w]) ** 2).sum(axis=2)
            error = box_sums(error, side, side)
            here = (slice(y, y + error.shape[0]), slice(x, x + error.shape[1]))
            there = (slice(y + dy, y + dy + error.shape[0]), slice(x + dx, x + dx + error.shape[1]))
            better = (error < best[here]) & (usable[there] > 0)
            best[here][better] = error[better]
            found[here][better] = place[:rows, :columns][there][better]
        place[:rows, :columns] = found
        return np.ascontiguousarray(place.ravel())

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

    def wedges(self, height: int, width: int, reach: int) -> NDArray[np.uint8]:
        """Which neighbour each border pixel of a block's window is taken from (Fig. 4.8b).

        1 to 4 for above, left, below and right, 0 off the border, which reaches so far to either
        side; `height` and `width` are the block's.
        """
        v, u = np.indices((height + 2 * self.margin, width + 2 * self.margin))
        away = np.stack([v, u, v[::-1], u[:, ::-1]]) - (self.margin - reach)
        nearest = away.min(axis=0)
        border = (nearest >= 0) & (nearest < 2 * reach)
        return np.where(border, away.argmin(axis=0) + 1, 0).astype(np.uint8)

    def zone(self, wedges: NDArray[np.uint8], block_side: int = 4) -> Any:
        """The border as what a search looks at."""
        most = max(16, _NUMBERS // self.pixels.shape[2])
        return boundary_zone(
            wedges > 0, max(1, 2 * self.margin), block_side=block_side, most_blocks=most
        )

    def _features(self) -> Any:
        """All windows' borders in few numbers, for the unconstrained search (section 5.2)."""
        size = self.side - 2 * self.margin
        zone = self.zone(self.wedges(size, size, self.margin), _BLOCK_SIDE)
        height, width = self.pixels.shape[:2]
        rows, columns = height - self.side + 1, width - self.side + 1
        stride = 1
        while stride * 2 <= zone.side and rows * columns > _WINDOWS * stride**2:
            stride *= 2
        usable = self.windows.usable[:rows:stride, :columns:stride]
        take = np.flatnonzero(usable)
        if zone.area == 0 or len(take) == 0:
            return _NO_SEARCH
        pyramid = QuadtreePyramid(self.pixels)
        windows = pyramid.windows(zone.blocks, zone.side, stride, *usable.shape)
        pca = fit_pca(np.ascontiguousarray(windows[:, take]), 0.97)
        y, x = np.divmod(take, usable.shape[1])
        places = (y * stride * width + x * stride).astype(np.int32)
        return zone.blocks, zone.side, pca.basis, pca.offset, pca.shift, pca.features, places


def has_room(exemplar: Exemplar, side: int) -> bool:
    """Whether a square of this side lies on usable pixels."""
    if exemplar.mask is None:
        return side <= min(exemplar.shape)
    try:
        windows_of(exemplar, (0, side - 1, 0, side - 1))
    except InvalidInputError:
        return False
    return True


_NO_SEARCH = (
    np.zeros((0, 2), np.int32),
    1,
    np.zeros((1, 1), np.int16),
    np.zeros(1, np.int32),
    0,
    np.zeros((1, 0), np.int16),
    np.zeros(0, np.int32),
)


def _nearest(step: tuple[int, int]) -> tuple[int, int, int]:
    return step[0] ** 2 + step[1] ** 2, *step
