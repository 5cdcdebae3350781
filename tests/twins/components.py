"""Windows by their principal components."""

from __future__ import annotations

import numpy as np


def feature_distances(features, query):
    """Squared distance of each column of `features` to the query."""
    return [sum((int(f) - int(q)) ** 2 for f, q in zip(c, query, strict=True)) for c in features.T]


def ridge_coordinates(known, basis, values, mean, ridge):
    """Coordinates z that minimize the sum of w (x - mean - basis z)**2 and of ridge z**2."""
    gram = (basis * known[:, None]).T @ basis + np.diag(ridge)
    return np.linalg.solve(gram, (basis * known[:, None]).T @ (values - mean))


def near_leaves(query, leaves, weight, visited, wanted):
    """The windows nearest in coordinates: of the `visited` leaves with the nearest means.

    `leaves` has for each (places, coordinates (n, D)); query and coordinates are bytes.
    """

    def distance(coordinates):
        difference = [int(a) - int(b) for a, b in zip(coordinates, query, strict=True)]
        return min(sum(d * d * weight >> 16 for d in difference), 40000)

    middles = [coordinates.sum(axis=0, dtype=int) // len(places) for places, coordinates in leaves]
    order = sorted(range(len(leaves)), key=lambda n: (distance(middles[n]), n))[:visited]
    windows = [(distance(c), p) for n in order for p, c in zip(*leaves[n], strict=True)]
    return [place for _, place in sorted(windows)[:wanted]]
