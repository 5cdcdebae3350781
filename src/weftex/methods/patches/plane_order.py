"""Where the patches of an endless plane go: blocks of patches that depend on few others.

The plane has the grid of patches of Fig. 3 (a). Every few patches both ways there is a node::

    o - - o - -
    | . . | . .     o  a node: any place of the sample
    | . . | . .     -  an edge across, |  down: depend on the nodes at their ends
    o - - o - -     .  inside, in scan order: depend on the nodes and edges around
    | . . | . .
    | . . | . .

A patch is pasted as any other: beside every neighbor that it may depend on it has a boundary zone.
Where an edge across and one down overlap, beside a node, both leave what the node shows: so neither
depends on the other, and the patch inside that comes last overlaps all three. The patches that a
window depends on are found by going back from the patches that show in it. The closer the nodes
are, the fewer patches are pasted that do not show in the window.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from weftex.endless.boxes import Box, Span
from weftex.endless.corners import SamplePieces
from weftex.endless.grid import Axis
from weftex.methods.patches.analysis import Zones
from weftex.methods.patches.orders import PIECE, THREADS_FROM, Order, Run, Step
from weftex.random import draw
from weftex.raster.arrays import Ints

CORNER, ACROSS, DOWN, INSIDE = range(4)
_PITCH, _FEWEST, _MOST = 144, 3, 8  # pixels, or so many patches, from one node to the next
_REACH = 2  # patches around that should not be repeated
_AROUND = [step for step in product(range(-_REACH, _REACH + 1), repeat=2) if any(step)]
_TOUCHING = [k for k, (i, j) in enumerate(_AROUND) if max(abs(i), abs(j)) == 1]
_TWO_STEPS = [
    (first, second, k)
    for k, (i, j) in enumerate(_AROUND)
    if k not in _TOUCHING
    for first in _TOUCHING
    for second in _TOUCHING
    if (_AROUND[first][0] + _AROUND[second][0], _AROUND[first][1] + _AROUND[second][1]) == (i, j)
]
_TURN = 1 << 20  # more than any place within a block


@dataclass(frozen=True)
class PatchAxis:
    """The patches of a plane along an axis."""

    window: int  # side of a patch in pixels
    patches: Axis  # where patches begin, in pixels
    nodes: Axis  # which patches are nodes

    @classmethod
    def of(cls, window: int, overlap: int, period: int | None) -> PatchAxis:
        """The patches of a plane with this period; at least `least_period`."""
        step = window - overlap
        between = min(max(-(-_PITCH // step), _FEWEST), _MOST)
        if period is None:
            return cls(window, Axis(step, 1), Axis(between, 1))
        count = -(-period // step)
        patches = Axis(period, count, wraps=True)
        return cls(window, patches, Axis(count, max(1, count // between), wraps=True))

    def around(self, span: Span) -> tuple[Ints, slice]:
        """Numbers of all patches that a span may depend on, and which of them show in it."""
        first = self.patches.last_before(span.first - self.window) + 1
        stop = self.patches.last_before(span.last - 1) + 1
        low = self.nodes.node(self.nodes.last_before(first)) - 1
        high = self.nodes.node(self.nodes.last_before(stop - 1) + 1) + 2
        return np.arange(low, high), slice(first - low, stop - low)


def least_period(window: int, overlap: int) -> int:
    """The shortest period that blocks of patches can have."""
    return (_FEWEST - 1) * (window - overlap) + 1


class PlaneOrder:
    """The patches that a window of a plane depends on."""

    def __init__(self, axes: tuple[PatchAxis, PatchAxis], box: Box) -> None:
        self.axes = axes
        around = [axis.around(span) for axis, span in zip(axes, box, strict=True)]
        # numbers of the rows and of the columns of patches, and which of them show
        self.numbers, self.shown = zip(*around, strict=True)
        # where they begin on the plane, in pixels
        self.starts = tuple(
            np.array([axis.patches.node(n) for n in line.tolist()], np.int64)
            for axis, line in zip(self.axes, self.numbers, strict=True)
        )
        self.shape = len(self.numbers[0]), len(self.numbers[1])
        # the block of each patch, and its turn: the kind of block, and the place in it
        (gap_y, after_y), (gap_x, after_x) = (
            _gaps(axis, line) for axis, line in zip(axes, self.numbers, strict=True)
        )
        y, x = after_y[:, None], after_x
        self.kind = np.where(y > 0, np.where(x > 0, INSIDE, DOWN), np.where(x > 0, ACROSS, CORNER))
        self.block = np.stack([self.kind, gap_y[:, None] + 0 * x, gap_x + 0 * y])
        self.turn = self.kind * _TURN + y * (_TURN >> 10) + x

    @cached_property
    def depends_on(self) -> NDArray[np.bool_]:
        """Return (n, rows, columns): for each of `_AROUND`, whether each patch may depend on it.

        Patches depend on earlier ones of their block and on nodes; inside, on edges too. Patches
        two steps away, which must not be repeated, are dependencies of dependencies.
        """
        result = np.zeros((len(_AROUND), *self.shape), bool)
        for k in _TOUCHING:
            i, j = _AROUND[k]
            (own_y, its_y), (own_x, its_x) = _shifted(i), _shifted(j)
            own, its = (slice(None), own_y, own_x), (slice(None), its_y, its_x)
            kind, other = self.kind[own[1:]], self.kind[its[1:]]
            same = (self.block[own] == self.block[its]).all(axis=0)
            lower = (other < kind) & ((kind == INSIDE) | (other == CORNER))
            earlier = same & (self.turn[its[1:]] < self.turn[own[1:]])
            result[k][own[1:]] = lower | earlier
        for first, second, k in _TWO_STEPS:
            (own_y, its_y), (own_x, its_x) = (_shifted(n) for n in _AROUND[first])
            result[k][own_y, own_x] |= result[first][own_y, own_x] & result[second][its_y, its_x]
        return result

    @cached_property
    def needed(self) -> NDArray[np.bool_]:
        """(rows, columns): patches that show in the window or that one of those depends on."""
        needed = np.zeros(self.shape, bool)
        needed[self.shown] = True
        flat, width = needed.ravel(), self.shape[1]
        steps = np.array([i * width + j for i, j in _AROUND])
        depends = self.depends_on.reshape(len(_AROUND), -1)
        order = np.argsort(self.turn.ravel(), kind="stable")
        turns = self.turn.ravel()[order]
        for group in reversed(np.split(order, np.flatnonzero(np.diff(turns)) + 1)):
            own = group[flat[group]]
            if len(own):
                flat[(own + steps[:, None])[depends[:, own]]] = True
        return needed

    def order(self, zones: Zones, seed: int, pieces: SamplePieces) -> Order:
        """Return the patches in their order, on a frame that begins with the first of them.

        `zones` numbers the boundary zones, `seed` is the plane's, and `pieces` are sources for
        nodes.
        """
        y, x = np.nonzero(self.needed)
        zone = self._zones(zones, y, x)
        ordered = np.lexsort((x, y, zone, self.turn[y, x]))
        y, x, zone = y[ordered], x[ordered], zone[ordered]
        turn = self.turn[y, x]
        number = np.full(self.shape, -1, np.int32)
        number[y, x] = np.arange(len(y))
        names = [
            np.array([axis.patches.name(n) for n in line.tolist()], np.int64)
            for axis, line in zip(self.axes, self.numbers, strict=True)
        ]
        bits = draw(seed, "patch", names[0][y], names[1][x])
        nodes = turn == 0
        bits[nodes] = self._bits(y[nodes], x[nodes], seed, pieces)
        i, j = np.array(_AROUND).T[:, :, None]
        both = zip((y, x), (i, j), self.shape, strict=True)
        rows, columns = ((at + by).clip(0, n - 1) for at, by, n in both)
        around = np.where(self.depends_on[:, y, x], number[rows, columns], np.int32(-1))
        around = np.ascontiguousarray(around.T)
        corners = np.stack([self.starts[0][y], self.starts[1][x]], axis=1)
        corners -= [span.first for span in self.frame]
        changes = np.flatnonzero((np.diff(zone) != 0) | (np.diff(turn) != 0)) + 1
        ends = [0, *changes.tolist(), len(y)]
        steps = []
        for a, b in pairwise(ends):  # patches with the same turn are independent of each other
            runs = [Run(int(zone[a]), k, min(k + PIECE, b)) for k in range(a, b, PIECE)]
            steps.append(Step([[run] for run in runs], b - a))
        return Order(
            corners=corners.astype(np.int32),
            bits=bits,
            around=around,
            steps=iter(steps),
            total=len(y),
            stage="patches",
            parallel=len(y) >= THREADS_FROM,
        )

    def _bits(self, y: Ints, x: Ints, seed: int, pieces: SamplePieces) -> NDArray[np.uint64]:
        """Bits by which the kernel draws the places that patches at nodes are to show."""
        names, at = [], []  # the same for every time around
        for axis, blocks, line, k in zip(
            self.axes, self.block[1:, y, x], self.numbers, (y, x), strict=True
        ):
            names.append([axis.nodes.name(n) for n in blocks.tolist()])
            at.append([axis.patches.node(axis.patches.name(n)) for n in line[k].tolist()])
        v, u = pieces.pick(seed, np.array(names, np.int64).T, np.array(at, np.int64).T).T
        numbers = pieces.numbers
        count = int(numbers[-1, -1]) + 1
        share = (numbers[v, u] << 32) // count + 1
        bits: NDArray[np.uint64] = share.astype(np.uint64) << np.uint64(32)
        return bits

    @cached_property
    def frame(self) -> Box:
        """The box of the plane that all needed patches lie in."""
        spans = []
        for k, axis in enumerate(self.axes):
            starts = self.starts[k][self.needed.any(axis=1 - k)].tolist()
            spans.append(Span(starts[0], starts[-1] + axis.window))
        return Box(*spans)

    def _zones(self, zones: Zones, y: Ints, x: Ints) -> Ints:
        """Return the number of each patch's boundary zone."""
        bits = np.zeros(len(y), np.int64)
        for k in _TOUCHING:
            i, j = _AROUND[k]
            crossing = self.kind[y, x] * self.kind[y + i, x + j] == ACROSS * DOWN
            bits = 4 * bits + 2 * crossing + self.depends_on[k][y, x]
        keys = [bits]
        for start, at, axis in zip(self.starts, (y, x), self.axes, strict=True):
            keys += [axis.window - (start[at] - start[at - 1]), start[at + 1] - start[at]]
        kinds, which = np.unique(np.stack(keys, axis=1), axis=0, return_inverse=True)
        window = self.axes[0].window, self.axes[1].window
        numbers = [zones.number(*known_of(window, *kind), often=True) for kind in kinds.tolist()]
        return np.array(numbers, np.int64)[which.ravel()]


