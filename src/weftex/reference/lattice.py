"""Regular structure detection (López Recas, 2011, chapter 3).

`weftex.analysis.lattice.find_lattice` follows it with `goodness="height"`, and adds vectors with
fractions, evidence for and against a lattice, and rows where there is no lattice.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from weftex.reference.common import checked


class Found(NamedTuple):
    """The result of `lattice`.

    Attributes
    ----------
    vectors : ((int, int), (int, int))
        The translation vectors v1 and v2 as (x, y) in pixels; the second is (0, 0) if there are
        none.
    goodness : float
        Goodness of the vectors, eq. (3.22).
    correlation : float array (2 h - 1, 2 w - 1)
        The normalized autocorrelation gamma; the shift (x, y) is at [y + h - 1, x + w - 1].
    """

    vectors: tuple[tuple[int, int], tuple[int, int]]
    goodness: float
    correlation: Any


def lattice(sample: Any, alpha: float = 1.12, significant: float = 0.85) -> Found:
    """Find the translation vectors of a near-regular texture.

    D. López Recas: Constrained random sampling and gap filling technique for near-regular texture
    synthesis, diploma thesis, TU Berlin 2011, chapter 3.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The input texture sample.
    alpha : float
        Exponent of eq. (3.22); above 1 it gives priority to smaller tiles.
    significant : float
        Share of the tile that an overlap must contain to count (section 3.3.1).

    Returns
    -------
    Found
        The vectors, their goodness, and the autocorrelation.

    Notes
    -----
    A local maximum is a value above or equal to its eight neighbors, and positive. Eq. (3.22) rates
    any pair with a significant multiple. The text at Fig. 3.5 says more, and is followed: a tile
    without a "valid multiple of v1" has goodness 0. The method asks the same of v2.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import lattice
    >>> tile = np.random.default_rng(0).integers(0, 255, (7, 9), np.uint8)
    >>> lattice(np.tile(tile, (4, 4))).vectors
    ((0, 7), (9, 0))
    """
    pixels, _ = checked(sample, 1)
    height, width = pixels.shape[:2]
    gamma = autocorrelation(pixels)

    def right_half(v: Any) -> Any:
        """V or -v, which is equivalent (observation iii)."""
        return v if (v[0], v[1]) > (0, 0) else -v

    # Steps 1 and 2: local maxima of the right half, as displacements in ascending length.
    padded = np.pad(gamma, 1, constant_values=-1)
    around = np.lib.stride_tricks.sliding_window_view(padded, (3, 3)).max(axis=(2, 3))
    y, x = np.nonzero((gamma >= around) & (gamma > 0))
    c1 = np.stack([x - width + 1, y - height + 1], axis=1)
    c1 = np.array([v for v in c1.tolist() if tuple(v) > (0, 0)], int).reshape(-1, 2)
    c1 = c1[np.lexsort((c1[:, 0], c1[:, 1], (c1**2).sum(axis=1)))]

    def reduced(v1: Any, longer: Any) -> Any:
        """Step 4: of all equivalent pairs the ones with the greatest angle, without duplicates."""
        times = np.rint(longer @ v1 / (v1 @ v1)).astype(int)
        pairs = {tuple(right_half(v2).tolist()) for v2 in longer - times[:, None] * v1}
        return sorted(v2 for v2 in pairs if v2[0] ** 2 + v2[1] ** 2 >= v1 @ v1)

    # Step 3: explore each vector in order, with those after it in the list.
    best: tuple[float, Any] = 0.0, ((0, 0), (0, 0))
    for i, v1 in enumerate(c1):
        for v2 in reduced(v1, c1[i + 1 :]):
            rated, _ = goodness(gamma, v1, v2, alpha, significant)
            if rated > best[0]:  # step 6: the pair with the higher goodness
                best = rated, (tuple(v1.tolist()), v2)
    return Found(best[1], best[0], gamma)


def autocorrelation(pixels: Any) -> Any:
    """Eq. (3.13), the GNCC of all channels with themselves, in the frequency domain."""
    height, width = pixels.shape[:2]
    shape = (2 * height - 1, 2 * width - 1)

    def correlated(f: Any, g: Any) -> Any:
        """The sum over the overlap of f(x) g(x - x0) for every shift x0."""
        product = np.fft.rfft2(f, shape) * np.conj(np.fft.rfft2(g, shape))
        return np.fft.fftshift(np.fft.irfft2(product, shape))

    ones, above, below = np.ones((height, width)), 0.0, 0.0
    n = np.rint(correlated(ones, ones))
    for f in np.moveaxis(pixels.astype(float), 2, 0):
        s_f, s_g = correlated(f, ones), correlated(ones, f)
        s_f2, s_g2 = correlated(f * f, ones), correlated(ones, f * f)
        above = above + n * correlated(f, f) - s_f * s_g
        energy = np.maximum(n * s_f2 - s_f**2, 0) * np.maximum(n * s_g2 - s_g**2, 0)
        below = below + np.sqrt(energy)
    constant = below <= 1e-9 * np.max(below)  # no structure information
    return np.where(constant, 0.0, above / np.where(constant, 1.0, below))


def goodness(
    gamma: Any, v1: Any, v2: Any, alpha: float = 1.12, significant: float = 0.85
) -> tuple[float, int]:
    """Step 5, eq. (3.22), and n: over the significant multiples on the right half."""
    height, width = (n // 2 + 1 for n in gamma.shape)
    area = abs(int(v1[0] * v2[1] - v1[1] * v2[0]))  # eq. (3.25)

    def counts(x: int, y: int) -> bool:
        """Section 3.3.1: whether the overlap at a shift contains enough of the tile."""
        wide, high = max(0, width - abs(x)), max(0, height - abs(y))
        if wide * high < significant * area:
            return False
        return identifiers(v1, v2, wide, high) >= significant * area

    if area == 0 or not counts(*v1):
        return 0.0, 0
    found = [(x, y) for x, y in multiples(v1, v2, width, height) if counts(x, y)]
    total = sum(gamma[y + height - 1, x + width - 1] for x, y in found)
    return max(total, 0.0) ** alpha / max(len(found), 1), len(found)


def multiples(v1: Any, v2: Any, width: int, height: int) -> Any:
    """All a v1 + b v2 on the right half of the autocorrelation, but the origin."""
    v = np.array([v1, v2])
    corners = np.array([[x, y] for x in (-width, width) for y in (-height, height)])
    reach = np.ceil(abs(corners @ np.linalg.inv(v)).max(axis=0)).astype(int)
    a, b = np.mgrid[-reach[0] : reach[0] + 1, -reach[1] : reach[1] + 1]
    found = np.stack([a.ravel(), b.ravel()], axis=1) @ v
    inside = (abs(found) < (width, height)).all(axis=1)
    return [v for v in found[inside].tolist() if tuple(v) > (0, 0)]


def identifiers(v1: Any, v2: Any, width: int, height: int) -> int:
    """Section 3.3.1: how many positions within the tile a rectangle contains (Fig. 3.7)."""
    determinant = v1[0] * v2[1] - v1[1] * v2[0]
    y, x = np.indices((height, width))
    # Eqs. (3.28) and (3.29): multiples of v1 and v2, times the area, wrapped to the first tile.
    along_v1 = (x * v2[1] - y * v2[0]) % abs(determinant)
    along_v2 = (y * v1[0] - x * v1[1]) % abs(determinant)
    return len(np.unique(along_v1 * abs(determinant) + along_v2))
