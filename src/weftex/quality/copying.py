"""Copying: how large pieces are, how evenly the sample is used, and how well pieces join."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar import as_array

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
    place = np.indices(result.shape, np.int32).transpose(1, 2, 0)
    piece = pieces(source - place, known)
    areas = np.bincount(piece[known])
    own = areas[piece[known]]
    index = np.where(known, source[..., 0] * sample.shape[1] + source[..., 1], -1)
    return Copying(
        copied=float((own >= _PIECE).mean()),
        piece=float(np.sqrt(own.mean())),
        largest=float(areas.max() / sample.usable.sum()),
        evenness=_evenness(sample, source[known]),
        distinct=_distinct(index, max(1, sample.side // 2)),
        joints=_joints(sample, result, source, known),
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
    whole: NDArray[np.int32] = np.maximum(given, -1).astype(np.int32)
    whole[(whole < 0).any(axis=2)] = -1
    return whole


def pieces(shift: NDArray[np.int32], known: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Number the connected areas of one shift, (H, W); each pixel without a source is its own."""
    height, width = known.shape
    alike_x = (shift[:, 1:] == shift[:, :-1]).all(axis=2) & known[:, 1:] & known[:, :-1]
    alike_y = (shift[1:] == shift[:-1]).all(axis=2) & known[1:] & known[:-1]
    starts = np.ones((height, width), bool)
    starts[:, 1:] = ~alike_x
    run = starts.ravel().cumsum().reshape(height, width) - 1  # runs along rows, then joined
    joined = np.unique(run[:-1][alike_y] * np.int64(run.max() + 1) + run[1:][alike_y])
    upper, lower = np.divmod(joined, np.int64(run.max() + 1))
    root = np.arange(run.max() + 1)
    while True:
        first, second = root[upper], root[lower]
        apart = first != second
        if not apart.any():
            break
        upper, lower, first, second = upper[apart], lower[apart], first[apart], second[apart]
        np.minimum.at(root, np.maximum(first, second), np.minimum(first, second))
        while (root != root[root]).any():
            root = root[root]
    names: NDArray[np.int64] = np.unique(root, return_inverse=True)[1].astype(np.int64)
    numbered: NDArray[np.int64] = names[run]
    return numbered


def _evenness(sample: View, used: NDArray[np.int32]) -> float:
    rows, columns = (min(_GRID, side) for side in sample.shape)
    y = np.arange(sample.shape[0]) * rows // sample.shape[0]
    x = np.arange(sample.shape[1]) * columns // sample.shape[1]
    cell = y[:, None] * columns + x
    size = np.bincount(cell[sample.usable], minlength=rows * columns).astype(np.float64)
    count = np.bincount(cell[used[:, 0], used[:, 1]], minlength=rows * columns)
    # For each usable pixel, so that a cell that the mask cuts does not count as used less.
    there = size > 0
    share = count[there] / size[there]
    weight = size[there] / size[there].sum()
    density = share / (share * weight).sum() if share.any() else np.ones(len(share))
    entropy = -(weight * density * np.log(np.where(density > 0, density, 1))).sum()
    return float(min(1.0, np.exp(entropy)))


def _distinct(index: NDArray[np.int64], side: int) -> float:
    """Mean over squares that overlap by half."""
    found, places = [], int(index.max()) + 1
    for top in _starts(index.shape[0], side):
        for left in _starts(index.shape[1], side):
            square = index[top : top + side, left : left + side].ravel()
            square = square[square >= 0]
            if len(square):
                seen = np.zeros(places, bool)
                seen[square] = True
                found.append(np.count_nonzero(seen) / len(square))
    return float(np.mean(found))


def _starts(length: int, side: int) -> list[int]:
    if length <= side:
        return [0]
    count = min(8, max(2, 2 * length // side - 1))
    return [k * (length - side) // (count - 1) for k in range(count)]


def _joints(
    sample: View, result: View, source: NDArray[np.int32], known: NDArray[np.bool_]
) -> float | None:
    total, count, steps, pairs = 0.0, 0, 0.0, 0
    own, made = sample.values.astype(np.int32), result.values.astype(np.int32)
    for axis in (0, 1):
        later = tuple(slice(axis == a, None) for a in (0, 1))
        earlier = tuple(slice(None, -1 if axis == a else None) for a in (0, 1))
        both = sample.usable[later] & sample.usable[earlier]
        steps += float(((own[later] - own[earlier])[both] ** 2).sum())
        pairs += int(both.sum())
        step = np.arange(2) == axis
        meet = known[later] & known[earlier]
        meet &= (source[later] - source[earlier] != step).any(axis=2)
        least = np.full(int(meet.sum()), np.inf)
        for at, beside, way in ((earlier, later, 1), (later, earlier, -1)):
            goes_on = source[at][meet] + way * step
            inside = ((goes_on >= 0) & (goes_on < sample.shape)).all(axis=1)
            goes_on = goes_on.clip(0, np.array(sample.shape) - 1)
            differs = ((made[beside][meet] - own[goes_on[:, 0], goes_on[:, 1]]) ** 2).sum(axis=1)
            least = np.minimum(least, np.where(inside, differs, np.inf))
        least = least[np.isfinite(least)]
        total, count = total + float(least.sum()), count + len(least)
    if count < _JOINTS or not pairs:
        return None
    channels = sample.values.shape[2]
    return float(np.sqrt((total / count + channels / 12) / (steps / pairs + channels / 12)))
