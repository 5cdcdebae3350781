"""Graphcut textures (Kwatra, Schödl, Essa, Turk and Bobick, 2003).

The method `graphcut` makes the same bytes with `candidates=1, halvings=0, variety=0, tone_reach=0`
and `seam_cost="difference"`, here `gradients=False`. Costs by gradients are not a metric: there the
method, which has arcs for old seams instead of seam nodes, cuts about one patch in fifty
differently at a few pixels. Only the method has sections 3.2, 5 (FFT), random and entire placement.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from weftex.errors import InvalidInputError, missing_packages
from weftex.random import draw
from weftex.reference.common import Made, at, checked, fits, made, places, windows

Place = tuple[int, int]
#: The terminals: what keeps its old pixels, and what takes new ones.
OLD, NEW = "old", "new"
#: The largest difference of a channel, and what is added to the gradient for each channel, so that
#: seams in flat parts have a finite cost. The paper names neither.
WHITE, SOFT = 255, 32


def graphcut(
    sample: Any,
    size: Any,
    patch: int,
    boundary: int,
    k: float = 0.003,
    gradients: bool = True,
    seed: int = 0,
) -> Made:
    """Place patches where they match, and cut them out along minimum cuts.

    V. Kwatra, A. Schödl, I. Essa, G. Turk, A. Bobick: Graphcut textures: image and video synthesis
    using graph cuts, SIGGRAPH 2003: section 3 with old seams (3.1), costs by gradients (5), and
    section 4 with sub-patch matching. Its maximum flow is SciPy's.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The input texture I.
    size : int or (int, int)
        Height and width of the output O in pixels.
    patch : int
        Side of the square patches in pixels.
    boundary : int
        How far a patch overlaps the patches before it, in pixels; at most (patch - 1) // 2.
    k : float
        Randomness of the placement: an offset is drawn with a probability proportional to
        exp(-C / (k sigma^2)). C and sigma^2 are sums over the channels.
    gradients : bool
        Whether the cost of a seam is divided by the gradients across it: M' of section 5, or M
        of eq. (1).
    seed : int
        Seed of the random draws.

    Returns
    -------
    Made
        The picture and where each pixel of it comes from.

    Raises
    ------
    UnsupportedError
        If SciPy is not installed.

    Notes
    -----
    The paper leaves the norm of colors open: here the sum of absolute differences, in whole steps
    of 1/256. Beyond the sample's border, one of both patches has no colors: its term then equals
    that of the other patch, and the sum counts twice. A small number is added to each gradient. Of
    equal cuts, the one with the fewest new pixels is used. Each patch covers the first missing
    pixel in scan order.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import graphcut
    >>> sample = np.random.default_rng(0).integers(0, 255, (24, 24), np.uint8)
    >>> graphcut(sample, (16, 20), patch=10, boundary=3, seed=1).image.shape
    (16, 20)
    """
    pixels, shape = checked(sample, size, seed)
    fits("patch", patch, pixels)
    if not 0 <= boundary <= (patch - 1) // 2:
        raise InvalidInputError(f"boundary is {boundary}; it must be from 0 to {(patch - 1) // 2}")
    side = min(patch, shape[0]), min(patch, shape[1])
    patches = windows(pixels, *side)
    count, flat = pixels[..., 0].size, pixels.reshape(-1, pixels.shape[2])
    sigma2 = int((count * (flat**2).sum(axis=0) - flat.sum(axis=0) ** 2).sum()) / count**2
    sources = np.full((*shape, 2), -1)
    m = functools.cache(functools.partial(matching_cost, pixels.tolist(), gradients))

    def offset(old: Any, known: Any) -> Any:
        """Sub-patch matching (section 4): draw an offset; its chance follows from the mean SSD."""
        cost = np.zeros(patches.shape[:2])
        if known.any():
            cost = ((patches[:, :, known] - old[known]) ** 2).sum(axis=(2, 3)) / known.sum()
        chances = chances_of(cost.ravel(), k * sigma2)
        left = int(draw(seed, "patch", number, 0)) % sum(chances)
        chosen = int(np.searchsorted(np.cumsum(chances), left, side="right"))
        return np.divmod(chosen, patches.shape[1])

    number = 0
    while (missing := np.argwhere(sources[..., 0] < 0)).size:
        top, left = (
            min(max(int(p) - min(boundary, (n - 1) // 2), 0), length - n)
            for p, n, length in zip(missing[0], side, shape, strict=True)
        )
        here = np.s_[top : top + side[0], left : left + side[1]]
        known = sources[here][..., 0] >= 0
        source = places(*side) + offset(at(pixels, sources[here]), known)
        new = {(top + v, left + u): tuple(source[v, u].tolist()) for v, u in np.ndindex(*side)}
        old = {p: tuple(sources[p].tolist()) for p in np.ndindex(shape) if sources[p][0] >= 0}
        graph = Graph()
        for y in range(max(top - 1, 0), top + side[0]):
            for x in range(max(left - 1, 0), left + side[1]):
                if y + 1 < shape[0]:
                    connect(graph, (y, x), (y + 1, x), old, new, m)
                if x + 1 < shape[1]:
                    connect(graph, (y, x), (y, x + 1), old, new, m)
        taken = graph.new_side()
        for p, place in new.items():
            if sources[p][0] < 0 or p in taken:
                sources[p] = place
        number += 1
    return made(sample, at(pixels, sources), sources)


def matching_cost(colors: Any, gradients: bool, step: Place, a: Place, b: Place) -> int:
    """M(s, t, A, B) of eq. (1), or M': s shows `a` of the sample, t = s + step shows `b`."""

    def color(y: int, x: int) -> Any:
        return colors[y][x] if 0 <= y < len(colors) and 0 <= x < len(colors[0]) else None

    if (a[0] + step[0], a[1] + step[1]) == b:
        return 0  # no seam
    a_s, a_t = color(*a), color(a[0] + step[0], a[1] + step[1])
    b_s, b_t = color(b[0] - step[0], b[1] - step[1]), color(*b)
    differences = [norm(p, q) for p, q in ((a_s, b_s), (a_t, b_t)) if p and q]
    gradient = [norm(p, q) for p, q in ((a_s, a_t), (b_s, b_t)) if p and q]
    cost, across = sum(differences), sum(gradient)
    if len(differences) < 2:  # a patch ends: the missing term is the other one; doubled
        cost, across = (4 * cost, 2 * across) if differences else (4 * WHITE * len(a_s), 0)
    return 256 * cost // (across + SOFT * len(a_s)) if gradients else cost


