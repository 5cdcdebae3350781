"""Methods: parameters that know their ranges, capabilities, the registry."""

import dataclasses
import importlib
import math

import numpy as np
import pytest

import weftex
from families import refused
from weftex.errors import InvalidInputError, UnsupportedError
from weftex.method import CANVAS_KINDS, Method
from weftex.naming import make_method
from weftex.parameters import bounds, parameter
from weftex.registry import METHODS

EVERY = list(METHODS)
FIELDS = [(slug, f) for slug in EVERY for f in dataclasses.fields(METHODS[slug])]
named = pytest.mark.parametrize("slug, field", FIELDS, ids=[f"{s}-{f.name}" for s, f in FIELDS])


def others(slug, field):
    """Values of other fields under which this one may be set."""
    needs = field.metadata["needs"]
    return {needs[0]: needs[1][0]} if needs else {}


@pytest.mark.parametrize("slug", EVERY)
def test_the_slug_is_one_guess_everywhere(slug):
    cls = METHODS[slug]
    assert cls.slug == slug
    assert cls.__module__ == "weftex.methods." + slug.replace("-", "_")
    assert getattr(importlib.import_module(cls.__module__), cls.__name__) is cls
    assert getattr(weftex, cls.__name__) is cls
    assert cls.title and cls.paper and "\n" not in cls.title
    assert cls.__doc__ and "Examples" in cls.__doc__


@pytest.mark.parametrize("slug", EVERY)
def test_it_is_a_frozen_dataclass_that_works_with_its_defaults(slug):
    method = METHODS[slug]()
    assert dataclasses.is_dataclass(method)
    refused("'seed'", setattr, method, "seed", 1, error=dataclasses.FrozenInstanceError)
    assert method == METHODS[slug]() and hash(method) == hash(METHODS[slug]())
    assert method.supports <= set(CANVAS_KINDS)
    about = method.describe()
    assert about.pop("method") == slug
    assert METHODS[slug](**about) == method


@named
def test_metadata_is_complete(slug, field):
    meta = field.metadata
    assert meta["help"] and "\n" not in meta["help"] and len(meta["help"]) <= 100
    assert not meta["help"].endswith(".")
    if field.default is None:
        assert meta["default_text"], "say what None stands for"
    assert bounds(field)
    if meta["needs"]:
        other, values = meta["needs"]
        (found,) = [f for f in dataclasses.fields(METHODS[slug]) if f.name == other]
        assert set(values) <= set(found.metadata["choices"])


@named
def test_bounds_are_enforced(slug, field):
    cls, meta, more = METHODS[slug], field.metadata, others(slug, field)
    if meta["count"]:
        return  # see test_several_numbers
    if meta["choices"]:
        for value in meta["choices"]:
            assert getattr(cls(**{field.name: value}, **more), field.name) == value
        for value in ("no-such-choice", 1, None, True):
            refused(f"{field.name} is ", cls, **{field.name: value}, **more)
        return
    if meta["parity"]:
        wrong = 4 if meta["parity"] == "odd" else 5
        message = f"{field.name} is {wrong}; it must be {meta['parity']}"
        refused(message, cls, **{field.name: wrong})
        assert getattr(cls(**{field.name: wrong + 1}), field.name) == wrong + 1
    whole = "int" in str(field.type)
    for end, step in (("low", -1), ("high", 1)):
        if meta[end] is None:
            continue
        number = np.array(meta[end])[()]  # one of NumPy is taken, too
        assert getattr(cls(**{field.name: number}, **more), field.name) == meta[end]
        outside = meta[end] + step if whole else np.nextafter(meta[end], step * math.inf)
        with pytest.raises(InvalidInputError) as caught:
            cls(**{field.name: outside}, **more)
        message = str(caught.value)
        assert message.startswith(f"{field.name} is ") and bounds(field) in message
    bad = ["12", True, math.nan, [1], 1j] + ([1.5, math.inf] if whole else [])
    bad += [None] if field.default is not None else []
    for value in bad:
        refused(f"^{field.name} ", cls, **{field.name: value}, **more)


@pytest.mark.parametrize("slug", EVERY)
def test_what_is_no_parameter_is_refused_by_the_class_too(slug):
    name = dataclasses.fields(METHODS[slug])[0].name
    refused(f"'{name}s'; did you mean '{name}'", METHODS[slug], **{name + "s": 3})
    count = len(dataclasses.fields(METHODS[slug]))
    refused(f"{slug} has {count} parameters, not 99", METHODS[slug], *range(99))


def test_several_numbers():
    """From any sequence, and from a text with commas, as the command line gives it."""
    for value in ((12, 0, 0.5, 9), [12, 0, 0.5, 9], np.array([12, 0, 0.5, 9]), "12,0, 0.5,9"):
        found = METHODS["best-tile"](lattice=value).lattice
        assert found == (12.0, 0.0, 0.5, 9.0) and {*map(type, found)} == {float}
    for value in ("12,0,9", (1, 2, 3, 4, 5), "a,b,c,d", 7, [1, 2, 3, math.nan], "1,2,3,inf", True):
        refused("^lattice is .*4 numbers", METHODS["best-tile"], lattice=value)


