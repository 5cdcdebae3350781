"""Image quilting for texture synthesis (Efros and Freeman, 2001).

Texture transfer, section 3 of the paper, is not here; `graphcut` and `ashikhmin` follow a guide.
The method `quilting` makes the same bytes with `search="exhaustive", repeat_distance=0`, if whole
blocks cover the output.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.reference.common import Made, checked, fits, made, pick, places, windows


def image_quilting(
    sample: Any, size: Any, block: int, overlap: int, tolerance: float = 0.1, seed: int = 0
) -> Made:
    """Stitch blocks of the sample together along minimum error boundary cuts.

    A. A. Efros, W. T. Freeman: Image quilting for texture synthesis and transfer, SIGGRAPH 2001,
    section 2.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The sample image.
    size : int or (int, int)
        Height and width of the output in pixels.
    block : int
        Side of the square blocks in pixels, the one parameter of the paper.
    overlap : int
        Width of the overlap of blocks in pixels; a sixth of the block in the paper.
    tolerance : float
        A block is drawn among the blocks with at most 1 + tolerance times the smallest error: the
        root of the sum of squared differences in the overlap.
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Notes
    -----
    Of paths with the same error, the one nearest to the border of the block wins, compared from
    its end on. Each cut goes through the whole side of the block, so both meet in its corner.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import image_quilting
    >>> sample = np.random.default_rng(0).integers(0, 255, (32, 32), np.uint8)
    >>> image_quilting(sample, (30, 40), block=12, overlap=3, seed=1).image.shape
    (30, 40)
    """
    pixels, (height, width) = checked(sample, size, seed)
    fits("block", block, pixels)
    if not 1 <= overlap < block:
        raise InvalidInputError(f"overlap is {overlap}; it must be from 1 to {block - 1}")
    step = block - overlap
    blocks = windows(pixels, block, block).reshape(-1, block, block, pixels.shape[2])
    count = [max(1, -(-(n - overlap) // step)) for n in (height, width)]
    shape = [k * step + overlap for k in count]
    output = np.zeros((*shape, pixels.shape[2]), np.int64)
    sources = np.zeros((*shape, 2), np.int64)

    def satisfying(old: Any, overlapping: Any) -> Any:
        """The blocks that satisfy the overlap constraints (above and left) within the tolerance."""
        if not overlapping.any():
            return np.arange(len(blocks))
        error = ((blocks[:, overlapping] - old[overlapping]) ** 2).sum(axis=(1, 2))
        return np.flatnonzero(error <= error.min() * (1 + tolerance) * (1 + tolerance))  # squares

    for i, j in np.ndindex(*count):  # in raster scan order in steps of one block less the overlap
        here = np.s_[i * step : i * step + block, j * step : j * step + block]
        overlapping = np.zeros((block, block), bool)
        overlapping[: overlap if i else 0] = overlapping[:, : overlap if j else 0] = True
        candidates = satisfying(output[here], overlapping)
        chosen = int(candidates[pick(len(candidates), seed, "patch", i, j)])
        new = blocks[chosen]

        # Section 2.1: the error surface at the overlap, and the path along which it is least.
        error = ((output[here] - new) ** 2).sum(axis=2)
        pasted = np.ones((block, block), bool)
        if j:  # a vertical cut
            pasted &= np.arange(block) >= minimum_error_boundary(error[:, :overlap])[:, None]
        if i:  # a horizontal cut; both make an L
            pasted &= np.arange(block)[:, None] >= minimum_error_boundary(error[:overlap].T)
        corner = np.divmod(chosen, pixels.shape[1] - block + 1)
        theirs = places(block, block) + corner
        output[here] = np.where(pasted[..., None], new, output[here])
        sources[here] = np.where(pasted[..., None], theirs, sources[here])
    return made(sample, output[:height, :width], sources[:height, :width])


def minimum_error_boundary(error: Any) -> Any:
    """The column of the cheapest path in each row: e is traversed for i = 2..N (section 2.1).

    E[i, j] = e[i, j] + min(E[i-1, j-1], E[i-1, j], E[i-1, j+1]).

    Examples
    --------
    >>> import numpy as np
    >>> minimum_error_boundary(np.array([[9, 1, 9], [9, 9, 1], [9, 1, 9]])).tolist()
    [1, 2, 1]
    """
    total = np.array(error, np.int64)
    for i in range(1, len(total)):
        beside = np.pad(total[i - 1], 1, constant_values=np.iinfo(np.int64).max)
        total[i] += np.minimum(np.minimum(beside[:-2], beside[1:-1]), beside[2:])
    path = [int(total[-1].argmin())]
    for i in range(len(total) - 2, -1, -1):  # traced back from the least E of the last row
        first = max(path[-1] - 1, 0)
        path.append(first + int(total[i, first : path[-1] + 2].argmin()))
    return np.array(path[::-1])
