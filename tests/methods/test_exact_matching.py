"""Exact neighborhood matching: what its parameters are to do; see `test_reference_pixels.py`."""

import numpy as np
import pytest

import weftex
from families import noise, refused


def pebbles(side):
    return weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:side, :side])


def test_sources_nearby_keep_their_distance():
    def repeats(distance):
        method = weftex.ExactMatching(window_width=9, levels=1, repeat_distance=distance)
        source = method.fit(pebbles(96)).sample(64, seed=1).source @ (96, 1)
        beside = [(source[:, d:] == source[:, :-d]).mean() for d in range(1, 8)]
        return sum(beside) + sum((source[d:] == source[:-d]).mean() for d in range(1, 8))

    assert repeats(8) < 0.05 * repeats(0)


def test_levels_keep_what_is_larger_than_the_window():
    """A chessboard of squares of 16 pixels, under noise, by a window of 7."""
    y, x = np.indices((96, 96))
    board = ((y // 16 + x // 16) % 2 * 100 + noise((96, 96)) // 3).astype(np.uint8)

    def order(levels):
        method = weftex.ExactMatching(window_width=7, levels=levels)
        image = method.fit(weftex.Exemplar(board)).sample(96, seed=1).image.astype(int)
        half, period = (abs(image[:, n:] - image[:, :-n]).mean() for n in (16, 32))
        return half - period

    assert order(3) > 40 > 20 > order(1)


def test_a_larger_tolerance_tests_more():
    """Figure 9; everything is a candidate at 100 %."""
    exemplar = pebbles(48)
    tested = []
    for tolerance in (0.0, 0.01, 0.05, 1.0):
        model = weftex.ExactMatching(
            window_width=7, tolerance=tolerance, init="random", candidates=0
        ).fit(exemplar)
        facts = model.sample((16, 16), seed=1).provenance
        tested.append(facts["windows_compared"] / facts["pixels_chosen"])
    assert tested == sorted(tested)
    assert tested[0] < 20 < 1000 < tested[-1]
    with_room = (48 - 6) * (48 - 6)
    assert tested[-1] <= with_room + 5


def test_grouping_shortens_lists():
    exemplar = weftex.load_exemplar("sample:weave")
    cost = []
    for grouping in (0.0, 0.03):
        model = weftex.ExactMatching(
            window_width=11, grouping=grouping, init="random", candidates=0
        ).fit(exemplar)
        cost.append(model.sample((20, 40), seed=1).provenance["windows_compared"])
    assert cost[1] < cost[0] / 2


@pytest.mark.parametrize("tolerance", [0.0, 0.1, 1.0])
def test_the_cap_counts_each_window_once(tolerance):
    """Where a tolerance takes everything, each window is in all four lists."""
    pixels = noise((40, 40), values=3)
    compared = []
    for candidates in (0, 100):
        model = weftex.ExactMatching(
            window_width=5, tolerance=tolerance, init="random", candidates=candidates
        ).fit(weftex.Exemplar(pixels))
        facts = model.sample((24, 24), seed=2).provenance
        compared.append(facts["windows_compared"] / facts["pixels_chosen"])
    assert compared[0] > 150
    assert 80 < compared[1] < 110


def test_the_beginning_follows_the_sample():
    """Section 4.3: structured for near-regular samples, random for stochastic ones."""
    for name, init in (("bricks", "structured"), ("weave", "structured"), ("pebbles", "random")):
        method = weftex.ExactMatching().resolved(weftex.load_exemplar(f"sample:{name}"))
        assert (name, method.init) == (name, init)
        assert method.repeat_distance == (0 if init == "structured" else method.window_width // 2)


def test_a_tolerance_is_proposed_where_colors_hardly_occur_twice():
    assert weftex.ExactMatching().resolved(weftex.load_exemplar("sample:weave")).tolerance == 0
    assert weftex.ExactMatching().resolved(weftex.load_exemplar("sample:grass")).tolerance == 0
    many = weftex.Exemplar(noise((40, 40, 3)))
    assert 0 < weftex.ExactMatching().resolved(many).tolerance < 0.1
    assert weftex.ExactMatching(nearest_colors=4).resolved(many).tolerance is None


@pytest.mark.parametrize(
    "parameters, message",
    [
        ({"tolerance": 0.1, "nearest_colors": 2}, "give tolerance or nearest_colors, not both"),
        ({"window_width": 41}, "window_width is 41; sample is 40x30, so it must be at most 29"),
        ({"levels": 9}, "levels is 9; sample is 40x30, which is enough for 3"),
    ],
)
def test_errors_name_what_is_wrong(parameters, message):
    refused(message, lambda: weftex.ExactMatching(**parameters).fit(noise((30, 40))))


def test_holes_are_filled_at_one_level():
    pixels = noise((30, 40))
    canvas = weftex.Canvas(30, 40, known=pixels, hole=pixels > 250)
    model = weftex.ExactMatching(levels=2).fit(weftex.Exemplar(pixels))
    refused("levels is 2; holes are filled with 1", model.sample, canvas, seed=1)
