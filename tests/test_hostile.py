"""Every public function with every kind of nonsense: an error of weftex, in one line."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

import weftex
from families import noise
from strategies import is_one_line
from weftex.pages import compare, report

PICTURE = noise((12, 13, 3))
SMALL = noise((12, 12))
WEFT = "patch-sampling"


class Odd:
    """Something that nobody expects."""

    def __repr__(self):
        return "Odd()"


#: Values that are no picture, no path and no number that anything takes.
NONSENSE = {
    "None": None,
    "True": True,
    "7": 7,
    "-1": -1,
    "0.5": 0.5,
    "nan": math.nan,
    "inf": math.inf,
    "10**400": 10**400,
    "-10**400": -(10**400),
    "complex": 1j,
    "text": "nonsense",
    "empty text": "",
    "null": "a\0b",
    "surrogate": "\udcff",
    "bytes": b"nonsense",
    "list": [1, 2, 3],
    "ragged": [[1], [1, 2]],
    "tuple": (1, 2, 3, 4),
    "dict": {"a": 1},
    "set": {1, 2},
    "object": Odd(),
    "class": Odd,
    "function": len,
    "array": np.zeros((2, 2, 2, 2)),
    "empty array": np.zeros((0, 3), np.uint8),
    "texts": np.array(["a", "b"]),
    "objects": np.array([None, {}], object),
    "dates": np.array(["2026-11-22"], "datetime64[D]"),
    "structured": np.zeros(3, [("a", "u1"), ("b", "f4")]),
    "0-d": np.array(3),
}


def result():
    return weftex.synthesize(PICTURE, 16, method="quilting", patch_size=5, seed=1)


def filled():
    return weftex.fill(PICTURE, np.arange(156).reshape(12, 13) == 70, seed=1)


def synth(**given):
    return weftex.synthesize(PICTURE, **{"size": 9, "method": WEFT, "seed": 1} | given)


HOLE = np.zeros((12, 13), bool)
HOLE[4:8, 4:8] = True
#: What is called with each value, and the values that it takes after all.
CALLS = {
    "synthesize sample": (lambda v: weftex.synthesize(v, 9), ()),
    "synthesize size": (lambda v: synth(size=v), ("7",)),
    "synthesize height": (lambda v: synth(size=(v, 7)), ("7",)),
    "synthesize method": (lambda v: synth(method=v), ()),
    "synthesize seed": (lambda v: synth(seed=v), ("None", "7")),
    "synthesize tileable": (lambda v: synth(tileable=v), ("True",)),
    "synthesize guide": (lambda v: synth(guide=v, method="ashikhmin"), ("None",)),
    "synthesize sample_guide": (
        lambda v: synth(sample_guide=v, guide=PICTURE[:9, :9], method="ashikhmin"),
        ("None",),
    ),
    "synthesize best_of": (lambda v: synth(best_of=v), ("7",)),
    "synthesize threads": (lambda v: synth(threads=v), ("None", "7", "10**400")),
    "synthesize progress": (lambda v: synth(progress=v), ("None", "True")),
    "fill photo": (lambda v: weftex.fill(v, HOLE), ()),
    "fill mask": (lambda v: weftex.fill(PICTURE, v), ()),
    "fill overlap": (lambda v: weftex.fill(PICTURE, HOLE, overlap=v), ()),  # 7 covers all
    "fill match_tone": (
        lambda v: weftex.fill(PICTURE, HOLE, match_tone=v, seed=1),
        ("None", "True"),
    ),
    "fill sample": (lambda v: weftex.fill(PICTURE, HOLE, sample=v), ("None",)),
    "fill method": (lambda v: weftex.fill(PICTURE, HOLE, method=v), ()),
    "fill seed": (lambda v: weftex.fill(PICTURE, HOLE, seed=v), ("None", "7")),
    "fill tileable": (lambda v: weftex.fill(PICTURE, HOLE, tileable=v, seed=1), ("True",)),
    "fill threads": (lambda v: weftex.fill(PICTURE, HOLE, threads=v), ("None", "7", "10**400")),
    "fill progress": (lambda v: weftex.fill(PICTURE, HOLE, progress=v), ("None", "True")),
    "fuse samples": (lambda v: weftex.fuse(v, "gradient", 20), ()),
    "fuse sample": (lambda v: weftex.fuse([PICTURE, v], "gradient", 20), ()),
    "fuse map": (lambda v: weftex.fuse([PICTURE, PICTURE], v, 20), ()),
    "fuse size": (lambda v: weftex.fuse([PICTURE, PICTURE], "gradient", v), ("7",)),
    "fuse colors": (lambda v: weftex.fuse([PICTURE] * 2, HOLE.astype(int), colors=v), ("None",)),
    "fuse mixed": (lambda v: weftex.fuse([PICTURE] * 2, HOLE.astype(int), mixed=v), ("None",)),
    "fuse method": (lambda v: weftex.fuse([PICTURE] * 2, "gradient", 20, method=v), ()),
    "analyze": (weftex.analyze, ()),
    "assess sample": (lambda v: weftex.assess(v, PICTURE), ()),
    "assess result": (lambda v: weftex.assess(weftex.Exemplar(PICTURE), v), ()),
    "report sample": (lambda v: report(v, PICTURE), ()),
    "report result": (lambda v: report(PICTURE, v), ()),
    "report source": (lambda v: report(PICTURE, PICTURE, v), ("None",)),
    "report tileable": (lambda v: report(PICTURE, PICTURE, tileable=v), ("None", "True")),
    "compare sample": (lambda v: compare(v, 9), ()),
    "compare size": (lambda v: compare(PICTURE, v, methods=[WEFT]), ("None", "7")),
    "compare methods": (lambda v: compare(PICTURE[:3], 3, methods=v), ("None",)),
    "load_exemplar": (weftex.load_exemplar, ()),
    "load_exemplar files": (
        lambda v: weftex.load_exemplar("sample:stone_wall", files=v),
        ("None",),
    ),
    "Exemplar": (weftex.Exemplar, ()),
    "Exemplar maps": (lambda v: weftex.Exemplar(PICTURE, maps=v), ("None",)),
    "Exemplar map": (lambda v: weftex.Exemplar(PICTURE, maps={"height": v}), ()),
    "Exemplar mask": (lambda v: weftex.Exemplar(PICTURE, mask=v), ("None",)),
    "Exemplar guide": (lambda v: weftex.Exemplar(PICTURE, guide=v), ("None",)),
    "Canvas height": (lambda v: weftex.Canvas(v, 9), ("7",)),
    "Canvas wrap": (lambda v: weftex.Canvas(9, 9, v), ()),
    "Canvas hole": (lambda v: weftex.Canvas(12, 13, known=PICTURE, hole=v), ()),
    "Canvas known": (lambda v: weftex.Canvas(12, 13, known=v, hole=HOLE), ("None",)),
    "Canvas guide": (lambda v: weftex.Canvas(12, 13, guide=v), ("None",)),
    "Canvas origin": (lambda v: weftex.Canvas(12, 13, origin=v), ()),
    "Canvas known_from": (
        lambda v: synth(size=weftex.Canvas(12, 13, known=PICTURE, hole=HOLE, known_from=v)),
        ("None",),
    ),
    "fit": (lambda v: weftex.Quilting().fit(v), ()),
    "sample size": (lambda v: weftex.Quilting().fit(PICTURE).sample(v), ("7",)),
    "window top": (lambda v: weftex.BestTile().fit(PICTURE).window(v, 0, 9, 9), ("7", "-1")),
    "window width": (lambda v: weftex.BestTile().fit(PICTURE).window(0, 0, 9, v), ("7",)),
    "METHODS": (lambda v: weftex.METHODS[v], ()),
    "read_image": (weftex.read_image, ()),
    "read_image max_pixels": (
        lambda v: weftex.read_image("sample:weave", max_pixels=v),
        ("None", "10**400"),
    ),
    "write_image path": (lambda v: weftex.write_image(v, PICTURE), ()),
    "write_image pixels": (lambda v: weftex.write_image("a.png", v), ()),
    "write_image icc": (lambda v: weftex.write_image("a.png", PICTURE, icc=v), ("None", "bytes")),
    "save": (lambda v: result().save(v), ("text", "bytes")),
    "load": (weftex.Synthesis.load, ()),
    "load exemplar": (lambda v: loaded(exemplar=v), ("None",)),
    "load known": (lambda v: loaded(known=v), ("None",)),
    "render": (lambda v: result().render(v), ("None",)),
    "render background": (lambda v: filled().render(PICTURE, background=v), ("None",)),
    "render window": (lambda v: result().render(window=v), ("None", "tuple")),
    "layers": (lambda v: result().layers(v), ("None", "tuple")),
    "draw": (lambda v: result().draw(v), ()),
    "Report.save": (lambda v: report(PICTURE, PICTURE).save(v), ()),
}
CALLS |= {
    f"{slug} {field.name}": (
        lambda v, slug=slug, name=field.name: weftex.METHODS[slug](**{name: v}),
        None,  # whatever is in its bounds
    )
    for slug in weftex.METHODS
    for field in dataclasses.fields(weftex.METHODS[slug])
}


def loaded(**given):
    filled().save("a.npz")
    made = weftex.Synthesis.load("a.npz", **given)
    made.image  # noqa: B018
    return made


@pytest.mark.parametrize("what", CALLS)
def test_nonsense_is_refused_in_one_line(what, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, takes = CALLS[what]
    wrong = []
    for name, value in NONSENSE.items():
        if "progress" in what and callable(value):
            continue  # what it raises is its own
        try:
            call(value)
        except weftex.WeftexError as error:
            if not str(error) or "\n" in str(error) or len(str(error)) > 600:
                wrong.append((name, "not one line", str(error)[:200]))
        except Exception as error:
            wrong.append((name, type(error).__name__, str(error)[:120]))
        else:
            if takes is not None and name not in takes:
                wrong.append((name, "taken", ""))
    assert wrong == []
    assert {path.name for path in Path().iterdir()} <= {"a.npz", "a.png", "nonsense"}


@pytest.mark.parametrize("scale", [1e-300, 1e-310, 5e-324, 1e300, 1.7e308])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_any_scale_of_floats(scale, dtype):
    """The same choices whatever the unit that values are in, as long as the type has digits."""
    plain = np.random.default_rng(1).random((20, 20)) * 0.9 + 0.1
    with np.errstate(over="ignore", under="ignore"):
        pixels = (plain * scale).astype(dtype)
    pixels = np.clip(pixels, np.finfo(dtype).min, np.finfo(dtype).max)
    for method in (WEFT, "quilting", "ashikhmin"):
        made = weftex.synthesize(pixels, 24, method=method, seed=1)
        assert np.isfinite(made.image).all()
    weftex.analyze(pixels)
    if dtype == np.float64 and scale in (1e-300, 1e300):
        levels = weftex.Exemplar(pixels).matching().astype(int)
        small = weftex.Exemplar(plain * 1e-30).matching().astype(int)
        assert abs(levels - small).max() <= 1


@pytest.mark.parametrize(
    "work, said",
    [
        (
            lambda: weftex.synthesize(SMALL, 20, method="quilting", patch_size=10**400),
            "must be at most 2**63 - 1",
        ),
        (
            lambda: weftex.synthesize(SMALL, 20, method="near-regular", lattice=(1e300, 0, 0, 9)),
            "at most 1e+09 pixels long",
        ),
        (lambda: weftex.analyze(SMALL, lattice=(1e300, 0, 0, 1e300)), "at most 1e+09 pixels long"),
        (lambda: weftex.write_image("a.png", SMALL, alpha=True), "alpha needs"),
        (lambda: weftex.assess(SMALL, SMALL, tileable="x"), "tileable is 'x'"),
        (lambda: weftex.assess(SMALL, SMALL, tileable=(True, False, True)), "two of them"),
        (lambda: weftex.fuse([SMALL, SMALL], SMALL, colors=[0, 0]), "color 0 is given twice"),
        (
            lambda: weftex.fill(SMALL, SMALL > 99, sample=np.zeros((9, 9))),
            "the sample sample is float64 with 1 channels, the photo sample is uint8",
        ),
    ],
)
def test_what_nobody_listed(work, said):
    with pytest.raises(weftex.InvalidInputError) as error:
        work()
    assert said in str(error.value) and is_one_line(error.value) and len(str(error.value)) < 200


def test_a_transition_narrower_than_numbers_is_a_step():
    ways = [weftex.label_maps.Gradient(width=width) for width in (1e-300, 1e-9)]
    first, second = (way.label_map((20, 20), [3, 3], 1)[0] for way in ways)
    assert np.array_equal(first, second)
    assert (first[:5] == 0).all() and (first[-5:] == 1).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 1)])
@pytest.mark.parametrize("candidates", [0, 3])
def test_lists_without_a_place(shape, candidates):
    """A build with checks finds an address of nothing."""
    sample = np.zeros(shape, np.uint8)
    made = weftex.synthesize(sample, 4, method="exact-matching", candidates=candidates, seed=1)
    assert made.image.shape == (4, 4)
