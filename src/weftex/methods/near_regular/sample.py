"""A sample prepared for near-regular synthesis: whole windows, similar places, borders."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.exemplar import Exemplar
from weftex.methods.lattices.mean_tile import MeanTile
from weftex.methods.near_regular.rectification import rectified
from weftex.methods.near_regular.rows import Courses, axis_of_rows, courses_of
from weftex.random import draw
from weftex.search.boundary_zone import boundary_zone, runs_over
from weftex.search.quadtree_pyramid import QuadtreePyramid
from weftex.search.windows import Windows, windows_of
from weftex.search.zone_search import ZoneSearch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.near_regular.settings import Settings

_BLOCK_SIDE = 16  # of the low resolution that unconstrained gaps are looked for by
_NUMBERS = 288  # that describe a border there, at most
_VARIANCE = 0.97  # of borders, that is kept there
_SOFT = 40  # squared difference of a channel, two pixels apart, that hides half of a seam


class Border(NamedTuple):
    """The pixels of a gap's window that must match.

    Attributes
    ----------
    wedges : uint8 array (rows, columns)
        From which neighbor: 1 to 4 for above, left, below and right, 0 off the border.
    runs : int32 array (n, 4)
        The border as runs of pixels, as in `BoundaryZone`.
    """

    wedges: NDArray[np.uint8]
    runs: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class BlockSample:
    """All that outputs of one sample have in common.

    Attributes
    ----------
    exemplar : Exemplar
        The sample.
    windows : Windows
        Its bytes, and the upper left corners of blocks' windows.
    lookup : int32 array (H, W) or None
        Which pixel of the sample is at each place, if it was rectified.
    pixels : uint8 array (H', W', K)
        The windows' pixels, rectified.
    turned : uint8 array (W', H', K)
        The same with their axes exchanged.
    visibility : uint16 array (H', W')
        How much a seam shows at each of them.
    steps : int64 array (n, 2)
        Sums of multiples of the vectors in 1/65536 pixel, shuffled, so that the first that will do
        is a random one; none if any place is similar to any other.
    multiples : int64 array (n,)
        The multiple of the first vector in each of them.
    row_axis : int or None
        Along which axis rows change that have a color each, see `axis_of_rows`.
    courses : (Courses or None, Courses or None)
        The rows that blocks keep to along both axes, see `Axis`.
    search : ZoneSearch or None
        All windows by their borders, where any place is similar to any other.
    """

    exemplar: Exemplar
    windows: Windows
    lookup: NDArray[np.int32] | None
    pixels: NDArray[np.uint8]
    turned: NDArray[np.uint8]
    visibility: NDArray[np.uint16]
    steps: NDArray[np.int64]
    multiples: NDArray[np.int64]
    row_axis: int | None
    courses: tuple[Courses | None, ...]
    search: ZoneSearch | None
    _borders: dict[tuple[int, ...], Border] = field(default_factory=dict, repr=False)

    def border(self, height: int, width: int, margin: int, reach: int) -> Border:
        """The border of gaps of one size, see `wedges_of`."""
        key = height, width, margin, reach
        if key not in self._borders:
            wedges = wedges_of(*key)
            self._borders[key] = Border(wedges, shuffled(runs_over(wedges > 0)))
        return self._borders[key]


def prepare(settings: Settings, exemplar: Exemplar) -> BlockSample:
    """Analyze a sample: its windows, rectified pixels and similar places."""
    vectors = settings.lattice
    windows = _windows(settings, exemplar)
    pixels, lookup = windows.pixels, None
    if settings.rectify:
        lookup = rectified(pixels, vectors, settings.rectify, by_rows=settings.by_rows)
        flat = pixels.reshape(-1, pixels.shape[2])
        pixels = np.ascontiguousarray(flat[lookup])
    steps, search = np.zeros((0, 2), np.int64), None
    multiples, row_axis = np.zeros(0, np.int64), None
    courses: list[Courses | None] = [None, None]
    if settings.unconstrained:
        search = _search(settings, pixels, windows)
    else:
        lattice = CanvasLattice(vectors)
        steps = lattice.steps(*exemplar.shape)
        order = np.argsort(draw(0, "steps", np.arange(len(steps))), kind="stable")
        steps = np.ascontiguousarray(steps[order])
        multiples = np.rint(steps @ lattice.inverse[:, 0] / 65536).astype(np.int64)
        if settings.by_rows and exemplar.mask is None:
            row_axis = axis_of_rows(pixels, vectors)
        if row_axis is not None:
            courses[row_axis] = courses_of(pixels, vectors, row_axis)
    return BlockSample(
        exemplar=exemplar,
        windows=windows,
        lookup=lookup,
        pixels=pixels,
        turned=np.ascontiguousarray(pixels.transpose(1, 0, 2)),
        visibility=visibility(pixels, settings.seam_cost == "gradient"),
        steps=steps,
        multiples=multiples,
        row_axis=row_axis,
        courses=tuple(courses),
        search=search,
    )


def _windows(settings: Settings, exemplar: Exemplar) -> Windows:
    if exemplar.tileable and not settings.tiles:
        exemplar = exemplar.changed(tileable=False)
    return windows_of(exemplar, (0, settings.side - 1, 0, settings.side - 1))


def _search(settings: Settings, pixels: NDArray[np.uint8], windows: Windows) -> ZoneSearch:
    """All windows, to be searched by the border of a gap (section 5.2)."""
    size, margin = settings.block_size, settings.margin
    zone = boundary_zone(
        wedges_of(size, size, margin, margin) > 0,
        max(1, 2 * margin),
        block_side=_BLOCK_SIDE,
        most_blocks=max(16, _NUMBERS // pixels.shape[2]),
    )
    rows, columns = (n - settings.side + 1 for n in pixels.shape[:2])
    usable = np.ascontiguousarray(windows.usable[:rows, :columns])
    return ZoneSearch(
        zone,
        QuadtreePyramid(pixels),
        usable,
        np.flatnonzero(usable).astype(np.int32),
        search="pca",
        candidates=settings.candidates,
        variance=_VARIANCE,
        often=True,
    )


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


def shuffled(runs: NDArray[np.int32]) -> NDArray[np.int32]:
    """Shuffle runs, so that a few of them lie all around and bad fits soon show."""
    order = np.argsort(draw(0, "runs", np.arange(len(runs))), kind="stable")
    return np.ascontiguousarray(runs[order])


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
    wide = np.pad(pixels.astype(np.int32), ((1, 1), (1, 1), (0, 0)), mode="edge")
    steep = (wide[2:, 1:-1] - wide[:-2, 1:-1]) ** 2
    steep += (wide[1:-1, 2:] - wide[1:-1, :-2]) ** 2
    soft = _SOFT * pixels.shape[2]
    shown = np.maximum(4096 * soft // (soft + steep.sum(axis=2)), 1)
    result: NDArray[np.uint16] = shown.astype(np.uint16)
    return result


def blockiness(settings: Settings, pixels: NDArray[np.uint8]) -> float:
    """Measure how much of the difference of similar places is brightness and color of whole blocks.

    From 0 to 1. Where it is high, blocks beside each other show (Fig. 5.12).
    """
    side = max(1, settings.side // 2)
    rest = pixels.astype(np.int64)
    if not settings.unconstrained:
        rest -= MeanTile(pixels, settings.lattice).at(*np.indices(pixels.shape[:2]))
    rows, columns = (n // side for n in rest.shape[:2])
    parts = rest[: rows * side, : columns * side].reshape(rows, side, columns, side, -1)
    means = parts.mean(axis=(1, 3))
    whole = float(parts.var(axis=(0, 1, 2, 3)).sum())
    return float(means.var(axis=(0, 1)).sum()) / whole if whole > 0 else 0.0
