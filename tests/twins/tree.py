"""Tree-structured vector quantization (Wei and Levoy, 2000)."""

from __future__ import annotations

import numpy as np


def _centroid(vectors):
    return (vectors.sum(axis=0) + len(vectors) // 2) // len(vectors)


def _spread(vectors):
    return int(((vectors - _centroid(vectors)) ** 2).sum())


def halves(vectors, rounds=8):
    """Which vectors are in the second of two clusters, by Lloyd's algorithm."""
    mean = vectors.sum(axis=0) // len(vectors)
    byte = int(np.argmax(((vectors - mean) ** 2).sum(axis=0)))
    second = vectors[:, byte] > mean[byte]
    for _ in range(rounds):
        centroids = [_centroid(vectors[second == k]) for k in (False, True)]
        first, other = (((vectors - c) ** 2).sum(axis=1) for c in centroids)
        now = other < first
        if (now == second).all() or now.all() or not now.any():
            break
        second = now
    return second


def vector_tree(vectors, tree_size=None, leaf=32):
    """Nodes as dicts: members, centroid and, if split, children; always the worst leaf is split."""
    vectors = vectors.astype(np.int64)
    nodes = [{"members": np.arange(len(vectors)), "spread": _spread(vectors)}]
    while True:
        open_leaves = [
            (-node["spread"] if number else 0, number)
            for number, node in enumerate(nodes)
            if "children" not in node
            and node["spread"]
            and (tree_size is not None or len(node["members"]) > leaf)
        ]
        leaves = sum("children" not in node for node in nodes)
        if not open_leaves or leaves == tree_size:
            return nodes
        node = nodes[min(open_leaves)[1]]
        second = halves(vectors[node["members"]])
        node["children"] = (len(nodes), len(nodes) + 1)
        for members in (node["members"][~second], node["members"][second]):
            own = vectors[members]
            nodes.append({"members": members, "centroid": _centroid(own), "spread": _spread(own)})


def nearest_in_tree(nodes, vectors, query, counts, leaves):
    """The member nearest in the bytes that count, among those of the leaves that are looked at."""

    asked = query[counts].astype(np.int64)

    def distances(vectors):
        return ((vectors[:, counts] - asked) ** 2).sum(axis=1).tolist()

    waiting, found = [(0, 0)], []
    while waiting and leaves:
        number = min(waiting)[1]
        waiting.remove(min(waiting))
        while "children" in nodes[number]:
            children = nodes[number]["children"]
            apart = distances(np.stack([nodes[child]["centroid"] for child in children]))
            near, far = sorted(zip(apart, children, strict=True))
            waiting.append(far)
            number = near[1]
        members = nodes[number]["members"]
        found += zip(distances(vectors[members]), members.tolist(), strict=True)
        leaves -= 1
    return min(found)[1]
