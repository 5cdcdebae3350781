"""Lattices: those that were drawn, those of real samples, and none where there is none."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from families import refused
from materials import wall
from weftex.analysis.autocorrelations import Field, find_peaks
from weftex.analysis.correlation import correlate
from weftex.analysis.lattice import Lattice, find_lattice, rate_lattices
from weftex.analysis.overlay import draw_lattice
from weftex.analysis.pairs import ALPHA, rate, reduced, tile_shares
from weftex.exemplar import Exemplar
from weftex.reference.lattice import goodness, identifiers
from weftex.tasks.auto.findings import look

HERE = Path(__file__).parent
SAMPLES = HERE.parents[1] / "examples" / "samples"
TRUTH = json.loads((HERE / "lattices.json").read_text())
TRUTH.pop("about")

#: Square, rectangular, brick bond, hexagonal, oblique, fractional, small and large, thirds.
SHAPES = {
    "square": ((24, 0), (0, 24)),
    "rectangular": ((40, 0), (0, 17)),
    "brick": ((44, 0), (22, 18)),
    "hexagonal": ((26, 0), (13, 22.517)),
    "oblique": ((31.3, 5.1), (-8.7, 23.9)),
    "fractional": ((17.37, 0), (0, 21.81)),
    "small": ((7.4, 0), (1.3, 6.2)),
    "large": ((61, 3), (-4, 55.5)),
    "third": ((45, 0), (15, 20)),
}


def smooth(values, radius):
    """A Gaussian of this radius, around the borders."""
    v, u = (np.fft.fftfreq(side) for side in values.shape[:2])
    kernel = np.exp(-2 * (np.pi * radius) ** 2 * (v[:, None] ** 2 + u**2))
    spectrum = np.fft.fft2(values, axes=(0, 1)) * kernel[..., None]
    return np.fft.ifft2(spectrum, axes=(0, 1)).real


def draw(vectors, rng, kind="pattern", *, noise=0.0, color=0.0, bend=0.0, light=0.0, checks=0.0):
    """A lattice of 160 x 160 pixels; noise and color of elements beside a contrast of about 1."""
    size = 320  # four places a pixel
    y, x = np.mgrid[:size, :size] / 2
    if bend:
        off = smooth(rng.standard_normal((size, size, 2)), size / 8)
        x, y = x + bend * off[..., 0] / off.std(), y + bend * off[..., 1] / off.std()
    a, b = np.tensordot(np.linalg.inv(vectors).T, np.stack([x, y]), 1) + [[[0.3]], [[0.6]]]
    if kind == "pattern":
        tile = smooth(rng.standard_normal((16, 16, 3)), 1.0)
        i, j = (np.floor(c * 16).astype(int) % 16 for c in (b, a))
        levels = tile[i, j] / tile.std()
        joint = np.zeros((size, size), bool)
    else:  # elements with joints between them
        lengths, area = np.hypot(*np.array(vectors).T), abs(np.linalg.det(vectors))
        near = [np.minimum(c % 1, 1 - c % 1) * area / length for c, length in
                zip((a, b), lengths[::-1], strict=True)]  # fmt: skip
        joint = np.minimum(*near) < 1.2
        levels = np.where(joint, -2.0, 0.5)[..., None] * np.ones(3)
    which = np.floor(a).astype(int) % 99, np.floor(b).astype(int) % 99
    hue = color * rng.standard_normal((99, 99, 3))[which]
    hue += checks * np.where((which[0] + which[1]) % 2, 1, -1)[..., None] * [1, 0.3, -0.5]
    levels = levels + np.where(joint[..., None], 0, hue)
    levels += light * (x / size + 0.7 * (y / size) ** 2)[..., None]
    levels = levels.reshape(160, 2, 160, 2, 3).mean(axis=(1, 3))
    levels += noise * rng.standard_normal(levels.shape)
    return np.clip(128 + 32 * levels, 0, 255).astype(np.uint8)


def assert_found(exemplar, vectors, tolerance=0.015):
    """Assert that a sample has a lattice, and that it is the one of these vectors."""
    found = find_lattice(exemplar)
    assert found is not None and found.same_as(Lattice(vectors), tolerance)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(
    "kind, flaws",
    [
        ("pattern", {}),
        ("joints", {}),
        ("pattern", {"noise": 1.0}),
        ("joints", {"color": 0.5, "light": 3.0}),
        ("pattern", {"noise": 0.5, "color": 0.5, "bend": 0.5}),
    ],
    ids=["pattern", "joints", "noise", "colors", "all"],
)
def test_drawn_lattices(shape, kind, flaws, rng):
    """Up to noise as strong as the pattern, and colors of elements half as strong."""
    if shape == "small":
        kind = "pattern"  # no room for joints
    assert_found(Exemplar(draw(SHAPES[shape], rng, kind, **flaws)), SHAPES[shape])


def load(name):
    return weftex.load_exemplar(name if ":" in name else str(SAMPLES / name))


@pytest.mark.parametrize("name", TRUTH)
def test_real_samples(name):
    found = find_lattice(load(name))
    if not TRUTH[name]:
        assert found is None
    else:
        assert found is not None and found.confidence >= 0.5
        # Rows of wood are not laid to the pixel.
        assert found.same_as(Lattice(TRUTH[name]), 0.015 if len(TRUTH[name]) == 2 else 0.03)


@pytest.mark.parametrize("radius", [0, 1, 3])
def test_noise_has_no_lattice(radius, rng):
    for _ in range(4):
        clouds = smooth(rng.standard_normal((128, 128, 3)), radius)
        assert find_lattice(Exemplar((128 + 40 * clouds / clouds.std()).clip(0, 255))) is None


def test_elements_of_any_color_and_colors_that_alternate(rng):
    """Figure 5.1 (a) to (d): the joints count there, the colors here."""
    tile = ((24, 0), (0, 20))
    two = ((24, 20), (24, -20))
    for _ in range(3):
        assert_found(Exemplar(draw(tile, rng, "joints", color=2.0)), tile)
        for checks in (0.6, 1.0):
            assert_found(Exemplar(draw(tile, rng, "joints", checks=checks, noise=0.2)), two)


def test_two_lattices_at_once(rng):
    """Figure 5.1 (e): one of the two."""
    tiles = ((24, 0), (0, 20)), ((17, 3), (0, 31))
    pixels = sum(draw(tile, rng).astype(int) for tile in tiles) // 2
    found = find_lattice(Exemplar(pixels.astype(np.uint8)))
    assert found is not None and any(found.same_as(Lattice(tile)) for tile in tiles)


def test_stripes_are_rows(rng):
    y, x = np.mgrid[:240, :280] / 2
    for angle in (0, 30, 90, 140):
        normal = np.array([-np.sin(np.deg2rad(angle)), np.cos(np.deg2rad(angle))])
        wave = np.where((x * normal[0] + y * normal[1]) % 17 < 6, 180.0, 60.0)
        wave = wave.reshape(120, 2, 140, 2).mean(axis=(1, 3))
        pixels = wave + rng.normal(0, 30, wave.shape)
        assert_found(Exemplar(pixels.clip(0, 255).astype(np.uint8)), (17 * normal,), 0.03)


def test_masks_maps_and_types(rng):
    pixels = draw(SHAPES["square"], rng)
    mask = np.ones(pixels.shape[:2], bool)
    mask[40:90, 30:100] = False
    spoilt = np.where(mask[..., None], pixels, rng.integers(0, 256, pixels.shape, np.uint8))
    for exemplar in (
        Exemplar(spoilt.astype(np.uint8), mask=mask),
        Exemplar(pixels.astype(np.uint16) * 257),
        Exemplar(pixels[..., 0].astype(np.float32) / 255),
        Exemplar(np.full_like(pixels, 9), maps={"height": pixels[..., 0]}),
    ):
        assert_found(exemplar, SHAPES["square"])


def test_large_samples_are_averaged(rng):
    tile = smooth(rng.standard_normal((60, 80, 1)), 3.0)[..., 0]
    pixels = np.tile(128 + 30 * tile / tile.std(), (4, 14)).clip(0, 255)
    assert_found(Exemplar(pixels.astype(np.uint8)), ((80, 0), (0, 60)))


VECTOR = st.tuples(st.integers(-9, 9), st.integers(-9, 9))


@given(VECTOR, VECTOR, st.integers(1, 12), st.integers(1, 12))
def test_shares_of_tiles_are_wrapped_positions(first, second, width, height):
    if first[0] * second[1] == first[1] * second[0]:
        return
    found = tile_shares(np.array([first, second]), np.array([width]), np.array([height]))
    area = abs(first[0] * second[1] - first[1] * second[0])
    assert found[0] == pytest.approx(identifiers(first, second, width, height) / area)


@pytest.mark.parametrize("vectors", [((6, 0), (0, 5)), ((8, 1), (-3, 7)), ((4, 6), (4, -6))])
def test_height_is_equation_3_22(vectors, rng):
    """Vectors shorter than 10 pixels are looked at where they are, not around."""
    correlation = correlate(rng.integers(0, 256, (1, 24, 30)).astype(float))
    expected, number = goodness(correlation, *vectors)
    field = Field(correlation)
    rated = rate(field, np.array([vectors], np.float64), 24, "height", exact=True)
    assert rated.count[0] == number
    assert rated.goodness[0] == pytest.approx(expected, rel=1e-9)


def test_the_best_of_all_pairs_is_found(rng):
    """Looking at peaks that dominate loses nothing: every pair of maxima, by definition."""
    tile = smooth(rng.standard_normal((7, 8, 1)), 1.0)[..., 0]
    pixels = np.tile(tile, (4, 4))[:24, :28] + 0.1 * tile.std() * rng.standard_normal((24, 28))
    correlation = correlate(pixels[None])
    peaks = find_peaks(correlation)
    pairs = [
        pair
        for pair in itertools.combinations(peaks.shifts[peaks.heights > 0.3].tolist(), 2)
        if abs(np.linalg.det(pair)) >= 9 and (reduced(np.array(pair)) ** 2).sum(axis=1).min() >= 9
    ]
    best = max(pairs, key=lambda pair: goodness(correlation, *pair)[0])
    scaled = 128 + 30 * (pixels - pixels.mean()) / pixels.std()
    found = find_lattice(Exemplar(scaled.clip(0, 255)), goodness="height")
    assert found is not None and found.same_as(Lattice(best), 0.1)
    assert found.same_as(Lattice(((8, 0), (0, 7))))


def test_peaks_are_maxima_and_what_they_dominate(rng):
    correlation = correlate(smooth(rng.standard_normal((30, 34, 1)), 1.0)[None, ..., 0])
    peaks = find_peaks(correlation)
    expected = set()
    for y, x in itertools.product(range(-29, 30), range(34)):
        value = correlation[y + 29, x + 33]
        around = correlation[max(0, y + 28) : y + 31, max(0, x + 32) : x + 35]
        if value > 0 and value >= around.max() - 1e-9 and (x, y) > (0, 0):
            expected.add((x, y))
    assert {(x, y) for x, y in peaks.shifts.tolist()} == expected
    for (x, y), height, reach in zip(peaks.shifts, peaks.heights, peaks.dominance, strict=True):
        for side in (reach, 2 * reach):
            rows = slice(max(0, y + 29 - side), y + 30 + side)
            part = correlation[rows, max(0, x + 33 - side) : x + 34 + side]
            assert (height >= part.max() - 1e-8) == (side == reach or side > 64)


@given(st.lists(st.floats(-60, 60), min_size=4, max_size=4), st.integers(-3, 3))
def test_bases_of_one_lattice(numbers, times):
    """Observation iv; and reduced vectors are the shortest."""
    first, second = np.array(numbers).reshape(2, 2)
    area = abs(np.linalg.det([first, second]))
    if min(np.hypot(*first), np.hypot(*second)) < 2 or area < 8:
        return
    lattice = Lattice((first, second))
    other = Lattice((second, first - times * second))
    assert lattice.same_as(other, 1e-6) and other.same_as(lattice, 1e-6)
    assert not lattice.same_as(Lattice((2 * first, second)))
    short = lattice.reduced()
    assert short.area == pytest.approx(area)
    shortest = min(
        np.hypot(*(a * first + b * second))
        for a, b in itertools.product(range(-4, 5), repeat=2)
        if (a, b) != (0, 0)
    )
    assert np.hypot(*short.vectors[0]) <= shortest + 1e-6


@pytest.mark.parametrize(
    "vectors, message",
    [
        (((1, 0), (2, 0)), "one line"),
        (((0, 0), (0, 5)), "1 pixel"),
        (((np.inf, 0), (0, 5)), "finite"),
        (((1, 0), (0, 1), (1, 1)), "one or two"),
        ((), "one or two"),
    ],
)
def test_no_lattices(vectors, message):
    refused(message, Lattice, vectors)


@pytest.mark.parametrize("channels", [(), (1,), (2,), (3,), (4,), (7,)])
def test_overlays_of_any_sample(channels, rng):
    exemplar = Exemplar(rng.integers(0, 256, (20, 30, *channels), np.uint8))
    for lattice in (None, Lattice(((5, 0),)), Lattice(((5, 1), (0, 6)))):
        drawn = draw_lattice(exemplar, lattice)
        assert drawn.shape == (20, 30, 3) and drawn.dtype == np.uint8


@pytest.mark.parametrize("side", [160, 480])
def test_rows_that_only_maps_show_are_found(side):
    """Stones of many colors hide joints that normals and heights show."""
    rng = np.random.default_rng(1)
    colors = smooth(rng.standard_normal((side, side, 3)), 3)
    colors = (128 + 90 * colors / colors.std()).clip(0, 255).astype(np.uint8)
    height = np.full((side, side), 200) + rng.integers(0, 20, (side, side))
    height[np.arange(side) % 20 < 3] -= 80
    maps = {"height": height.astype(np.uint8)}
    assert look(Exemplar(colors)).lattice is None
    found = look(Exemplar(colors, maps=maps)).lattice
    assert found is not None and np.allclose(found.vectors, [(0, 20)], atol=0.5)
    assert look(Exemplar(colors, maps=maps, weights={"height": 0})).lattice is None


BOND = Lattice(((16, 0), (8, 12)))


@pytest.fixture(scope="module")
def sample():
    return Exemplar(wall(96, 96, spread=10))


def test_goodness_is_the_papers(sample):
    """Eq. 3.23, from the mean and the number of multiples."""
    own, others = rate_lattices(sample, BOND, goodness="height")
    for rated in (own, *others):
        expected = max(rated.mean, 0) ** ALPHA * rated.multiples ** (ALPHA - 1)
        assert rated.goodness == pytest.approx(expected, rel=2e-3, abs=2e-4)
    assert [one.goodness for one in others] == sorted((o.goodness for o in others), reverse=True)
    assert not any(Lattice(one.vectors).same_as(BOND) for one in others)


@pytest.mark.parametrize("name", ["bricks", "tiles", "weave"])
def test_height_takes_the_highest_goodness(name):
    exemplar = weftex.load_exemplar(f"sample:{name}")
    found = find_lattice(exemplar, goodness="height")
    own, others = rate_lattices(exemplar, found, goodness="height", runners_up=24)
    assert len(own.vectors) == 2 and own.goodness >= max(other.goodness for other in others)


def test_overlaps_count_from_the_share_on(sample):
    """A larger tile has fewer multiples whose overlap holds 85 % of it."""
    larger = (BOND, Lattice(((40, 0), (8, 36))), Lattice(((80, 0), (8, 72))))
    counts = [rate_lattices(sample, one)[0].multiples for one in larger]
    assert counts == sorted(counts, reverse=True) and counts[0] > counts[1] > counts[2]


def test_rows_are_rated_by_their_ridges():
    """Of exact rows in any colors along them: the correlation is 0 between, and 1 at, the rows."""
    y = np.arange(120)[:, None]
    rows = Exemplar((128 + 90 * np.cos(y * np.pi / 6) + 0 * y.T).astype(np.uint8))
    own, _ = rate_lattices(rows, Lattice(((0, 12),)), runners_up=0)
    assert own.vectors == ((0, 12),) and own.multiples == 6 and own.mean > 1
    off, _ = rate_lattices(rows, Lattice(((0, 18),)), runners_up=0)
    assert off.goodness < own.goodness / 4
