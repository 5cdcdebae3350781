"""Coherent candidates (Ashikhmin, 2001)."""

from __future__ import annotations

import itertools

import numpy as np

from twins.guides import guides
from twins.randomness import pick, random_bits
from twins.seams import path_around
from twins.windows import inwards, known_window, usable, window_centers


def coherent_places(source, y, x, steps, exemplar, centers):
    """Where the sources of the neighbors go on, the last neighbor first; None out of place."""
    places = []
    for dy, dx in reversed(steps):
        v, u = source[(y + dy) % len(source)][(x + dx) % len(source[0])] or (None, None)
        if v is None:
            continue
        place = v - dy, u - dx
        if exemplar.tileable:
            place = place[0] % exemplar.shape[0], place[1] % exemplar.shape[1]
        place = place if place in centers else None
        if place not in places:
            places.append(place)
    return places


def ashikhmin(method, exemplar, canvas, seed):
    """Choose all pixels, `passes` times; (H, W, 2) sources, -1 for known pixels from elsewhere.

    `method` has the window's width settled.
    """
    pixels, (height, width) = exemplar.matching().astype(int), canvas.shape
    half = method.window_width // 2
    reach = [half] * 4
    mask = usable(exemplar)
    centers = window_centers(mask, reach, exemplar.tileable)
    allowed = set(centers)
    levels = np.zeros((height, width, pixels.shape[2]), int)
    done = np.zeros(canvas.shape, bool)
    source = [[None] * width for _ in range(height)]
    guide, own_guide = guides(exemplar, canvas)
    weight = round(256 * method.guide_weight)
    jumps = method.jumps if method.jumps is not None else int(guide is not None)

    def random_place(*words):
        return centers[pick(random_bits(seed, *words), len(centers))]

    def lay(y, x, place):
        source[y][x], levels[y, x] = place, pixels[place]

    lines = [[(y, x) for x in range(width)] for y in range(height)]
    holes = canvas.hole is not None and not canvas.hole.all()
    if holes:
        done = ~canvas.hole
        levels[done] = exemplar.as_matching(canvas.known)[done]
        for y, x in np.argwhere(done).tolist():
            if canvas.known_from is not None:
                source[y][x] = (y + canvas.known_from[0], x + canvas.known_from[1])
        lines = inwards(done, canvas.wrap)
    elif half:
        for y, x in itertools.product(range(max(0, height - half), height), range(width)):
            lay(y, x, random_place("ashikhmin start", y * width + x))

    def choose(line, seen, start, number):
        for y, x in line:
            wrap = (canvas.wrap[0] or start, canvas.wrap[1])
            steps = known_window(seen, y, x, wrap, reach)
            found = coherent_places(source, y, x, steps, exemplar, allowed)
            if number > 0:
                found = [source[y][x]] + [place for place in found if place != source[y][x]]
            tries = max(jumps, 8) if None in found or not found else jumps
            found = [place for place in found if place is not None] + [
                random_place("ashikhmin", number, y * width + x, k) for k in range(tries)
            ]

            def distance(place, y=y, x=x, steps=steps, wrap=wrap):
                total = 0
                for dy, dx in steps:
                    made = levels[(y + dy) % height, (x + dx) % width]
                    v, u = (place[0] + dy) % len(pixels), (place[1] + dx) % pixels.shape[1]
                    total += 256 * ((pixels[v, u] - made) ** 2).sum()
                if guide is not None:
                    for dy, dx in itertools.product(range(-half, half + 1), repeat=2):
                        at = [y + dy, x + dx]
                        if any(not wrap[k] and not 0 <= at[k] < canvas.shape[k] for k in (0, 1)):
                            continue
                        at = (at[0] % height, at[1] % width)
                        if number > 0 or not seen[at] or (dy, dx) == (0, 0):
                            v, u = (place[0] + dy) % len(pixels), (place[1] + dx) % pixels.shape[1]
                            total += weight * ((own_guide[v, u] - guide[at]) ** 2).sum()
                return int(total)

            lay(y, x, min(found, key=distance))
            done[y, x] = seen[y, x] = True

    for number, (i, line) in itertools.product(range(method.passes), enumerate(lines)):
        # In the first pass the first rows see random pixels above them, around the border.
        start = not holes and number == 0 and i < half
        seen = done.copy()
        if start:
            seen[max(i + 1, height - half) :] = True
        choose(line, seen, start, number)
        band = min(32, height // 4)
        if number == 0 and i == len(lines) - 1 and band > 1 and canvas.wrap[0] and not holes:
            # The first rows once more, below the last; cut where both differ least.
            old = [row[:] for row in source[:band]]
            seen = done.copy()
            seen[: band + half] = False
            for again in lines[:band]:
                choose(again, seen, True, -1)
            apart = np.array(
                [
                    [((pixels[old[y][x]] - pixels[source[y][x]]) ** 2).sum() for y in range(band)]
                    for x in range(width)
                ]
            )
            cut = path_around(apart[:, :-1] + apart[:, 1:], canvas.wrap[1])
            for y, x in itertools.product(range(band), range(width)):
                if y > cut[x]:
                    lay(y, x, old[y][x])
    return np.array(
        [
            [(-1, -1) if source[y][x] is None else source[y][x] for x in range(width)]
            for y in range(height)
        ]
    )
