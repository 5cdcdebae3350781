"""Copying: how large pieces are, how evenly the sample is used, and how well pieces join."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar import as_array
from weftex.quality import piece_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.quality.view import View

_PIECE = 64  # pixels; a smaller piece counts as pixels that were chosen one by one
_GRID = 16  # cells of the sample along each side
_JOINTS = 20  # fewer say nothing


@dataclass(frozen=True, eq=False)
class Copying:
    """What `copying` finds.

    Attributes
    ----------
    copied : float
        Share of what was made in pieces of at least 64 pixels.
    piece : float
        Side in pixels of a square of the size of the piece that a pixel usually lies in.
    largest : float
        The largest piece, over the sample's size.
    evenness : float
        Share of the sample that, used evenly, would give the same entropy.
    distinct : float
        Different source pixels, over pixels, within half the sample's side.
    joints : float or None
        Difference of colors where pieces meet, over that between neighbors in the sample; None if
        there are hardly any joints.
    """

    copied: float
    piece: float
    largest: float
    evenness: float
    distinct: float
    joints: float | None


def copying(sample: View, result: View, source: NDArray[Any]) -> Copying | None:
    """Describe how the sample was used.

    *Definition.* Pieces are connected pixels whose sources have one shift. `copied`, `piece`
    and `largest` are their sizes. `evenness` is exp of the entropy of how often each cell of a
    16x16 grid over the sample was used, over the number of cells with usable pixels. `distinct`
    is taken in squares of half the sample's side. At `joints`, where two pieces meet, each of the
    two pixels is compared with the pixel that would continue the other's piece in the sample; the
    root mean square of the lesser difference, over that between neighbors in the sample.

    *Unit.* Shares, pixels, and steps of the sample. *Good.* `evenness` and `distinct` high,
    `joints` low: at 1 a joint is as large a step as any between two neighbors. `copied`, `piece`
    and `largest` say what a method does, not how well. *Blind to* everything else: sources
    that are laid evenly and at random join badly, and small pieces of a smooth sample are no fault.

    Parameters
    ----------
    sample, result : View
        From `views`.
    source : int array (H, W, 2)
        Row and column in the sample of each pixel; negative where it comes from nowhere.

    Returns
    -------
    Copying or None
        None where no pixel has a source.

    Raises
    ------
    InvalidInputError
        If the source has another size than the result, or leaves the sample.
    """
    source = check_source(source, sample.shape, result.shape)
    known = source[..., 0] >= 0
    if not known.any():
        return None
    shift = source.copy()
    shift[..., 0] -= np.arange(result.shape[0], dtype=np.int32)[:, None]
    shift[..., 1] -= np.arange(result.shape[1], dtype=np.int32)
    areas = np.bincount(pieces(shift, known)[known])
    count = int(areas.sum())
    index = np.where(known, source[..., 0] * np.int32(sample.shape[1]) + source[..., 1], -1)
    return Copying(
        copied=float(areas[areas >= _PIECE].sum() / count),
        piece=float(np.sqrt((areas**2).sum() / count)),
        largest=float(areas.max() / sample.usable.sum()),
        evenness=_evenness(sample, index[known]),
        distinct=_distinct(index, max(1, sample.side // 2)),
        joints=_joints(sample, result, source),
    )


def check_source(
    source: NDArray[Any], sample: tuple[int, int], result: tuple[int, int]
) -> NDArray[np.int32]:
    """Return the source in whole numbers, or raise `InvalidInputError`."""
    given = as_array(source, "the source")
    if given.shape != (*result, 2) or given.dtype.kind not in "iu":
        size = f"{given.shape[1]}x{given.shape[0]}" if given.ndim == 3 else str(given.shape)
        raise InvalidInputError(
            f"the source is {size} of {given.dtype}, the result is {result[1]}x{result[0]}; it "
            "must be rows and columns, (H, W, 2), of the result's size"
        )
    if (given >= sample).any():
        raise InvalidInputError(
            f"the source leaves the sample, which is {sample[1]}x{sample[0]}; give the sample that "
            "the result was made from"
        )
    whole: NDArray[np.int32] = np.maximum(given, -1).astype(np.int32, "C")
    whole[(whole[..., 0] < 0) | (whole[..., 1] < 0)] = -1
    return whole


def pieces(shift: NDArray[np.integer], known: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Number the connected areas of one shift, (H, W); each pixel without a source is its own."""
    names = np.empty(known.shape, np.int32)
    plain = np.ascontiguousarray(known, np.uint8)
    kernels.number_pieces(np.ascontiguousarray(shift, np.int32), plain, names)
    return names


def _evenness(sample: View, used: NDArray[np.int32]) -> float:
    """Of the places that were used, as flat indices."""
    rows, columns = (min(_GRID, side) for side in sample.shape)
    y = np.arange(sample.shape[0]) * rows // sample.shape[0]
    x = np.arange(sample.shape[1]) * columns // sample.shape[1]
    cell = y[:, None] * columns + x
    size = np.bincount(cell[sample.usable], minlength=rows * columns).astype(np.float64)
    count = np.bincount(cell.ravel()[used], minlength=rows * columns)
    # For each usable pixel, so that a cell that the mask cuts does not count as used less.
    there = size > 0
    share = count[there] / size[there]
    weight = size[there] / size[there].sum()
    density = share / (share * weight).sum() if share.any() else np.ones(len(share))
    entropy = -(weight * density * np.log(np.where(density > 0, density, 1))).sum()
    return float(min(1.0, np.exp(entropy)))


def _distinct(index: NDArray[np.int32], side: int) -> float:
    """Mean over squares that overlap by half."""
    height, width = index.shape
    corners = [(y, x) for y in _starts(height, side) for x in _starts(width, side)]
    boxes = np.array([(y, x, min(y + side, height), min(x + side, width)) for y, x in corners])
    counts = np.empty((len(boxes), 2), np.int64)
    kernels.count_different(index, boxes, np.zeros(int(index.max()) + 1, np.int32), counts)
    counts = counts[counts[:, 1] > 0]
    return float(np.mean(counts[:, 0] / counts[:, 1]))


def _starts(length: int, side: int) -> list[int]:
    if length <= side:
        return [0]
    count = min(8, max(2, 2 * length // side - 1))
    return [k * (length - side) // (count - 1) for k in range(count)]


def _joints(sample: View, result: View, source: NDArray[np.int32]) -> float | None:
    found, steps, pairs = np.zeros(2, np.int64), 0, 0
    pixels, made = (np.ascontiguousarray(view.values) for view in (sample, result))
    kernels.differ_at_joints(pixels, made, source, found)
    total, count = found.tolist()
    own = sample.values.astype(np.int32)
    for axis in (0, 1):
        later = tuple(slice(axis == a, None) for a in (0, 1))
        earlier = tuple(slice(None, -1 if axis == a else None) for a in (0, 1))
        both = sample.usable[later] & sample.usable[earlier]
        squares = (own[later] - own[earlier]) ** 2
        steps += int((squares if both.all() else squares[both]).sum())
        pairs += int(both.sum())
    if count < _JOINTS or not pairs:
        return None
    channels = sample.values.shape[2]
    return float(np.sqrt((total / count + channels / 12) / (steps / pairs + channels / 12)))
