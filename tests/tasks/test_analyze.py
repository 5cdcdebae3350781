"""What `weftex analyze` says, and that it is true."""

import json

import numpy as np
import pytest

import weftex
from weftex import cli
from weftex.analysis.lattice import Lattice
from weftex.analysis.overlay import draw_lattice
from weftex.analysis.properties import border_steps, regularity
from weftex.analysis.scale import structure_scale
from weftex.exemplar import Exemplar
from weftex.io.pictures import write_image
from weftex.tasks.analyze import analyze


def steps_by_definition(levels, usable):
    """Mean squared difference of each row to the one before, the first to the last."""
    height, width = usable.shape
    steps = []
    for y in range(height):
        pairs = [x for x in range(width) if usable[y, x] and usable[y - 1, x]]
        total = sum(int(((levels[y, x].astype(int) - levels[y - 1, x]) ** 2).sum()) for x in pairs)
        steps.append(total / max(1, len(pairs)))
    inside = steps[1:] or steps
    return round(steps[0] / max(np.median(inside), inside[0], inside[-1], 1), 2)


@pytest.mark.parametrize("shape", [(7, 9), (5, 4, 3), (1, 6), (6, 1), (1, 1), (5, 700, 3)])
@pytest.mark.parametrize("masked", [False, True])
def test_border_steps_are_their_definition(shape, masked, rng):
    pixels = rng.integers(0, 256, shape, np.uint8)
    mask = rng.random(shape[:2]) < 0.7 if masked else np.ones(shape[:2], bool)
    mask[0, 0] = True
    exemplar = Exemplar(pixels, mask=mask)
    levels = exemplar.matching()
    down, across = (levels, mask), (levels.swapaxes(0, 1), mask.T)
    assert border_steps(exemplar) == (steps_by_definition(*down), steps_by_definition(*across))


def test_tiles_are_told_from_crops():
    """Mostly, and as `tile --check` does."""
    tiles, crops = [], []
    for name in ("pebbles", "bricks", "grass", "weave", "leaves", "tiles", "wood"):
        sample = weftex.load_exemplar(f"sample:{name}")
        model = weftex.Quilting().fit(sample)
        for seed in range(3):
            tiles += analyze(model.sample(160, seed=seed, tileable=True).image).tiles
        for corner in (0, 30, 60):
            piece = sample.pixels[corner : corner + 120, corner : corner + 120]
            crops += analyze(np.ascontiguousarray(piece)).tiles
    assert np.mean(tiles) >= 0.95 and np.mean(crops) <= 0.15


def test_tiles_says_along_which_axis():
    wave = np.rint(127 + 100 * np.sin(np.arange(64) * 2 * np.pi / 16)).astype(np.uint8)
    sample = np.add.outer(2 * np.arange(64), wave // 2).astype(np.uint8)
    assert analyze(sample).tiles == (False, True)
    assert analyze(sample.T.copy()).tiles == (True, False)
    assert "to the right only" in str(analyze(sample))


def test_everything_is_what_its_own_function_says():
    exemplar = weftex.load_exemplar("sample:tiles")
    found = analyze(exemplar)
    scale = structure_scale(exemplar)
    assert (found.height, found.width, found.channels, found.dtype) == (256, 256, 3, "uint8")
    assert (found.scale, found.confidence) == (scale.scale, scale.confidence)
    assert found.regularity == regularity(exemplar)
    assert found.border_steps == border_steps(exemplar)


@pytest.mark.parametrize("masked", [False, True])
def test_windows_are_those_that_the_methods_take(masked, rng):
    mask = np.full((40, 40), not masked)
    mask[3:9, 5:30] = True  # alone, no room for the windows that are proposed
    exemplar = Exemplar(rng.integers(0, 256, (40, 40), np.uint8), mask=mask)
    windows = analyze(exemplar).windows
    for slug, cls in weftex.METHODS.items():
        if "window_width" in cls.__dataclass_fields__:
            try:
                settled = cls().fit(exemplar).method
            except weftex.InvalidInputError:  # what is proposed has no room
                windows.pop(slug)
                continue
            assert windows.pop(slug) == settled.window_width
            assert cls().resolved(exemplar) == settled
    assert windows == {}


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (6, 6), (40, 40, 3)])
def test_constant_and_tiny_samples(shape):
    found = analyze(np.full(shape, 7, np.uint8))
    assert (found.scale, found.confidence, found.regularity) == (1, 0, 0)
    assert found.tiles == (True, True)
    assert "no clear peak" in str(found)


def test_the_command_prints_it(capsys):
    assert cli.main(["analyze", "sample:weave"]) == 0
    out, err = capsys.readouterr()
    assert out.rstrip("\n") == str(analyze("sample:weave")) and err == ""
    assert "192x192, 3 x uint8" in out and "confidence 0.9" in out
    assert max(map(len, out.splitlines())) <= 100


def test_lattices_are_rated_as_asked(tmp_path, capsys):
    """A given lattice and runners-up, drawn and in JSON."""
    drawn = tmp_path / "o.png"
    words = ["--lattice", "126,0,0,84", "--overlay", str(drawn)]
    assert cli.main(["analyze", "sample:bricks", "--json", *words]) == 0
    found = json.loads(capsys.readouterr().out)
    expected = analyze("sample:bricks", lattice=(126, 0, 0, 84))
    assert found == json.loads(json.dumps(expected.as_dict()))
    ratings = found["ratings"]
    assert ratings["given"]["vectors"] == [[0, 84], [126, 0]] and len(ratings["runners_up"]) == 4
    sample = weftex.load_exemplar("sample:bricks")
    given = Lattice(((126, 0), (0, 84)))
    assert np.array_equal(weftex.load_exemplar(drawn).pixels, draw_lattice(sample, given))
    text = str(expected)
    assert "given" in text and "126 x 84 px" in text and "runner-up 4" in text


def test_a_running_bond_has_courses():
    """And not the lengths of its vectors, which are diagonals."""
    text = str(analyze("sample:bricks"))
    words = "126.2 x 41.8 px, every other row shifted by half"
    assert " ".join(text.split()).count(words) >= 2  # the lattice, and what auto says


def test_rows_are_printed_as_they_are_taken(tmp_path, capsys):
    """As four numbers: the second vector is a pixel along the rows, as `--lattice` takes it."""
    y = np.arange(96)[:, None]
    sample, drawn = tmp_path / "rows.png", tmp_path / "drawn.png"
    pixels = np.rint(128 + 90 * np.cos(y * np.pi / 8) + 0 * y.T).astype(np.uint8)
    write_image(sample, pixels + np.random.default_rng(0).integers(0, 30, (96, 96), np.uint8))
    assert cli.main(["analyze", str(sample)]) == 0
    lines = dict(line.split(None, 1) for line in capsys.readouterr().out.splitlines() if line)
    assert lines["lattice"].startswith("rows 16 px apart, confidence")
    assert lines["vectors"] == "0,16,1,0 px"
    words = ["--lattice", "0,16,1,0", "--overlay", str(drawn)]
    assert cli.main(["analyze", str(sample), *words]) == 0
    assert "0,16,1,0 px, rows 16 px apart; goodness" in capsys.readouterr().out
    expected = draw_lattice(weftex.load_exemplar(sample), Lattice(((0, 16),)))
    assert np.array_equal(weftex.load_exemplar(drawn).pixels, expected)
    model = weftex.NearRegular(lattice=(0, 16, 1, 0)).fit(weftex.load_exemplar(sample))
    assert model.sample(64, seed=1).image.shape == (64, 64)
