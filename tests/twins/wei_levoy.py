"""Multiresolution synthesis (Wei and Levoy, 2000)."""

from __future__ import annotations

import functools
import itertools

import numpy as np

from twins.pyramids import pyramid
from twins.randomness import random_bits
from twins.tree import nearest_in_tree, vector_tree
from twins.windows import inwards, usable


def wei_levoy(exemplar, method, canvas, seed):
    """Source index of every pixel; `method` with settled levels and widths."""
    count, width = method.levels, method.window_width
    parent_width = method.parent_width if count > 1 else 0
    tiles = (exemplar.tileable, exemplar.tileable)
    samples, masks = pyramid(exemplar.matching(), usable(exemplar), tiles, count)
    hole = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    holed = not hole.all()
    wrap = canvas.wrap if holed else (True, True)

    def noise(level, shape):
        usable = np.flatnonzero(masks[level])
        share = sorted(usable, key=lambda p: (random_bits(seed, "wei-levoy share", level, p), p))
        total = shape[0] * shape[1]
        pixels = [share[k % len(share)] for k in range(total)]
        place = sorted(
            range(total), key=lambda k: (random_bits(seed, "wei-levoy noise", level, k), k)
        )
        return np.array([pixels[k] for k in place]).reshape(shape)

    source = noise(0, canvas.shape)
    channels = samples[0].shape[2]
    picture = samples[0].reshape(-1, channels)[source]
    if holed:
        picture[~hole] = exemplar.as_matching(canvas.known)[~hole]
    pictures, knowns = pyramid(picture, ~hole, wrap, count)
    above = None
    for level in range(count - 1, -1, -1):
        above = _wei_levoy_level(
            method, canvas, seed, level, samples, masks, tiles, pictures, knowns[level], source,
            above, wrap, holed, noise, width, parent_width if level + 1 < count else 0,
        )  # fmt: skip
    return np.where(hole, above, -1)


def _wei_levoy_level(
    method, canvas, seed, level, samples, masks, tiles, pictures, known, source, above, wrap, holed,
    noise, width, parent_width,
):  # fmt: skip
    """The source map of one level; `above` is that of the coarser one."""
    sample, picture = samples[level], pictures[level]
    flat = sample.reshape(-1, sample.shape[2])
    shape, many = picture.shape[:2], len(samples) > 1
    source = source.copy() if level == 0 else np.full(shape, -1)
    if method.start == "parent" and many:
        fresh = noise(level, shape)
        if above is not None:
            for y, x in np.ndindex(shape):
                v, u = divmod(int(above[y // 2, x // 2]), samples[level + 1].shape[1])
                v = min(2 * v + y % 2, sample.shape[0] - 1)
                u = min(2 * u + x % 2, sample.shape[1] - 1)
                fresh[y, x] = v * sample.shape[1] + u
        source = np.where(known, source, fresh)
        picture[~known] = flat[source[~known]]
    if width == 1:
        return source
    reach, parent_reach = width // 2, parent_width // 2
    around = [o for o in itertools.product(range(-reach, reach + 1), repeat=2) if o != (0, 0)]
    parents = list(itertools.product(range(-parent_reach, parent_reach + 1), repeat=2))
    parents = parents if parent_width else []

    size = 1 if method.search == "full" else method.tree_size

    @functools.cache
    def windows(causal):
        """The places of all whole windows, their vectors, a tree over them; steps to the pixels."""
        own = around[: len(around) // 2] if causal else around
        box = [step for step in (*around, (0, 0)) if not causal or step[0] <= 0]
        whole = _seen(masks[level], sample.shape, 1, box, tiles).all(axis=2)
        vectors = [_seen(sample, sample.shape, 1, own)]
        if parents:
            whole &= _seen(masks[level + 1], sample.shape, 2, parents, tiles).all(axis=2)
            vectors.insert(0, _seen(samples[level + 1], sample.shape, 2, parents))
        vectors = np.concatenate([part[whole].reshape(whole.sum(), -1) for part in vectors], axis=1)
        return np.flatnonzero(whole), vectors, vector_tree(vectors, size), own

    done = known.copy() if holed else np.ones(shape, bool)

    def run(pixels, causal, leaves):
        places, vectors, tree, own = windows(causal)
        cells = [(picture, done, 1, own)]
        if parents:
            above = pictures[level + 1]
            cells.insert(0, (above, np.ones(above.shape[:2], bool), 2, parents))
        for y, x in pixels:
            query, counts = [], []
            for values, made, scale, steps in cells:
                v, u = np.array(steps).T + [[y // scale], [x // scale]]
                counts.append(_inside(values, v, u, wrap) & made[_around(values, v, u)])
                query.append(values[_around(values, v, u)])
            done[y, x] = True
            counts = np.concatenate(counts).repeat(picture.shape[2])
            if counts.any():
                query = np.concatenate(query).ravel()
                found = nearest_in_tree(tree, vectors, query, counts, leaves)
                source[y, x] = places[found]
                picture[y, x] = flat[places[found]]

    every = list(np.ndindex(shape))
    if holed:
        inwards = _wei_levoy_inwards(known, wrap, seed)
        run(inwards, False, 8 * method.leaves)
        for _ in range(4 + method.passes):
            run(inwards, False, method.leaves)
        return source
    run(every, True, method.leaves)
    for _ in range(method.passes):
        run(every, False, method.leaves)

    def near(at, length):
        return at < reach or at >= length - reach

    border = [
        (y, x) for y, x in every
        if (canvas.wrap[0] and near(y, shape[0])) or (canvas.wrap[1] and near(x, shape[1]))
    ]  # fmt: skip
    for _ in range(2 if border else 0):
        run(border, False, method.leaves)
    return source


def _around(values, y, x):
    return y % values.shape[0], x % values.shape[1]


def _inside(values, y, x, wrap):
    """Whether places are on a picture, all of them on one that goes around."""
    return ((y >= 0) & (y < len(values)) | wrap[0]) & ((x >= 0) & (x < values.shape[1]) | wrap[1])


def _seen(values, shape, scale, steps, wrap=(True, True)):
    """What lies at some steps from each pixel, or its parent; 0 beyond borders: (H, W, N, ...)."""
    y, x = np.indices(shape[:2])[..., None] // scale
    dy, dx = np.array(steps).T
    inside = _inside(values, y + dy, x + dx, wrap)
    return values[_around(values, y + dy, x + dx)] * inside.reshape(
        inside.shape + (1,) * (values.ndim - 2)
    ).astype(values.dtype)


def _wei_levoy_inwards(known, wrap, seed):
    """Unknown pixels, those next to known ones first; each layer by lines from a random corner."""
    order = []
    for number, layer in enumerate(inwards(known, wrap), 1):
        bits = random_bits(seed, "wei-levoy order", number)
        down, right = 1 - 2 * (bits & 1), 1 - (bits & 2)
        if bits & 4:  # by rows, else by columns
            layer.sort(key=lambda p: (down * p[0], right * p[1]))
        else:
            layer.sort(key=lambda p: (right * p[1], down * p[0]))
        order += layer
    return order
