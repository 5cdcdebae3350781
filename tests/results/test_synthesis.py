"""The answer and its renderings: replay, windows, layers."""

import pickle

import numpy as np
import pytest

import weftex
from families import BLENDS, noise, refused
from laid import SAMPLE, filled, make
from weftex.canvas import Canvas


@pytest.mark.parametrize("blend", BLENDS)
@pytest.mark.parametrize("scale", [1, 2, 3])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_maps_at_multiples_and_depths(rng, blend, scale, dtype):
    result = make(blend)
    for channels in ((), (1,), (3,), (5,)):
        big = (rng.random((30 * scale, 34 * scale, *channels)) * 250).astype(dtype)
        got = result.render(big)
        assert got.dtype == dtype
        assert got.shape == (40 * scale, 45 * scale, *channels)
        # Each phase of a larger map is a map of the sample's own size.
        for v in range(scale):
            for u in range(scale):
                one = result.render(np.ascontiguousarray(big[v::scale, u::scale]))
                assert np.array_equal(got[v::scale, u::scale], one)


@pytest.mark.parametrize("make_one", [lambda: make("cut"), lambda: make(wrap=(True, True)), filled])
def test_windows_are_parts_of_the_whole(rng, make_one):
    result = make_one()
    height, width = result.shape
    coordinates, shares = result.layers()
    windows = [(0, 0, 1, 1), (height - 1, width - 1, 1, 1), (0, 0, height, width), (5, 7, 11, 3)]
    big = rng.integers(0, 65536, (60, 68)).astype(np.uint16)
    for top, left, rows, columns in windows:
        part = slice(top, top + rows), slice(left, left + columns)
        window = (top, left, rows, columns)
        assert np.array_equal(result.render(window=window), result.image[part])
        got = result.layers(window)
        assert np.array_equal(got[0], coordinates[part])
        assert np.array_equal(got[1], shares[part])
        twice = slice(2 * top, 2 * (top + rows)), slice(2 * left, 2 * (left + columns))
        assert np.array_equal(result.render(big, window=window), result.render(big)[twice])


@pytest.mark.parametrize(
    "window", [(-1, 0, 5, 5), (0, -1, 5, 5), (0, 0, 0, 5), (0, 0, 5, -1), (36, 0, 5, 5),
               (0, 41, 5, 5), (0, 0, 41, 1)],
)  # fmt: skip
def test_windows_outside_are_refused(window):
    result = make()
    for ask in (lambda: result.render(window=window), lambda: result.layers(window)):
        refused("window", ask)


@pytest.mark.parametrize("blend", BLENDS)
def test_layers_say_what_the_picture_is_made_of(blend):
    """The weighted mean of the layers is the picture, up to its rounding at each patch."""
    result = make(blend, (False, True))
    coordinates, shares = result.layers()
    assert coordinates.shape == (40, 45, 4, 2) and coordinates.dtype == np.int32
    assert shares.shape == (40, 45, 4) and shares.dtype == np.float32
    assert np.allclose(shares.sum(axis=2), 1, atol=1e-6)
    assert (np.diff(shares, axis=2) <= 0).all()
    assert ((coordinates[..., 0] == -1) == (shares == 0)).all()
    there = coordinates[shares > 0]
    assert (there >= 0).all() and (there < SAMPLE.shape[:2]).all()
    values = SAMPLE[coordinates[..., 0], coordinates[..., 1]] * shares[..., None]
    assert np.abs(values.sum(axis=2) - result.image).max() <= 2
    if blend in ("cut", "none"):
        assert set(np.unique(shares)) == {0.0, 1.0}


@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
@pytest.mark.parametrize("size", [(24, 41), (31, 45)])
def test_shares_sum_to_one_with_the_widest_boundary(wrap, size):
    """Half of a patch: three patches meet along each axis, nine in a corner."""
    method = weftex.PatchSampling(patch_size=16, boundary_width=8)
    result = method.fit(weftex.Exemplar(SAMPLE)).sample(weftex.Canvas(*size, wrap), seed=1)
    assert np.allclose(result.layers()[1].sum(axis=2), 1, atol=1e-6)


def test_source_of_a_tall_result_is_put_together_from_bands():
    result = weftex.synthesize(SAMPLE, (600, 20), seed=1, method="patch-sampling", patch_size=10)
    assert np.array_equal(result.source, result.layers()[0][:, :, 0])


def test_known_pixels_of_a_filled_photo():
    result = filled()
    hole = result.canvas.hole
    assert np.array_equal(result.image[~hole], SAMPLE[2:28, 3:33][~hole])
    y, x = np.nonzero(~hole)
    assert np.array_equal(result.source[y, x], np.stack([y + 2, x + 3], axis=1))
    _coordinates, shares = result.layers()
    assert (shares[y, x, 0] == 1).all() and (shares[y, x, 1:] == 0).all()
    assert np.allclose(shares.sum(axis=2), 1, atol=1e-6)
    normals = np.arange(30 * 34, dtype=np.uint16).reshape(30, 34)
    assert np.array_equal(result.render(normals)[~hole], normals[2:28, 3:33][~hole])


def test_known_pixels_from_elsewhere():
    result = filled(known_from=None)
    hole = result.canvas.hole
    assert (result.source[~hole] == -1).all() and (result.source[hole] >= 0).all()
    normals = np.zeros((60, 68), np.uint16)
    refused("give their map as background", result.render, normals)
    background = np.full((52, 60), 7, np.uint16)
    known = ~hole.repeat(2, 0).repeat(2, 1)
    assert (result.render(normals, background=background)[known] == 7).all()
    for bad in (
        background[:-1],
        background[:26, :30],
        background.astype(np.uint8),
        background[..., None],
    ):
        refused("background is", result.render, normals, background=bad)


@pytest.mark.parametrize(
    "shape", [(29, 34), (15, 18), (60, 34), (30, 68), (61, 68), (30, 35), (1, 1)]
)
def test_maps_of_another_size_are_refused(shape):
    refused("integer multiple", make().render, np.zeros(shape, np.uint8))


def test_maps_come_along():
    values = np.arange(30 * 34, dtype=np.uint16).reshape(30, 34)
    result = make(maps={"height": values, "roughness": values})
    assert set(result.maps) == {"height", "roughness"}
    assert np.array_equal(result.maps["roughness"], result.render(values))
    assert np.array_equal(result.maps["height"], result.render(values, role="height"))
    assert make().maps == {}
    refused("normal", result.maps.__getitem__, "normal", error=KeyError)


def test_results_can_be_pickled():
    result = make("cut")
    assert np.array_equal(pickle.loads(pickle.dumps(result)).image, result.image)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda source: source[:5], r"source is int64 \(5, 8, 2\); it must be integer \(6, 8, 2\)"),
        (lambda source: source / 2, "source is float64"),
        (lambda source: source - 1, "lies outside the sample, which is 10x9"),
        (lambda source: source + 3, "lies outside the sample, which is 10x9"),
    ],
)
def test_sources_of_ones_own_are_checked(change, message):
    sample = weftex.Exemplar(noise((9, 10, 3)))
    source = np.stack(np.indices((6, 8)), axis=2) + [1, 0]
    made = weftex.Synthesis.from_source(Canvas(6, 8), source, sample, {"seed": 4})
    assert np.array_equal(made.image, sample.pixels[1:7, :8])
    assert np.array_equal(made.source, source) and made.provenance == {"seed": 4}
    refused(message, weftex.Synthesis.from_source, Canvas(6, 8), change(source), sample)
