"""The optimized kd-tree of section 3.1: sliding midpoint splits, approximate search."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import UnsupportedError

if TYPE_CHECKING:
    from numpy.typing import NDArray


class KDTree:
    """Approximate nearest neighbors of integer points.

    Parameters
    ----------
    points : integer array (n, K)
        One row for each window.
    places : int32 array (n,)
        The number to return for each of them.
    error : float
        A neighbor may be this much farther, relatively, than the true one.
    """

    def __init__(
        self, points: NDArray[np.integer], places: NDArray[np.int32], error: float
    ) -> None:
        try:
            from scipy.spatial import cKDTree
        except ImportError:
            raise UnsupportedError(
                "kd-trees come from SciPy; install it with: pip install 'weftex[kdtree]'"
            ) from None
        # Without balancing, SciPy splits by the sliding midpoint rule, as the paper wants.
        self.tree: Any = cKDTree(points, leafsize=8, balanced_tree=False, compact_nodes=False)
        self.places, self.error = places, error

    def nearest(self, query: NDArray[np.integer], wanted: int) -> NDArray[np.int32]:
        """Return the places of about the `wanted` nearest points."""
        wanted = min(wanted, len(self.places))
        found = self.tree.query(query, k=wanted, eps=self.error, workers=1)[1]
        nearest: NDArray[np.int32] = self.places[np.atleast_1d(found)]
        return nearest