@named
def test_a_parameter_without_effect_is_refused(slug, field):
    needs = field.metadata["needs"]
    if not needs:
        return
    other, values = needs
    (switch,) = [f for f in dataclasses.fields(METHODS[slug]) if f.name == other]
    given = field.metadata["low"]
    if field.metadata["count"]:
        given = (7.0, 0.0, 0.0, 5.0)
    elif given == field.default:
        given += 1
    if field.metadata["choices"]:
        (given, *_) = (name for name in field.metadata["choices"] if name != field.default)
    for choice in switch.metadata["choices"]:
        if choice in values:
            METHODS[slug](**{other: choice, field.name: given})
        else:
            with pytest.raises(InvalidInputError, match=f"{field.name} has no effect unless"):
                METHODS[slug](**{other: choice, field.name: given})
            METHODS[slug](**{other: choice, field.name: field.default})


@pytest.mark.parametrize("wrong, right", [("quiltin", "quilting"), ("patch_sampling", "patch-sam")])
def test_unknown_methods_name_the_nearest(wrong, right):
    refused(f"unknown method '{wrong}'; did you mean '{right}", METHODS.__getitem__, wrong)
    refused("did you mean", weftex.synthesize, np.zeros((9, 9), np.uint8), 9, method=wrong)


def test_the_registry_is_a_mapping():
    assert len(METHODS) == len(list(METHODS)) == len(dict(METHODS))
    assert "quilting" in METHODS and "zzz" not in METHODS and 5 not in METHODS
    assert METHODS.get("zzz") is None and METHODS.get("quilting") is weftex.Quilting


@named
def test_unknown_values_name_the_nearest(slug, field):
    for choice in field.metadata["choices"]:
        with pytest.raises(InvalidInputError, match=f"{field.name} is '{choice}x'; did you mean"):
            make_method(slug, {field.name: choice + "x"})


def test_make_method():
    method = weftex.Quilting(patch_size=9)
    assert make_method(method, {}) == method
    assert make_method(method, {"blend": "none"}) == weftex.Quilting(patch_size=9, blend="none")
    for wrong in (3, None, weftex.Quilting):
        refused("must be a name or a Method", make_method, wrong, {})
    refused("patchsize", make_method, weftex.Quilting(), {"patchsize": 3})


@dataclasses.dataclass(frozen=True)
class Humble(Method):
    """Supports nothing but plain canvases."""

    slug = "humble"
    title = "Humble"
    paper = "none"
    size: int = parameter(3, "of something", low=1)

    def fit_exemplar(self, exemplar):
        raise AssertionError("nobody fits it")


def test_unsupported_canvases_are_refused_with_those_that_can():
    known, hole = np.zeros((4, 4), np.uint8), np.ones((4, 4), bool)
    method = Humble()
    method.require(weftex.Canvas(4, 4))
    for canvas, kind in (
        (weftex.Canvas(4, 4, (True, False)), "wrap"),
        (weftex.Canvas(4, 4, (False, True)), "wrap"),
        (weftex.Canvas(4, 4, known=known, hole=hole), "known"),
        (weftex.Canvas(4, 4, guide=known), "guide"),
    ):
        with pytest.raises(UnsupportedError) as caught:
            method.require(canvas)
        start, able = str(caught.value).split("; these methods do: ")
        assert start == f"humble does not support {CANVAS_KINDS[kind]}"
        assert able.split(", ") == [s for s in EVERY if kind in METHODS[s].supports]


def test_errors_are_what_python_programs_expect():
    assert issubclass(weftex.InvalidInputError, ValueError)
    assert issubclass(weftex.FileError, OSError)
    for kind in (weftex.InvalidInputError, weftex.FileError, weftex.UnsupportedError):
        assert issubclass(kind, weftex.WeftexError)


CONTROLS = [(slug, field) for slug, field in FIELDS if field.metadata["control"]]


@pytest.mark.parametrize(
    "slug, field", CONTROLS, ids=[f"{s}-{f.metadata['control']}" for s, f in CONTROLS]
)
def test_a_slider_of_pages_changes_the_picture(slug, field):
    """One parameter of a method for each slider; its ends make different pictures."""
    twins = [f for s, f in CONTROLS if s == slug]
    assert len({f.metadata["control"] for f in twins}) == len(twins)
    ends = {"size": (9, 25), "variety": (0.01, 0.8), "softness": (2, 8)}[field.metadata["control"]]
    sample = weftex.load_exemplar("sample:weave").pixels[:96, :96]
    more = others(slug, field)
    made = [
        weftex.synthesize(sample, 112, method=slug, seed=1, **{field.name: end}, **more).image
        for end in ends
    ]
    assert (made[0] != made[1]).any()
