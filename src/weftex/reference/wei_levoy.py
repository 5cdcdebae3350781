"""Synthesis by tree-structured vector quantization (Wei and Levoy, 2000).

The method `wei-levoy` makes the same bytes with `start="noise"`, and either `search="full"` or
`tree_size` and `leaves=1`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from weftex.random import draw
from weftex.reference.common import Made, checked, fits, made, window_steps


def wei_levoy(
    sample: Any,
    size: Any,
    window: int,
    levels: int = 1,
    parent_window: int = 3,
    tree_size: int = 0,
    seed: int = 0,
) -> Made:
    """Replace noise by the nearest pixels of the sample, in raster scan order.

    L.-Y. Wei, M. Levoy: Fast texture synthesis using tree-structured vector quantization, SIGGRAPH
    2000: section 2 (one resolution), 3 (several) and 4 (TSVQ). The steps are named as in section
    III.B of the survey of non-parametric sampling and TSVQ.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The sample image.
    size : int or (int, int)
        Height and width of the output in pixels. Windows wrap around, yet a seam may remain.
    window : int
        S, the width of the causal neighborhood in pixels, odd.
    levels : int
        Levels of the Gaussian pyramids; 1 is the algorithm of a single resolution.
    parent_window : int
        N < S, the width of the whole neighborhood at the next coarser level in pixels, odd.
    tree_size : int
        Number of leaves of each level's tree (TSVQ); 0 compares all neighborhoods.
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Notes
    -----
    The paper leaves open how noise gets the sample's histogram: here each pixel of the sample is
    used equally often, in random order. Borders of the sample are continued by their last pixels
    when its pyramid is made. Of equal distances the first in scan order wins. In a leaf, the
    nearest neighborhood replaces the codeword, so that every pixel is a copy.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import wei_levoy
    >>> sample = np.indices((16, 16)).sum(0).astype(np.uint8) % 4 * 60
    >>> wei_levoy(sample, (10, 12), window=5, levels=2, seed=1).image.shape
    (10, 12)
    """
    pixels, shape = checked(sample, size, seed)
    half, parent_half = fits("window", window, pixels, odd=True, least=3) // 2, parent_window // 2
    inputs = gaussian_pyramid(pixels, levels, torus=False)

    # Step 1: random white noise. Step 2: with the histogram of the input image.
    sources = noise_like(pixels.shape[:2], shape, seed)
    noise = pixels.reshape(-1, pixels.shape[2])[sources]
    outputs = gaussian_pyramid(noise, levels, torus=True)

    causal = window_steps(half)[: window**2 // 2]  # before the pixel in raster scan order
    whole = window_steps(parent_half)

    for level in reversed(range(levels)):
        own, result = inputs[level], outputs[level]
        coarse = [inputs[level + 1], outputs[level + 1]] if level + 1 < levels else [None, None]

        def neighborhood(fine: Any, coarser: Any, y: Any, x: Any) -> Any:
            """The causal S x S one and, at the coarser level, the whole N x N one; toroidal."""
            parts = [around(fine, y, x, causal)]
            if coarser is not None:
                parts.insert(0, around(coarser, y // 2, x // 2, whole))
            return np.concatenate(parts, axis=-2).reshape(*np.shape(y), -1)

        # Of the input, only pixels with a completely interior neighborhood are considered.
        rows, columns = np.indices(own.shape[:2])
        inside = (rows >= half) & interior(columns, half, own.shape[1])
        if coarse[0] is not None:
            inside &= interior(rows // 2, parent_half, coarse[0].shape[0])
            inside &= interior(columns // 2, parent_half, coarse[0].shape[1])
        y, x = np.nonzero(inside)
        vectors = neighborhood(own, coarse[0], y, x)
        tree = tsvq(vectors, tree_size) if tree_size else np.arange(len(vectors))

        # Step 3: replace each pixel in raster scan order by the one with the lowest SSD.
        for p in np.ndindex(result.shape[:2]):
            vector = neighborhood(result, coarse[1], *map(np.array, p))
            members = descend(tree, vector)
            best = members[np.argmin(((vectors[members] - vector) ** 2).sum(axis=1))]
            result[p] = own[y[best], x[best]]
            if level == 0:
                sources[p] = y[best] * own.shape[1] + x[best]
    return made(sample, outputs[0], np.stack(np.divmod(sources, pixels.shape[1]), axis=2))


def noise_like(sample: tuple[int, ...], shape: tuple[int, int], seed: int) -> Any:
    """Indices of sample pixels, each used equally often, at random places (steps 1 and 2)."""
    numbers, cells = np.arange(sample[0] * sample[1]), np.arange(shape[0] * shape[1])
    pool = np.argsort(draw(seed, "wei-levoy share", 0, numbers), kind="stable")
    order = np.argsort(draw(seed, "wei-levoy noise", 0, cells), kind="stable")
    return np.resize(pool, len(cells))[order].reshape(shape)


def gaussian_pyramid(picture: Any, levels: int, torus: bool) -> list[Any]:
    """The picture and its coarser levels: every second pixel of the 1 4 6 4 1 mean, rounded."""
    pyramid, taps = [picture], [1, 4, 6, 4, 1]
    for _ in range(levels - 1):
        (height, width), total = pyramid[-1].shape[:2], np.full(1, 128)
        padded = np.pad(pyramid[-1], ((2, 2), (2, 2), (0, 0)), "wrap" if torus else "edge")
        for v, u in np.ndindex(5, 5):
            total = total + taps[v] * taps[u] * padded[v : v + height : 2, u : u + width : 2]
        pyramid.append(total // 256)
    return pyramid


def around(picture: Any, y: Any, x: Any, steps: Any) -> Any:
    """What lies at some steps from pixels (y, x), around the borders: (..., steps, channels)."""
    height, width = picture.shape[:2]
    return picture[(y[..., None] + steps[:, 0]) % height, (x[..., None] + steps[:, 1]) % width]


def interior(at: Any, reach: int, length: int) -> Any:
    """Whether a window around a row or column lies within the picture."""
    return (at >= reach) & (at < length - reach)


def centroid(vectors: Any) -> Any:
    """The mean of some vectors, rounded."""
    return (vectors.sum(axis=0) + len(vectors) // 2) // len(vectors)


def distortion(vectors: Any) -> int:
    """The sum of squared distances to the centroid."""
    return int(((vectors - centroid(vectors)) ** 2).sum())


def halves(vectors: Any) -> Any:
    """Which vectors are in the second of two clusters, by the generalized Lloyd algorithm."""
    mean = vectors.sum(axis=0) // len(vectors)
    widest = np.argmax(((vectors - mean) ** 2).sum(axis=0))
    second = vectors[:, widest] > mean[widest]
    for _ in range(8):
        left, right = centroid(vectors[~second]), centroid(vectors[second])
        nearer = ((vectors - right) ** 2).sum(axis=1) < ((vectors - left) ** 2).sum(axis=1)
        if (nearer == second).all() or nearer.all() or not nearer.any():
            break
        second = nearer
    return second


def tsvq(vectors: Any, tree_size: int) -> Any:
    """The tree of section 4: a node is (centroid, child, centroid, child); a leaf is its members.

    The leaf with the largest distortion is split by the generalized Lloyd algorithm, which begins
    at the mean of the dimension that varies most, until the tree has as many leaves as tree_size.
    """
    leaves = [np.arange(len(vectors))]
    spread = [distortion(vectors)]
    children: list[Any] = [None]
    while sum(c is None for c in children) < tree_size:
        open_leaves = [k for k, c in enumerate(children) if c is None and spread[k]]
        if not open_leaves:
            break
        worst = max(open_leaves, key=lambda k: (spread[k], -k))
        children[worst] = len(leaves), len(leaves) + 1
        second = halves(vectors[leaves[worst]])
        for members in (leaves[worst][~second], leaves[worst][second]):
            leaves.append(members)
            spread.append(distortion(vectors[members]))
            children.append(None)

    def node(k: int) -> Any:
        if children[k] is None:
            return leaves[k]
        left, right = children[k]
        centroids = [centroid(vectors[leaves[child]]) for child in (left, right)]
        return centroids[0], node(left), centroids[1], node(right)

    return node(0)


def descend(tree: Any, vector: Any) -> Any:
    """The members of the leaf that one reaches by the nearer centroid of each node."""
    while isinstance(tree, tuple):
        left_centroid, left, right_centroid, right = tree
        nearer = ((right_centroid - vector) ** 2).sum() < ((left_centroid - vector) ** 2).sum()
        tree = right if nearer else left
    return tree
