"""What methods show of their work is what they do."""

import numpy as np
import pytest

import weftex
from twins import boundary_zone as zones
from weftex.explanation import RECORDERS, explain
from weftex.methods import METHODS
from weftex.notes import pixel_asked

SMALL = {
    "patch-sampling": {"patch_size": 12, "boundary_width": 3},
    "quilting": {"patch_size": 12, "boundary_width": 3},
    "graphcut": {"patch_size": 16},
    "efros-leung": {"window_width": 5},
    "wei-levoy": {"window_width": 5, "levels": 2},
    "ashikhmin": {},
    "exact-matching": {"window_width": 5, "levels": 2},
    "refinement": {"window_width": 9, "iterations": 2},
    "near-regular": {"lattice": (8, 0, 0, 6)},
    "best-tile": {"lattice": (8, 0, 0, 6)},
}


@pytest.fixture(scope="module")
def sample():
    y, x = np.indices((36, 40))
    levels = (
        np.random.default_rng(3).integers(0, 40, (36, 40, 3))
        + 90 * ((y // 3 + x // 4) % 2)[..., None]
    )
    return weftex.Exemplar(levels.astype(np.uint8), name="checks")


@pytest.fixture(scope="module")
def shown(sample):
    made = {}

    def of(slug):
        if slug not in made:
            made[slug] = explain(sample, (40, 44), method=slug, seed=5, **SMALL[slug])
        return made[slug]

    return of


def test_every_method_says_how_it_works():
    assert set(RECORDERS) == set(METHODS) == set(SMALL)


@pytest.mark.parametrize("slug", SMALL)
def test_the_picture_is_the_one_that_is_made_without(slug, sample, shown):
    explanation = shown(slug)
    alone = weftex.synthesize(sample, (40, 44), method=slug, seed=5, **SMALL[slug])
    assert np.array_equal(explanation.result.image, alone.image)
    assert len(explanation) >= 4 and len({stage.title for stage in explanation}) == len(explanation)
    for stage in explanation:
        assert stage.picture.dtype == np.uint8 and stage.picture.shape[2] == 3
        assert stage.caption.endswith(".") and stage.array.size
    assert pixel_asked() is None  # nobody listens any more


@pytest.mark.parametrize("slug", ["patch-sampling", "quilting"])
def test_a_patch_matches_its_zone_as_the_twin_says(slug, sample, shown):
    explanation = shown(slug)
    best = explanation["candidates"].array[0]
    errors, zone = explanation["error surface"].array, explanation["boundary zone"].array
    compared = explanation["candidates"].array
    assert errors[best[0], best[1]] == best[2] == errors[compared[:, 0], compared[:, 1]].min()
    # The twin's zone of a patch with one above and one to the left (Fig. 3 d).
    result = explanation.result
    _, _, v, u = last_patch(result, explanation.pixel)
    window, width = np.zeros((12, 12), bool), 3
    window[:width], window[:, :width] = True, True
    expected = zones.zone_of(window, width)
    assert not zone[~expected].any() and zone[expected].any(axis=1).mean() > 0.9
    patch = sample.pixels[v : v + 12, u : u + 12].astype(int)
    assert ((zone - patch)[expected] ** 2).sum() == errors[v, u]


def last_patch(result, pixel):
    covering = [
        tuple(row[:4])
        for row in result.placements.tolist()
        if all(0 <= at - first < 12 for at, first in zip(pixel, row[:2], strict=True))
    ]
    return covering[-1]


@pytest.mark.parametrize("slug", ["efros-leung", "ashikhmin", "exact-matching"])
def test_the_pixel_comes_from_a_candidate(slug, shown):
    explanation = shown(slug)
    last = [stage for stage in explanation if stage.title.startswith("candidates")][-1]
    source = explanation.result.source[explanation.pixel].tolist()
    assert source in last.array.tolist()


def test_efros_and_leungs_candidates_are_within_the_tolerance(shown):
    explanation = shown("efros-leung")
    errors, candidates = explanation["error surface"].array, explanation["candidates"].array
    assert errors[tuple(candidates.T)].max() <= 1.1 * errors.min() + 1e-9
    order = explanation["order of growth"].array
    assert order.min() == 0 and (np.diff(np.unique(order)) == 1).all()


def test_the_way_down_the_tree_gets_narrower_and_ends_at_the_source(shown):
    explanation = shown("wei-levoy")
    path = explanation["tree of level 0"].array
    assert (np.diff(path[:, 2] - path[:, 1]) < 0).all()
    assert (np.diff(path[:, 1]) >= 0).all() and (np.diff(path[:, 2]) <= 0).all()
    source = explanation.result.source[explanation.pixel].tolist()
    assert source in explanation["candidates of level 0"].array.tolist()


def test_a_cut_changes_only_its_box(shown):
    explanation = shown("graphcut")
    before, after = explanation["canvas"].array, explanation["canvas after"].array
    new = explanation["cut"].array
    assert new.any() and np.array_equal(before[~new], after[~new])


def test_blocks_that_are_drawn_stay(shown):
    explanation = shown("near-regular")
    drawn, filled = (explanation[f"blocks {step}"].array for step in ("drawn", "filled"))
    there = drawn >= 0
    assert 0 < there.mean() < 1 and np.array_equal(drawn[there], filled[there])


def test_the_best_tile_has_the_lowest_error(shown):
    explanation = shown("best-tile")
    errors = explanation["error of tiles"].array
    anchor = tuple(explanation.result.provenance["anchor"])
    assert errors[anchor] == errors[errors >= 0].min()


def test_it_shows_and_saves_itself(shown, tmp_path):
    explanation = shown("quilting")
    assert repr(explanation).startswith("<Explanation of quilting at (25, 27): canvas,")
    page = explanation._repr_html_()
    assert page.count("<img") == len(explanation) and "boundary zone" in page
    paths = explanation.save(tmp_path / "work")
    assert len(paths) == len(explanation) + 1 and all(path.exists() for path in paths)
    read = weftex.read_image(paths[0]).pixels
    assert np.array_equal(read, explanation[0].picture)
    assert explanation.strip(60).shape[0] == 60


@pytest.mark.parametrize(
    "words, said",
    [
        ({"at": (40, 0)}, "at is (40, 0); the output is 44x40"),
        ({"at": "x"}, "at is 'x'; it must be a row and a column"),
        ({"method": "quiltin"}, "quiltin"),
        ({"method": "quilting", "window": 3}, "quilting has no parameter 'window'"),
    ],
)
def test_bad_input_is_one_line(words, said, sample):
    with pytest.raises(weftex.WeftexError, match=said.replace("(", r"\(").replace(")", r"\)")):
        explain(sample, (40, 44), **words)
