"""Arrays and images of Python: values that do not fit, masks, and inputs that change later."""

import numpy as np
import pytest

import weftex
from families import noise, refused

SAMPLE = noise((40, 44, 3))


@pytest.mark.parametrize(("value", "fits"), [(70000, False), (-5, False), (65535, True)])
def test_integers_of_pillow(value, fits):
    image = pytest.importorskip("PIL.Image")
    pixels = noise((20, 24)).astype(np.int32)
    pixels[3, 4] = value
    given = image.fromarray(pixels, "I")
    if fits:
        assert (weftex.load_exemplar(given).pixels == pixels).all()
        return
    refused(f"{value}.*from 0 to 65535", weftex.load_exemplar, given)


@pytest.mark.parametrize("mode", ["CMYK", "YCbCr", "HSV", "LAB", "RGBX", "RGBa"])
def test_modes_of_pillow_that_are_no_colors_of_ours(mode):
    image = pytest.importorskip("PIL.Image")
    refused(rf"mode '{mode}'.*convert\('RGB'\)", weftex.load_exemplar, image.new(mode, (20, 20)))


def test_the_mask_of_an_array_counts():
    """A pixel that is masked in any channel is not used, whatever its value."""
    pixels = SAMPLE.astype(np.float32)
    pixels[:20, :, 1] = np.nan
    found = weftex.load_exemplar(np.ma.masked_invalid(pixels))
    assert (found.mask == (np.arange(40) >= 20)[:, None]).all()
    assert np.isfinite(found.pixels).all() and (found.pixels[20:] == pixels[20:]).all()
    coordinates, shares = weftex.synthesize(found, 60, method="quilting", seed=1).layers()
    assert coordinates[shares > 0][:, 0].min() >= 20
    own = np.ones((40, 44), bool)
    own[:, :10] = False
    both = weftex.Exemplar(np.ma.masked_invalid(pixels), mask=own)
    assert (both.mask == (found.mask & own)).all()
    refused("no usable pixel", weftex.Exemplar, np.ma.masked_all((4, 4), np.uint8))


def test_masks_that_have_no_meaning_are_refused(tmp_path):
    given = np.ma.array(SAMPLE, mask=SAMPLE > 200)
    for act in (
        lambda: weftex.Exemplar(SAMPLE, maps={"height": given}),
        lambda: weftex.fill(SAMPLE, given[..., 0]),
        lambda: weftex.write_image(tmp_path / "a.png", given),
    ):
        refused(r"masked.*filled", act)


def test_later_changes_of_inputs_change_nothing():
    pixels, height = SAMPLE.copy(), noise((40, 44))
    mask, guide = np.ones((40, 44), bool), noise((40, 44))
    sample = weftex.Exemplar(pixels, maps={"height": height}, mask=mask, guide=guide)
    model = weftex.METHODS["quilting"]().fit(sample)
    view = weftex.METHODS["quilting"]().fit(pixels[::-1])
    before = model.sample(60, seed=1), view.sample(60, seed=1).image
    before = before[0].image, before[0].render(sample.map("height")), before[1]
    for array in (pixels, height, guide):
        array[:] = 0
    mask[1:] = False
    assert sample.mask.all() and sample.guide.any()
    after = model.sample(60, seed=1)
    assert (after.image == before[0]).all() and (view.sample(60, seed=1).image == before[2]).all()
    assert (after.render(sample.map("height")) == before[1]).all()


def test_the_pixels_of_a_sample_are_kept_once():
    """Changing something else about a sample copies no pixels."""
    sample = weftex.Exemplar(SAMPLE, maps={"height": noise((40, 44))})
    changed = sample.changed(tileable=True)
    assert np.shares_memory(changed.pixels, sample.pixels)
    assert np.shares_memory(changed.maps["height"], sample.maps["height"])


def test_auto_is_not_among_the_methods():
    refused("is not a method, it chooses one", weftex.METHODS.__getitem__, "auto")
