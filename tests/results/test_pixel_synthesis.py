"""Results that keep one source a pixel."""

import numpy as np
import pytest

import weftex
from weftex.results.pixels import PixelSynthesis

SAMPLE = np.random.default_rng(5).integers(0, 256, (9, 11, 3)).astype(np.uint8)


def make(sample=SAMPLE, size=(7, 8), known_from=None):
    index = np.random.default_rng(1).integers(0, 99, size).astype(np.int32)
    canvas = weftex.Canvas(*size, wrap=(True, False))
    if known_from is not None:
        where, (y, x) = np.random.default_rng(2).random(size) < 0.5, known_from
        known = sample[y : y + size[0], x : x + size[1]]
        canvas = weftex.Canvas(*size, known=known, hole=where)
        index[~where] = -1
    about = {"sample_shape": (9, 11), "exemplar": weftex.Exemplar(sample)}
    return PixelSynthesis(canvas, index, known_from=known_from, **about)


@pytest.mark.parametrize("scale", [1, 2, 3])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
@pytest.mark.parametrize("channels", [(), (1,), (3,), (5,)])
def test_every_pixel_is_that_of_its_source(rng, scale, dtype, channels):
    result = make()
    big = (rng.random((9 * scale, 11 * scale, *channels)) * 250).astype(dtype)
    got = result.render(big)
    assert got.shape == (7 * scale, 8 * scale, *channels) and got.dtype == dtype
    for y, x in np.ndindex(got.shape[:2]):
        v, u = divmod(int(result.index[y // scale, x // scale]), 11)
        assert np.array_equal(got[y, x], big[v * scale + y % scale, u * scale + x % scale])


DAMAGE = {
    "sources lie outside": [lambda a, value=value: np.full_like(a, value) for value in (-1, 99)],
    "size": [lambda a: a[1:]],
    "types": [lambda a: a.astype(float)],
}


@pytest.mark.parametrize("text", DAMAGE)
def test_damaged_sources_are_refused(tmp_path, text):
    result, path = make(), tmp_path / "r.npz"
    for change in DAMAGE[text]:
        result.index = change(make().index)
        result.save(path)
        with pytest.raises(weftex.FileError, match=text):
            weftex.Synthesis.load(path)


@pytest.mark.parametrize("size", [37, 43])
def test_lines_are_left_out_or_doubled_evenly(size):
    """Of two pieces of 20 columns: where they meet, inside and around, no column is left out."""
    y, x = np.indices((40, 40))
    index = (60 * y + x + x // 20 * 20).astype(np.int32)
    whole = PixelSynthesis(weftex.Canvas(40, 40), index, sample_shape=(40, 60), exemplar=None)
    source = whole.stretched(weftex.Canvas(size, size)).source
    steps = np.diff(source[:, 0, 0])
    assert set(steps.tolist()) == {1, 2 if size < 40 else 0}
    assert np.ptp(np.diff(np.flatnonzero(steps != 1))) <= 7  # of 13 lines
    assert {0, 19, 40, 59} <= set(source[0, :, 1].tolist())


def test_a_part_moves_into_the_whole():
    result = make(known_from=(1, 2))
    large = weftex.Exemplar(np.tile(SAMPLE, (2, 2, 1)))
    canvas = weftex.Canvas(20, 20, (True, True))
    moved = result.moved(canvas, large, to=(16, 17), source_to=(9, 13))
    hole = result.canvas.hole
    y, x = np.nonzero(hole)
    assert (moved.index >= 0).sum() == hole.sum()
    at = moved.source[(y + 16) % 20, (x + 17) % 20]
    assert np.array_equal(at, (result.source[y, x] + (9, 13)) % (18, 22))
    assert moved.provenance == result.provenance
