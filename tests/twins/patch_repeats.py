"""Patches that would repeat the source of a patch pasted nearby."""

from __future__ import annotations


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


def laid_nearby(corner, placements, reach, most):
    """In a hole: the latest few patches whose corners are nearer than that along both axes."""
    near = [
        p
        for p in placements
        if abs(p[0] - corner[0]) < reach[0] and abs(p[1] - corner[1]) < reach[1]
    ]
    return near[-most:]
