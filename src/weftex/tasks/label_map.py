"""Label maps: which sample goes where (section 4 of the paper on texture fusion)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.random import draw

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

_SIGMA = 80.0  # pixels: how fast the second sample takes over in a circle map
_SHOWN = 6  # colors that a message lists


def labels_of(
    picture: NDArray[Any], count: int, colors: Sequence[Any] | None = None
) -> tuple[NDArray[np.int32], list[Any]]:
    """Number the colors of a painted map.

    Parameters
    ----------
    picture : array (H, W) or (H, W, C)
        Of any dtype; alpha must be constant.
    count : int
        How many colors there must be.
    colors : sequence of colors, optional
        The color of each label, as numbers or tuples of numbers of the picture's dtype; then
        other colors count as the nearest of these, so that painted edges may be smooth. By
        default the colors are numbered as they appear, from the upper left corner row by row.

    Returns
    -------
    labels : int32 array (H, W)
    colors : list
        The color of each label.

    Raises
    ------
    InvalidInputError
        If the map has more or fewer colors, or one of `colors` is not in it.
    """
    if picture.ndim not in (2, 3) or picture.size == 0:
        raise InvalidInputError(f"the map has shape {picture.shape}; it must be (H, W[, C])")
    flat = picture.reshape(picture.shape[0] * picture.shape[1], -1)
    if colors is None:
        found, first, inverse = np.unique(flat, axis=0, return_index=True, return_inverse=True)
        order = np.argsort(first)
        if len(found) != count:
            shown = ", ".join(_text(c) for c in found[order][:_SHOWN])
            more = ", ..." if len(found) > _SHOWN else ""
            raise InvalidInputError(
                f"the map has {len(found)} colors ({shown}{more}) for {count} samples; there must "
                "be one for each sample, or say which colors to take"
            )
        rank = np.empty(count, np.int32)
        rank[order] = np.arange(count, dtype=np.int32)
        labels, wanted = rank[inverse.ravel()], found[order]
    else:
        if len(colors) != count:
            raise InvalidInputError(
                f"{len(colors)} colors for {count} samples or mixed regions; give one each"
            )
        try:
            wanted = np.array([np.ravel(c) for c in colors])
            wanted = wanted if wanted.dtype.kind in "biuf" else np.zeros((0, 0))
        except (TypeError, ValueError, OverflowError):
            wanted = np.zeros((0, 0))
        if wanted.shape != (count, flat.shape[1]):
            raise InvalidInputError(f"each color must have {flat.shape[1]} numbers, as in the map")
        distance = np.stack([((flat - c.astype(np.float64)) ** 2).sum(axis=1) for c in wanted])
        labels = distance.argmin(axis=0).astype(np.int32)
        for k in range(count):
            if not (distance[k] == 0).any():
                raise InvalidInputError(f"the map has no pixel of the color {_text(wanted[k])}")
    return labels.reshape(picture.shape[:2]), [tuple(c.tolist()) for c in wanted]


def circle_map(size: tuple[int, int], radii: tuple[int, int], seed: int) -> NDArray[np.int32]:
    """Make a map that goes over from the first sample to the second, from top to bottom.

    Circles are placed at random until everything is covered. At a distance of x pixels from the
    top row a circle is of the first sample with probability exp(-x^2 / 2 sigma^2), sigma being
    80; where it meets the other sample's color, that becomes a region of both mixed.

    Parameters
    ----------
    size : (int, int)
        Height and width.
    radii : (int, int)
        Of the circles: the dominant scales of the two samples, in pixels.
    seed : int
        From `weftex.random.seed_number`.

    Returns
    -------
    int32 array (H, W)
        0 and 1 for the samples, 2 where they are mixed.

    Examples
    --------
    >>> circle_map((200, 60), (9, 7), seed=1)[[0, -1]].max(axis=1).tolist()
    [0, 1]
    """
    height, width = size
    labels = np.full(size, -1, np.int32)
    left, number = height * width, 0
    while left:
        # The last gaps are aimed at, or they would take for ever.
        bits = draw(seed, "circle", number, np.arange(3))
        if number % 2:
            open_pixels = np.flatnonzero(labels < 0)
            y, x = divmod(int(open_pixels[int(bits[0] % np.uint64(len(open_pixels)))]), width)
        else:
            y, x = int(bits[0] % np.uint64(height)), int(bits[1] % np.uint64(width))
        first = int(bits[2] >> np.uint64(11)) / 2**53 < np.exp(-(y**2) / (2 * _SIGMA**2))
        label, radius = (0, radii[0]) if first else (1, radii[1])
        rows = slice(max(0, y - radius), y + radius + 1)
        columns = slice(max(0, x - radius), x + radius + 1)
        v, u = np.ogrid[
            rows.start : min(rows.stop, height), columns.start : min(columns.stop, width)
        ]
        inside = (v - y) ** 2 + (u - x) ** 2 <= radius**2
        part = labels[rows, columns]
        left -= int((inside & (part < 0)).sum())
        met = inside & (part == 1 - label)
        part[inside & (part < 0)] = label
        part[met] = 2
        number += 1
    return labels


def _text(color: NDArray[Any]) -> str:
    return "(" + ", ".join(f"{v:g}" for v in color) + ")" if len(color) > 1 else f"{color[0]:g}"
