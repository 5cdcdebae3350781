"""How good lattices are: eq. 3.22 at any alpha and share, for any vectors."""

import numpy as np
import pytest

import weftex
from materials import wall
from weftex.analysis.lattice import Lattice, find_lattice, rate_lattices
from weftex.analysis.overlay import draw_correlation, gncc

BOND = Lattice(((16, 0), (8, 12)))


@pytest.fixture(scope="module")
def sample():
    return weftex.Exemplar(wall(96, 96, spread=10))


def test_goodness_is_the_papers(sample):
    """Eq. 3.23, from the mean and the number of multiples."""
    for alpha in (1.0, 1.12, 2.0):
        own, others = rate_lattices(sample, BOND, goodness="height", alpha=alpha)
        for rated in (own, *others):
            expected = max(rated.mean, 0) ** alpha * rated.multiples ** (alpha - 1)
            assert rated.goodness == pytest.approx(expected, rel=2e-3, abs=2e-4)
        assert [one.goodness for one in others] == sorted(
            (o.goodness for o in others), reverse=True
        )
        assert not any(Lattice(one.vectors).same_as(BOND) for one in others)


def test_overlaps_count_from_the_share_on(sample):
    """The more of a tile an overlap must hold, the fewer multiples count."""
    large = Lattice(((40, 0), (8, 36)))
    counts = [rate_lattices(sample, large, significant=s)[0].multiples for s in (0.1, 0.5, 0.85, 1)]
    assert counts == sorted(counts, reverse=True) and counts[0] > counts[-1]


def test_the_lattice_follows_the_rule(sample):
    """Without a preference for small tiles all multiples are alike, and a large one may win."""
    found = [find_lattice(sample, goodness="height", alpha=alpha) for alpha in (1.0, 1.12, 4.0)]
    assert not found[0].same_as(BOND) and found[1].same_as(BOND) and found[2].same_as(BOND)
    assert find_lattice(sample).same_as(BOND)


@pytest.mark.parametrize(
    "rule, message",
    [
        ({"alpha": 0.9}, "alpha is 0.9; it must be from 1 to 4"),
        ({"alpha": float("nan")}, "alpha is nan"),
        ({"significant": 0}, "significant is 0; it must be above 0, at most 1"),
        ({"significant": 1.01}, "significant is 1.01"),
        ({"goodness": "heigt"}, "did you mean 'height'"),
    ],
)
def test_bad_rules(sample, rule, message):
    for find in (find_lattice, rate_lattices):
        with pytest.raises(weftex.InvalidInputError, match=message):
            find(sample, **rule)


def test_the_correlation_is_1_in_the_middle(sample):
    found = gncc(sample)
    assert found.shape == (191, 191) and found[95, 95] == pytest.approx(1)
    assert np.allclose(found, found[::-1, ::-1])
    drawn = draw_correlation(found)
    assert drawn.dtype == np.uint8 and drawn[95, 95] == 255


def test_rows_are_rated_by_their_ridges():
    """Of exact rows in any colors along them: the correlation is 0 between, and 1 at, the rows."""
    y = np.arange(120)[:, None]
    rows = weftex.Exemplar((128 + 90 * np.cos(y * np.pi / 6) + 0 * y.T).astype(np.uint8))
    own, _ = rate_lattices(rows, Lattice(((0, 12),)), runners_up=0)
    assert own.vectors == ((0, 12),) and own.multiples == 6 and own.mean > 1
    off, _ = rate_lattices(rows, Lattice(((0, 18),)), runners_up=0)
    assert off.goodness < own.goodness / 4
