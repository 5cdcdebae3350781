"""What hypothesis draws: methods, samples and canvases of every kind, all small.

A method's parameters are drawn from the bounds that its fields declare, so a new method, or a new
parameter, is tried without a line here.
"""

from __future__ import annotations

import dataclasses
import math
import os
from typing import Any

import numpy as np
from hypothesis import assume, settings
from hypothesis import strategies as st

import weftex
from families import DTYPES
from weftex.raster.turning import TURNS

#: Times as many cases as usual, and others in each run: for a run over night.
FACTOR = int(os.environ.get("WEFTEX_CASES", "1"))
#: Calls of the progress callback after which a run is cancelled: no parameter makes a case long.
PATIENCE = 400

_LARGE = 2**62  # what an integer without a bound may be
_SIDES = st.one_of(st.integers(1, 4), st.integers(5, 16))
_CHANNELS = (None, None, 3, 3, 1, 2, 4, 5)


def cases(count: int) -> Any:
    """Settings of a test of so many cases."""
    return settings(max_examples=count * FACTOR)


def values(field: dataclasses.Field[Any]) -> st.SearchStrategy[Any]:
    """Allowed values of a field: often small ones, and its ends."""
    meta = field.metadata
    if meta["choices"]:
        return st.sampled_from(list(meta["choices"]))
    if meta["count"]:
        part = st.one_of(st.integers(-12, 12).map(float), st.floats(-30, 30), st.floats(-1e9, 1e9))
        return st.tuples(*[part] * meta["count"])
    whole = "int" in str(field.type)
    low, high = meta["low"], meta["high"]
    if whole:
        high = _LARGE if high is None else high
        near = st.integers(low, min(low + 9, high))
        return st.one_of(near, near, near, st.integers(low, high), st.just(high))
    high = 1.7e308 if high is None else high
    near = st.floats(low, min(low + 1, high))
    return st.one_of(near, near, near, st.floats(low, high), st.sampled_from([low, high]))


@st.composite
def methods(draw: Any, slug: str) -> weftex.Method:
    """A method with a few of its parameters set."""
    fields = dataclasses.fields(weftex.METHODS[slug])
    chosen = draw(st.lists(st.sampled_from(fields), max_size=5, unique=True)) if fields else []
    given = {field.name: draw(values(field)) for field in chosen}
    for field in chosen:  # what it needs is set too, mostly
        needs = field.metadata["needs"]
        if needs and needs[0] not in given and draw(st.booleans()):
            given[needs[0]] = draw(st.sampled_from(list(needs[1])))
    try:
        return weftex.METHODS[slug](**given)
    except weftex.InvalidInputError:  # they exclude each other; said in a line
        assume(False)
        raise


@st.composite
def pictures(draw: Any, shape: tuple[int, int], like: Any = None) -> Any:
    """Pixels: noise, few values, one value, a ramp, or numbers that floats just hold."""
    dtype = np.dtype(draw(st.sampled_from(DTYPES))) if like is None else like.dtype
    channels = draw(st.sampled_from(_CHANNELS)) if like is None else None
    full = (*shape, channels) if channels else shape
    full = (*shape, *like.shape[2:]) if like is not None else full
    rng = np.random.default_rng(draw(st.integers(0, 2**16)))
    kinds = ["noise", "noise", "few", "one", "ramp"] + ["wild"] * (dtype.kind == "f")
    kind = draw(st.sampled_from(kinds))
    top = 1.0 if dtype.kind == "f" else float(np.iinfo(dtype).max)
    if kind == "noise":
        return (rng.random(full) * top).astype(dtype)
    if kind == "few":
        return (rng.integers(0, 3, full) * (top / 2)).astype(dtype)
    if kind == "one":
        return np.full(full, draw(st.sampled_from([0.0, top / 3, top])), dtype)
    if kind == "ramp":
        y, x = np.indices(shape)
        ramp = (y * 5 + x * 3) % 16 * (top / 16)
        return np.broadcast_to(ramp.reshape(*shape, *[1] * (len(full) - 2)), full).astype(dtype)
    about = np.finfo(dtype)
    scale = draw(st.sampled_from([about.max, about.tiny, about.smallest_subnormal, 1e30, 1e-30]))
    return (rng.choice([-1, 0, 0.25, 1], full) * float(scale)).astype(dtype)


