"""Hole filling as a task: what stays, what is refused, where patches come from."""

import numpy as np
import pytest
from PIL import Image

import families
import weftex
from families import noise
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.raster.boxes import holes_in
from weftex.tasks.auto import rule
from weftex.tasks.auto.rule import choose_for_hole

METHODS = [slug for slug in families.METHODS if "hole" in families.kinds_of(slug)]


def box(shape, *boxes):
    hole = np.zeros(shape, bool)
    for top, left, bottom, right in boxes:
        hole[top:bottom, left:right] = True
    return hole


HOLES = {
    "square": box((70, 90), (20, 30, 45, 60)),
    "several": box((70, 90), (5, 5, 12, 20), (40, 50, 60, 58), (30, 80, 33, 83)),
    "border": box((70, 90), (0, 0, 10, 30), (60, 70, 70, 90)),
    "scratch": np.abs(np.arange(70)[:, None] - np.arange(90) // 2 - 8) < 2,
    "pixel": box((70, 90), (33, 44, 34, 45)),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", HOLES)
def test_known_pixels_stay_and_holes_get_sample_pixels(method, kind):
    hole = HOLES[kind]
    photo = noise((70, 90, 3))
    photo[hole] = 255
    trial = families.TRIALS[method]
    copying = {"blend": "none"} if trial.family == "patch" else trial.small
    result = weftex.fill(photo, hole, method=method, seed=1, **copying)
    image = result.image
    assert image.dtype == photo.dtype and image.shape == photo.shape
    assert (image[~hole] == photo[~hole]).all()
    source = result.source
    assert (source[~hole] == np.argwhere(~hole)).all()
    assert not hole[tuple(source[hole].T)].any()
    assert (image == photo[source[..., 0], source[..., 1]]).all()


def test_what_marks_the_hole_does_not_matter():
    photo, hole = noise((70, 90), dtype=np.uint16) // 20, HOLES["square"]
    images = []
    for mark in (0, 65535):
        photo[hole] = mark
        images.append(weftex.fill(photo, hole, seed=2).image)
    assert (images[0] == images[1]).all()


@pytest.mark.parametrize("across_border", [False, True])
def test_a_regular_pattern_is_continued(across_border):
    y, x = np.mgrid[:128, :160]
    photo = (((x // 8 + y // 8) % 2) * 200).astype(np.uint8)
    sides = (50, 0, 70, 11), (50, 149, 70, 160)
    hole = box(photo.shape, *(sides if across_border else [(50, 60, 80, 95)]))
    broken = np.where(hole, 90, photo).astype(np.uint8)
    assert (weftex.fill(broken, hole, seed=1, tileable=across_border).image == photo).all()


@pytest.mark.parametrize("method", ["graphcut", "patch-sampling"])
@pytest.mark.parametrize("name", ["bricks", "pebbles", "wood"])
def test_each_seed_makes_another_filling(method, name):
    photo = weftex.load_exemplar(f"sample:{name}").pixels[:192, :192]
    hole = box(photo.shape[:2], (60, 60, 110, 130))
    how = {"placement": "entire"} if method == "graphcut" else {}
    made = [weftex.fill(photo, hole, method=method, seed=seed, **how).image for seed in range(4)]
    for k, one in enumerate(made):
        for other in made[:k]:
            assert (abs(one[hole].astype(int) - other[hole]).max(axis=1) > 12).mean() > 0.05


def test_a_mask_that_covers_nothing_changes_nothing():
    photo = noise((30, 40, 3))
    result = weftex.fill(photo, np.zeros((30, 40), bool), seed=1)
    assert (result.index == -1).all()
    assert (result.image == photo).all()
    assert (result.source == np.stack(np.mgrid[:30, :40], axis=-1)).all()


def test_a_mask_that_covers_everything_needs_a_sample():
    photo, everything = noise((50, 60, 3)), np.ones((50, 60), bool)
    with pytest.raises(weftex.InvalidInputError, match="no pixels are left to copy from.*sample"):
        weftex.fill(photo, everything)
    sample = noise((64, 64, 3), seed=1)
    result = weftex.fill(photo, everything, sample=sample, seed=1, blend="none")
    assert (result.image == sample[result.source[..., 0], result.source[..., 1]]).all()


def test_from_a_sample_of_its_own():
    photo, sample, hole = noise((70, 90, 3)), noise((80, 80, 3), seed=1), HOLES["border"]
    result = weftex.fill(photo, hole, sample=sample, seed=1, blend="none")
    image, source = result.image, result.source
    assert (image[~hole] == photo[~hole]).all()
    assert (source[~hole] == -1).all()
    assert (image[hole] == sample[tuple(source[hole].T)]).all()
    with pytest.raises(weftex.InvalidInputError, match="background"):
        result.render(sample[..., 0])
    around = np.zeros((70, 90), np.uint8)
    assert (result.render(sample[..., 0], background=around)[~hole] == 0).all()


def test_masks_from_files_and_pil_are_the_same(tmp_path):
    photo, hole = noise((70, 90, 3)), HOLES["several"]
    image = Image.fromarray(hole)
    image.save(tmp_path / "hole.png")
    masks = (hole, image, tmp_path / "hole.png")
    images = [weftex.fill(photo, m, method="quilting", seed=1).image for m in masks]
    assert (images[0] == images[1]).all() and (images[0] == images[2]).all()


def test_all_maps_are_filled_alike():
    rough = noise((70, 90), dtype=np.uint16)
    exemplar = weftex.Exemplar(noise((70, 90, 3)), maps={"rough": rough})
    hole = HOLES["several"]
    result = weftex.fill(exemplar, hole, seed=1, blend="none")
    filled = result.maps["rough"]
    assert filled.dtype == np.uint16
    assert (filled == rough[result.source[..., 0], result.source[..., 1]]).all()
    with pytest.raises(weftex.InvalidInputError, match="maps"):
        weftex.fill(exemplar, hole, sample=exemplar.pixels)


def test_maps_take_part_in_matching():
    # The picture tells nothing; only the map shows where the pattern goes on.
    y, x = np.mgrid[:128, :128]
    pattern = (((x // 8 + y // 8) % 2) * 200).astype(np.uint8)
    hole = box(pattern.shape, (50, 60, 70, 90))
    exemplar = weftex.Exemplar(np.full((128, 128), 60, np.uint8), maps={"height": pattern})
    assert (weftex.fill(exemplar, hole, seed=1).maps["height"] == pattern).all()


@pytest.mark.parametrize("wrap", [False, True])
def test_a_large_photo_is_filled_from_nearby(monkeypatch, wrap):
    monkeypatch.setattr("weftex.tasks.fill._NEIGHBORHOOD", 40_000)
    photo = noise((900, 1000))
    hole = box(photo.shape, (0, 980, 30, 1000))
    result = weftex.fill(photo, hole, seed=1, tileable=wrap, patch_size=16)
    source = result.source[hole].astype(int)
    far = np.abs(source - (15, 990))
    far = np.minimum(far, photo.shape - far) if wrap else far
    assert far.max() < 500
    assert (result.image[~hole] == photo[~hole]).all()
    assert not hole[tuple(source.T)].any()


def test_parameters_given_are_kept_and_the_rest_chosen():
    photo, hole = noise((300, 300)), box((300, 300), (100, 100, 180, 180))
    chosen = weftex.fill(photo, hole, seed=1, method="graphcut").provenance
    assert (chosen["patch_size"], chosen["boundary_width"]) == (48, 16)
    given_size = weftex.fill(photo, hole, seed=1, patch_size=20, epsilon=0.3).provenance
    assert (given_size["patch_size"], given_size["epsilon"]) == (20, 0.3)
    ready = weftex.PatchSampling(patch_size=24, boundary_width=5)
    kept = weftex.fill(photo, hole, seed=1, method=ready).provenance
    assert (kept["patch_size"], kept["boundary_width"]) == (24, 5)
    assert kept["epsilon"] == ready.epsilon


def test_patches_shrink_where_holes_leave_little():
    hole = np.zeros((120, 120), bool)
    hole[::14] = hole[:, ::14] = True
    photo = noise((120, 120))
    result = weftex.fill(photo, hole, seed=1, method="graphcut")
    assert result.provenance["patch_size"] <= 13
    assert (result.image[~hole] == photo[~hole]).all()


Y, X = np.indices((128, 128))
#: Holes that leave little of a small photo.
LITTLE_LEFT = {
    "ellipse": ((Y - 64) / 26) ** 2 + ((X - 64) / 34) ** 2 <= 1,
    "frame": box((40, 40), (4, 4, 36, 36)),
    "corner": box((128, 128), (20, 18, 128, 126)),
    "diagonal": np.eye(9, 30, dtype=bool),
    "line": np.indices((20, 20)).sum(axis=0) != 5,
    "corners": np.array([[True, False, False], [False, False, True]]),
}


@pytest.mark.parametrize("name", LITTLE_LEFT)
@pytest.mark.parametrize("method", ["efros-leung", "wei-levoy", "ashikhmin", "exact-matching"])
def test_windows_shrink_to_what_holes_leave(method, name):
    """Of the proposed windows and levels, on a photo of bricks at half its size."""
    hole = LITTLE_LEFT[name]
    bricks = weftex.load_exemplar("sample:bricks").pixels
    photo = np.ascontiguousarray(bricks[: 2 * len(hole) : 2, : 2 * hole.shape[1] : 2])
    result = weftex.fill(photo, hole, method=method, seed=1)
    assert np.array_equal(result.image[~hole], photo[~hole])
    assert not hole[tuple(result.source[hole].T)].any()


def test_progress_can_cancel():
    with pytest.raises(weftex.CancelledError):
        weftex.fill(noise((70, 90)), HOLES["several"], seed=1, progress=lambda *_: False)


def test_joints_of_a_sure_lattice_go_on():
    """By default pieces are shifted by the lattice of a photo, and are cut among things."""
    photo = weftex.load_exemplar("sample:tiles").pixels[:240, :250]
    hole = box(photo.shape[:2], (90, 110, 150, 170))
    made = weftex.fill(photo, hole, seed=1).provenance
    assert made["method"] == "graphcut" and "lattice" in made["reason"] and made["lattice"]
    for asked in ({"method": "patch-sampling"}, {"patch_size": 20}):
        assert weftex.fill(photo, hole, seed=1, **asked).provenance["method"] == "patch-sampling"
    canvas = weftex.Canvas(240, 250, known=photo, hole=hole, known_from=(0, 0))
    model = weftex.Auto().fit(weftex.Exemplar(photo, mask=~hole))
    assert model.sample(canvas, seed=1).provenance["method"] == "graphcut"
    made = weftex.fill(noise((180, 190)), hole[:180, :190], seed=1).provenance
    assert made["method"] == "graphcut" and made["placement"] == "entire"
    assert (made["candidates"], made["refinements"], made["halvings"]) == (48, 2, 2)


def test_large_photos_with_a_lattice_are_filled_on_it(monkeypatch):
    """On the vectors of the photo itself, not of a smaller copy; small holes by its rows, too."""
    photo = np.tile(weftex.load_exemplar("sample:tiles").pixels[:204, :249], (3, 3, 1))
    holes = [box(photo.shape[:2], ends) for ends in ((250, 300, 330, 400), (9, 9, 522, 522))]
    known = {"known": photo, "known_from": (0, 0)}
    canvas, large = (weftex.Canvas(*photo.shape[:2], hole=hole, **known) for hole in holes)
    sample = weftex.Exemplar(photo, mask=~holes[0])
    choice = choose_for_hole(sample, canvas)
    assert choice.method == "graphcut"
    assert choice.parameters["lattice"] == tuple(find_lattice(sample))
    for rows, by in ((Lattice(((0.0, 68.0),), 0.9), {"lattice": (0, 68, 1, 0)}), (None, {})):
        monkeypatch.setattr(rule, "find_lattice", lambda one, rows=rows: rows)
        assert choose_for_hole(sample, canvas).parameters == {"placement": "entire", **by}
        assert choose_for_hole(sample, large).parameters == {}


@pytest.mark.parametrize("wrap", [(False, False), (False, True), (True, True)])
def test_holes_far_apart_have_boxes_of_their_own(rng, wrap):
    mask = rng.random((190, 120)) < 0.001
    seen = np.zeros(mask.shape, int)
    for (top, bottom), (left, right) in holes_in(mask, wrap, apart=5):
        near = np.s_[max(top - 5, 0) : bottom + 5, max(left - 5, 0) : right + 5]
        seen[near] += mask[near]
        assert wrap == ((top, bottom) == (0, 190), (left, right) == (0, 120))
        rows, columns = (mask[top:bottom, left:right].any(axis=axis) for axis in (1, 0))
        assert (wrap[0] or rows[[0, -1]].all()) and (wrap[1] or columns[[0, -1]].all())
    assert mask.any() and np.array_equal(seen, mask)  # each pixel is near one of them only


@pytest.mark.parametrize("overlap", [0, 5])
def test_holes_all_over_a_large_photo_are_filled_each_from_nearby(monkeypatch, overlap):
    photo = weftex.load_exemplar("sample:pebbles").pixels
    photo = np.concatenate([photo, photo[:, ::-1]], axis=1)
    hole = box(photo.shape[:2], (100, 30, 130, 60))
    mask = hole | box(hole.shape, (0, 240, 12, 260), (150, 360, 192, 384))
    for name, value in (("LARGE", 200**2), ("SQUARE", 64), ("MARGIN", 40), ("LEAST_REACH", 24)):
        monkeypatch.setattr(f"weftex.tasks.fill._{name}", value)
    result = weftex.fill(photo, mask, overlap=overlap, seed=1)
    part = np.s_[28 - overlap :, : 132 + overlap]
    alone = weftex.fill(photo[part], hole[part], overlap=overlap, seed=1)
    assert np.array_equal(result.source[part], alone.source + (28 - overlap, 0))
    cut = result.canvas.hole
    assert np.array_equal(result.image[~cut], photo[~cut]) and cut[mask].all()
    assert (cut == mask).all() == (not overlap)
    away = result.source[cut] - np.argwhere(cut)
    assert abs(away).max() < 40 + 32 + 40 + 2 * overlap
    assert not mask[tuple(result.source[cut].T)].any()


@pytest.mark.parametrize("overlap", [0, 5])
def test_a_large_hole_has_the_sources_of_a_smaller_copy(monkeypatch, overlap):
    photo = weftex.load_exemplar("sample:pebbles").pixels[:187, :191]
    mask = box(photo.shape[:2], (131, 70, 187, 131))
    monkeypatch.setattr("weftex.tasks.fill._LARGE_HOLE", 40**2)
    result = weftex.fill(photo, mask, overlap=overlap, seed=1)
    cut = result.canvas.hole
    assert np.array_equal(result.image[~cut], photo[~cut]) and cut[mask].all()
    assert not mask[tuple(result.source[cut].T)].any()
    whole = result.source[:186, :190].reshape(93, 2, 95, 2, 2)
    inside = cut[:186, :190].reshape(93, 2, 95, 2).all(axis=(1, 3))
    steps = (whole - whole[:, :1, :, :1])[inside.nonzero()[0], :, inside.nonzero()[1]]
    assert (steps == [[[0, 0], [0, 1]], [[1, 0], [1, 1]]]).all() and inside.sum() > 700


@pytest.mark.parametrize("method", ["patch-sampling", "quilting", "graphcut"])
def test_an_overlap_cuts_where_photo_and_filling_differ_least(method):
    photo = weftex.load_exemplar("sample:tiles").pixels[:200, :240]
    hole = box(photo.shape[:2], (70, 90, 120, 150))
    result = weftex.fill(photo, hole, seed=1, method=method, overlap=10)
    cut, ring = result.canvas.hole, box(hole.shape, (60, 80, 130, 160))
    assert cut[hole].all() and not cut[~ring].any()
    assert 0 < cut[ring & ~hole].mean() < 1, "it does not follow the outline"
    assert np.array_equal(result.image[~cut], photo[~cut])
    assert np.array_equal(result.image, result.render())
    assert np.array_equal(result.source[~cut], np.argwhere(~cut))

    def step(inside, image):
        """What changes across the outline of an area, in the mean."""
        across = [inside[:, 1:] ^ inside[:, :-1], inside[1:] ^ inside[:-1]]
        steps = [abs(np.diff(image.astype(int), axis=axis)).sum(2) for axis in (1, 0)]
        return np.concatenate([s[a] for s, a in zip(steps, across, strict=True)]).mean()

    filled = weftex.fill(photo, ring, seed=1, method=method).image
    straight = np.where(ring[..., None], filled, photo)
    assert step(cut, result.image) < 1.2 * step(ring, straight)
