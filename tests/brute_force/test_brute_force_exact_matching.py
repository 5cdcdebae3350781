"""Exact matching: the windows in the union of the neighbors' lists, and the best of them (4.2)."""

import numpy as np

import weftex
from random_cases import (
    centers_of,
    distances,
    known_steps,
    random_canvas,
    random_cases,
    random_exemplar,
)  # fmt: skip
from weftex.methods.exact_matching.matching import Matching


@random_cases(40)
def test_a_pixel_is_the_best_of_the_union_of_lists(rng, monkeypatch):
    """On wrapped canvases, in holes, of samples that tile or have unusable pixels."""
    exemplar = random_exemplar(rng, *rng.integers(14, 20, 2))
    canvas = random_canvas(rng, *rng.integers(7, 18, 2))
    half, tolerance = int(rng.integers(1, 4)), float(rng.choice([0, 0.02, 0.1]))
    method = weftex.ExactMatching(
        window_width=2 * half + 1, tolerance=tolerance, candidates=0, repeat_distance=0,
        **({"levels": 1, "init": "random"} if canvas.hole is None else {}),
    )  # fmt: skip
    holes = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    pixel = tuple(rng.choice(np.argwhere(holes)).tolist())
    centers, compared = centers_of(exemplar, half), []

    def make(self, order, purpose):
        """Make the pixel alone, and compare it with the union."""
        sheet = self.sheet
        at = pixel[0] + sheet.top, pixel[1]
        asked = np.flatnonzero(order == at[0] * sheet.done.shape[1] + at[1])
        if not len(asked):
            whole(self, order, purpose)
            return
        whole(self, order[: asked[0]], purpose)
        steps = known_steps(sheet.done, at, half, sheet.wrap)
        if sheet.lists.causal:
            steps = steps[steps[:, 0] <= 0]  # where rows wrap, a row's end sees its beginning
        picture, latest = sheet.pixels.copy(), self.seen.max()
        whole(self, order[asked], purpose)
        colors, radius = sheet.lists.index.colors, sheet.lists.radius.max()
        union = np.zeros(len(centers), bool)
        for step in steps[abs(steps).max(axis=1) == 1]:
            y, x = (at + step) % picture.shape[:2]
            color = picture[y, x].astype(int)
            listed = (colors == color).all(axis=1).any()  # else the nearest color stands for it
            if not listed or (sheet.lists.causal and tuple(step) == (0, 1)):
                continue
            there = exemplar.pixels[tuple(((centers + step) % exemplar.shape).T)]
            union |= ((there - color) ** 2).sum(axis=1) <= radius
        flat = np.append(np.flatnonzero(self.seen > latest), sheet.source[at]).astype(np.int32)
        places = np.divmod(sheet.lists.windows.to_sample(flat), exemplar.shape[1])
        *listed, chosen = distances(exemplar, np.transpose(places), picture, at, steps).tolist()
        expected = distances(exemplar, centers[union], picture, at, steps).tolist()
        if chosen > 0:  # else the first one that equals the window may be taken
            assert {*expected} <= {*listed}  # of equal windows one stands for all
        assert chosen <= min(expected, default=chosen)
        compared.append(len(expected))
        whole(self, order[asked[0] + 1 :], purpose)

    whole = Matching.make
    monkeypatch.setattr(Matching, "make", make)
    method.fit(exemplar).sample(canvas, seed=int(rng.integers(2**32)))
    assert compared
