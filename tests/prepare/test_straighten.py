"""Photos taken askew lie straight again, by lattice, rows or corners."""

import math

import numpy as np
import pytest

import weftex
from families import refused
from materials import wall
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.prepare import straighten


def drawn(shape, matrix):
    """Tiles of 40 x 24 px with joints, seen through the affine matrix (2, 2) for rows (x, y)."""
    y, x = np.indices(shape) + 0.5
    place = np.stack([x, y], axis=-1) @ np.linalg.inv(matrix)
    u, v = place[..., 0], place[..., 1]
    joint = (np.minimum(u % 40, -u % 40) < 1.5) | (np.minimum(v % 24, -v % 24) < 1.5)
    noise = np.random.default_rng(0).integers(0, 12, shape)
    tones = 120 + 20 * np.sin(u // 40 * 2.3 + v // 24 * 1.7)
    return np.where(joint, 230, tones + noise).astype(np.uint8)


def turned(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, s], [-s, c]])


@pytest.mark.parametrize("degrees", [-9, 2.5, 6])
@pytest.mark.parametrize("shear", [0, 0.08])
def test_by_the_lattice(degrees, shear):
    photo = drawn((240, 300), np.array([[1, 0], [shear, 1]]) @ turned(degrees))
    straight = straighten(photo)
    (a, b), (c, d) = find_lattice(straight).vectors
    found = sorted([(a, b), (c, d)], key=lambda v: abs(v[1]))
    high = 24 * math.hypot(1, shear)
    assert np.allclose(found, [(40, 0), (0, high)], atol=0.4)
    assert min(straight.shape) > 160


@pytest.mark.parametrize("down", [False, True])
def test_rows_become_level_or_upright(down):
    matrix = turned(4)
    rng = np.random.default_rng(0)
    y, x = np.indices((200, 240)) + 0.5
    across = (np.stack([x, y], axis=-1) @ np.linalg.inv(matrix))[..., 0 if down else 1]
    photo = np.where(across % 25 < 3, 20, 180) + rng.integers(0, 20, across.shape)
    straight = straighten(photo.astype(np.uint8)).pixels
    dark = (straight < 100).mean(axis=0 if down else 1)  # lines are dark or bright as a whole
    assert ((dark < 0.1) | (dark > 0.9)).mean() > 0.85


@pytest.mark.parametrize("lattice", [(16, 0, 8, 12), Lattice(((16.0, 0.0), (8.0, 12.0)))])
def test_a_straight_one_stays_as_it_is(lattice):
    photo = wall(120, 160)
    straight = straighten(photo, lattice=lattice)
    assert np.array_equal(straight.pixels, photo)


