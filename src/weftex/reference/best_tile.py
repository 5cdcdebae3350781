"""Best self-similar tile repetition (López Recas, 2011, section 4.1).

The method `best-tile` makes the same bytes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.reference.common import Made, at, checked, made, places


def best_tile(sample: Any, size: Any, vectors: Any, border: int = 10) -> Made:
    """Repeat the tile of the sample whose opposite borders differ least.

    D. López Recas: Constrained random sampling and gap filling technique for near-regular texture
    synthesis, diploma thesis, TU Berlin 2011, section 4.1.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The input texture sample.
    size : int or (int, int)
        Height and width of the output in pixels.
    vectors : ((x, y), (x, y))
        The translation vectors v1 and v2 in pixels, x to the right and y downwards.
    border : int
        Width of the borders that are compared in pixels, centered on the sides of a tile.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Notes
    -----
    Fractional vectors are rounded only when a pixel is looked up. A tile is considered if
    it lies in the sample with half its borders.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import best_tile
    >>> tile = np.arange(30, dtype=np.uint8).reshape(5, 6)
    >>> image = best_tile(np.tile(tile, (4, 4)), (10, 12), ((6, 0), (0, 5)), border=2).image
    >>> bool((image == np.tile(tile, (2, 2))).all())
    True
    """
    pixels, (height, width) = checked(sample, size)
    v = np.array(vectors, float)[:, ::-1]  # rows first
    inverse = np.linalg.inv(v)
    shape = pixels.shape[:2]

    def differences(k: int) -> Any:
        """Eq. (4.2), Fig. 4.4 (b): squared color difference of each pixel and the one at v_k."""
        there = places(*shape) + np.rint(v[k]).astype(int)
        inside = ((there >= 0) & (there < shape)).all(axis=2)
        result = np.zeros(shape, np.int64)
        result[inside] = ((at(pixels, there[inside]) - pixels[inside]) ** 2).sum(axis=1)
        return result

    def integrated(values: Any, patch: Any) -> Any:
        """Fig. 4.4 (c): the sum of a patch of the border's shape at every place."""
        reach = int(abs(patch).max())
        padded, total = np.pad(values, reach), np.zeros(shape, np.int64)
        for dy, dx in patch + reach:
            total += padded[dy : dy + shape[0], dx : dx + shape[1]]
        return total

    # The left and right borders are v1 apart and lie along v2, the top and bottom ones v2 and v1.
    reach = (border + 1) // 2  # on either side of an edge
    error = integrated(differences(0), within(0 * v[1], v[1], reach))
    error += integrated(differences(1), within(0 * v[0], v[0], reach))
    # Tiles whose borders are outside have undefined self-similarity.
    tile = within(v[0], v[1], reach)
    first, last = np.maximum(-tile.min(axis=0), 0), shape - np.maximum(tile.max(axis=0), 0)
    if (first >= last).any():
        raise InvalidInputError(f"vectors are {vectors}; no such tile lies in the sample")
    defined = error[first[0] : last[0], first[1] : last[1]]
    # The lowest total is the best self-similar tile; its top-left corner is the anchor point.
    anchor = first + np.unravel_index(defined.argmin(), defined.shape)

    # Eq. (4.1): f(x) = f(x + a v1 + b v2).
    offset = places(height, width) - anchor
    multiples = np.floor(offset @ inverse + 2.0**-20)
    sources = anchor + offset - np.rint(multiples @ v).astype(int)
    sources = np.clip(sources, 0, np.array(shape) - 1)
    return made(sample, at(pixels, sources), sources)


def within(v1: Any, v2: Any, reach: int) -> Any:
    """Steps to the pixels within `reach` rows and columns of the parallelogram of two vectors.

    They lie between two lines along each side, and within a range of rows and of columns. Pixels on
    a lower or right border belong to the next tile.
    """
    corners = np.array([0 * v1, v1, v2, v1 + v2])
    first = np.floor(corners.min(axis=0)).astype(int) - reach - 1
    last = np.ceil(corners.max(axis=0)).astype(int) + reach + 1
    steps = first + places(*(last - first + 1)).reshape(-1, 2)
    inside = np.ones(len(steps), bool)
    for normal in np.array([[1, 0], [0, 1], [v1[1], -v1[0]], [v2[1], -v2[0]]]):
        along, margin = corners @ normal, reach * abs(normal).sum()
        nudged = (steps + (2.0**-40, 2.0**-20)) @ normal
        inside &= (along.min() - margin <= nudged) & (nudged <= along.max() + margin)
    return steps[inside]
