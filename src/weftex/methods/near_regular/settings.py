"""The settings of near-regular synthesis: every value settled."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.canvas_lattice import (
    ANYWHERE,
    CanvasLattice,
    check_lattice,
    found_vectors,
    four_numbers,
    given_lattice,
)
from weftex.analysis.lattice import Lattice
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar

_PAPERS_BLOCK = 40 / 128  # over the sample's shorter side (section 5.1)
_SMALLEST_BLOCK = 0.15  # that is chosen, over the same
_PLACES = 6.0  # similar places that a block should have to choose from
_ROWS = 3  # rows to choose from, where nothing else repeats
_TOLERANCE = 3  # px (section 4.2.2)
_ALL_SIMILAR = 512  # candidates: all that a gap compares
_FREE = 4.0  # pixels of a tile so small that any place is similar to any other
_STRAIN = 0.02  # of a sample that tiles; past it the border is not gone over
_BLOCKY = 0.15  # blockiness from which blocks show
_WIDE = 0.7  # of a block that is blended then
_CELL = 1.5  # pixels; a tile is cut into such parts to see whether all of them are there


@dataclass(frozen=True)
class Settings:
    """The parameters of near-regular synthesis, settled.

    Attributes
    ----------
    lattice : (float, float, float, float)
        x1, y1, x2, y2 in pixels; stretched a little if the sample tiles, so that it goes around.
    unconstrained : bool
        There is no lattice: any place is similar to any other (section 5.2).
    by_rows : bool
        The sample repeats along the first vector only: along the second, one pixel, any place is as
        good.
    tiles : bool
        Windows go over the sample's border to its other side.
    block_size, border_width, blend_width, tolerance, rectify : int
        In pixels. `blend_width` is 0 unless blocks are feathered; `rectify` is 0 where nothing is
        rectified.
    blend : {"cut", "feather", "none"}
    seam_cost, match, candidates, variety
        See `NearRegular`.
    """

    lattice: tuple[float, ...]
    unconstrained: bool
    by_rows: bool
    tiles: bool
    block_size: int
    border_width: int
    blend: str
    blend_width: int
    seam_cost: str
    tolerance: int
    rectify: int
    match: str
    candidates: int
    variety: float

    @property
    def margin(self) -> int:
        """How far a block's window reaches beyond the block: half a border."""
        return self.border_width // 2

    @property
    def side(self) -> int:
        """The side of a block's window."""
        return self.block_size + 2 * self.margin

    def blended_for(self, blockiness: float) -> Settings:
        """Widen the blending area if blocks beside each other would show (Fig. 5.12)."""
        if blockiness <= _BLOCKY:
            return self
        return replace(self, blend_width=min(round(_WIDE * self.block_size), self.border_width))

    def parameters(self) -> dict[str, Any]:
        """The settled values of those parameters that may be left open, by name."""
        names = ["lattice", "block_size", "border_width", "blend", "tolerance", "rectify"]
        names += ["candidates", "variety"] + ["blend_width"] * (self.blend == "feather")
        return {name: getattr(self, name) for name in names}


def settle(method: Any, exemplar: Exemplar) -> Settings:
    """Fill in the values that follow from the sample and the preset.

    Parameters
    ----------
    method : NearRegular
        Parameters; None where they are left open.
    exemplar : Exemplar
        The sample.

    Returns
    -------
    Settings
        Blending is as narrow as in the paper if its width was left open.

    Raises
    ------
    InvalidInputError
        If the vectors or a block do not fit the sample, or a value has no effect on it.
    """
    paper = method.preset == "paper"
    vectors = method.lattice
    if vectors is not None:
        check_lattice(vectors, exemplar)
    else:
        vectors = _found(exemplar)
    vectors, by_rows = _rows_of(vectors)
    tolerance, rectify = method.tolerance, method.rectify
    if tolerance is None:
        # Where the tile is hardly larger, a few pixels are another place in it.
        side = float(np.hypot(vectors[0], vectors[1])) if by_rows else _area(vectors) ** 0.5
        tolerance = _TOLERANCE
        if not paper and vectors != ANYWHERE:
            tolerance = min(_TOLERANCE, int(side / 4))
    if rectify is None:
        # Little beside the tile, or one thing would be taken for the next.
        x1, y1, x2, y2 = vectors
        shortest = float(min(np.hypot(x1, y1), np.inf if by_rows else np.hypot(x2, y2)))
        rectify = 0 if paper else min(_TOLERANCE, round(shortest / 10))
    size, border = _block(method, exemplar, vectors, by_rows)
    blend, width = blend_of(method), method.blend_width
    if width is not None and width > border:
        raise InvalidInputError(
            f"blend_width is {width}; it must be at most the border_width, which is {border}"
        )
    for name, default in (("match", "difference"), ("seam_cost", "gradient")):
        if border == 0 and getattr(method, name) != default:
            raise InvalidInputError(f"{name} has no effect without borders; border_width is 0")
    unconstrained = _area(vectors) < _FREE
    vectors, tiles = _around(vectors, exemplar)
    unmoved = {
        "without a lattice": unconstrained,
        f"where {exemplar.name} has a mask or a hole": exemplar.mask is not None,
        f"where {exemplar.name} tiles": tiles,
    }
    for case in (case for case, holds in unmoved.items() if holds):
        if method.rectify:
            raise InvalidInputError(f"rectify is {rectify}; it has no effect {case}")
        rectify = 0
    return Settings(
        lattice=vectors,
        unconstrained=unconstrained,
        by_rows=by_rows,
        tiles=tiles,
        block_size=size,
        border_width=border,
        blend=blend,
        blend_width=(min(4, border) if width is None else width) if blend == "feather" else 0,
        seam_cost=method.seam_cost,
        tolerance=tolerance,
        rectify=rectify,
        match=method.match,
        candidates=method.candidates or (_ALL_SIMILAR if paper else 6),
        variety=(0.0 if paper else 1.0) if method.variety is None else method.variety,
    )


