"""What every model declares: outputs, and windows of an endless plane."""

import dataclasses

import numpy as np
import pytest

import weftex
from families import METHODS, method_of, noise, refused
from weftex.method import Model


@pytest.mark.parametrize("slug", METHODS)
def test_windows_with_a_way_of_their_own_are_parts_of_what_sample_makes(slug):
    if "random_access" in weftex.METHODS[slug].supports:
        model = method_of(slug).fit(weftex.Exemplar(noise((30, 31, 3))))
        whole = model.sample((40, 45), seed=3).image
        part = model.window(7, 9, 20, 25, seed=3)
        assert np.array_equal(part.image, whole[7:27, 9:34])
        assert part.canvas.origin == (7, 9)


#: Parameters that are None in a settled method, as they have no effect there: one of two that
#: exclude each other, or one that hangs on the canvas.
WITHOUT_EFFECT = {
    "exact-matching": {"tolerance", "nearest_colors"},
    "graphcut": {"halvings", "lattice"},  # each patch has its own; anywhere
    "refinement": {"joints", "seed_scale"},
    "near-regular": {"blend_width"},
}


@pytest.mark.parametrize("slug", METHODS)
def test_a_result_says_all_that_was_settled(slug):
    exemplar = weftex.Exemplar(noise((30, 31, 3)))
    model = method_of(slug).fit(exemplar)
    assert method_of(slug).resolved(exemplar) == model.method
    said = model.sample((24, 25), seed=3).provenance
    assert [name for name, value in said.items() if value is None] == []
    settled = dataclasses.asdict(model.method)
    open_still = {name for name, value in settled.items() if value is None}
    assert open_still <= WITHOUT_EFFECT.get(slug, set())
    assert {name: said[name] for name in settled if settled[name] is not None} == {
        name: value for name, value in settled.items() if value is not None
    }


def test_an_origin_is_saved_with_the_result(tmp_path):
    model = weftex.NearRegular(lattice="10,0,0,10").fit(weftex.Exemplar(noise((40, 40))))
    result = model.window(2**33, -5, 30, 31, seed=1)
    result.save(tmp_path / "window.npz")
    again = weftex.Synthesis.load(tmp_path / "window.npz", result.exemplar)
    assert again.canvas.origin == (2**33, -5)
    assert np.array_equal(again.image, result.image)


@pytest.mark.parametrize(
    "more, match",
    [
        ({"origin": (0.5, 0)}, "top is 0.5"),
        ({"origin": (0, 2**40 + 1)}, "left is"),
        ({"origin": (1,)}, r"must be \(top, left\)"),
        ({"origin": 7}, r"must be \(top, left\)"),
        ({"origin": (3, 3), "wrap": (True, False)}, "neither wraps nor has known pixels"),
        ({"origin": (3, 3), "hole": np.ones((4, 4), bool)}, "neither wraps nor has known pixels"),
    ],
)
def test_origins_are_checked(more, match):
    refused(match, weftex.Canvas, 4, 4, **more)


@pytest.mark.parametrize("threads", [1, 2])
def test_samples_are_those_of_the_seeds_that_follow(threads):
    model = weftex.PatchSampling(patch_size=12, boundary_width=3).fit("sample:pebbles")
    found = list(model.samples(7, (20, 30), seed=5, tileable=True, threads=threads))
    assert len(found) == 7
    for k, one in enumerate(found):
        assert np.array_equal(one, model.sample((20, 30), seed=5 + k, tileable=True).image)
    first = list(model.samples(2, (20, 30), seed=5, tileable=True, channels_first=True))
    assert np.array_equal(first[1], found[1].transpose(2, 0, 1)) and first[1].flags["C_CONTIGUOUS"]
    gray = weftex.Quilting(patch_size=9).fit(noise((20, 20)))
    assert [one.shape for one in gray.samples(1, 16, seed=1)] == [(16, 16)]
    assert [one.shape for one in gray.samples(1, 16, channels_first=True)] == [(1, 16, 16)]


@pytest.mark.parametrize("threads", [1, 2])
def test_samples_without_end_are_made_as_they_are_asked_for(threads):
    asked = []

    class Counting:
        def sample(self, canvas, *, seed, threads):
            asked.append(seed)
            return type("Result", (), {"image": np.full(canvas.shape, seed % 256)})()

    endless = Model.samples(Counting(), None, 4, seed=2**64 - 1, threads=threads)
    assert [int(next(endless)[0, 0]) for _ in range(3)] == [255, 0, 1]
    endless.close()
    assert len(asked) <= 3 + 2 * threads


@pytest.mark.parametrize("count", [-1, 2.5, True, "3"])
def test_bad_counts_of_samples_are_refused_at_once(count):
    model = weftex.PatchSampling(patch_size=12).fit("sample:pebbles")
    refused("count is", model.samples, count, 20)
    refused("threads is 0", model.samples, 1, 20, threads=0)
