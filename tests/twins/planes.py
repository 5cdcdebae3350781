"""A plane of blocks, whole and naively: three pictures, one after the other, and no cache.

Corners are laid on the first; every edge is made from what the first shows and laid on the second;
every interior from what the second shows, and laid on the third. What no node is near to is left
out at the border, so only the middle of the area is that of the plane.
"""

import numpy as np

import weftex
from weftex.endless.boxes import Box, PlaneRequest, Span
from weftex.endless.plane import kept_of
from weftex.random import draw


class Area:
    """Pixels of the plane from `top`, `left` on; -1 where there is nothing yet."""

    def __init__(self, top, left, height, width):
        self.top, self.left = top, left
        self.shown = np.full((height, width), -1, np.int32)

    def part(self, rows, columns):
        both = zip((rows, columns), self.corner, strict=True)
        y, x = (slice(a - at, b - at) for (a, b), at in both)
        return self.shown[y, x]

    @property
    def corner(self):
        return self.top, self.left

    def copy(self):
        other = Area(self.top, self.left, *self.shown.shape)
        other.shown[:] = self.shown
        return other


def whole_plane(model, seed, nodes, period=None):
    """Rows and columns `nodes` of the grid, without period or with one that they go around."""
    sizes, first, last = model.block_sizes(), nodes[0], nodes[-1]
    half, loose, around = sizes.belt // 2, sizes.loose, sizes.around
    count = 1 if period is None else max(2, period // sizes.pitch)
    length = sizes.pitch if period is None else period

    def node(k):
        return k // count * length + k % count * length // count

    def name(k):
        return k if period is None else k % count

    top = node(first) - half - around
    side = node(last) + half + around - top
    area = Area(top, top, side, side)
    asked = PlaneRequest(seed, None if period is None else (period, period))
    flat = model.exemplar.pixels.reshape(-1, *model.exemplar.pixels.shape[2:])
    width, pieces = model.exemplar.shape[1], kept_of(model)[1]

    def made(before, after, block, own, seen, free):
        """Fill a block from one picture, and lay it on the next."""
        box = Box(Span(*seen[0]), Span(*seen[1]))
        start = model.start_of(box, asked) if around else None
        shown = before.part(*seen).copy()
        if start is not None:
            shown = np.where(shown < 0, start, shown)
        hole = np.zeros(shown.shape, bool)
        for rows, columns in (own, free):
            y, x = (
                slice(a - s[0], b - s[0]) for (a, b), s in zip((rows, columns), seen, strict=True)
            )
            hole[y, x] = True
        bits = int(draw(seed, "block", block[0], name(block[1]), name(block[2]))[()])
        canvas = weftex.Canvas(*shown.shape, known=flat[shown], hole=hole, shown=shown)
        source = model.sample(canvas, seed=bits, threads=1).source
        after.part(*seen)[hole] = (source[..., 0] * width + source[..., 1])[hole]

    def ends(k, grown=0):
        return node(k) - half - grown, node(k) + half + grown

    def gap(k, grown=0):
        return node(k) + half - grown, node(k + 1) - half + grown

    corners = area
    for i in nodes:
        for j in nodes:
            if around:
                own = ends(i), ends(j)
                made(area, corners, (0, i, j), own, (ends(i, around), ends(j, around)), own)
            else:
                at = np.array([[ends(i)[0], ends(j)[0]]])
                y, x = pieces.pick(seed, np.array([[name(i), name(j)]]), at)[0].tolist()
                line = np.arange(sizes.belt)
                corners.part(ends(i), ends(j))[:] = (y + line)[:, None] * width + x + line
    edges = corners.copy()
    for i in nodes:
        for j in nodes[:-1]:
            for kind in (1, 2):  # the second is the first, turned
                own, seen = (ends(i), gap(j)), (ends(i, around), gap(j, sizes.belt))
                free = ends(i, -loose), gap(j, loose)
                block = (1, i, j)
                if kind == 2:
                    own, seen, free, block = own[::-1], seen[::-1], free[::-1], (2, j, i)
                made(corners, edges, block, own, seen, free)
    whole = edges.copy()
    for i in nodes[:-1]:
        for j in nodes[:-1]:
            grown = sizes.belt - loose
            seen, free = (gap(i, grown), gap(j, grown)), (gap(i, loose), gap(j, loose))
            made(edges, whole, (3, i, j), (gap(i), gap(j)), seen, free)
    return whole
