"""The exact search: the distances of the definition, and every window within the tolerance."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import families
import weftex
from materials import made_up, states
from random_cases import centers_of, distances
from twins.windows import known_steps
from weftex.methods.efros_leung.weighted_search import ExactSearch, gaussian_weights
from weftex.search.picture_kernels import Picture
from weftex.search.windows import windows_of

WRAPS = list(families.WRAPS.values())


@given(st.data())
def test_it_finds_what_comparing_everything_finds(data):
    draw = data.draw
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    kind = draw(st.sampled_from(["noise", "few", "extreme", "smooth"]))
    pixels = made_up(rng, (rng.integers(12, 24), rng.integers(12, 90)), kind, rng.integers(1, 6))
    mask = np.ones(pixels.shape[:2], bool)
    mask[3, 2] = draw(st.booleans())
    exemplar = weftex.Exemplar(pixels, mask=mask, tileable=draw(st.booleans()), alpha=False)
    reach = draw(st.integers(0, 3))
    windows = windows_of(exemplar, (reach,) * 4)
    search = ExactSearch(windows, gaussian_weights(2 * reach + 1, (2 * reach + 1) / 6.4))
    shape, wrap = tuple(rng.integers(1, 14, 2)), draw(st.sampled_from(WRAPS))
    levels, done, source = states(rng, exemplar, windows, shape, wrap)
    done.flat[0], source.flat[0], levels[0, 0] = 0, -1, 0
    places = np.flatnonzero(done == 0)[:20].astype(np.int32)
    bits = rng.integers(0, 2**64, len(places), dtype=np.uint64)
    tolerance = draw(st.sampled_from([0.0, 0.1, 3.0]))
    found = search.on(Picture(levels, done, source, wrap), tolerance)(places, bits)
    centers, weights = centers_of(exemplar, reach), search.weights.astype(int)
    for place, drawn, chosen, distance, total in zip(places, bits, *found, strict=True):
        pixel = np.array(divmod(int(place), shape[1]))
        steps = known_steps(done, pixel, reach, wrap)
        known = weights[tuple((steps + reach).T)]
        apart = distances(exemplar, centers, levels, pixel, steps, known)
        within = np.flatnonzero(apart <= apart.min() * (1 + tolerance))
        expected = within[(int(drawn) >> 32) * len(within) >> 32]
        (made,) = windows.to_sample(np.array([chosen], np.int32))
        assert divmod(int(made), pixels.shape[1]) == tuple(centers[expected])
        assert distance == apart[expected] and total == known.sum()


def test_long_sums_do_not_overflow(rng):
    """Black against white, all over a window of 61 pixels with eight channels."""
    exemplar = weftex.Exemplar(np.full((70, 70, 8), 255, np.uint8), alpha=False)
    windows = windows_of(exemplar, (30,) * 4)
    search = ExactSearch(windows, np.full((61, 61), 127, np.int16))
    done = np.ones((61, 61), np.uint8)
    done[30, 30] = 0
    levels, source = np.zeros((61, 61, 8), np.uint8), np.full((61, 61), -1, np.int32)
    place, bits = np.array([30 * 61 + 30], np.int32), np.zeros(1, np.uint64)
    found = search.on(Picture(levels, done, source, (False, False)), 0.1)(place, bits)
    known = 61 * 61 - 1
    assert found[1][0] == known * 8 * 127 * 255**2 and found[2][0] == known * 127
