"""Texture synthesis by non-parametric sampling (Efros and Leung, 1999).

The method `efros-leung` makes the same bytes with the default `threshold` and `seed_size`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.random import draw
from weftex.reference.common import Made, checked, fits, made, pick, windows


def efros_leung(
    sample: Any,
    size: Any,
    window: int,
    tolerance: float = 0.1,
    threshold: float = 0.3,
    seed_size: int = 3,
    seed: int = 0,
) -> Made:
    """Grow a texture from a small piece of the sample, one pixel at a time.

    A. A. Efros, T. K. Leung: Texture synthesis by non-parametric sampling, ICCV 1999, section 2,
    with the values of the pseudocode that its authors published.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The sample image.
    size : int or (int, int)
        Height and width of the output in pixels.
    window : int
        Width of the context window in pixels, odd; the only parameter of the paper.
    tolerance : float
        ErrThreshold, the paper's epsilon: candidates differ at most 1 + epsilon times as much as
        the best match.
    threshold : float
        MaxErrThreshold: a pixel whose match differs more waits. In mean squared difference, 1 is
        black against white. It rises by a tenth when no pixel of a layer has such a
        match, and in each layer after 8 tries per pixel.
    seed_size : int
        Side of the piece of the sample in the middle from which the texture grows, in pixels;
        larger values than `window` are reduced to it.
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Notes
    -----
    The paper leaves open how weights are stored: here as whole numbers from 1 to 127.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import efros_leung
    >>> sample = np.indices((12, 12)).sum(0).astype(np.uint8) % 3 * 100
    >>> efros_leung(sample, (8, 9), window=5, seed=1).image.shape
    (8, 9)
    """
    pixels, (height, width) = checked(sample, size, seed)
    half = fits("window", window, pixels, odd=True) // 2
    side = fits("seed_size", min(seed_size, window), pixels)
    if tolerance < 0 or threshold <= 0:
        raise InvalidInputError(
            f"tolerance is {tolerance} and threshold {threshold}; from 0 on and above 0"
        )
    omega = windows(pixels, window, window).reshape(-1, window, window, pixels.shape[2])
    columns = pixels.shape[1] - 2 * half
    image = np.zeros((height, width, pixels.shape[2]), np.int64)
    sources = np.full((height, width, 2), -1)
    filled = np.zeros((height, width), bool)

    # G, a two-dimensional Gaussian kernel with sigma = WindowSize / 6.4.
    distance = np.hypot(*np.mgrid[-half : half + 1, -half : half + 1])
    gauss = np.exp(-(distance**2) / 2 / (window / 6.4) ** 2)
    gauss = np.maximum(1, np.rint(127 * gauss)).astype(np.int64)

    def fill(p: tuple[int, int], at: tuple[int, int]) -> None:
        image[p], sources[p], filled[p] = pixels[at], at, True

    def plant_seed() -> None:
        """Copy a random piece of the sample into the middle."""
        v, u = divmod(pick(len(omega), seed, "efros-leung seed"), columns)
        rows, cols = min(side, height), min(side, width)
        for i, j in np.ndindex(rows, cols):
            at = v + half - side // 2 + i, u + half - side // 2 + j
            fill(((height - rows) // 2 + i, (width - cols) // 2 + j), at)

    def neighborhood(p: tuple[int, int]) -> Any:
        """GetNeighborhoodWindow: which pixels around p are filled, as steps in the window."""
        steps = np.argwhere(np.pad(filled, half)[p[0] :, p[1] :][:window, :window])
        return steps[(steps != half).any(axis=1)].T

    def unfilled_neighbors() -> list[tuple[int, int]]:
        """GetUnfilledNeighbors: next to filled pixels, those with most filled pixels around first.

        "The list is randomly permuted and then sorted."
        """
        around = windows(np.pad(filled, 1), 3, 3).any(axis=(2, 3))
        layer = [(int(y), int(x)) for y, x in np.argwhere(around & ~filled)]
        known = {p: neighborhood(p).shape[1] for p in layer}
        return sorted(layer, key=lambda p: (-known[p], int(draw(seed, "efros-leung order", *p))))

    def find_matches(p: tuple[int, int]) -> tuple[Any, Any, int]:
        """FindMatches: the SSD weighted by G over filled pixels, for each window of the sample."""
        v, u = neighborhood(p)
        template = image[p[0] + v - half, p[1] + u - half]
        ssd = (((omega[:, v, u] - template) ** 2).sum(axis=2) * gauss[v, u]).sum(axis=1)
        candidates = np.flatnonzero(ssd <= ssd.min() * (1 + tolerance))
        return candidates, ssd, int(gauss[v, u].sum())

    plant_seed()
    tries_left = 8 * int((~filled).sum())
    while not filled.all():
        progress, layer = False, unfilled_neighbors()
        for p in layer:
            candidates, ssd, total_weight = find_matches(p)
            best = candidates[pick(len(candidates), seed, "efros-leung", *p)]  # RandomPick
            error = ssd[best] / (255**2 * pixels.shape[2] * max(total_weight, 1))
            if error <= threshold:
                v, u = divmod(int(best), columns)
                fill(p, (v + half, u + half))
                progress = True
        tries_left -= progress * len(layer)
        if not progress or tries_left < 0:  # the paper has no bound on tries; one is needed
            threshold *= 1.1
    return made(sample, image, sources)
