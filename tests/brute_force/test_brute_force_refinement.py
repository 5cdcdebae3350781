"""Iterative refinement with the nearest of all windows, pixel by pixel (section 3)."""

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
from weftex.methods import refinement


def order_of(hole, iteration, cyclic):
    """The pixels of an iteration: in scan order, or a hole's from its four sides (Fig. 12)."""
    pixels = np.argwhere(hole)
    if cyclic and iteration % 2:
        pixels = np.argwhere(hole.T)[:, ::-1]
    return pixels[::-1] if cyclic and iteration % 4 > 1 else pixels


@random_cases(20)
def test_each_pixel_takes_the_nearest_window(rng, monkeypatch):
    """On wrapped canvases, in holes, of samples that tile or have unusable pixels."""
    exemplar = random_exemplar(rng, *rng.integers(14, 20, 2))
    canvas = random_canvas(rng, *rng.integers(6, 12, 2))
    half, cyclic = int(rng.integers(1, 4)), canvas.hole is not None
    method = weftex.Refinement(
        search="nearest", init="seeds", window_width=2 * half + 1, threshold=0, seed_scale=4.0,
        iterations=int(rng.integers(1, 4)),
    )  # fmt: skip
    hole = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    centers, compared = centers_of(exemplar, half), []

    def sweep_of(prepared, output, *given):
        outputs.append(output)
        return whole_sweep_of(prepared, output, *given)

    def refine_texture(sweep, iteration, progress):
        """Refine all pixels, and compare with a plain search for each."""
        output = outputs[-1]
        picture, done = output.pixels.copy(), output.done.copy()
        changed = whole(sweep, iteration, progress)
        wrap = canvas.wrap if cyclic or iteration == 0 else (True, True)
        for pixel in order_of(hole, iteration, cyclic):
            steps = known_steps(done, pixel, half, wrap)
            nearest = distances(exemplar, centers, picture, pixel, steps).argmin()
            place = centers[nearest] % exemplar.shape
            picture[tuple(pixel)], done[tuple(pixel)] = exemplar.pixels[tuple(place)], True
        compared.append(iteration)
        assert np.array_equal(output.pixels, picture)
        return changed

    outputs, whole_sweep_of, whole = [], refinement.sweep_of, refinement.refine_texture
    monkeypatch.setattr(refinement, "sweep_of", sweep_of)
    monkeypatch.setattr(refinement, "refine_texture", refine_texture)
    method.fit(exemplar).sample(canvas, seed=int(rng.integers(2**32)))
    assert compared
