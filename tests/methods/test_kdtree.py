"""The approximate kd-tree of section 3.1; what it finds is in `test_patch_sampling.py`."""

import sys

import numpy as np
import pytest

from weftex.errors import UnsupportedError
from weftex.search.acceleration import kd_tree


def test_equal_points_make_a_tree():
    """Sliding midpoint splits cannot part them; the tree must still end."""
    tree = kd_tree(np.zeros((500, 7), np.int16))
    assert len(set(tree.query(np.ones(7), 40)[1].tolist())) == 40


def test_without_scipy_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.spatial", None)
    with pytest.raises(UnsupportedError, match="pip install 'scipy>=1.13'"):
        kd_tree(np.zeros((1, 1), np.int16))