def norm(p: list[int], q: list[int]) -> int:
    """The distance of two colors."""
    return sum(abs(a - b) for a, b in zip(p, q, strict=True))


def chances_of(cost: Any, spread: float) -> list[int]:
    """Whole numbers in proportion to exp(-cost / spread), as (1 + cost / spread / 1024)**-1024."""
    if spread == 0:
        return [int(c == cost.min()) for c in cost]
    power = 1 + np.minimum((cost - cost.min()) / spread, 64.0) / 1024
    for _ in range(10):
        power = power * power
    return [int(chance) for chance in 2.0**32 / power]


def connect(
    graph: Graph, s: Place, t: Place, old: dict[Place, Any], new: dict[Place, Any], m: Any
) -> None:
    """Add to the graph the costs of s and its neighbor t being old or new (Figs. 2 and 3)."""
    step = t[0] - s[0], t[1] - s[1]
    old_s, old_t, new_s, new_t = old.get(s), old.get(t), new.get(s), new.get(t)
    if old_s and new_s and old_t and new_t:
        if m(step, old_s, old_t) == 0:  # Fig. 2: an arc between both
            graph.join(s, t, m(step, old_s, new_t))
        else:  # Fig. 3: a seam node for the old seam, joined with the new patch
            graph.join(s, (s, t), m(step, old_s, new_t))
            graph.join((s, t), t, m(step, new_s, old_t))
            graph.join((s, t), NEW, m(step, old_s, old_t))
    elif old_s and new_s and (old_t or new_t):  # t is constrained to be old or new
        graph.join(s, NEW, m(step, old_s, old_t or new_t))
        graph.join(s, OLD, m(step, new_s, old_t) if old_t else 0)
    elif old_t and new_t and (old_s or new_s):
        graph.join(t, NEW, m(step, old_s or new_s, old_t))
        graph.join(t, OLD, m(step, old_s, new_t) if old_s else 0)


class Graph:
    """A graph whose nodes are pixels, seam nodes and the terminals, and its minimum cut."""

    def __init__(self) -> None:
        self.numbers: dict[Any, int] = {NEW: 0, OLD: 1}
        self.arcs: list[tuple[int, int, int]] = []

    def join(self, p: Any, q: Any, capacity: int) -> None:
        """Add an arc in both directions."""
        i, j = (self.numbers.setdefault(node, len(self.numbers)) for node in (p, q))
        self.arcs += [(i, j, capacity), (j, i, capacity)]

    def new_side(self) -> set[Any]:
        """The nodes that stay joined with the new patch: the flow does not cut them off."""
        try:
            from scipy.sparse import coo_array
            from scipy.sparse.csgraph import breadth_first_order, maximum_flow
        except ImportError as error:
            raise missing_packages("this reference needs SciPy", "kdtree") from error
        if not self.arcs:
            return set()
        rows, columns, capacities = np.array(self.arcs).T
        count = len(self.numbers)
        graph = coo_array((capacities.astype(np.int32), (rows, columns)), (count, count)).tocsr()
        residual = graph - maximum_flow(graph, 0, 1).flow
        residual.eliminate_zeros()
        reached = breadth_first_order(residual, 0, return_predecessors=False).tolist()
        nodes = list(self.numbers)
        return {nodes[i] for i in reached}
