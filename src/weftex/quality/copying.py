"""Copying: how large the pieces are, how often they repeat, and how well they join."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.quality import kernels
from weftex.raster.arrays import as_array

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.quality.view import View

_PIECE = 64  # pixels; a smaller piece counts as pixels that were chosen one by one
_JOINTS = 20  # fewer say nothing


@dataclass(frozen=True, eq=False)
class Copying:
    """How a result was copied from its sample.

    `copied`: share of what was made in pieces of at least 64 pixels. `piece`: side of a square of
    the size of the piece that a pixel usually lies in. `largest`: largest piece over the sample's
    size. `distinct`: different source pixels, over pixels, within half the sample's side.
    `joints`: difference of colors where pieces meet, over that of neighbors in the sample.
    """

    copied: float
    piece: float
    largest: float
    distinct: float
    joints: float | None


def copying(sample: View, result: View, source: NDArray[Any]) -> Copying | None:
    """Measure how a result was copied; None where no pixel has a source.

    A piece is a connected area whose sources (H, W, 2) have one shift; negative sources are none.
    """
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
        distinct=_distinct(index, max(1, sample.side // 2)),
        joints=_joints(sample, result, source),
    )


def check_source(
    source: NDArray[Any], sample: tuple[int, int], result: tuple[int, int]
) -> NDArray[np.int32]:
    """Return the source as int32, -1 for none, or raise `InvalidInputError`."""
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
    """Number the connected areas of one shift, (H, W); a pixel without a source is an area."""
    names = np.empty(known.shape, np.int32)
    plain = np.ascontiguousarray(known, np.uint8)
    kernels.number_pieces(np.ascontiguousarray(shift, np.int32), plain, names)
    return names


def _distinct(index: NDArray[np.int32], side: int) -> float:
    """Return the mean share of different pixels, over squares that overlap by half."""
    height, width = index.shape
    shares = []
    for y in _starts(height, side):
        for x in _starts(width, side):
            part = index[y : y + side, x : x + side]
            known = part[part >= 0]
            if len(known):
                shares.append(np.count_nonzero(np.bincount(known)) / len(known))
    return float(np.mean(shares))


def _starts(length: int, side: int) -> list[int]:
    if length <= side:
        return [0]
    count = min(8, max(2, 2 * length // side - 1))
    return [k * (length - side) // (count - 1) for k in range(count)]


def _joints(sample: View, result: View, source: NDArray[np.int32]) -> float | None:
    """Return the root mean square step at joints over that between neighbors in the sample.

    Each of two pixels at a joint is compared with the pixel that would continue the other's piece
    in the sample; the lesser difference counts. None for fewer than 20 joints.
    """
    total = count = steps = pairs = 0
    own = sample.values.astype(np.int32)
    for axis in (0, 1):
        later = tuple(slice(int(axis == a), None) for a in (0, 1))
        earlier = tuple(slice(None, -1 if axis == a else None) for a in (0, 1))
        squares = squared_steps(own, result.values, source, (earlier, later))
        total, count = total + int(squares.sum()), count + len(squares)
        both = sample.usable[later] & sample.usable[earlier]
        steps += int(((own[later] - own[earlier]) ** 2)[both].sum())
        pairs += int(both.sum())
    if count < _JOINTS or not pairs:
        return None
    channels = own.shape[2]
    return float(np.sqrt((total / count + channels / 12) / (steps / pairs + channels / 12)))


def squared_steps(
    own: NDArray[np.int32],
    made: NDArray[np.uint8],
    source: NDArray[np.int32],
    neighbors: tuple[tuple[slice, ...], tuple[slice, ...]],
) -> NDArray[np.int64]:
    """Return the squared steps (N,) at all joints between `neighbors`: earlier and later pixels."""
    earlier, later = neighbors
    step = np.array([later[0].start or 0, later[1].start or 0])
    first, second = source[earlier], source[later]
    joint = (first[..., 0] >= 0) & (second[..., 0] >= 0) & (second - first != step).any(axis=2)
    least = np.full(int(joint.sum()), np.iinfo(np.int64).max)
    for at, pixels in ((first[joint] + step, made[later]), (second[joint] - step, made[earlier])):
        inside = ((at >= 0) & (at < own.shape[:2])).all(axis=1)
        y, x = at[inside].T
        squares = ((own[y, x] - pixels[joint][inside]) ** 2).sum(axis=1)
        least[inside] = np.minimum(least[inside], squares)
    return least[least < np.iinfo(np.int64).max]
