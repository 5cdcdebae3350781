"""In fusion a parameter changes the picture of one map at least, or it is refused."""

import dataclasses

import numpy as np
import pytest

import weftex
from weftex.methods.refinement import Refinement
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
    ("best-tile", {}),
    ("wei-levoy", {"window_width": 5}),
]


def made(number, slug, boundary, given):
    """What lies where, on one of the maps."""
    labels = MAPS[number].astype(int)
    return weftex.fuse(SAMPLES, labels, method=slug, boundary=boundary, seed=3, **given).index


def values_of(field, given):
    """Values that a parameter may have: its bounds, or some around what it is."""
    now = given.get(field.name, field.default)
    low, high = field.metadata["low"], field.metadata["high"]
    if field.metadata["choices"]:
        found = [v for v in field.metadata["choices"] if v != "auto"][:3]
    elif "int" in str(field.type):
        base = now or 8
        found = [base + 2, 2, 3 * base + 6, base // 25, low]
    else:
        base = now or 4.0
        found = [5.0 * base, 0.2 * base, low, high, 100.0]
    allowed = [v for v in found if v is not None and v != now]
    if field.metadata["choices"]:
        return allowed
    return [v for v in allowed if (low is None or v >= low) and (high is None or v <= high)]


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
    idle = []
    for field in dataclasses.fields(METHODS[slug]):
        tried = {}
        for value in values_of(field, given):
            try:
                more = given | {field.name: value}
                tried[value] = any(
                    not np.array_equal(made(number, slug, boundary, more), plain[number])
                    for number in range(len(MAPS))
                )
            except weftex.InvalidInputError as error:
                tried[value] = str(error)
            if tried[value] is True:
                break
        if True not in tried.values() and False in tried.values():
            idle.append((field.name, tried))
    assert not idle


@pytest.mark.parametrize("name", sorted(Refinement.belt_parameters))
def test_what_only_belts_take(name):
    """Belts of merged samples start from seeds, also where regions start from quilting."""
    given = {"window_width": 15, "iterations": 2}
    value = {"matches": 40, "seed_density": 0.5, "seed_scale": 3.0}[name]
    result = weftex.fuse(
        SAMPLES, MAPS[0].astype(int), boundary="merged", seed=3, **given, **{name: value}
    )
    assert result.provenance[name] == value
    refusal = f"{name} has no effect unless init is 'seeds'"
    for more in ({}, {"init": "graphcut"}):
        with pytest.raises(weftex.InvalidInputError, match=refusal):
            weftex.fuse(SAMPLES, MAPS[0].astype(int), **given, **more, **{name: value})
    for boundary in ("cut", "merged"):
        with pytest.raises(weftex.InvalidInputError, match=refusal):
            method = Refinement(init="graphcut", **given)
            weftex.fuse(SAMPLES, MAPS[0].astype(int), method=method, boundary=boundary,
                        **{name: value})  # fmt: skip