def blend_of(method: Any) -> str:
    """How a method joins blocks, by its preset where that is left open."""
    if method.blend != "auto":
        return str(method.blend)
    return "feather" if method.preset == "paper" else "cut"


def _found(exemplar: Exemplar) -> tuple[float, ...]:
    """The sample's own vectors, or the unconstrained mode's."""
    vectors = found_vectors(exemplar)
    if len(vectors) == 2:
        return four_numbers(Lattice((vectors,)))
    return vectors or ANYWHERE


def _rows_of(vectors: tuple[float, ...]) -> tuple[tuple[float, ...], bool]:
    """The vectors, that across rows first; and whether the other one leads along rows."""
    lattice = given_lattice(vectors)
    if len(lattice.vectors) == 2 or _area(vectors) < _FREE:
        return vectors, False
    return four_numbers(lattice), True


def _around(vectors: tuple[float, ...], exemplar: Exemplar) -> tuple[tuple[float, ...], bool]:
    """The vectors stretched so that they go around a sample that tiles; and whether that is so."""
    if exemplar.tileable:
        lattice = CanvasLattice(vectors, Canvas(*exemplar.shape, (True, True)))
        if lattice.strain <= _STRAIN:
            (y1, x1), (y2, x2) = lattice.canvas.tolist()
            return (x1, y1, x2, y2), True
    return vectors, False


def check_border(size: int, border: int) -> None:
    """Refuse borders as wide as their block."""
    if border >= size:
        raise InvalidInputError(f"border_width is {border}; it must be less than the block, {size}")


def _block(
    method: Any, exemplar: Exemplar, vectors: tuple[float, ...], by_rows: bool
) -> tuple[int, int]:
    """The side of blocks and the width of borders, checked."""
    paper, shorter = method.preset == "paper", min(exemplar.shape)
    size, border = method.block_size, method.border_width
    if size is None:
        size = max(1, int(_PAPERS_BLOCK * shorter))
        if not paper:
            size = _largest_block(vectors, exemplar, border, by_rows)
    if border is None:
        border = 10 if paper else size // 3 * 2
        border = min(border, (size - 1) // 2 * 2, max(0, shorter - size) // 2 * 2)
    check_border(size, border)
    if size + border > shorter:
        raise InvalidInputError(
            f"block_size is {size} and border_width {border}; {exemplar.name} is "
            f"{exemplar.shape[1]}x{exemplar.shape[0]}, which has room for {shorter} together"
        )
    if not _has_room(exemplar, size + border):
        raise InvalidInputError(
            f"no block of {size} pixels with a border of {border} lies on usable pixels of "
            f"{exemplar.name}; make them smaller"
        )
    return size, border


def _largest_block(
    vectors: tuple[float, ...], exemplar: Exemplar, border: int | None, by_rows: bool
) -> int:
    """The largest block, up to the paper's, that has a choice of places."""
    x1, y1, _, _ = vectors
    shorter = min(exemplar.shape)
    size, least = int(_PAPERS_BLOCK * shorter), max(1, round(_SMALLEST_BLOCK * shorter))

    def room(size: int) -> tuple[int, int]:
        """Places of a block, and how many rows they lie in."""
        height, width = (max(0, n - _window(size, border)) for n in exemplar.shape)
        across = (height * abs(y1) + width * abs(x1)) / (x1 * x1 + y1 * y1)
        return height * width, int(across) + 1

    # Where rows are so wide that no block has so many to choose from, as many as there can be.
    rows = min(_ROWS, room(least)[1]) if by_rows else 1
    while size > least:
        places, in_rows = room(size)
        if places >= _PLACES * _area(vectors) and in_rows >= rows:
            break
        size -= 1
    if exemplar.mask is None:
        while size > 1 and _window(size, border) > shorter:
            size -= 1
        return max(size, 1)
    # What a mask leaves must have a place for every part of the tile.
    low, high = 0, max(size, 1)
    while low < high:
        size = (low + high + 1) // 2
        if _has_room(exemplar, _window(size, border), vectors):
            low = size
        else:
            high = size - 1
    return max(low, 1)


def _window(size: int, border: int | None) -> int:
    """The side of a block with its border, which is two thirds of it if that is left open."""
    return size + (size // 3 * 2 if border is None else border)


def _area(vectors: tuple[float, ...]) -> float:
    x1, y1, x2, y2 = vectors
    return abs(x1 * y2 - x2 * y1)


def _has_room(exemplar: Exemplar, side: int, vectors: tuple[float, ...] = ()) -> bool:
    """Whether a square of this side lies on usable pixels; with vectors, at any place of a tile."""
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
    y, x = np.nonzero(windows.usable)
    cells = [max(1, round(float(np.hypot(*v)) / _CELL)) for v in lattice.sample]
    found = np.unique(lattice.cell(y, x, cells))
    return len(found) == cells[0] * cells[1]
