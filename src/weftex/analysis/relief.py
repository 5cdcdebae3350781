"""What the analyses look at: the sample's levels without slow lighting."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from weftex.exemplar import Exemplar

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LARGEST_SIDE = 1024  # pixels a side; more are averaged together first
#: Scale, lattice, regularity and evenness of one sample all look at the same.
_TAKEN: WeakKeyDictionary[Exemplar, Relief] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Relief:
    """Levels around a smooth surface.

    Attributes
    ----------
    levels : float64 array (K, h, w)
        The bytes of `Exemplar.matching` less the quadratic surface nearest to them; 0 where the
        sample may not be used.
    usable : float64 array (h, w)
        Share of usable pixels, from 0 to 1.
    step : int
        Pixels of the sample to one here.
    """

    levels: NDArray[np.float64]
    usable: NDArray[np.float64]
    step: int


def relief(exemplar: Exemplar) -> Relief:
    """Take slow lighting off a sample: a quadratic surface, fitted to each channel.

    What lies outside the box around the usable pixels is cut off. Samples larger than 1024 pixels
    are averaged over squares of step x step pixels, so structure of a few steps is lost in them.

    Parameters
    ----------
    exemplar : Exemplar
        The sample.

    Returns
    -------
    Relief
        Not to be changed: it is taken once from each sample.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.exemplar import Exemplar
    >>> ramp = np.add.outer(np.arange(20), 2 * np.arange(30)).astype(np.uint8)
    >>> bool(abs(relief(Exemplar(ramp)).levels).max() < 1e-9)
    True
    """
    if exemplar not in _TAKEN:
        found = _taken(exemplar)
        found.levels.flags.writeable = found.usable.flags.writeable = False
        _TAKEN[exemplar] = found
    return _TAKEN[exemplar]


def _taken(exemplar: Exemplar) -> Relief:
    levels = exemplar.matching()
    usable = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    rows, columns = (np.flatnonzero(usable.any(axis=axis)) for axis in (1, 0))
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    levels, usable = levels[box], usable[box]
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


def mixed(levels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mixture of channels that varies most.

    Parameters
    ----------
    levels : float64 array (K, h, w)
        Around 0.

    Returns
    -------
    float64 array (h, w)
        Dark where most channels are dark.

    Examples
    --------
    >>> red = np.array([[3.0, -3.0]])
    >>> mixed(np.stack([red, 0 * red])).tolist()
    [[3.0, -3.0]]
    """
    alike = [[np.einsum("yx,yx->", one, other) for other in levels] for one in levels]
    shares = np.linalg.eigh(alike)[1][:, -1]
    result: NDArray[np.float64] = np.zeros(levels.shape[1:])
    for share, level in zip(shares if shares.sum() >= 0 else -shares, levels, strict=True):
        result += share * level
    return result


def maps_alone(exemplar: Exemplar) -> Exemplar | None:
    """Return a sample's maps, as they are matched, without its own pixels; None if it has none.

    Examples
    --------
    >>> flat = np.zeros((8, 8, 3), np.uint8)
    >>> maps_alone(Exemplar(flat, maps={"normal": flat, "ao": flat[..., 0]})).channels
    4
    """
    levels = exemplar.matching()[..., exemplar.channels :]
    if not levels.shape[2]:
        return None
    return Exemplar(levels, mask=exemplar.mask, alpha=False, name=exemplar.name)


def means(values: NDArray[Any], step: int) -> NDArray[np.float64]:
    """Means over squares of step x step of the last two axes; those not whole are left out."""
    if step == 1:
        return values.astype(np.float64)
    *first, height, width = values.shape
    high, wide = min(step, height), min(step, width)  # a thin sample has fewer
    rows, columns = height // high, width // wide
    cut = values[..., : rows * high, : columns * wide].reshape(*first, rows, high, columns, wide)
    found: NDArray[np.float64] = cut.mean(axis=(-3, -1), dtype=np.float64)
    return found


def _moments(
    values: NDArray[np.float64], down: NDArray[np.float64], along: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Sums of values times each power of y and of x (n, y) and (m, x).

    Not by a matrix product, whose threads wait for one another longer than it takes.
    """
    rows = [np.einsum("yx,x->y", values, power) for power in along]
    result: NDArray[np.float64] = np.array([[(row * p).sum() for row in rows] for p in down])
    return result


def smaller_copy(exemplar: Exemplar, largest: int) -> tuple[Exemplar, int]:
    """Average a sample down until it has at most so many pixels a side.

    Parameters
    ----------
    exemplar : Exemplar
        The sample.
    largest : int
        Pixels a side.

    Returns
    -------
    Exemplar, int
        The sample itself, or a copy of what distances are taken on; and how many times smaller.
    """
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
