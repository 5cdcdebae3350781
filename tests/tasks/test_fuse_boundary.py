"""Boundaries that no ruler could draw: benchmarks/quality/fusion.py, on small pictures."""

import functools
import sys
from pathlib import Path

import numpy as np
import pytest

import weftex

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks" / "quality"))
import fusion

SMALL = (110, 130)


@pytest.mark.pictures
@pytest.mark.parametrize(
    ("pair", "kind"),
    [
        *((pair, "straight") for pair in fusion.PAIRS),
        *((fusion.PAIRS[0], k) for k in fusion.MAPS[1:]),
    ],
)
def test_boundaries_follow_no_line_and_step_little(pair, kind):
    _, (edge, line, step) = fusion.row(pair, kind, SMALL)
    _, (_, _, on_the_line) = fusion.row(pair, kind, SMALL, belt_width=2)
    assert edge <= 0.1
    assert line <= 0.5
    assert step <= 0.6 * on_the_line


def test_the_figures_of_a_ruler():
    """A boundary along a belt's edge is found out, and so is one along any parallel."""
    labels = fusion.label_map("straight", (40, 60))
    x = np.arange(60) * np.ones((40, 1), int)
    along = (x >= 38).astype(int)
    assert fusion.at_edges(along, labels, reach=8) == 1
    assert fusion.at_edges(along, labels, reach=15) == 0
    assert fusion.on_one_line(along, labels) == 1
    wild = (x >= 30 + 14 * np.sin(np.arange(40) / 3)[:, None]).astype(int)
    assert fusion.on_one_line(wild, labels) < 0.4
    image = (100 * along + 5 * (x % 2)).astype(np.uint8)
    assert fusion.step(image, along) == pytest.approx(95 / 2.5, rel=0.2)


def test_mixed_regions_have_belts_too():
    """Their borders are not those of the map, and step no more than twice the mean."""
    samples = [weftex.load_exemplar(f"sample:{name}") for name in ("pebbles", "leaves")]
    labels = np.zeros((120, 180), int)
    labels[:, 60:120], labels[:, 120:] = 2, 1
    result = weftex.fuse(samples, labels, mixed={2: (0, 1)}, seed=1)
    pixels = result.image.astype(int)
    steps = np.abs(np.diff(pixels, axis=1)).mean(axis=(0, 2))
    # The sources break at the map's border no more often than elsewhere.
    broken = (np.diff(result.source, axis=1) != [0, 1]).any(axis=2).mean(axis=0)
    for border in (60, 120):
        assert steps[border - 1] < 2 * steps.mean() and broken[border - 1] < 0.5


@functools.cache
def halves(axis, tileable):
    """Pebbles and leaves in halves along an axis; the sample that each pixel is from."""
    samples = [weftex.load_exemplar(f"sample:{name}") for name in ("pebbles", "leaves")]
    labels = (np.indices((90, 100))[axis] >= 45).astype(int)
    result = weftex.fuse(samples, labels, tileable=tileable, window_width=15, belt_width=22, seed=1)
    return fusion.materials(result, [s.shape[0] for s in samples])


@pytest.mark.parametrize(("axis", "along"), [(0, "x"), (1, "y")])
def test_boundaries_go_on_around_the_border(axis, along):
    """Where one leaves the picture at one side it comes in at the other."""
    for tileable in (along, True):
        ends = np.moveaxis(halves(axis, tileable), axis, 0)[:, [0, -1]]
        assert (ends[:, 0] != ends[:, 1]).sum() <= 4
    assert 0 < halves(axis, False).mean() < 1


@pytest.mark.parametrize(("axis", "across"), [(0, "y"), (1, "x")])
def test_the_border_itself_is_no_boundary(axis, across):
    """A map whose ends differ has a boundary there, which wanders as all others do."""
    made = np.moveaxis(halves(axis, across), axis, 0)
    assert (made[0] != made[-1]).mean() < 0.4
    apart = np.moveaxis(halves(axis, False), axis, 0)
    assert (apart[0] == 0).all() and (apart[-1] == 1).all()
