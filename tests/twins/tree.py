"""Tree-structured vector quantization (Wei and Levoy, 2000)."""

import numpy as np

from weftex.reference.wei_levoy import centroid, distortion, halves


def vector_tree(vectors, tree_size=None, leaf=32):
    """Nodes as dicts: members, centroid and, if split, children; always the worst leaf is split."""
    vectors = vectors.astype(np.int64)
    nodes = [{"members": np.arange(len(vectors)), "spread": distortion(vectors)}]
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
            nodes.append({"members": members, "centroid": centroid(own), "spread": distortion(own)})


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
