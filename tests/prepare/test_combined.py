"""Several samples as one."""

import numpy as np
import pytest

import weftex
from families import noise, refused
from materials import normal_map


def test_nothing_is_taken_from_two_samples_at_once():
    one, other = noise((20, 30, 3)), noise((26, 24, 3), seed=5)
    whole = weftex.prepare.together([one, other])
    assert whole.shape == (47, 30)
    assert np.array_equal(whole.pixels[:20], one) and np.array_equal(whole.pixels[21:, :24], other)
    assert not whole.mask[20].any() and not whole.mask[:, 24:][21:].any()
    assert whole.mask[:20].all() and whole.mask[21:, :24].all()
    result = weftex.Quilting(patch_size=8).fit(whole).sample((60, 60), seed=1)
    rows = result.source[..., 0]
    assert (rows < 20).any() and (rows > 20).any() and not (rows == 20).any()


def test_maps_are_paired_by_role_at_any_scale(rng):
    one = weftex.Exemplar(
        noise((20, 30)), maps={"height": rng.random((40, 60)), "ao": rng.random((10, 15))}
    )
    other = weftex.Exemplar(
        noise((24, 30)), maps={"ao": rng.random((12, 15)), "height": rng.random((48, 60))}
    )
    whole = weftex.prepare.together([one, other])
    assert whole.shape == (46, 30)  # two lines between: one pixel of the coarser map
    assert whole.maps["height"].shape == (92, 60) and whole.maps["ao"].shape == (23, 15)
    assert np.array_equal(whole.maps["height"][44:], other.maps["height"])
    assert np.array_equal(whole.maps["ao"][11:], other.maps["ao"])


def test_a_lattice_that_samples_share_goes_on():
    tile = noise((16, 24))
    tiles = np.tile(tile, (8, 8))
    whole = weftex.prepare.together([tiles[:90, :100], tiles[7:95, 5:120], tiles[3:, 1:]])
    y, x = np.nonzero(whole.usable)
    assert not whole.pieces and np.array_equal(whole.pixels[y, x], tile[y % 16, x % 24])


def test_other_samples_share_no_lattice():
    tiles = np.tile(noise((8, 8)), (9, 9))
    apart = weftex.prepare.together([tiles, np.tile(noise((8, 8), seed=1), (9, 9))])
    with pytest.raises(weftex.UnsupportedError, match="needs one lattice"):
        weftex.NearRegular(lattice=(8, 0, 0, 8)).fit(apart)


@pytest.mark.parametrize(
    "samples, message",
    [
        ([], "must be a list"),
        ("sample:pebbles", "must be a list"),
        (weftex.Exemplar(noise((9, 9))), "must be a list"),
        ([noise((9, 9)), noise((9, 9), dtype=np.uint16)], "sample 2 .* is uint16"),
    ],
)
def test_what_is_no_list_of_one_kind_is_refused(samples, message):
    refused(message, weftex.prepare.together, samples)


@pytest.mark.parametrize("store", [lambda v: v, lambda v: (v + 1) / 2])
def test_normals_are_turned_to_the_first_convention_however_they_are_stored(rng, store):
    vectors = normal_map(rng, (12, 14))
    one, other = noise((12, 14)), noise((12, 14), seed=5)
    whole = weftex.prepare.together(
        [
            weftex.Exemplar(one, maps={"normal_gl": store(vectors)}),
            weftex.Exemplar(other, maps={"normal_dx": store(vectors * [1, -1, 1])}),
        ]
    )
    assert np.allclose(whole.maps["normal_gl"][:12], whole.maps["normal_gl"][13:])
