"""The sample's levels without slow lighting, which all analyses use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.raster.arrays import Floats

LOOK = 320  #: pixels a side, which `smaller_copy` gets where a glance is enough
_LARGEST_SIDE = 1024  # pixels a side; more are averaged together first
#: Cached, as scale, lattice, regularity and evenness of one sample use the same.
_TAKEN: WeakKeyDictionary[Exemplar, Relief] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Relief:
    """Levels less a smooth surface; read-only."""

    levels: Floats  # (K, h, w); 0 where the sample may not be used
    usable: Floats  # (h, w): share of usable pixels
    step: int  # pixels of the sample to one here


def relief(exemplar: Exemplar) -> Relief:
    """Return a sample less slow lighting, a quadratic surface fitted to each channel.

    Cropped to the box around the usable pixels; larger than 1024 pixels, averaged over squares.
    """
    if exemplar not in _TAKEN:
        found = _taken(exemplar)
        found.levels.flags.writeable = found.usable.flags.writeable = False
        _TAKEN[exemplar] = found
    return _TAKEN[exemplar]


def _taken(exemplar: Exemplar) -> Relief:
    box = usable_box(exemplar)
    levels, usable = exemplar.matching()[box], exemplar.usable[box]
    step = -(-max(usable.shape) // _LARGEST_SIDE)
    share = means(usable, step)
    down, along = (
        np.vander(np.linspace(-1, 1, side) if side > 1 else np.zeros(1), 5, increasing=True).T
        for side in share.shape
    )
    # Products of powers of y and x up to the second degree, so sums over rows, then columns.
    powers = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    moments = _moments(share, down, along)
    gram = np.array([[moments[i + k, j + m] for k, m in powers] for i, j in powers])
    # A pseudoinverse, because a thin sample does not tell all six apart.
    inverse = np.linalg.pinv(gram, hermitian=True)
    result = np.empty((levels.shape[2], *share.shape))
    for k in range(levels.shape[2]):
        total = means(levels[..., k] * usable, step)
        sums = _moments(total, down[:3], along[:3])
        lines = np.zeros((3, share.shape[1]))
        for (i, j), factor in zip(powers, inverse @ [sums[p] for p in powers], strict=True):
            lines[i] += factor * along[j]
        for power, line in zip(down, lines, strict=False):
            total -= share * (power[:, None] * line)
        total[abs(total) < 1e-6] = 0  # the surface's own rounding
        result[k] = total
    return Relief(result, share, step)


def usable_box(exemplar: Exemplar) -> tuple[slice, ...]:
    """Return the box around the usable pixels."""
    if exemplar.mask is None:
        return ()
    lines = [np.flatnonzero(exemplar.mask.any(axis=axis)) for axis in (1, 0)]
    return tuple(slice(one[0], one[-1] + 1) for one in lines)


def mixed(levels: Floats) -> Floats:
    """Return the mixture of channels that varies most, dark where most channels are dark."""
    alike = [[np.einsum("yx,yx->", one, other) for other in levels] for one in levels]
    shares = np.linalg.eigh(alike)[1][:, -1]
    result: Floats = np.zeros(levels.shape[1:])
    for share, level in zip(shares if shares.sum() >= 0 else -shares, levels, strict=True):
        result += share * level
    return result


def maps_alone(exemplar: Exemplar) -> Exemplar | None:
    """Return a sample's maps, as they are matched, without its own pixels; None if it has none."""
    levels = exemplar.matching()[..., exemplar.channels :]
    if not levels.shape[2]:
        return None
    return Exemplar(levels, mask=exemplar.mask, alpha=False, name=exemplar.name)


def means(values: NDArray[Any], step: int) -> Floats:
    """Return means over whole squares of step x step of the last two axes."""
    if step == 1:
        return values.astype(np.float64)
    *first, height, width = values.shape
    high, wide = min(step, height), min(step, width)  # a thin sample has fewer
    rows, columns = height // high, width // wide
    cut = values[..., : rows * high, : columns * wide].reshape(*first, rows, high, columns, wide)
    return np.asarray(cut.mean(axis=(-3, -1), dtype=np.float64))


def _moments(values: Floats, down: Floats, along: Floats) -> Floats:
    """Sums of values times each power of y and of x (n, y) and (m, x).

    Not by a matrix product, whose threads wait for one another longer than it takes.
    """
    rows = [np.einsum("yx,x->y", values, power) for power in along]
    return np.array([[(row * p).sum() for row in rows] for p in down])


def smaller_copy(exemplar: Exemplar, largest: int) -> tuple[Exemplar, int]:
    """Return a sample averaged to at most `largest` pixels a side, and how many times smaller."""
    step = -(-max(exemplar.shape) // largest)
    if step == 1:
        return exemplar, 1
    levels = exemplar.matching()
    pixels = np.stack([means(levels[..., k], step) for k in range(levels.shape[2])], axis=2)
    mask = None
    if exemplar.mask is not None:
        share = means(exemplar.mask, step)
        mask = share > (0.5 if (share > 0.5).any() else 0)
    pixels = np.rint(pixels).astype(np.uint8)
    return Exemplar(pixels, mask=mask, alpha=False, name=exemplar.name), step
