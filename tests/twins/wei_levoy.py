"""Multiresolution synthesis (Wei and Levoy, 2000)."""

from __future__ import annotations

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

    def windows(causal):
        """Vectors and places of all pixels whose windows are whole."""
        own = around[: len(around) // 2] if causal else around
        box = [
            (v, u)
            for v in range(-reach, 1 if causal else reach + 1)
            for u in range(-reach, reach + 1)
        ]
        vectors, places = [], []
        for y, x in np.ndindex(sample.shape[:2]):
            if not all(_usable(masks[level], y + v, x + u, tiles) for v, u in box):
                continue
            if not all(
                _usable(masks[level + 1], y // 2 + v, x // 2 + u, tiles) for v, u in parents
            ):
                continue
            vectors.append(
                [
                    samples[level + 1][_around(samples[level + 1], y // 2 + v, x // 2 + u)]
                    for v, u in parents
                ]
                + [sample[_around(sample, y + v, x + u)] for v, u in own]
            )
            places.append(y * sample.shape[1] + x)
        return np.array(vectors, np.uint8).reshape(len(places), -1), places, own

    size = 1 if method.search == "full" else method.tree_size
    done = known.copy() if holed else np.ones(shape, bool)

    def run(pixels, causal, leaves):
        vectors, places, own = windows(causal)
        tree = vector_tree(vectors, size)
        for y, x in pixels:
            query, counts = [], []
            cells = [(pictures[level + 1], None, y // 2 + v, x // 2 + u) for v, u in parents]
            cells += [(picture, done, y + v, x + u) for v, u in own]
            for values, made, v, u in cells:
                inside = all(
                    w or 0 <= at < length
                    for w, at, length in zip(wrap, (v, u), values.shape, strict=False)
                )
                v, u = _around(values, v, u)
                counts += [inside and (made is None or bool(made[v, u]))] * values.shape[2]
                query += list(values[v, u])
            done[y, x] = True
            if any(counts):
                found = nearest_in_tree(tree, vectors, np.array(query), np.array(counts), leaves)
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


def _usable(mask, y, x, tiles):
    inside = 0 <= y < mask.shape[0] and 0 <= x < mask.shape[1]
    return (inside or tiles[0]) and bool(mask[_around(mask, y, x)])


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
