"""Non-parametric sampling: a pixel is drawn from the best windows of the sample (section III.A)."""

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
from weftex.methods.efros_leung.weighted_search import ExhaustiveSearch
from weftex.random import draw


@random_cases(8)
def test_plain_canvases_are_the_reference(rng):
    exemplar = weftex.Exemplar(random_exemplar(rng, *rng.integers(12, 24, 2)).pixels)
    size, seed = tuple(rng.integers(6, 14, 2).tolist()), int(rng.integers(2**32))
    given = {"tolerance": float(rng.choice([0, 0.1, 1]))}
    width = int(rng.choice([3, 5, 7]))
    expected = reference.efros_leung(exemplar.pixels, size, window=width, seed=seed, **given)
    result = weftex.EfrosLeung(window_width=width, **given).fit(exemplar).sample(size, seed=seed)
    assert np.array_equal(result.source, expected.sources)


@random_cases(40)
def test_a_pixel_is_drawn_from_all_windows_within_the_tolerance(rng, monkeypatch):
    """On wrapped canvases, in holes, of samples that tile or have unusable pixels."""
    exemplar = random_exemplar(rng, *rng.integers(14, 20, 2))
    canvas = random_canvas(rng, *rng.integers(7, 14, 2))
    half, tolerance = int(rng.integers(1, 4)), float(rng.choice([0, 0.1, 1]))
    method = weftex.EfrosLeung(window_width=2 * half + 1, tolerance=tolerance)
    away = np.arange(-half, half + 1)
    bell = np.exp(-np.add.outer(away**2, away**2) / 2 / ((2 * half + 1) / 6.4) ** 2)
    bell = np.maximum(1, np.rint(127 * bell)).astype(int)
    centers, compared = centers_of(exemplar, half), []
    holes = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    pixel = tuple(rng.choice(np.argwhere(holes)).tolist())
    seed = int(rng.integers(2**32))

    def on(self, pixels, done, *given):
        draw_windows = whole(self, pixels, done, *given)

        def checked(wave, bits):
            made = draw_windows(wave, bits)
            for k in np.flatnonzero(wave == pixel[0] * canvas.width + pixel[1]):
                steps = known_steps(done, pixel, half, canvas.wrap)
                weights = bell[tuple((steps + half).T)]
                apart = distances(exemplar, centers, pixels, pixel, steps, weights)
                within = centers[apart <= apart.min() * (1 + tolerance)]
                share = int(draw(seed, "efros-leung", *pixel) >> np.uint64(32))
                place = int(self.windows.to_sample(made[0][k]))
                chosen = within[share * len(within) >> 32]
                assert divmod(place, exemplar.shape[1]) == tuple(chosen % exemplar.shape)
                compared.append(len(within))
            return made

        return checked

    whole = ExhaustiveSearch.on
    monkeypatch.setattr(ExhaustiveSearch, "on", on)
    method.fit(exemplar).sample(canvas, seed=seed, threads=1)
    assert compared or canvas.hole is None  # the pixel may be of the piece that it starts from
