"""What a patch would show again of those laid before it."""

from __future__ import annotations

import math

#: So many patches away others are seen, and so many in the same row or column of the grid.
SIGHT, IN_LINE = 5, 16
#: Patches that a thread lays at a time: more of the row above may not be there yet.
PIECE = 16


def mark_repeats(corner, places, around, reach, leave):
    """Which candidates would show again what a patch laid nearby shows.

    `around` lists (y, x, source y, source x) of earlier patches. A source within `reach` of one of
    theirs repeats it, unless it goes on exactly as the sample does, which `leave` forbids too.
    """
    marks = []
    for sy, sx in places:
        mark = ""
        for y, x, oy, ox in around:
            if (sy - oy, sx - ox) == (corner[0] - y, corner[1] - x):
                if leave:
                    mark = "continues"
                    break
            elif max(abs(sy - oy), abs(sx - ox)) < reach:
                mark = "repeats"
                break
        marks.append(mark)
    return marks


def around(away, n, turns):
    """The shortest way to a place, on an axis of n that goes around or does not."""
    return min((away + k * n for k in ((0, -1, 1) if turns else (0,))), key=abs)


def shown_again(corner, source, seen, window, canvas, exemplar):
    """How much of a patch is shown already, in patches: the nearer the more, and more in line.

    `seen` lists (y, x, source y, source x) of earlier patches.
    """
    total = 0.0
    for y, x, *place in seen:
        apart = [
            around(a - b, n, exemplar.tileable)
            for a, b, n in zip(source, place, exemplar.shape, strict=True)
        ]
        shared = [max(0, side - abs(d)) for side, d in zip(window, apart, strict=True)]
        away = [
            around(a - b - d, n, wrap)
            for a, b, d, n, wrap in zip(
                corner, (y, x), apart, canvas.shape, canvas.wrap, strict=True
            )
        ]
        if away == [0, 0]:
            continue  # it goes on as in the sample
        weight = max(0.0, 1 - math.sqrt(away[0] ** 2 + away[1] ** 2) / (4.5 * max(window)))
        if any(16 * abs(d) <= side for d, side in zip(away, window, strict=True)):
            weight += 0.5
        total += weight * (shared[0] * shared[1])
    return min(total / (window[0] * window[1]), 4.0)


def seen_from(step, laid, shape, wrap):
    """What a patch of the grid sees: near it, or in line, and laid before it in any order.

    `laid` has the placements by steps (row, column); in the kernel's order of adding up.
    """
    near, far = range(-SIGHT, SIGHT + 1), range(SIGHT + 1, IN_LINE + 1)
    away = [(i, j) for i in near for j in near]
    away += [(k, 0) for k in far] + [(-k, 0) for k in far]
    away += [(0, k) for k in far] + [(0, -k) for k in far]
    found = []
    for by in away:
        if any(
            w and not -(n // 2) <= d < n - n // 2 for d, n, w in zip(by, shape, wrap, strict=True)
        ):
            continue
        i, j = (
            (at + d) % n if w else at + d for at, d, n, w in zip(step, by, shape, wrap, strict=True)
        )
        up, right = step[0] - i, j - step[1]
        finished = up > 0 and (wrap[1] or right <= (up - 1) * PIECE + up)
        if (finished or (up == 0 and right < 0)) and (i, j) in laid:
            found.append(laid[i, j])
    return found


def laid_nearby(corner, placements, reach, most):
    """In a hole: the latest few patches whose corners are nearer than that along both axes."""
    near = [
        p
        for p in placements
        if abs(p[0] - corner[0]) < reach[0] and abs(p[1] - corner[1]) < reach[1]
    ]
    return near[-most:]