@lru_cache(maxsize=256)
def known_of(
    window: tuple[int, int], bits: int, above: int, below: int, left: int, right: int
) -> tuple[NDArray[np.bool_], NDArray[np.bool_] | None]:
    """Return masks (height, width) of a patch's pixels that are pasted already and that must stay.

    `bits` are the neighbors that it depends on and the edges that cross it. `above` and `left` are
    how far the patches before reach into it, `below` and `right` where the next ones begin.
    """
    known, stays = np.zeros((2, *window), bool)
    rows = {-1: slice(0, above), 0: slice(None), 1: slice(below, None)}
    columns = {-1: slice(0, left), 0: slice(None), 1: slice(right, None)}
    for k in reversed(_TOUCHING):
        i, j = _AROUND[k]
        known[rows[i], columns[j]] |= bool(bits & 1)
        stays[rows[i], columns[j]] |= bool(bits & 2)
        bits >>= 2
    return known, stays if stays.any() else None


def _gaps(axis: PatchAxis, line: Ints) -> tuple[Ints, Ints]:
    """For each patch the last node at or before it, and how far after that it is."""
    nodes = np.array([axis.nodes.last_before(n) for n in line.tolist()], np.int64)
    return nodes, line - np.array([axis.nodes.node(n) for n in nodes.tolist()], np.int64)


def _shifted(by: int) -> tuple[slice, slice]:
    """The lines that have a line `by` further on, and those lines."""
    if by >= 0:
        return slice(0, -by or None), slice(by, None)
    return slice(-by, None), slice(0, by)
