"""A sample prepared for near-regular synthesis: sizes that suit it, and its similar windows."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import (
    CanvasLattice,
    check_lattice,
    found_vectors,
    given_lattice,
)
from weftex.analysis.lattice import Lattice
from weftex.analysis.rows import ColoredRows, find_colored_rows
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError, size_words
from weftex.exemplar import Exemplar
from weftex.random import draw
from weftex.raster.masks import row_runs
from weftex.search.windows import Windows, windows_of

Vectors = tuple[float, ...]

_PAPERS_BLOCK = 40 / 128  # over the sample's shorter side (section 5.1)
_SMALLEST_BLOCK = 0.15  # chosen here, over the same
_WINDOWS = 6.0  # similar windows that a block should have to choose from
_ROWS = 3  # rows to choose from, where nothing else repeats
_TOLERANCE = 3  # px (section 4.2.2)
_PAPERS_BLEND = 4  # px (section 5.2)
_BLEND = 12  # px; wider than the paper's, as a judge liked it better
_STRAIN = 0.02  # of a sample that tiles; past it windows do not cross its border
_CELL = 1.5  # pixels; a tile is cut into such cells to see whether all of them have a window


def resolve(method: Any, exemplar: Exemplar) -> Any:
    """Return a NearRegular whose parameters fit the sample.

    Raises `InvalidInputError` without a lattice, if vectors or blocks do not fit the sample, or if
    a parameter has no effect.
    """
    if method.lattice is not None:
        check_lattice(method.lattice, exemplar)
    vectors = method.lattice or _found(exemplar)
    if is_rows(vectors):  # the one that leads from row to row first
        vectors = tuple(given_lattice(vectors))
    by_rows = is_rows(vectors)
    tolerance = method.tolerance
    if tolerance is None:
        # In a small tile, a few pixels away is another part of it.
        side = float(np.hypot(vectors[0], vectors[1])) if by_rows else _area(vectors) ** 0.5
        paper = method.defaults == "paper"
        tolerance = _TOLERANCE if paper else min(_TOLERANCE, int(side / 4))
    size, border, blend_width = _block(method, exemplar, vectors, by_rows)
    if border == 0 and method.match != "difference":
        raise InvalidInputError("match has no effect without borders; border_width is 0")
    return replace(
        method,
        lattice=vectors_around(vectors, exemplar) or vectors,
        block_size=size,
        border_width=border,
        blend_width=blend_width,
        tolerance=tolerance,
    )


def is_rows(vectors: Vectors) -> bool:
    """Whether the sample repeats from row to row only, and along rows any window is similar."""
    return len(given_lattice(vectors).vectors) == 1


def vectors_around(vectors: Vectors, exemplar: Exemplar) -> Vectors | None:
    """The vectors stretched to wrap around a sample that tiles; None if windows cannot wrap."""
    if exemplar.tileable:
        lattice = CanvasLattice(vectors, Canvas(*exemplar.shape, (True, True)))
        if lattice.strain <= _STRAIN:
            (y1, x1), (y2, x2) = lattice.canvas.tolist()
            return x1, y1, x2, y2
    return None


def check_block(size: int, border: int | None, blend: int | None) -> None:
    """Refuse borders and blends as wide as their block."""
    for name, width in (("border_width", border), ("blend_width", blend)):
        if width is not None and width >= size:
            raise InvalidInputError(f"{name} is {width}; it must be less than the block, {size}")


def margin_of(border: int | None, blend: int | None) -> int:
    """How far a block's window reaches beyond the block: half a border, or half a wider blend."""
    return max(border or 0, (blend or 0) + 1) // 2


def _found(exemplar: Exemplar) -> Vectors:
    """The sample's own vectors, of rows with a second one along them."""
    vectors = found_vectors(exemplar)
    if not vectors:
        raise InvalidInputError(
            f"{exemplar.name} has neither a lattice nor rows; give its translation vectors "
            "(lattice), or use graphcut, which needs none"
        )
    return tuple(Lattice((vectors,))) if len(vectors) == 2 else vectors


