"""Tree-structured vector quantization (Gersho and Gray, 1992), as Wei and Levoy search with it.

A binary tree of centroids over the windows of a sample: each node is split in two by the
generalized Lloyd algorithm. A query goes down to the nearer child; backtracking then looks into
more leaves, those first whose branch was nearest when it was passed by. Vectors, centroids and
distances are integers, so every machine builds the same tree. A tree of one leaf is exhaustive
search.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.methods.wei_levoy import tsvq_kernels as kernels
from weftex.progress import counted
from weftex.search.pyramid_windows import window_vectors

#: Leaves of a tree without a given size hold at most so many vectors, unless these are all equal.
LEAF_VECTORS = 32
_LLOYD_ROUNDS = 8  # at each split


@dataclass(frozen=True, eq=False)
class TSVQ:
    """A tree over vectors; from `build_tsvq`."""

    rows: NDArray[np.uint8]  # (n, D): the vectors, leaf after leaf
    places: NDArray[np.int32]  # (n,): the pixel or other number of each vector
    nodes: NDArray[np.int32]  # (m, 3): first child or -1 for a leaf; first and last row + 1
    centroids: NDArray[np.uint8]  # (m, D): the root's is not used

    def bundle(self, spans: NDArray[np.int32]) -> Any:
        """Return the kernels' view, with scratch for a search by spans (s, 2) of a vector."""
        keys, waiting = (np.empty(len(self.nodes), kind) for kind in (np.int64, np.int32))
        query = np.empty(self.rows.shape[1], np.uint8)
        return kernels.Tree(
            self.rows, self.places, self.nodes, self.centroids, keys, waiting, query, spans
        )


def build_tsvq(vectors: NDArray[np.uint8], places: NDArray[np.int32], tree_size: int = 0) -> TSVQ:
    """Return a tree over vectors (n, D), split at the node that its codeword describes worst.

    It has at most `tree_size` leaves; with 0, leaves hold at most `LEAF_VECTORS`. `places` number
    the vectors; of equally near ones the lowest number is found.
    """
    count, size = vectors.shape
    order = np.argsort(places, kind="stable").astype(np.int32)
    most_nodes = 2 * (min(tree_size or count, count)) - 1
    centroids, spread = np.zeros((most_nodes, size), np.uint8), np.zeros(most_nodes, np.int64)
    nodes = np.empty((most_nodes, 3), np.int32)
    nodes[0] = (-1, 0, count)
    spread[0] = (vectors != vectors[0]).any()
    splitting = kernels.Splitting(
        vectors, order, centroids, spread, np.empty((2, count), np.uint8),
        np.empty(count, np.int32), np.empty((2, size), np.int64),
    )  # fmt: skip
    made, heap = 1, [(0, 0)]
    with counted(max(1.0, _splits(count)), "trees") as step:
        while heap and made < most_nodes:
            node = heapq.heappop(heap)[1]
            _, start, stop = nodes[node].tolist()
            if spread[node] == 0 or (not tree_size and stop - start <= LEAF_VECTORS):
                step(_splits(stop - start))
                continue
            middle = kernels.split(splitting, start, stop, made, _LLOYD_ROUNDS)
            step(_splits(stop - start) - _splits(middle - start) - _splits(stop - middle))
            nodes[node, 0] = made
            for ends in ((start, middle), (middle, stop)):
                nodes[made] = (-1, *ends)
                heapq.heappush(heap, (-int(spread[made]), made))
                made += 1
    nodes, spread = nodes[:made].copy(), spread[:made]
    # Of equal vectors the first one stands for all, or a sample of few colors would take long.
    equal = (nodes[:, 0] < 0) & (spread == 0)
    nodes[equal, 2] = nodes[equal, 1] + 1
    return TSVQ(np.ascontiguousarray(vectors[order]), places[order], nodes, centroids[:made].copy())


def _splits(count: int) -> float:
    """Return how often vectors would be split down to leaves, each time in halves, in all."""
    return count * math.log2(max(1.0, count / LEAF_VECTORS))


class Trees:
    """The trees of a sample's levels; those of windows to all sides are built at first use."""

    def __init__(
        self,
        samples: list[Exemplar],
        window_width: int,
        parent_width: int,
        tree_size: int,
        most_windows: int,
    ) -> None:
        self._samples, self._tree_size, self._most = samples, tree_size, most_windows
        self.window_width = window_width
        #: N of each level; at the coarsest 0, as pixels have no parents there.
        self.parent_widths = [parent_width] * (len(samples) - 1) + [0]
        self._built: dict[tuple[int, bool], TSVQ] = {}
        if window_width > 1:
            for level in range(len(samples)):
                self.of(level, causal=True)

    def of(self, level: int, *, causal: bool) -> TSVQ:
        """Return the tree of a level, 0 the finest."""
        if (level, causal) not in self._built:
            parent_width = self.parent_widths[level]
            parent = self._samples[level + 1] if parent_width else None
            widths = self.window_width, parent_width
            vectors, places = window_vectors(
                self._samples[level], parent, *widths, causal=causal, most=self._most
            )
            self._built[level, causal] = build_tsvq(vectors, places, self._tree_size)
        return self._built[level, causal]
