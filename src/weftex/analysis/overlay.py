"""A lattice drawn over its sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.lattice import Lattice
    from weftex.exemplar import Exemplar

    Floats = NDArray[np.float64]

_BINS = 48  # phases of a line that are tried


def draw_lattice(exemplar: Exemplar, lattice: Lattice | None) -> NDArray[np.uint8]:
    """Draw the sides of the tiles over a sample, or lines between rows.

    A lattice says how far to shift and not where tiles begin, so the lines lie where the sample
    changes most: in the joints, where there are some.
    """
    levels = _levels(exemplar)
    picture = levels.copy()
    if lattice is None:
        return picture
    height, width = exemplar.shape
    y, x = np.mgrid[:height, :width].astype(np.float64)
    lines = np.zeros((height, width), bool)
    for across, phase in _lines_over(levels, lattice):
        # Whole numbers are where a line could be; it is as thick as a pixel, more on big samples.
        off = x * across[0] + y * across[1] - phase
        thick = max(1.0, max(height, width) / 500)
        lines |= abs(off - np.rint(off)) < thick / 2 * float(np.hypot(*across)) + 1e-9
    red, green, blue = levels.reshape(-1, 3).mean(axis=0)
    picture[lines] = (0, 255, 0) if max(red, blue) > 1.2 * green + 10 else (255, 0, 255)
    return picture


def lattice_lines(exemplar: Exemplar, lattice: Lattice) -> list[tuple[Floats, float]]:
    """Return where `draw_lattice` draws lines, for whoever draws them."""
    return _lines_over(_levels(exemplar), lattice)


def _levels(exemplar: Exemplar) -> NDArray[np.uint8]:
    """The sample in three channels of bytes; clear pixels are white."""
    matching = exemplar.as_matching(exemplar.pixels)
    colors = exemplar.channels - exemplar.alpha
    levels = matching[..., :3] if colors >= 3 else np.repeat(matching[..., :1], 3, axis=2)
    if exemplar.alpha:
        clear = 255 - matching[..., -1:].astype(int)
        levels = np.minimum(levels + clear, 255).astype(np.uint8)
    return levels


def _lines_over(levels: NDArray[np.uint8], lattice: Lattice) -> list[tuple[Floats, float]]:
    """Each family of lines where the levels change most."""
    gray = levels.mean(axis=2)
    change = sum(
        abs(np.gradient(gray, axis=axis)) if side > 1 else 0 * gray
        for axis, side in enumerate(gray.shape)
    )
    y, x = np.mgrid[: gray.shape[0], : gray.shape[1]].astype(np.float64)
    return [
        (across, _busiest(x * across[0] + y * across[1], change)) for across in _across(lattice)
    ]


def draw_correlation(correlation: Floats) -> NDArray[np.uint8]:
    """A correlation as a gray picture: white is 1, the gray in the middle 0, black -1."""
    gray: NDArray[np.uint8] = np.rint((correlation + 1) * 127.5).astype(np.uint8)
    return gray


def _across(lattice: Lattice) -> list[Floats]:
    """For each family of lines, what times (x, y) counts them: rows of the inverse basis."""
    vectors = np.array(lattice.vectors)
    if len(vectors) == 1:
        return [vectors[0] / (vectors[0] @ vectors[0])]
    return list(np.linalg.inv(vectors).T)


def _busiest(place: Floats, change: Floats) -> float:
    """The phase of a line along which the sample changes most."""
    bins = (place % 1 * _BINS).astype(int) % _BINS
    total = np.bincount(bins.ravel(), change.ravel(), _BINS)
    count = np.bincount(bins.ravel(), minlength=_BINS)
    return float((np.argmax(np.rint(total / np.maximum(count, 1) * 1e6)) + 0.5) / _BINS)
