"""Wei and Levoy's full search: the pixel with the nearest of all neighborhoods (section 2)."""

from dataclasses import replace

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
from weftex.methods import wei_levoy
from weftex.search.pyramid_windows import window_offsets


@random_cases(12)
def test_plain_canvases_are_the_reference(rng):
    exemplar = weftex.Exemplar(random_exemplar(rng, *rng.integers(28, 40, 2)).pixels)
    size, seed = tuple(rng.integers(8, 20, 2).tolist()), int(rng.integers(2**32))
    width, levels = int(rng.choice([5, 7])), int(rng.integers(1, 4))
    codewords = int(rng.choice([0, 0, 5, 20]))
    expected = reference.wei_levoy(exemplar.pixels, size, width, levels, 3, codewords, seed)
    several = {"start": "noise", "parent_width": 3} if levels > 1 else {}
    search = {"tree_size": codewords, "leaves": 1} if codewords else {"search": "full"}
    method = weftex.WeiLevoy(window_width=width, levels=levels, most_windows=0, **several, **search)
    assert np.array_equal(method.fit(exemplar).sample(size, seed=seed).source, expected.sources)


@random_cases(40)
def test_a_pixel_has_the_nearest_neighborhood(rng, monkeypatch):
    """Causal in the first pass, else to all sides: on wrapped canvases, in holes, of masks."""
    exemplar = random_exemplar(rng, *rng.integers(14, 20, 2))
    canvas = random_canvas(rng, *rng.integers(8, 18, 2))
    half = int(rng.integers(1, 4))
    method = weftex.WeiLevoy(
        window_width=2 * half + 1, levels=1, search="full", most_windows=0,
        passes=int(rng.integers(0, 2)),
    )  # fmt: skip
    holes = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    pixel = tuple(rng.choice(np.argwhere(holes)).tolist())
    centers, compared = centers_of(exemplar, half), []

    def replace_by_nearest(level, step, trees, wrap, progress):
        """Replace the pixel alone, and compare it with all windows."""

        def part(places):
            whole(level, replace(step, places=places), trees, wrap, progress)

        (at,) = np.flatnonzero(step.places == pixel[0] * canvas.width + pixel[1]).tolist() or [-1]
        if at < 0:  # of the border alone
            part(step.places)
            return
        part(step.places[:at])
        steps = known_steps(level.done, pixel, half, wrap)
        own = {tuple(s) for s in window_offsets(2 * half + 1, step.causal).tolist()}
        assert len(own) == (2 * half * (half + 1) if step.causal else (2 * half + 1) ** 2 - 1)
        steps = np.array([s for s in steps.tolist() if tuple(s) in own]).reshape(-1, 2)
        picture = level.pixels.copy()
        part(step.places[at : at + 1])
        place = divmod(int(level.source[pixel]), exemplar.shape[1])
        chosen = distances(exemplar, [place], picture, pixel, steps)[0]
        compared.append(chosen)
        assert chosen <= distances(exemplar, centers, picture, pixel, steps).min()
        part(step.places[at + 1 :])

    whole = wei_levoy.replace_by_nearest
    monkeypatch.setattr(wei_levoy, "replace_by_nearest", replace_by_nearest)
    method.fit(exemplar).sample(canvas, seed=int(rng.integers(2**32)))
    assert compared
