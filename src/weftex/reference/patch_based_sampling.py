"""Real-time texture synthesis by patch-based sampling (Liang, Liu, Xu, Guo and Shum, 2001).

The method `patch-sampling` makes the same bytes with `repeat_distance=0`, if whole patches cover
the output; otherwise it spreads its patches evenly. What makes the paper fast (section 3) is not
here: kd-tree, quadtree pyramid and principal components are `kd_tree`, `QuadtreePyramid` and
`fit_pca` of `weftex.search.approximate_nearest`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.reference.common import Made, checked, fits, made, pick, places, windows


def patch_based_sampling(
    sample: Any,
    size: Any,
    patch: int,
    boundary: int = 4,
    epsilon: float = 0.2,
    tileable: bool = False,
    seed: int = 0,
) -> Made:
    """Paste patches whose boundary zones match the output so far, and feather them.

    L. Liang, C. Liu, Y.-Q. Xu, B. Guo, H.-Y. Shum: Real-time texture synthesis by patch-based
    sampling, ACM Transactions on Graphics 20(3), 2001: section 2. All patches are compared.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        I_in, the sample image.
    size : int or (int, int)
        Height and width of the output I_out in pixels; of tileable output multiples of
        `patch - boundary`.
    patch : int
        w_B, the side of the square patches in pixels.
    boundary : int
        w_E, the width of the boundary zone in pixels.
    epsilon : float
        Relative matching error between boundary zones.
    tileable : bool
        Whether the output tiles (section 2.3).
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Notes
    -----
    The first patch lies in the upper left corner, in the paper in the lower left one. Feathering
    follows each patch. The paper leaves its weights open: here they fall evenly through the zone,
    in steps of 1/256.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import patch_based_sampling
    >>> sample = np.random.default_rng(0).integers(0, 255, (32, 32), np.uint8)
    >>> patch_based_sampling(sample, (30, 40), patch=12, boundary=3, seed=1).image.shape
    (30, 40)
    """
    i_in, (height, width) = checked(sample, size, seed)
    w_b, w_e = fits("patch", patch, i_in), boundary
    step = w_b - w_e
    if not 1 <= w_e <= w_b // 2:
        raise InvalidInputError(f"boundary is {w_e}; it must be from 1 to {w_b // 2}")
    if tileable and (height % step or width % step or min(height, width) < 2 * step):
        raise InvalidInputError(f"size is {size}; tileable sides must be 2 or more times {step}")
    patches = windows(i_in, w_b, w_b).reshape(-1, w_b, w_b, i_in.shape[2])
    # As many patches as cover I_out, which is cropped in the end.
    count = [-(-n // step) if tileable else max(1, -(-(n - w_e) // step)) for n in (height, width)]
    shape = [k * step + (0 if tileable else w_e) for k in count]
    i_out = np.zeros((*shape, i_in.shape[2]), np.int64)
    sources = np.zeros((*shape, 2), np.int64)

    def depth(k: int, of: int) -> Any:
        """How deep each row or column of the k-th patch lies in what is pasted; 0 is outside."""
        at, first, last = np.arange(w_b), w_e if k else 0, w_b
        if tileable and k == of - 1:  # Fig. 5: it also meets the first patch of the row
            last = w_b - w_e
        return np.maximum(np.maximum(first - at, at - last + 1), 0)

    def boundary_zone(i: int, j: int) -> Any:
        """Fig. 3 (b) to (d): the depth of each pixel of E_out, 0 where nothing is pasted."""
        return np.maximum.outer(depth(i, count[0]), depth(j, count[1]))

    def psi_b(zone: Any, e_out: Any) -> Any:
        """Eq. (1): the patches whose zones differ less than d_max from E_out; step 3."""
        a_d2 = ((patches[:, zone] - e_out) ** 2).sum(axis=(1, 2))  # A d^2 of eq. (2)
        a_d_max2 = int((e_out**2).sum()) * epsilon * epsilon  # A d_max^2 of section 2.4
        matching = np.flatnonzero(a_d2 < a_d_max2)
        return matching if len(matching) else np.array([a_d2.argmin()])

    def feathered(old: Any, new: Any, zone_depth: Any) -> Any:
        """Step 6: the share of the new patch falls from the inside of the zone outwards."""
        share = (w_e + 1 - zone_depth) / (w_e + 1)
        weight = np.floor(256 * share + 1e-9).astype(int)[..., None]
        return (old * (256 - weight) + new * weight + 128) // 256

    for i, j in np.ndindex(*count):  # the order of Fig. 3 (a)
        rows, columns = (np.arange(k * step, k * step + w_b) for k in (i, j))
        here = np.ix_(rows % shape[0], columns % shape[1])  # section 2.3: x mod w_out
        zone_depth = boundary_zone(i, j)
        zone = zone_depth > 0
        # Step 1 for B_0: any patch. Steps 2 to 4 for B_k: a random element of Psi_B.
        psi = psi_b(zone, i_out[here][zone]) if zone.any() else np.arange(len(patches))
        b_k = int(psi[pick(len(psi), seed, "patch", i, j)])
        i_out[here] = feathered(i_out[here], patches[b_k], zone_depth)
        corner = np.divmod(b_k, i_in.shape[1] - w_b + 1)
        theirs = places(w_b, w_b) + corner
        more = (2 * zone_depth < w_e + 1)[..., None]
        sources[here] = np.where(more, theirs, sources[here])
    return made(sample, i_out[:height, :width], sources[:height, :width])
