"""Wei and Levoy's full search: the pixel with the nearest of all neighborhoods (section 2)."""

import numpy as np

import weftex
from random_cases import (
    centers_of,
    distances,
    known_steps,
    notes_of,
    random_canvas,
    random_cases,
    random_exemplar,
)  # fmt: skip
from weftex import reference


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
def test_a_pixel_has_the_nearest_neighborhood(rng):
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
    centers, before, compared = centers_of(exemplar, half), [], []

    def record(step, facts):
        level = facts["level"]
        if step == "window":
            steps = known_steps(level.done, pixel, half, facts["wrap"])
            own = {tuple(step) for step in facts["own"].tolist()}
            causal = len(own) == 2 * half * (half + 1)
            assert causal or len(own) == (2 * half + 1) ** 2 - 1
            steps = np.array([s for s in steps.tolist() if tuple(s) in own]).reshape(-1, 2)
            before[:] = level.pixels.copy(), steps
            return
        picture, steps = before
        place = divmod(int(level.source[pixel]), exemplar.shape[1])
        chosen = distances(exemplar, [place], picture, pixel, steps)[0]
        compared.append(chosen)
        assert chosen <= distances(exemplar, centers, picture, pixel, steps).min()

    notes_of(method, exemplar, canvas, pixel, int(rng.integers(2**32)), record)
    assert compared
