"""In fusion a parameter changes the picture of one map at least, or it is refused."""

import numpy as np
import pytest

import weftex
from families import refused
from parameters import idle
from weftex.methods.refinement import Refinement
from weftex.registry import METHODS, supporting

SAMPLES = [
    weftex.load_exemplar(f"sample:{name}").pixels[99:147, 60:108] for name in ("pebbles", "leaves")
]
Y, X = np.indices((34, 44))
MAPS = np.array([X >= 22, (Y - 17) ** 2 + (X - 22) ** 2 < 120], int)
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


def made(number, slug, boundary, given):
    """What lies where, on one of the maps."""
    return weftex.fuse(SAMPLES, MAPS[number], method=slug, boundary=boundary, seed=3, **given).index


def test_all_methods_that_fuse_are_tried():
    assert {slug for slug, _ in SETTINGS} == set(ABLE)


@pytest.mark.parametrize(
    ("slug", "given", "boundary"),
    [
        (slug, given, boundary)
        for boundary in ("cut", "merged")
        for slug, given in SETTINGS
        # Other methods treat belts as regions, and the nearest of all windows takes long.
        if boundary == "cut" or (METHODS[slug].belt_parameters and "search" not in given)
    ],
)
def test_a_parameter_has_an_effect_or_is_refused(slug, given, boundary):
    plain = [made(number, slug, boundary, given) for number in range(len(MAPS))]

    def changes(more):
        return any(
            not np.array_equal(made(number, slug, boundary, more), plain[number])
            for number in range(len(MAPS))
        )

    assert not idle(slug, given, changes)


@pytest.mark.parametrize("name", sorted(Refinement.belt_parameters))
def test_what_only_belts_take(name):
    """Belts of merged samples start from seeds, also where regions start from quilting."""
    given = {"window_width": 15, "iterations": 2}
    value = {"matches": 40, "seed_density": 0.5, "seed_scale": 3.0}[name]
    only = {name: value}
    result = weftex.fuse(SAMPLES, MAPS[0], boundary="merged", seed=3, **given, **only)
    assert result.provenance[name] == value
    refusal = f"{name} has no effect unless init is 'seeds'"
    for more in ({}, {"init": "graphcut"}):
        refused(refusal, weftex.fuse, SAMPLES, MAPS[0], **given, **more, **only)
    method = Refinement(init="graphcut", **given)
    for boundary in ("cut", "merged"):
        refused(refusal, weftex.fuse, SAMPLES, MAPS[0], method=method, boundary=boundary, **only)
