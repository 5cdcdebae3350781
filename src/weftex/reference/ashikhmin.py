"""Synthesizing natural textures (Ashikhmin, 2001).

The method `ashikhmin` makes the same bytes with one pass, if `replacements=8` here.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from weftex.reference.common import Made, checked, fits, made, pick, window_steps


def ashikhmin(
    sample: Any, size: Any, window: int = 5, replacements: int = 1, seed: int = 0
) -> Made:
    """Copy each pixel from where the source of one of its neighbors continues.

    M. Ashikhmin: Synthesizing natural textures, Symposium on Interactive 3D Graphics 2001,
    section 3.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The sample image.
    size : int or (int, int)
        Height and width of the output in pixels.
    window : int
        Width of the square whose part before the pixel is the L-shaped neighborhood, in pixels,
        odd.
    replacements : int
        Random positions that are tried if candidates lie outside the sample.
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Notes
    -----
    Rows wrap around: the last rows start as random pixels, with which the first rows are compared.
    If the output is no higher than the window, they are compared with nothing. The paper wraps
    columns too, and this function does not. The whole square around a candidate lies in the
    sample. Candidates are tried from the last neighbor in scan order to the first, then random
    ones; of equal distances the first wins.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import ashikhmin
    >>> sample = np.random.default_rng(0).integers(0, 255, (24, 24), np.uint8)
    >>> ashikhmin(sample, (12, 16), seed=1).image.shape
    (12, 16)
    """
    pixels, (height, width) = checked(sample, size, seed)
    half = fits("window", window, pixels, odd=True) // 2
    rows, columns = pixels.shape[0] - 2 * half, pixels.shape[1] - 2 * half
    image = np.zeros((height, width, pixels.shape[2]), np.int64)
    # The array of original pixel positions: where each pixel of the output comes from.
    sources = np.full((height, width, 2), -1)
    l_shaped = window_steps(half)[: window**2 // 2].tolist()

    def copy(p: tuple[int, int], place: tuple[int, int]) -> None:
        image[p], sources[p] = pixels[place], place

    def random_position(*purpose: Any) -> tuple[int, int]:
        v, u = divmod(pick(rows * columns, seed, *purpose), columns)
        return v + half, u + half

    def neighborhood(y: int, x: int) -> list[tuple[int, int]]:
        """Steps to the L-shaped neighborhood; above the first row lie the last ones."""
        return [(a, b) for a, b in l_shaped if 0 <= x + b < width and (height >= window or a >= -y)]

    def candidates(y: int, x: int) -> list[tuple[int, int]]:
        """The neighbors' positions, shifted; random ones for those outside the valid region."""
        found: list[tuple[int, int] | None] = []  # None is outside
        for dy, dx in reversed(neighborhood(y, x)):
            v, u = sources[(y + dy) % height, x + dx] - (dy, dx)
            valid = half <= v < half + rows and half <= u < half + columns
            place = (int(v), int(u)) if valid else None
            if place not in found:  # duplicates are removed
                found.append(place)
        inside = [place for place in found if place is not None]
        if len(inside) < len(found) or not found:
            for k in range(replacements):
                inside.append(random_position("ashikhmin", 0, y * width + x, k))
        return inside

    def distance(y: int, x: int, place: tuple[int, int]) -> int:
        """The sum of squared differences of both L-shaped neighborhoods."""
        dy, dx = np.array(neighborhood(y, x), int).reshape(-1, 2).T
        here, there = image[(y + dy) % height, x + dx], pixels[place[0] + dy, place[1] + dx]
        return int(((here - there) ** 2).sum())

    for y in range(max(0, height - half), height):  # what lies above the first row
        for x in range(width):
            copy((y, x), random_position("ashikhmin start", y * width + x))
    for y, x in np.ndindex(height, width):  # in scan order
        copy((y, x), min(candidates(y, x), key=lambda place: distance(y, x, place)))
    return made(sample, image, sources)
