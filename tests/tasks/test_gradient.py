"""Maps that go over from one sample to the next."""

import numpy as np
import pytest

from families import refused
from weftex.label_maps import Gradient


def test_the_papers_map():
    """Fig. 11: sigma of 80 on 200 pixels, circles of 15 and 11."""
    labels, pairs = Gradient().label_map((200, 200), (15, 11), seed=3)
    assert set(np.unique(labels)) == {0, 1, 2} and pairs == [(0, 1)]
    even, _ = Gradient().label_map((200, 200), (5, 5), seed=3)
    shares = ((even == 0) + (even == 2) / 2).mean(axis=1)  # of the first sample, row by row
    assert abs(shares - np.exp(-(np.arange(200) ** 2) / (2 * 80**2))).mean() < 0.06
    again, _ = Gradient().label_map((200, 200), (15, 11), seed=3)
    other, _ = Gradient().label_map((200, 200), (15, 11), seed=4)
    assert np.array_equal(labels, again) and not np.array_equal(labels, other)


def test_coarse_materials_do_not_cover_the_others():
    for radii in ((270, 24), (24, 270)):
        labels, _ = Gradient().label_map((384, 384), radii, seed=1)
        assert (labels[:48] == 0).mean() > 0.8 and (labels[-48:] == 1).mean() > 0.7


def test_a_circle_map_goes_over_from_top_to_bottom():
    labels, _ = Gradient(width=0.5).label_map((400, 300), (15, 11), seed=3)
    first = (labels == 0).mean(axis=1)
    assert first[:20].mean() > 0.8 and first[-50:].mean() < 0.02
    # Mixed regions lie between the two, not at the ends.
    mixed = (labels == 2).mean(axis=1)
    assert mixed[140:260].mean() > 2 * max(mixed[:60].mean(), mixed[-60:].mean())


@pytest.mark.parametrize(
    ("direction", "near", "far"),
    [
        (0, np.s_[:, :9], np.s_[:, -9:]),
        (90, np.s_[:9], np.s_[-9:]),
        (180, np.s_[:, -9:], np.s_[:, :9]),
        (-90, np.s_[-9:], np.s_[:9]),
        (45, np.s_[:15, :15], np.s_[-15:, -15:]),
    ],
)
def test_directions(direction, near, far):
    gradient = Gradient(direction=direction, width=0.2)
    labels, _ = gradient.label_map((90, 120), (4, 4), seed=1)
    assert (labels[near] == 0).all() and (labels[far] == 1).all()


def test_any_number_of_samples():
    labels, pairs = Gradient(direction=0, width=0.1).label_map((200, 300), (6,) * 4, seed=1)
    for k, (first, last) in enumerate(((0, 25), (80, 120), (180, 220), (275, 300))):
        assert (labels[:, first:last] == k).mean() > 0.95
    assert pairs == [(0, 1), (1, 2), (2, 3)]
    assert set(np.unique(labels)) == set(range(7))


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (50, 1), (3, 4)])
@pytest.mark.parametrize("radii", [(1, 1), (40, 2), (0, 0, 0)])
def test_small_maps_are_covered(size, radii):
    labels, pairs = Gradient().label_map(size, radii, seed=1)
    assert labels.shape == size and (labels >= 0).all()
    assert labels.max() < len(radii) + len(pairs)


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"direction": 900}, "direction is 900"),
        ({"direction": "down"}, "direction is 'down'"),
        ({"direction": float("nan")}, "direction is nan"),
        ({"width": 0}, "width is 0; it must be above 0 and at most 1"),
        ({"width": 1.5}, "width is 1.5"),
        ({"width": True}, "width is True"),
    ],
)
def test_bad_values_are_named(given, match):
    refused(match, Gradient, **given)
