"""Places of a sample that look alike, level by level; see the twin in `test_refinement.py`."""

import numpy as np
import pytest

import weftex
from weftex.exemplar import Exemplar
from weftex.methods.refinement.similar import similar_places
from weftex.raster.pyramids import gaussian_pyramid
from weftex.search.windows import windows_of


def by_place(windows, found):
    """What was found for each center, in pixels of the sample."""
    width, (top, left) = windows.pixels.shape[1], windows.period[:2]

    def place(flat):
        y, x = divmod(int(flat), width)
        return y - int(top), x - int(left)

    return {place(c): [place(p) for p in found[c] if p >= 0] for c in windows.centers}


def two_levels(tileable):
    """A sample and half of it, the coarser one first, with windows of five pixels."""
    pixels = weftex.load_exemplar("sample:pebbles").pixels[:20, :24, :1].copy()
    fine, coarse = gaussian_pyramid(pixels, 2, (tileable, tileable))
    return [windows_of(Exemplar(k, tileable=tileable), (2, 2, 2, 2)) for k in (coarse, fine)]


def test_centers_are_taken_in_parts(monkeypatch):
    coarse, fine = two_levels(False)
    coarser = coarse, similar_places(coarse, 2, 2)
    expected = similar_places(fine, 2, 2, coarser)
    monkeypatch.setattr("weftex.methods.refinement.similar._AT_ONCE", 7)
    assert np.array_equal(similar_places(fine, 2, 2, coarser), expected)


@pytest.mark.parametrize("tileable", [False, True])
def test_large_levels_take_the_children_themselves(tileable, monkeypatch):
    """Without a search: a child is like the children that lie as it does beside their parents."""
    coarse, fine = two_levels(tileable)
    parents = similar_places(coarse, 2, 2)
    monkeypatch.setattr("weftex.methods.refinement.similar._MOST_CENTERS", 100)
    monkeypatch.setattr("weftex.methods.refinement.similar.kernels.nearest_windows", None)
    found = by_place(fine, similar_places(fine, 2, 2, (coarse, parents)))
    top, left = (int(n) for n in coarse.period[:2])
    like = {
        (y, x): [
            divmod(int(p), coarse.pixels.shape[1])
            for p in parents[(y // 2 + top) * coarse.pixels.shape[1] + x // 2 + left]
        ]
        for y, x in found
    }
    assert len(found) > 100
    for (y, x), places in found.items():
        children = [(2 * (v - top) + y % 2, 2 * (u - left) + x % 2) for v, u in like[y, x]]
        assert places == [place for place in children if place in found]
