"""In fusion a parameter changes the picture of one map at least, or it is refused."""

import numpy as np
import pytest

import weftex
from parameters import idle
from weftex.registry import METHODS, supporting

SAMPLES = [
    weftex.load_exemplar(f"sample:{name}").pixels[99:147, 60:108] for name in ("pebbles", "leaves")
]
Y, X = np.indices((26, 36))
MAPS = (X >= 18, (Y - 13) ** 2 + (X - 18) ** 2 < 70)
ABLE = [slug for slug in METHODS if slug in supporting("many") and slug in supporting("known")]
#: The parameters beside which each other one is tried.
SETTINGS = [
    ("refinement", {"window_width": 15, "iterations": 3}),
    ("refinement", {"window_width": 15, "iterations": 3, "init": "seeds"}),
    ("refinement", {"window_width": 15, "iterations": 3, "init": "patch-sampling"}),
    ("refinement", {"window_width": 5, "iterations": 4, "search": "nearest"}),
    ("refinement", {"window_width": 5, "iterations": 4, "search": "nearest", "init": "quilting"}),
    ("ashikhmin", {"window_width": 5}),
    ("efros-leung", {"window_width": 5}),
    ("exact-matching", {"window_width": 5, "levels": 2, "tileable": "y"}),
    ("exact-matching", {"window_width": 5, "levels": 2}),
    ("wei-levoy", {"window_width": 5}),
]


def made(number, slug, given):
    """What lies where, on one of the maps."""
    return weftex.fuse(SAMPLES, MAPS[number].astype(int), method=slug, seed=3, **given).index


def test_all_methods_that_fuse_are_tried():
    assert {slug for slug, _ in SETTINGS} == set(ABLE)


@pytest.mark.parametrize(("slug", "given"), SETTINGS)
def test_a_parameter_has_an_effect_or_is_refused(slug, given):
    plain = [made(number, slug, given) for number in range(len(MAPS))]

    def changes(more):
        return any(
            not np.array_equal(made(number, slug, more), plain[number])
            for number in range(len(MAPS))
        )

    assert not idle(slug, given, changes)