@st.composite
def masks(draw: Any, shape: tuple[int, int], least: int = 0) -> Any:
    """Scattered pixels, a rectangle, or everything."""
    mask = np.zeros(shape, bool)
    kind = draw(st.sampled_from(["scattered", "rectangle", "rectangle", "all"]))
    if kind == "scattered":
        rng = np.random.default_rng(draw(st.integers(0, 2**16)))
        mask = rng.random(shape) < draw(st.sampled_from([0.02, 0.3, 0.9]))
    elif kind == "rectangle":
        spans = []
        for side in shape:
            start = draw(st.integers(0, side - 1))
            spans.append(slice(start, draw(st.integers(start + 1, side))))
        mask[tuple(spans)] = True
    else:
        mask[:] = True
    if mask.sum() < least:
        mask[0, 0] = True
    return mask


@st.composite
def exemplars(draw: Any, shape: tuple[int, int] | None = None, like: Any = None) -> Any:
    """A sample with or without mask, maps, guide; one that tiles, or not, or turned copies."""
    shape = shape or draw(st.tuples(_SIDES, _SIDES))
    pixels = draw(pictures(shape, like))
    about: dict[str, Any] = {"tileable": draw(st.booleans())}
    if draw(st.integers(0, 3)) == 0:
        about["mask"] = draw(masks(shape, least=1))
    if like is None and draw(st.integers(0, 4)) == 0:
        about["maps"] = {"height": draw(pictures(shape)), "normal": draw(pictures(shape))}
    if draw(st.integers(0, 4)) == 0:
        about["guide"] = draw(pictures(shape))
    if pixels.ndim == 3 and pixels.shape[2] > 1:
        about["alpha"] = draw(st.sampled_from([None, True, False]))
    exemplar = weftex.Exemplar(pixels, **about)
    if draw(st.integers(0, 7)) == 0:
        return weftex.prepare.turned(exemplar, draw(st.sampled_from(list(TURNS))))
    return exemplar


@st.composite
def canvases(draw: Any, method: weftex.Method, exemplar: Any) -> weftex.Canvas:
    """A canvas of a kind that the method supports."""
    size = draw(st.tuples(_SIDES, _SIDES))
    about: dict[str, Any] = {}
    kinds = ["plain", "plain", *sorted(method.supports & {"wrap", "known", "guide"})]
    kinds += ["origin"] * ("random_access" in method.supports)
    kind = draw(st.sampled_from(kinds))
    if kind == "wrap" or (kind == "known" and "wrap" in method.supports):
        about["wrap"] = draw(st.tuples(st.booleans(), st.booleans()))
    if kind == "known":
        about["known"] = draw(pictures(size, exemplar.pixels))
        about["hole"] = draw(masks(size))
        if min(np.subtract(exemplar.shape, size)) >= 0 and draw(st.booleans()):
            about["known_from"] = (0, 0)
    if kind == "guide":
        guide = exemplar.pixels if exemplar.guide is None else exemplar.guide
        about["guide"] = draw(pictures(size, guide))
        if exemplar.labels is not None and draw(st.integers(0, 3)):
            rng = np.random.default_rng(draw(st.integers(0, 99)))
            colors = exemplar.labels[rng.integers(0, len(exemplar.labels), size)]
            about["guide"] = colors.reshape(*size, *guide.shape[2:])
    if kind == "origin":
        far = st.one_of(st.integers(-20, 20), st.sampled_from([-(2**40), 2**40]))
        about["origin"] = draw(st.tuples(far, far))
    return weftex.Canvas(*size, **about)


def patience() -> Any:
    """A progress callback that cancels what takes long, and looks at a preview."""
    calls = 0

    def callback(done: int, total: int, stage: str, preview: Any) -> bool:
        nonlocal calls
        calls += 1
        assert 0 <= done <= total and stage
        if calls == 2:
            preview()
        return calls < PATIENCE

    return callback


def finite(pixels: Any) -> bool:
    """No number beyond the type's own."""
    return pixels.dtype.kind != "f" or bool(np.isfinite(pixels).all())


def is_one_line(error: Exception) -> bool:
    """What every message is."""
    return bool(str(error)) and "\n" not in str(error) and math.isfinite(len(str(error)))
