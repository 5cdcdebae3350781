"""Windows by their principal components."""

from __future__ import annotations


def feature_distances(features, query):
    """Squared distance of each column of `features` to the query."""
    return [sum((int(f) - int(q)) ** 2 for f, q in zip(c, query, strict=True)) for c in features.T]
