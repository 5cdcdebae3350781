"""Tree-structured vector quantization (Gersho and Gray, 1992), as Wei and Levoy search with it.

A binary tree of centroids over the windows of a sample: each node is split in two by the
generalized Lloyd algorithm. A query goes down to the nearer child; backtracking then looks into
more leaves, those first whose branch was nearest when it was passed by. Vectors, centroids and
distances are integers, so every machine builds the same tree. A tree of one leaf is exhaustive
search.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.search import tsvq_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Leaves of a tree without a given size hold at most so many vectors, unless these are all equal.
LEAF_VECTORS = 32
_LLOYD_ROUNDS = 8  # at each split


@dataclass(frozen=True, eq=False)
class TSVQ:
    """A tree over vectors; from `build_tsvq`.

    Attributes
    ----------
    rows : uint8 array (n, D)
        The vectors, leaf after leaf.
    places : int32 array (n,)
        The pixel of the sample that each vector is the window of, or any other number.
    nodes : int32 array (m, 3)
        Number of the first of two children, or -1 for a leaf; first and last row + 1 to look at.
    centroids : uint8 array (m, D)
        Of the nodes; the root's is not used.
    """

    rows: NDArray[np.uint8]
    places: NDArray[np.int32]
    nodes: NDArray[np.int32]
    centroids: NDArray[np.uint8]

    @cached_property
    def depth(self) -> int:
        """The number of splits from the root to the deepest leaf."""
        depth = np.zeros(len(self.nodes), np.int64)
        for node, (child, _, _) in enumerate(self.nodes.tolist()):
            if child >= 0:
                depth[child : child + 2] = depth[node] + 1
        return int(depth.max())

    def bundle(self) -> Any:
        """Return the kernels' view, with scratch for the nodes that wait in a search."""
        waiting = np.empty(len(self.nodes), np.int64), np.empty(len(self.nodes), np.int32)
        return kernels.Tree(self.rows, self.places, self.nodes, self.centroids, *waiting)

    def nearest(
        self,
        queries: NDArray[np.uint8],
        leaves: int = 1,
        spans: NDArray[np.int32] | None = None,
    ) -> NDArray[np.int32]:
        """Return for each query the row of the nearest vector that is found.

        Parameters
        ----------
        queries : uint8 array (q, D)
            One query is one row.
        leaves : int
            How many leaves to look into.
        spans : int32 array (s, 2), optional
            First byte and number of bytes of each part that is compared; all by default.
        """
        if spans is None:
            spans = np.array([[0, queries.shape[1]]], np.int32)
        found = np.empty(len(queries), np.int32)
        kernels.nearest_rows(self.bundle(), queries, spans, leaves, found)
        return found


def build_tsvq(vectors: NDArray[np.uint8], places: NDArray[np.int32], tree_size: int = 0) -> TSVQ:
    """Split vectors into a tree, always that node next that its centroid describes worst.

    Parameters
    ----------
    vectors : uint8 array (n, D)
        Not empty in either axis.
    places : int32 array (n,)
        A number for each vector; of equally near ones the one with the lowest is found.
    tree_size : int
        The most leaves; with 0, nodes are split until they hold at most `LEAF_VECTORS` vectors.

    Examples
    --------
    >>> import numpy as np
    >>> vectors = np.array([[0, 9], [200, 7], [1, 9], [201, 7]], np.uint8)
    >>> tree = build_tsvq(vectors, np.arange(4, dtype=np.int32), tree_size=2)
    >>> tree.places[tree.nearest(np.array([[190, 0]], np.uint8))].tolist()
    [1]
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
    while heap and made < most_nodes:
        node = heapq.heappop(heap)[1]
        _, start, stop = nodes[node].tolist()
        if spread[node] == 0 or (not tree_size and stop - start <= LEAF_VECTORS):
            continue
        middle = kernels.split(splitting, start, stop, made, _LLOYD_ROUNDS)
        nodes[node, 0] = made
        nodes[made] = (-1, start, middle)
        nodes[made + 1] = (-1, middle, stop)
        heapq.heappush(heap, (-int(spread[made]), made))
        heapq.heappush(heap, (-int(spread[made + 1]), made + 1))
        made += 2
    nodes, spread = nodes[:made].copy(), spread[:made]
    # Of equal vectors the first one stands for all, or a sample of few colors would take long.
    equal = (nodes[:, 0] < 0) & (spread == 0)
    nodes[equal, 2] = nodes[equal, 1] + 1
    return TSVQ(np.ascontiguousarray(vectors[order]), places[order], nodes, centroids[:made].copy())
