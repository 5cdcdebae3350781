"""More from less: a sample beside its mirror image, or its quarter turns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError, shown
from weftex.exemplar import Exemplar
from weftex.loading import load_exemplar
from weftex.raster.mixing import Kind, mixing_of
from weftex.raster.vectors import opposite
from weftex.roles import COLOR, Role

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.loading import Sample

    #: How often a copy is turned to the left by a quarter, after it was mirrored or not.
    Copy = tuple[int, bool]
    #: Top, left, height and width.
    Box = tuple[int, int, int, int]

#: The copies of each way to turn a sample; those in one row are of one shape.
TURNS: dict[str, list[list[Copy]]] = {
    "flip": [[(0, False), (0, True)]],
    "half": [[(0, False), (2, False)]],
    "4": [[(0, False), (2, False)], [(1, False), (3, False)]],
    "8": [
        [(0, False), (2, False), (0, True), (2, True)],
        [(1, False), (3, False), (1, True), (3, True)],
    ],
}


def turned(sample: Sample, turn: str) -> Exemplar:
    """Put copies of a sample beside it, mirrored or turned, so that there is more to choose from.

    The copies lie in one picture, a masked line of pixels between any two, so that every method
    takes pieces from all of them and none from two at once. The vectors of normal maps are turned
    with their pixels, whether y is up (OpenGL) or down (DirectX), as the map's name says.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        Of a material that has no way up, or no left and right.
    turn : {"flip", "half", "4", "8"}
        Mirrored left to right; upside down, by half a turn; turned by quarters; both.

    Returns
    -------
    Exemplar
        With two, four or eight copies, maps, mask and guide; the first is the sample.

    Raises
    ------
    FileError, InvalidInputError
        If the sample cannot be read, is of turned copies already, or there is no such way.

    Notes
    -----
    Coordinates of results are those in the picture of copies; `Synthesis.render` takes maps of the
    sample itself, and turns them alike.

    Examples
    --------
    >>> row = turned(np.array([[1, 2, 3]], np.uint8), "flip")
    >>> row.pixels.tolist(), row.mask.tolist()
    ([[1, 2, 3, 1, 3, 2, 1]], [[True, True, True, False, True, True, True]])
    """
    exemplar = load_exemplar(sample)
    if not isinstance(turn, str) or turn not in TURNS:
        raise InvalidInputError(f"turn is {shown(turn)}; it must be one of {', '.join(TURNS)}")
    if exemplar.turn is not None:
        raise InvalidInputError(f"{exemplar.name} is of turned copies already")
    own = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    return exemplar.changed(
        pixels=turned_pixels(exemplar.pixels, turn, exemplar.role),
        maps={name: _turned_map(exemplar, name, turn) for name in exemplar.maps},
        mask=turned_pixels(own, turn, between=np.False_),
        guide=None if exemplar.guide is None else turned_pixels(exemplar.guide, turn),
        tileable=False,
        turn=turn,
        pieces=True,
    )


def as_made_from(exemplar: Exemplar, turn: str | None) -> Exemplar:
    """Return the sample, or the picture of its copies that a result was made from."""
    return exemplar if turn is None or exemplar.turn == turn else turned(exemplar, turn)


def as_it_was(exemplar: Exemplar) -> Exemplar:
    """Return the sample that a picture of copies was made from, without its maps; or the sample."""
    if exemplar.turn is None:
        return exemplar
    top, left, height, width = copies_in(exemplar)[0]
    here = np.s_[top : top + height, left : left + width]
    assert exemplar.mask is not None
    plain: dict[str, Any] = {"maps": {}, "guide": None, "turn": None, "pieces": False}
    return exemplar.changed(pixels=exemplar.pixels[here], mask=exemplar.mask[here], **plain)


def turned_pixels(
    pixels: NDArray[Any],
    turn: str,
    role: Role = COLOR,
    *,
    gap: int = 1,
    between: Any = None,
) -> NDArray[Any]:
    """Return the picture of copies of one picture.

    Parameters
    ----------
    pixels : array (H, W) or (H, W, C)
    turn : str
        One of `TURNS`.
    role : Role
        What it shows; the vectors of a normal map are turned too.
    gap : int
        The width of the line between copies.
    between
        The pixel of that line, and of what is left over where copies are not square; by default the
        first one, so that values keep their range.
    """
    mixing = mixing_of(pixels, role.kind, alpha=False)

    def copy(quarters: int, mirrored: bool) -> NDArray[Any]:
        made = pixels[:, ::-1] if mirrored else pixels
        if mixing.kind is Kind.VECTORS:
            made = _turned_vectors(made, quarters, mirrored, role, mixing.middle)
        return np.rot90(made, quarters)

    result = np.empty((*_size(pixels.shape, turn, gap), *pixels.shape[2:]), pixels.dtype)
    result[:] = pixels[0, 0] if between is None else between
    top = 0
    for row in TURNS[turn]:
        left = 0
        for one in row:
            made = copy(*one)
            result[top : top + made.shape[0], left : left + made.shape[1]] = made
            left += made.shape[1] + gap
        top += made.shape[0] + gap
    return result


def copies_in(exemplar: Exemplar) -> list[Box]:
    """Return where the copies lie in a picture of them, the sample as it is first.

    Parameters
    ----------
    exemplar : Exemplar
        See `turned`.
    """
    assert exemplar.turn is not None and exemplar.mask is not None
    rows = TURNS[exemplar.turn]
    height, width = exemplar.shape
    side = (width + 1) // len(rows[0]) - 1
    shapes = [(height, side)]
    if len(rows) > 1:  # the longer side is known, and both together
        shapes = [(height - 1 - side, side), (side, height - 1 - side)]
    shape = next(
        shape
        for shape in shapes
        if not exemplar.mask[
            ~turned_pixels(np.ones(shape, bool), exemplar.turn, between=False)
        ].any()
    )
    boxes, top = [], 0
    for row in rows:
        high, wide = shape if row[0][0] % 2 == 0 else shape[::-1]
        boxes += [(top, k * (wide + 1), high, wide) for k in range(len(row))]
        top += high + 1
    return boxes


def as_copies(given: Exemplar, turn: str, size: tuple[int, int]) -> Exemplar:
    """Return a map of a sample as one of its picture of copies, which has this size.

    The map may be at a multiple of the sample's resolution. What is of that picture already, and
    what fits neither, is returned as it is.
    """
    most = given.shape[0] * len(TURNS[turn]) // size[0] + 1
    for scale in range(1, most + 1):
        if _size(given.shape, turn, scale) == (scale * size[0], scale * size[1]):
            pixels = turned_pixels(given.pixels, turn, given.role, gap=scale)
            return given.changed(pixels=pixels, maps={}, mask=None, guide=None)
    return given


def _turned_map(exemplar: Exemplar, name: str, turn: str) -> Exemplar:
    """A map at its own resolution, or where that is a fraction of the sample's, at the sample's."""
    scale, given = exemplar.scale_of(name), exemplar.map(name)
    pixels = exemplar.aligned(name) if scale < 1 else given.pixels
    made = turned_pixels(pixels, turn, given.role, gap=max(1, int(scale)))
    return given.changed(pixels=made)


def _size(shape: tuple[int, ...], turn: str, gap: int) -> tuple[int, int]:
    """Height and width of the picture of copies of one of this shape."""
    high, wide = 0, 0
    for row in TURNS[turn]:
        height, width = shape[:2] if row[0][0] % 2 == 0 else shape[1::-1]
        high += height + gap
        wide = max(wide, len(row) * (width + gap))
    return high - gap, wide - gap


def _turned_vectors(
    pixels: NDArray[Any], quarters: int, mirrored: bool, role: Role, middle: float
) -> NDArray[Any]:
    """The vectors of a normal map as they are in a mirrored and turned copy."""
    right, up = pixels[..., 0], pixels[..., 1]
    down = role.name == "normal_dx"
    if mirrored:
        right = opposite(right, middle)
    for _ in range(quarters % 4):
        right, up = (up, opposite(right, middle)) if down else (opposite(up, middle), right)
    return np.concatenate([right[..., None], up[..., None], pixels[..., 2:]], axis=2)
