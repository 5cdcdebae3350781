"""How the tests that run over every method try each one; a new method is one line of TRIALS.

Samples in these tests have sides of 20 to 40 pixels, and canvases of 40 to 200.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

import weftex

DTYPES = (np.uint8, np.uint16, np.float32, np.float64)
#: Every dtype and every number of channels (None: two axes), though not each with each.
FORMATS = (
    (np.uint8, None),
    (np.uint8, 3),
    (np.uint16, 1),
    (np.uint16, 4),
    (np.float32, 2),
    (np.float64, 5),
)
WRAPS = {"plain": (False, False), "x": (False, True), "y": (True, False), "xy": (True, True)}
BLENDS = ("feather", "feather-at-end", "cut", "none")
SEARCHES = ("exhaustive", "quadtree", "pca", "kdtree", "kdtree-pca")


@dataclass(frozen=True)
class Trial:
    """How to try one method."""

    family: str  # "patch" or "pixel": what the method copies in one step
    small: dict[str, Any]  # parameters for samples and canvases of 20 to 40 pixels
    #: Every way in which pixels are chosen or joined, as parameters over `small`.
    ways: dict[str, dict[str, Any]] = field(default_factory=lambda: {"": {}})
    wide: dict[str, Any] = field(default_factory=dict)  # lets in candidates, so a seed shows
    window: str = "window_width"  # the parameter that a sample must have room for
    least: int = 1  # shorter side of the smallest sample that the defaults work on
    largest: int = 60  # side of the largest canvas that a test may ask for
    real: tuple[dict[str, Any], ...] = ({},)  # for materials of 200 pixels, to look for seams
    unguided: tuple[str, ...] = ()  # ways that follow no guide, although the method does
    #: Over all that: what is made is copied, pixel by pixel, where no hole is filled.
    plain: dict[str, Any] = field(default_factory=dict)

    def copies(self, way: str) -> bool:
        """Whether every pixel made in this way is one of the sample."""
        return self.ways[way].get("blend", "cut") in ("cut", "none")


_PATCH: dict[str, Any] = {
    "family": "patch",
    "small": {"patch_size": 9, "boundary_width": 3},
    "ways": {
        **{blend: {"blend": blend} for blend in BLENDS},
        "single pixels": {"patch_size": 1, "boundary_width": 2, "blend": "none"},
    },
    "window": "patch_size",
    "least": 3,
    "largest": 200,
    "real": ({"patch_size": 32, "boundary_width": 5}, {"patch_size": 24, "boundary_width": 12}),
}
TRIALS = {
    "patch-sampling": Trial(**_PATCH, wide={"epsilon": 2.0}),
    "quilting": Trial(**_PATCH, wide={"tolerance": 1.0}),
    "graphcut": Trial(
        "pixel",
        {"candidates": 2},
        {
            "subpatch": {"patch_size": 8, "tolerance": 1.0},
            "difference": {"patch_size": 7, "seam_cost": "difference", "tolerance": 1.0},
            "entire": {"placement": "entire", "tolerance": 1.0},
            "random": {"placement": "random"},
        },
        window="patch_size",
        largest=120,
        plain={"tone_reach": 0.0},
        unguided=("entire", "random"),
    ),
    "efros-leung": Trial("pixel", {"window_width": 5}, largest=40, real=({"window_width": 9},)),
    "wei-levoy": Trial(
        "pixel",
        {"window_width": 5, "levels": 1},
        {
            "full": {"search": "full"},
            "tsvq": {"search": "tsvq"},
            "pyramid": {"search": "tsvq", "levels": 2, "window_width": 3},
        },
    ),
    "ashikhmin": Trial(
        "pixel",
        {"window_width": 5},
        {"one pass": {"passes": 1}, "passes": {"passes": 3}},
        largest=120,
    ),
    "exact-matching": Trial(
        "pixel",
        {"window_width": 5},
        {"random": {"init": "random"}, "structured": {"init": "structured"}},
        real=({"window_width": 11},),
    ),
    "refinement": Trial(
        "pixel",
        {"window_width": 5, "iterations": 3},
        {
            "another's": {"init": "quilting"},
            "seeds": {"init": "seeds"},
            "wide": {"init": "seeds", "window_width": 7},
            "nearest": {"search": "nearest"},
        },
        largest=60,
        real=({}, {"init": "seeds"}),
    ),
    "best-tile": Trial(
        "pixel",
        {"border_width": 2, "lattice": (6, 0, 0, 5)},
        window="border_width",
        least=100,  # noise has no lattice
        largest=90,
        real=(),  # tests/methods/test_best_tile.py looks at its borders
    ),
    "near-regular": Trial(
        "pixel",
        {"lattice": (1, 0, 0, 1), "block_size": 5, "border_width": 2},
        {
            "feather": {"blend": "feather", "blend_width": 2},
            "none": {"blend": "none", "match": "gncc"},
        },
        window="block_size",
        least=100,  # noise has no lattice
        largest=90,
        real=({"lattice": (1, 0, 0, 1)},),
    ),
}

#: Every method that has a line above; that all have one is a test of its own.
METHODS = [slug for slug in weftex.METHODS if slug in TRIALS]


def kinds_of(slug: str, way: str = "") -> list[str]:
    """The kinds of canvas that a method declares, and does in this way."""
    supports, kinds = weftex.METHODS[slug].supports, ["plain"]
    kinds += ["x", "y", "xy"] * ("wrap" in supports)
    kinds += ["hole"] * ("known" in supports)
    kinds += ["wrapped hole"] * (supports >= {"known", "wrap"})
    return kinds + ["guide"] * ("guide" in supports and way not in TRIALS[slug].unguided)


def every(*axes: str, family: str | None = None, kinds: Any = None) -> Any:
    """Parametrize a test by methods, all or those of a family, and by what each of them does.

    Axes: "method" first; then "kind" of canvas (only `kinds`), "way", "real"; last "dtype", which
    gives two of four types to each kind and way: together they have all.
    """
    cases = []
    for slug in METHODS:
        trial = TRIALS[slug]
        if family in (None, trial.family):
            values = {
                "method": [slug],
                "kind": [kind for kind in kinds_of(slug) if kinds is None or kind in kinds],
                "way": list(trial.ways),
                "real": list(trial.real),
            }
            product = itertools.product(*(values[axis] for axis in axes if axis != "dtype"))
            if "dtype" in axes:
                order = values["kind"], values["way"]
                product = [
                    (*case, dtype)
                    for case in product
                    for dtype in DTYPES[sum(map(list.index, order, case[1:])) % 2 :: 2]
                ]
            cases += [c for c in product if not ("guide" in c and set(c) & {*trial.unguided})]
    ids = ["-".join(getattr(v, "__name__", str(v)) for v in case) for case in cases]
    return pytest.mark.parametrize(
        ",".join(axes), [case if len(axes) > 1 else case[0] for case in cases], ids=ids
    )


def method_of(slug: str, way: str | None = None, **parameters: Any) -> weftex.Method:
    """The method with small parameters, those of the way, and these."""
    trial = TRIALS[slug]
    way_of = {} if way is None else trial.ways[way]
    return weftex.METHODS[slug](**trial.small | way_of | parameters)


def noise(
    shape: Any,
    dtype: Any = np.uint8,
    seed: int = 2,
    *,
    values: int | None = None,
    wide: bool = False,
    rng: Any = None,
) -> Any:
    """Random pixels of any dtype, from `rng` or of a seed.

    Of `values` different values over 0 to 255: few make ties and many matches. `wide` floats lie
    around 0.5, also below 0 and above 1, as in files.
    """
    rng = np.random.default_rng(seed) if rng is None else rng
    if values is not None:
        return (rng.integers(0, values, shape) * (255 // max(values - 1, 1))).astype(dtype)
    if np.dtype(dtype).kind == "f":
        return (rng.normal(0.5, 1, shape) if wide else rng.random(shape)).astype(dtype)
    return rng.integers(0, np.iinfo(dtype).max + 1, shape).astype(dtype)


def canvas_of(kind: str, pixels: Any, size: tuple[int, int] = (40, 37)) -> weftex.Canvas:
    """A canvas of this kind; a hole's surroundings, and a guide, are pixels of the same sort."""
    if kind in WRAPS:
        return weftex.Canvas(*size, WRAPS[kind])
    other = np.resize(pixels[::-1], (*size, *pixels.shape[2:])).astype(pixels.dtype)
    if kind == "guide":
        return weftex.Canvas(*size, guide=other)
    y, x = np.indices(size)
    hole = (y - 18) ** 2 + (x - 15) ** 2 < 90
    hole[-3:, 25:] = True  # touches the border
    hole[:2, 30:33] = True
    other[hole] = 0
    return weftex.Canvas(*size, (kind == "wrapped hole",) * 2, known=other, hole=hole)


def made(result: weftex.Synthesis) -> Any:
    """True where a pixel was made and not known."""
    return np.ones(result.shape, bool) if result.canvas.hole is None else result.canvas.hole


def refused(
    match: str, call: Any, /, *values: Any, error: Any = weftex.InvalidInputError, **named: Any
) -> None:
    """Check that the call raises this error, with a message of one line that matches."""
    with pytest.raises(error, match=match) as caught:
        call(*values, **named)
    assert "\n" not in str(caught.value)