@pytest.mark.parametrize("seed", range(4))
def test_by_the_corners_of_a_rectangle(seed):
    """A camera looks at a wall from aside; proportions come out as they are."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(0.2, 0.6, 2) * rng.choice([-1, 1], 2)
    sides = rng.integers(3, 7, 2) * (40, 24)
    turn = np.array([[math.cos(a), 0, math.sin(a)], [0, 1, 0], [-math.sin(a), 0, math.cos(a)]])
    turn = turn @ [[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]]
    shape, focus, far = (300, 400), 500, 600.0
    y, x = np.indices(shape) + 0.5
    rays = np.stack([x - 200, y - 150, np.full(shape, focus)], axis=-1) @ turn
    start = np.array([0, 0, -far]) @ turn
    place = start[:2] - rays[..., :2] * (start[2] / rays[..., 2])[..., None] + sides / 2
    joint = (place % (40, 24) < 2).any(axis=-1)
    photo = np.where(joint, 230, 90).astype(np.uint8)
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    there = np.pad(signs * sides / 2, ((0, 0), (0, 1))) @ turn.T + (0, 0, far)
    corners = there[:, :2] / there[:, 2:] * focus + (200, 150)
    straight = straighten(photo, corners=corners.ravel()).pixels
    assert straight.shape[1] / straight.shape[0] == pytest.approx(sides[0] / sides[1], rel=0.02)
    y, x = (np.indices(straight.shape) + 0.5) / np.reshape(straight.shape, (2, 1, 1))
    expected = ((x * sides[0]) % 40 < 2) | ((y * sides[1]) % 24 < 2)
    assert ((straight > 160) ^ expected).mean() < 0.06


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_every_part_of_a_sample(dtype):
    rng = np.random.default_rng(2)
    top = 1.0 if np.dtype(dtype).kind == "f" else np.iinfo(dtype).max
    pixels = (rng.random((60, 80, 4)) * top).astype(dtype)
    pixels[20:40, 30:50, 3] = 0
    mask = rng.random((60, 80)) < 0.8
    guide = rng.integers(0, 3, (60, 80)).astype(np.uint8)
    sample = weftex.Exemplar(pixels, maps={"h": pixels[..., 0]}, mask=mask, guide=guide)
    found = straighten(sample, lattice=(20, 2, -1, 10))
    assert found.pixels.dtype == dtype and found.alpha and found.pixels.shape[2] == 4
    assert found.maps["h"].shape == found.mask.shape == found.guide.shape == found.shape
    assert set(np.unique(found.guide)) <= {0, 1, 2}
    assert found.pixels.min() >= 0 and found.pixels.max() <= top


def test_clear_pixels_bleed_nothing():
    pixels = np.full((60, 80, 4), 200, np.uint8)
    pixels[:, 40:] = (255, 0, 255, 0)
    found = straighten(pixels, lattice=(20, 2, -1, 10)).pixels
    assert (abs(found[..., :3].astype(int) - 200)[found[..., 3] > 8] <= 2).all()


@pytest.mark.parametrize("value", [np.finfo(np.float32).max, 1e-40])
def test_numbers_of_every_size_stay_numbers(value):
    rng = np.random.default_rng(0)
    pixels = rng.choice([-1, 0, 1 / 3, 1], (30, 30)).astype(np.float32) * np.float32(value)
    assert np.isfinite(straighten(pixels, lattice=(9, 1, 0, 9)).pixels).all()


@pytest.mark.parametrize(
    "given, words",
    [
        ({}, "no lattice or rows"),
        ({"lattice": (1, 2, 3)}, "four|4 numbers"),
        ({"lattice": (9, 0, 18, 0)}, "one line"),
        ({"lattice": (9, 0, 0, 9), "corners": range(8)}, "not both"),
        ({"corners": (1, 1, 30, 1, 30, 99, 1, 30)}, "outside"),
        ({"corners": (1, 1, 1, 30, 30, 30, 30, 1)}, "top left, top right"),
        ({"corners": (1, 1, 30, 1, 10, 10, 1, 30)}, "convex"),
        ({"corners": (1, 1, 1, 1, 1, 1, 1, 1)}, "convex"),
        ({"corners": "1,1,a"}, "8 numbers"),
    ],
)
def test_what_cannot_be_straightened_is_refused(given, words):
    noise = np.random.default_rng(0).integers(0, 255, (40, 40)).astype(np.uint8)
    refused(words, straighten, noise, **given)


def relief(shape):
    """A made-up surface, and its normals with y up or down."""
    y, x = np.indices(shape) / 40
    height = (0.5 + 0.2 * np.sin(5 * x + 2 * y) + 0.2 * np.sin(4 * y - x)).astype(np.float32)
    down, across = np.gradient(16 * height.astype(float))
    vectors = np.dstack([-across, down, np.ones(shape)])
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    maps = {"height": height}
    for name, y_is in (("normal_gl", 1), ("normal_dx", -1)):
        maps[name] = np.rint((vectors * (1, y_is, 1) + 1) * 127.5).astype(np.uint8)
    return weftex.Exemplar(np.full((*shape, 3), 200, np.uint8), maps=maps)


@pytest.mark.parametrize(
    "how",
    [
        {"lattice": (39, 8, -8, 39)},
        {"lattice": (40, 3, 0, 40)},
        {"corners": (150, 5, 190, 120, 20, 150, 8, 20)},
        {"corners": (195, 5, 195, 155, 5, 155, 5, 5)},
    ],
    ids=["turned", "sheared", "from aside", "lying"],
)
def test_normals_are_those_of_the_straightened_heights(how):
    """The slopes toward a light are alike; with the photo's own vectors they would not be."""

    def shade(normal, down):
        vectors = normal / 127.5 - 1
        vectors[..., 1] *= 1 - 2 * down
        return np.maximum(vectors @ (-0.63, 0.63, 0.45), 0)

    photo = relief((160, 200))
    made = straighten(photo, **how)
    down, across = np.gradient(16 * made.maps["height"])
    slopes = np.dstack([-across, down, np.ones(down.shape)])
    by_height = shade(127.5 * (slopes / np.linalg.norm(slopes, axis=2, keepdims=True) + 1), False)
    for name in ("normal_gl", "normal_dx"):
        down = name == "normal_dx"
        shown = shade(made.maps[name], down)
        kept = photo.changed(maps={"vectors": photo.maps[name]})
        as_numbers = straighten(kept, **how).maps["vectors"]
        other = shade(as_numbers, down)
        inner = np.s_[4:-4, 4:-4]
        off, before = (abs(one - by_height)[inner].mean() for one in (shown, other))
        assert off < 0.6 * before
        assert np.corrcoef(shown[inner].flat, by_height[inner].flat)[0, 1] > 0.98
        lengths = np.linalg.norm(made.maps[name] / 127.5 - 1, axis=2)
        assert abs(lengths - 1).max() < 0.02
