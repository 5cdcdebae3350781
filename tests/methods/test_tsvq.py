"""Trees of vectors."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from twins import tree as reference
from weftex.methods.wei_levoy import tsvq, tsvq_kernels
from weftex.methods.wei_levoy.tsvq import build_tsvq


def vectors_of(count, size, values, seed):
    rng = np.random.default_rng(seed)
    return rng.integers(0, values, (count, size)).astype(np.uint8) * np.uint8(255 // values)


def leaves_of(tree):
    return tree.nodes[tree.nodes[:, 0] < 0]


def nearest(tree, queries, leaves=1, spans=None):
    """The place of the nearest window that is found for each query."""
    bundle = tree.bundle(np.array([[0, queries.shape[1]]], np.int32) if spans is None else spans)
    rows = []
    for bundle.query in queries:
        rows.append(tsvq_kernels.nearest(bundle, leaves))
    return tree.places[rows]


CASES = {
    "count": st.integers(1, 90),
    "size": st.integers(1, 12),
    "values": st.sampled_from([1, 2, 3, 255]),
    "tree_size": st.sampled_from([0, 1, 2, 7, 1000]),
    "seed": st.integers(0, 2**32 - 1),
}


@given(**CASES, leaves=st.integers(1, 9), data=st.data())
def test_it_finds_what_the_slow_search_finds(count, size, values, tree_size, seed, leaves, data):
    vectors = vectors_of(count, size, values, seed)
    tree = build_tsvq(vectors, np.arange(count, dtype=np.int32), tree_size)
    slow = reference.vector_tree(vectors, tree_size or None)
    queries = vectors_of(5, size, values, seed + 1)
    counts = np.array(data.draw(st.lists(st.booleans(), min_size=size, max_size=size)))
    counts[seed % size] = True
    spans = np.flatnonzero(np.diff(np.concatenate([[0], counts, [0]]))).reshape(-1, 2)
    spans[:, 1] -= spans[:, 0]
    found = nearest(tree, queries, leaves, spans.astype(np.int32))
    for query, place in zip(queries, found, strict=True):
        expected = reference.nearest_in_tree(slow, vectors, query.astype(int), counts, leaves)
        assert place == expected


def test_long_vectors_and_far_values():
    """Black against white over 40,000 bytes passes 2**31."""
    vectors = np.repeat(np.array([[0], [255]], np.uint8), 40_000, axis=1)
    tree = build_tsvq(vectors, np.array([7, 3], np.int32), 2)
    query = np.full((1, 40_000), 128, np.uint8)
    assert nearest(tree, query).tolist() == [3]


def test_sizes():
    vectors = vectors_of(2000, 6, 255, 4)
    every = np.arange(2000, dtype=np.int32)
    for size in (1, 2, 3, 100, 2000, 5000):
        assert len(leaves_of(build_tsvq(vectors, every, size))) == min(size, 2000)
    sizes = np.diff(leaves_of(build_tsvq(vectors, every))[:, 1:])
    assert sizes.max() <= tsvq.LEAF_VECTORS and sizes.sum() == 2000


def test_equal_vectors_are_one_leaf():
    """Otherwise a sample of one color would be searched through for every pixel."""
    tree = build_tsvq(np.full((50_000, 8), 9, np.uint8), np.arange(50_000, dtype=np.int32), 64)
    assert tree.nodes.tolist() == [[-1, 0, 1]]
    assert tree.places[0] == 0


def test_places_may_come_in_any_order():
    vectors = vectors_of(300, 5, 4, 5)
    places = np.random.default_rng(6).permutation(300).astype(np.int32)
    shuffled = build_tsvq(vectors, places)
    ordered = build_tsvq(vectors[np.argsort(places)], np.arange(300, dtype=np.int32))
    assert np.array_equal(shuffled.places, ordered.places)
    assert np.array_equal(shuffled.nodes, ordered.nodes)
