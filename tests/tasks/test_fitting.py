"""Sizes of tileable outputs: any can be made, and `fit` takes the nearest that fits."""

import numpy as np
import pytest

import weftex
from materials import normal_map
from weftex.analysis.canvas_lattice import FITTING_STRAIN, CanvasLattice
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.recipe import Recipe
from weftex.recipe.opening import open_recipe

RNG = np.random.default_rng(8)
Y, X = np.indices((360, 350))


def _ribs(pitch):
    """Corrugated sheet with bolts at places that do not repeat."""
    levels = 128 + 90 * np.sin(2 * np.pi * X / pitch) + RNG.normal(0, 12, X.shape)
    for k in range(12):
        levels[30 * k + 5 : 30 * k + 9, (k * 5 % 7) * pitch : (k * 5 % 7) * pitch + 4] = 0
    return np.clip(levels, 0, 255).astype(np.uint8)


def _bricks(width, height):
    row = Y // height
    shifted = X + row % 2 * (width // 2)
    tone = RNG.integers(90, 200, (99, 99))[row, shifted // width]
    return np.where((Y % height < 3) | (shifted % width < 3), 40, tone).astype(np.uint8)


def _checks(side):
    levels = (Y // side + X // side) % 2 * 150 + 50 + RNG.normal(0, 9, X.shape)
    return np.clip(levels, 0, 255).astype(np.uint8)


DRAWN = {"ribs": _ribs(47), "bricks": _bricks(62, 30), "checks": _checks(58)}


@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("size", [(270, 256), (100, 3)])
def test_auto_makes_any_tileable_size(name, size):
    how = {"seed": 1, "tileable": True}
    made = weftex.synthesize(DRAWN[name], size, **how)
    assert made.shape == size
    fitted = weftex.synthesize(DRAWN[name], size, fit=True, **how)
    said = [one for one in made.provenance.get("warnings", ()) if "stretched by" in one]
    assert bool(said) == (name != "ribs")  # a map of rows has nearly any size
    assert not said or f"{fitted.shape[1]}x{fitted.shape[0]}" in said[0]
    assert "strained" not in str(fitted.provenance.get("warnings"))


@pytest.mark.parametrize("width", [270, 290])
def test_ribs_that_do_not_fit_are_stretched_evenly(width, tmp_path):
    """Six ribs of 45 or 48.3 px, of a sample that has them at 47 px, with all of its maps."""
    levels = 128 + 60 * np.sin(2 * np.pi * X / 47) + RNG.normal(0, 12, X.shape)
    maps = {"normal": normal_map(RNG, X.shape), "id": (X // 47 * 5000).astype(np.uint16)}
    coarse = {"ao": np.zeros((X.shape[0] // 2, X.shape[1] // 2), np.uint8)}
    sample = weftex.Exemplar(np.clip(levels, 0, 255).astype(np.uint8), maps=maps | coarse)
    method = weftex.GraphCut(placement="entire", lattice=(47.2, 0, 0, -1))  # not by whole rows
    how = {"tileable": True, "method": method, "seed": 1}
    made, same = (weftex.synthesize(sample, (120, width), threads=n, **how) for n in (1, 3))
    waves = abs(np.fft.rfft(made.image.astype(float), axis=1)) ** 2
    assert (waves[:, 6] > 0.87 * waves[:, 1:].sum(axis=1)).mean() > 0.9
    assert made.provenance["method"] == "graphcut" and made.shape == (120, width)
    y, x = np.moveaxis(made.source, 2, 0)
    assert np.median(abs(made.image.astype(int) - sample.pixels[y, x])) == 0  # no new seams
    assert all(np.array_equal(made.maps[name], maps[name][y, x]) for name in maps)
    made.save(tmp_path / "made.npz")
    for other in (same, weftex.Synthesis.load(tmp_path / "made.npz", sample)):
        assert np.array_equal(made.image, other.image)


def test_planes_that_wrap_say_it_too():
    model = weftex.Auto().fit(DRAWN["bricks"])
    made = model.window(0, 0, 20, 30, seed=1, period=(600, 640))
    said = made.provenance["warnings"][-1]
    assert "stretched by" in said and "would fit better" in said


def test_the_nearest_size_that_fits_is_found():
    """Against every size around it, for a lattice whose rows are shifted."""
    vectors, wrap = (31.05, 0.1, 15.4, 26.2), (True, True)
    recipe = {"materials": [{"sample": "bricks"}], "size": [100, 120], "tileable": True}
    recipe |= {"fit": True, "method": "near-regular", "parameters": {"lattice": list(vectors)}}
    made = open_recipe(Recipe.from_json(recipe)).make().shape
    strains = {
        (y, x): CanvasLattice(vectors, Canvas(y, x, wrap)).strain
        for y in range(60, 141)
        for x in range(80, 161)
    }
    fits = [size for size, strain in strains.items() if strain <= FITTING_STRAIN]
    nearest = min(abs(y - 100) + abs(x - 120) for y, x in fits)
    assert made in fits and abs(made[0] - 100) + abs(made[1] - 120) == nearest


def test_samples_without_a_lattice_fit_any_size():
    how = {"method": "quilting", "tileable": "x", "seed": 1}
    assert weftex.synthesize("sample:grass", (90, 101), fit=True, **how).shape == (90, 101)
    with pytest.raises(InvalidInputError, match="fit has no effect without tileable"):
        weftex.synthesize("sample:grass", 90, fit=True)
    with pytest.raises(InvalidInputError, match="give fit or guide, not both"):
        given = {"size": [9, 9], "tileable": True, "fit": True, "guide": "a"}
        Recipe.from_json({"materials": [{"sample": "bricks"}], **given})
