"""Non-parametric sampling (Efros and Leung, 1999)."""

from __future__ import annotations

import itertools

import numpy as np

from twins.exhaustive import bell_weights, weighted_distances
from twins.randomness import pick, random_bits
from twins.windows import beside, known_window, usable, window_centers


def efros_leung(method, exemplar, canvas, seed):
    """Grow a canvas one pixel after the other; (H, W, 2) sources, -1 for known pixels.

    `method` has the window's width and the seed's size settled.
    """
    pixels, wrap = exemplar.matching(), canvas.wrap
    levels = np.zeros((*canvas.shape, pixels.shape[2]), np.uint8)
    done, source = np.zeros(canvas.shape, bool), np.full((*canvas.shape, 2), -1)
    reach = [method.window_width // 2] * 4
    mask = usable(exemplar)
    centers = window_centers(mask, reach, exemplar.tileable)
    weights = bell_weights(method.window_width)

    def lay(y, x, v, u):
        v, u = v % exemplar.shape[0], u % exemplar.shape[1]
        levels[y, x], done[y, x], source[y, x] = pixels[v, u], True, (v, u)

    if canvas.hole is not None and not canvas.hole.all():
        levels[~canvas.hole] = exemplar.as_matching(canvas.known)[~canvas.hole]
        done[~canvas.hole] = True
    else:
        v, u = centers[pick(random_bits(seed, "efros-leung seed"), len(centers))]
        side = [min(method.seed_size, n) for n in canvas.shape]
        top, left = ((n - s) // 2 for n, s in zip(canvas.shape, side, strict=True))
        for i, j in np.ndindex(*side):
            half = method.seed_size // 2
            lay(top + i, left + j, v + i - half, u + j - half)

    def has_filled_neighbor(y, x):
        steps = itertools.product((-1, 0, 1), repeat=2)
        near = [beside((y, x), step, canvas.shape, wrap) for step in steps]
        return any(at is not None and done[at] for at in near)

    threshold, tries_left = method.threshold, 8 * int((~done).sum())
    while not done.all():
        layer = [p for p in np.ndindex(*canvas.shape) if not done[p] and has_filled_neighbor(*p)]
        layer.sort(
            key=lambda p: (
                -len(known_window(done, *p, wrap, reach)),
                random_bits(seed, "efros-leung order", *p),
            )
        )
        progress = False
        for y, x in layer:
            known = known_window(done, y, x, wrap, reach)
            distances = weighted_distances(levels, y, x, known, exemplar, centers, weights)
            limit = min(distances) * (1 + method.tolerance)
            similar = [i for i, d in enumerate(distances) if d <= limit]
            drawn = similar[pick(random_bits(seed, "efros-leung", y, x), len(similar))]
            total = sum(weights[dy + reach[0]][dx + reach[0]] for dy, dx in known)
            if distances[drawn] / (255**2 * pixels.shape[2] * max(total, 1)) <= threshold:
                lay(y, x, *centers[drawn])
                progress = True
        tries_left -= progress * len(layer)
        if not progress or tries_left < 0:
            threshold *= 1.1
    return source