def _area(vectors: Vectors) -> float:
    """Pixels of a tile."""
    x1, y1, x2, y2 = vectors
    return abs(x1 * y2 - x2 * y1)


def _block(
    method: Any, exemplar: Exemplar, vectors: Vectors, by_rows: bool
) -> tuple[int, int, int | None]:
    """The side of blocks, the width of borders, and of blends if there are any; checked."""
    paper, shorter = method.defaults == "paper", min(exemplar.shape)
    size, border, blend = method.block_size, method.border_width, method.blend_width
    if size is None and paper:
        size = max(1, int(_PAPERS_BLOCK * shorter))
    elif size is None:
        size = _largest_block(vectors, exemplar, border, blend or 0, by_rows)
    if border is None:
        border = 10 if paper else _border(size)
        border = min(border, (size - 1) // 2 * 2, max(0, shorter - size) // 2 * 2)
    if blend is None and method.blend == "feather":
        blend = min(_PAPERS_BLEND if paper else _BLEND, border)
    check_block(size, border, blend)
    around = 2 * margin_of(border, blend)
    if size + around > shorter:
        wide = "border_width" if around == border else "blend_width"
        raise InvalidInputError(
            f"block_size is {size} and {wide} {around}; {exemplar.name} is "
            f"{size_words(exemplar.shape)}, so together they must be at most {shorter}"
        )
    if not _fits(exemplar, size + around):
        raise InvalidInputError(
            f"no block of {size} pixels with a border of {around} lies on usable pixels of "
            f"{exemplar.name}; make them smaller"
        )
    return size, border, blend


def _border(size: int) -> int:
    """The default width of the borders of a block."""
    return size // 3 * 2


def _largest_block(
    vectors: Vectors, exemplar: Exemplar, border: int | None, blend: int, by_rows: bool
) -> int:
    """The side of the largest block, up to the paper's, that has a choice of windows."""
    x1, y1, _, _ = vectors
    shorter = min(exemplar.shape)
    size, least = int(_PAPERS_BLOCK * shorter), max(1, round(_SMALLEST_BLOCK * shorter))

    def window(size: int) -> int:
        return size + 2 * margin_of(_border(size) if border is None else border, blend)

    def choice(size: int) -> tuple[int, int]:
        """The number of windows, and of rows that they lie in."""
        height, width = (max(0, n - window(size)) for n in exemplar.shape)
        across = (height * abs(y1) + width * abs(x1)) / (x1 * x1 + y1 * y1)
        return height * width, int(across) + 1

    # Wide rows leave no block as many to choose from: then as many as the smallest block has.
    rows = min(_ROWS, choice(least)[1]) if by_rows else 1
    while size > least:
        windows, in_rows = choice(size)
        if windows >= _WINDOWS * _area(vectors) and in_rows >= rows:
            break
        size -= 1
    # Usable pixels must hold a window for every part of the tile.
    low, high = 0, max(size, 1)
    while low < high:
        size = (low + high + 1) // 2
        if _fits(exemplar, window(size), vectors):
            low = size
        else:
            high = size - 1
    return max(low, 1)


def _fits(exemplar: Exemplar, side: int, vectors: Vectors = ()) -> bool:
    """Whether a window of this side lies on usable pixels; with vectors, at any part of a tile."""
    if side > min(exemplar.shape):
        return False
    if exemplar.mask is None:
        return True
    try:
        windows = windows_of(exemplar, (0, side - 1, 0, side - 1))
    except InvalidInputError:
        return False
    if not vectors:
        return True
    lattice = CanvasLattice(vectors)
    cells = [max(1, round(float(np.hypot(*v)) / _CELL)) for v in lattice.sample]
    y, x = np.nonzero(windows.usable)
    found = np.unique(lattice.cell(y, x, cells))
    return len(found) == cells[0] * cells[1]


class Border(NamedTuple):
    """The pixels of a gap's window that must match, see `block_kernels.Gaps`."""

    size: int  # of the window
    pieces: NDArray[np.int32]  # (m, 4): of the neighbors
    runs: NDArray[np.int32]  # (n, 3), shuffled


@dataclass(frozen=True, eq=False)
class BlockSample:
    """All that outputs of one sample have in common.

    An offset leads from a block's phase to a similar window: a sum of multiples of the lattice
    vectors in 1/65536 pixel.
    """

    exemplar: Exemplar
    windows: Windows  # by their upper left corners
    offsets: NDArray[np.int64]  # (n, 2), shuffled
    multiples: NDArray[np.int64]  # (n,), of the first vector in each
    #: Rows that blocks beside each other share, or each of them would end with its block.
    colored_rows: ColoredRows | None
    _borders: dict[tuple[int, ...], Border] = field(default_factory=dict, repr=False)

    def border(self, height: int, width: int, margin: int, half: int) -> Border:
        """The border of gaps of one size, see `wedges_of`."""
        key = int(height), int(width), margin, half
        if key not in self._borders:
            wedges, columns = wedges_of(*key), self.pixels.shape[1]
            pieces = [row_stretches(wedges == k + 1, columns, k) for k in range(4)]
            runs = shuffled(row_stretches(wedges > 0, columns))
            self._borders[key] = Border(wedges.size, np.concatenate(pieces), runs)
        return self._borders[key]

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """(H', W', K): those of the windows."""
        return self.windows.pixels


def prepare(method: Any, exemplar: Exemplar) -> BlockSample:
    """Analyze a sample for a resolved method: its windows, colored rows, similar windows."""
    vectors, reach = method.lattice, method.window_side - 1
    if exemplar.tileable and vectors_around(vectors, exemplar) is None:
        windows = windows_of(exemplar.changed(tileable=False), (0, reach, 0, reach))
    else:
        windows = windows_of(exemplar, (0, reach, 0, reach))
    lattice = CanvasLattice(vectors)
    offsets = shuffled(lattice.steps(*exemplar.shape), "steps")
    free = not is_rows(vectors) or exemplar.mask is not None
    return BlockSample(
        exemplar=exemplar,
        windows=windows,
        offsets=offsets,
        multiples=np.rint(offsets @ lattice.inverse[:, 0] / 65536).astype(np.int64),
        colored_rows=None if free else find_colored_rows(windows.pixels, vectors),
    )


def wedges_of(height: int, width: int, margin: int, half: int) -> NDArray[np.uint8]:
    """Wedge-shaped borders (Fig. 4.8b) of a block's window, 2 * `half` wide.

    1 to 4 are of the neighbor above, left, below, right; 0 is off the border.

    >>> wedges_of(4, 4, 1, 1)[:3]
    array([[1, 1, 1, 1, 1, 1],
           [2, 1, 1, 1, 1, 4],
           [2, 2, 0, 0, 4, 4]], dtype=uint8)
    """
    v, u = np.indices((height + 2 * margin, width + 2 * margin))
    away = np.stack([v, u, v[::-1], u[:, ::-1]]) - (margin - half)
    nearest = away.min(axis=0)
    border = (nearest >= 0) & (nearest < 2 * half)
    return np.where(border, away.argmin(axis=0) + 1, 0).astype(np.uint8)


def row_stretches(mask: NDArray[np.bool_], columns: int, *more: int) -> NDArray[np.int32]:
    """The runs of a window's rows: first pixel in it and in the sample, and length, then `more`."""
    start, stop, row = row_runs(mask)
    parts = [row * mask.shape[1] + start, row * columns + start, stop - start]
    return np.stack([*parts, *(0 * row + k for k in more)], axis=1).astype(np.int32)


def shuffled(values: NDArray[Any], purpose: str = "runs") -> NDArray[Any]:
    """Shuffle rows: the first few then tell about all, such as runs on all sides of a border."""
    order = np.argsort(draw(0, purpose, np.arange(len(values))), kind="stable")
    return np.ascontiguousarray(values[order])
