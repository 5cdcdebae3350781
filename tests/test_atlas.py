"""Corner tiles: all of them, continuous wherever they may meet, in phase, the same bytes."""

from itertools import product

import numpy as np
import pytest

import weftex
from families import noise, refused
from weftex.atlas import atlas, corner_colors
from weftex.endless.tiles import torus


@pytest.fixture(scope="module", params=["pebbles", "bricks", "stone_wall"])
def made(request):
    """An irregular texture, bricks on their lattice, a set of maps."""
    return atlas(f"sample:{request.param}", tile_size=88, gutter=2, seed=7)


def cut_out(made, pixels):
    """Tiles with gutters, by the colors of their corners."""
    gutter, (height, width) = made.gutter, made.tile_size
    return {
        tuple(tile["corners"]): pixels[tile["y"] - gutter :, tile["x"] - gutter :][
            : height + 2 * gutter, : width + 2 * gutter
        ]
        for tile in made.index["tiles"]
    }


@pytest.mark.parametrize("colors", [2, 3])
def test_a_torus_has_each_square_once(colors):
    nodes = torus(colors)
    around = np.stack([np.roll(nodes, (-v, -u), (0, 1)) for v in (0, 1) for u in (0, 1)], axis=-1)
    assert len({tuple(one) for one in around.reshape(-1, 4).tolist()}) == colors**4 == nodes.size


def test_every_two_tiles_that_may_touch_continue_each_other(made):
    gutter = made.gutter
    for pixels in (made.image, *made.maps.values()):
        tiles = cut_out(made, pixels)
        assert len(tiles) == 16
        for (a, first), (b, second) in product(tiles.items(), repeat=2):
            if a[1::2] == b[::2]:  # right beside left
                here, there = first[gutter:-gutter], second[gutter:-gutter]
                assert np.array_equal(here[:, -2 * gutter :], there[:, : 2 * gutter])
            if a[2:] == b[:2]:  # below
                assert np.array_equal(
                    first[-2 * gutter :, gutter:-gutter], second[: 2 * gutter, gutter:-gutter]
                )


def test_borders_look_like_the_inside(made):
    """Steps across borders, and the measured border of a grid, where all tiles meet others."""
    tiles = made.tiles.astype(float)
    inside = abs(np.diff(tiles, axis=2)).mean()
    fit, other = [], []
    for a, b in product(range(16), repeat=2):
        step = abs(tiles[a][:, -1] - tiles[b][:, 0]).mean()
        (fit if a >> 1 & 1 == b & 1 and a >> 3 & 1 == b >> 2 & 1 else other).append(step)
    assert len(fit) == 64
    assert np.mean(fit) < 1.25 * inside
    assert np.mean(fit) < 0.9 * np.mean(other)
    sample = made.synthesis.sample
    assert weftex.assess(sample, made.synthesis).wrap < 0.1
    assert weftex.assess(sample, made.plane(5, 5)).seams < 4


def test_a_plane_shows_the_tiles_of_its_corners(made):
    height, width = made.tile_size
    plane, nodes = made.plane(4, 6, seed=3), corner_colors(5, 7, 3, 2)
    for y, x in np.ndindex(4, 6):
        around = nodes[y : y + 2, x : x + 2].ravel()
        tile = plane[y * height :, x * width :][:height, :width]
        assert np.array_equal(tile, made.tiles[int(around @ [1, 2, 4, 8])])
    assert not np.array_equal(made.plane(4, 6, seed=4), plane)
    many = corner_colors(300, 300, 9, 3)
    assert abs(np.bincount(many.ravel()) / many.size - 1 / 3).max() < 0.01


def test_bricks_are_in_phase_in_all_tiles():
    made = atlas("sample:bricks", tile_size=128, seed=7)
    assert made.tile_size == (167, 126)
    assert "126x167, not 128x128" in made.notes[0]
    mean = made.tiles.astype(float).mean(axis=(0, 3))
    assert mean.std() > 0.6 * made.synthesis.sample.pixels.astype(float).mean(axis=2).std()


def test_eighty_one_tiles_of_a_tileable_sample_with_a_method():
    sample = weftex.Exemplar(noise((40, 40, 3), values=5), tileable=True)
    made = atlas(sample, colors=3, tile_size=(40, 48), method="quilting", patch_size=12, seed=1)
    assert made.tiles.shape == (81, 40, 48, 3)
    assert sorted(made.index["ids"]) == list(range(81))


def test_the_same_seed_gives_the_same_bytes_with_any_threads():
    sample = weftex.load_exemplar("sample:pebbles")
    one, two = (atlas(sample, tile_size=64, seed=5, threads=n).image for n in (1, 3))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, atlas(sample, tile_size=64, seed=6).image)


@pytest.mark.parametrize(
    "said, sample, given",
    [
        ("colors is 1; it must be 2 or 3", "pebbles", {"colors": 1}),
        ("gutter is -1; it must be from 0 to 32", "pebbles", {"gutter": -1, "tile_size": 64}),
        (
            "tile_size is 20; it must be a number of pixels, 32 or more",
            "pebbles",
            {"tile_size": 20},
        ),
        ("192x192, too small for the corners of tiles", "pebbles", {"tile_size": 800}),
        ("the lattice of .*bricks; the nearest is 126x84", "bricks", {"tile_size": 40}),
        ("near-regular does not support hole filling", "pebbles", {"method": "near-regular"}),
        ("effort has no effect on an atlas", "pebbles", {"effort": "best"}),
    ],
)
def test_bad_arguments_are_one_line(said, sample, given):
    refused(said, atlas, f"sample:{sample}", error=weftex.WeftexError, **given)


def test_a_coarser_map_needs_sizes_that_divide():
    sample = weftex.Exemplar(noise((64, 64, 3)), maps={"height": noise((32, 32))})
    refused("gutter 3; both must be multiples of 2", atlas, sample, tile_size=64, gutter=3)
