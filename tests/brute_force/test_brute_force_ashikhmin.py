"""Coherent candidates: where the neighbors' sources continue, and the best of them (section 3)."""

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
from weftex import reference
from weftex.methods.ashikhmin.choice import Choice


@random_cases(40)
def test_plain_canvases_are_the_reference(rng):
    exemplar = weftex.Exemplar(random_exemplar(rng, *rng.integers(16, 40, 2)).pixels)
    size, seed = tuple(rng.integers(1, 22, 2).tolist()), int(rng.integers(2**32))
    width = int(rng.choice([3, 5, 7]))
    expected = reference.ashikhmin(exemplar.pixels, size, width, replacements=8, seed=seed)
    method = weftex.Ashikhmin(window_width=width, passes=1)
    assert np.array_equal(method.fit(exemplar).sample(size, seed=seed).source, expected.sources)


@random_cases(60)
def test_a_pixel_is_the_best_of_its_candidates(rng, monkeypatch):
    """On wrapped canvases, in holes, in later passes, of samples that tile or are masked."""
    exemplar = random_exemplar(rng, *rng.integers(14, 20, 2))
    canvas = random_canvas(rng, *rng.integers(2, 24, 2))
    half, jumps = int(rng.integers(1, 4)), int(rng.choice([0, 0, 3]))
    method = weftex.Ashikhmin(
        window_width=2 * half + 1, passes=int(rng.integers(1, 4)), jumps=jumps
    )
    holes = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    pixel = tuple(rng.choice(np.argwhere(holes)).tolist())
    allowed, compared = {tuple(c) for c in centers_of(exemplar, half)}, []

    def choose(self, line, number, **how):
        """Choose the pixel alone, and compare it with what might have been chosen."""
        asked = np.flatnonzero(line == pixel[0] * canvas.width + pixel[1])
        if not len(asked):
            whole(self, line, number, **how)
            return
        growth, at = self.growth, int(asked[0])

        def place_of(index):
            return divmod(int(growth.windows.to_sample(index)), exemplar.shape[1])

        whole(self, line[:at], number, **how)
        pixels, done, source = (a.copy() for a in (growth.pixels, growth.done, growth.source))
        self.candidates.fill(-1)
        whole(self, line[at : at + 1], number, **how)
        start = canvas.hole is None and number == 0 and pixel[0] < half < canvas.height / 2
        wrap = canvas.wrap[0] or start, canvas.wrap[1]
        steps = known_steps(done, pixel, half, wrap)
        if canvas.hole is None and number == 0 and not any(canvas.wrap):
            assert (steps @ [100, 1] < 0).all()  # L-shaped
        found = {place_of(source[pixel])} if number > 0 else set()
        for dy, dx in steps:
            index = source[(pixel[0] + dy) % canvas.height, (pixel[1] + dx) % canvas.width]
            if index >= 0:
                v, u = np.subtract(place_of(index), (dy, dx))
                if exemplar.tileable:
                    v, u = v % exemplar.shape[0], u % exemplar.shape[1]
                found.add((int(v), int(u)) if (v, u) in allowed else None)
        places = [place_of(index) for index in self.candidates if index >= 0]
        assert found - {None} <= set(places) <= allowed
        random = max(jumps, 8) if None in found or not found else jumps
        assert len(places) == len(found - {None}) + random
        apart = distances(exemplar, places, pixels, pixel, steps)
        chosen = places.index(place_of(growth.source[pixel]))
        assert apart[chosen] == apart.min()
        compared.append(chosen)
        whole(self, line[at + 1 :], number, **how)

    whole = Choice.choose
    monkeypatch.setattr(Choice, "choose", choose)
    method.fit(exemplar).sample(canvas, seed=int(rng.integers(2**32)))
    assert len(compared) >= method.passes
