"""Whatever shows a material: folders of maps, folders of none, and what `fit` takes."""

import numpy as np
import pytest

import weftex
from commands import fails, read_maps, weft_run
from families import every, method_of, noise, refused
from weftex.io.pictures import write_image


@pytest.fixture
def photos(tmp_path, monkeypatch):
    """A folder of unrelated photos of one size."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "photos").mkdir()
    for seed, name in enumerate(("bricks", "leaves", "wood")):
        write_image(f"photos/{name}.png", noise((40, 40, 3), seed=seed))
    return tmp_path


def test_maps_can_be_named(photos, capsys):
    words = ["synth", "photos", "-o", "out", "--size", 50, "--seed", 1]
    assert weft_run(*words, "--maps", "color=wood.png,height=leaves.png") == 0
    err = capsys.readouterr().err
    assert "map: wood.png is color, the main map\n" in err
    assert "map: leaves.png is height\n" in err
    files = {"color": "wood.png", "height": "leaves.png"}
    exemplar = weftex.load_exemplar("photos", files=files)
    assert exemplar.name == "photos" and list(exemplar.maps) == ["height"]
    expected = weftex.synthesize(exemplar, 50, seed=1)
    made = read_maps("out")
    assert sorted(made) == ["leaves", "wood"]
    assert np.array_equal(made["wood"].pixels, expected.image)
    assert np.array_equal(made["leaves"].pixels, expected.maps["height"])


def test_maps_that_cannot_be_named(photos, capsys):
    refused(r"match no map \(bricks, leaves, wood\).*--maps", weftex.synthesize, "photos", 50)
    words = ["synth", "photos", "-o", "out", "--maps"]
    assert "--maps is 'wood.png'" in fails(capsys, photos, *words, "wood.png")
    assert "each once" in fails(capsys, photos, *words, "color=a.png,color=b.png")
    assert "not a file in photos" in fails(capsys, photos, *words, "color=../a.png")
    assert "nothing.png" in fails(capsys, photos, *words, "color=nothing.png")
    words = ["synth", "photos/wood.png", "-o", "out.png", "--maps", "color=wood.png"]
    assert "is not a folder" in fails(capsys, photos, *words)
    for sample in (noise((9, 9)), weftex.Exemplar(noise((9, 9)))):
        refused("files has no effect", weftex.load_exemplar, sample, files={"color": "a.png"})


@every("method")
def test_fit_takes_what_synthesize_takes(method, tmp_path):
    pixels = noise((24, 26, 3))
    write_image(tmp_path / "a.png", pixels)
    expected = method_of(method).fit(weftex.Exemplar(pixels)).sample(24, seed=1).image
    for sample in (pixels, str(tmp_path / "a.png"), tmp_path / "a.png"):
        assert np.array_equal(method_of(method).fit(sample).sample(24, seed=1).image, expected)
    for wrong in (None, 7, "nowhere.png", [[1, 2], [3]], {}, object()):
        refused("sample|nowhere", method_of(method).fit, wrong, error=weftex.WeftexError)


@pytest.mark.parametrize("shape", [(3, 64, 64), (1, 40, 50), (4, 3, 33), (2, 9, 100)])
def test_channels_first_are_refused(shape):
    for call in (
        lambda p: weftex.synthesize(p, 64),
        weftex.Exemplar,
        weftex.Quilting().fit,
        weftex.analyze,
        lambda p: weftex.Exemplar(noise(shape[:2]), maps={"normal": p}),
    ):
        refused(r"np\.moveaxis\(pixels, 0, -1\)", call, noise(shape))
    assert weftex.Exemplar(noise(shape), alpha=False).channels == shape[2]
    assert weftex.Exemplar(np.moveaxis(noise(shape), 0, -1)).shape == shape[1:]
    for low in ((3, 64, 3), (4, 40, 4), (1, 1, 3), (3, 3, 3), (3, 40), (4, 9, 32)):
        assert weftex.Exemplar(noise(low)).shape == low[:2]
