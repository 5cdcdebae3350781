"""Patch-based sampling and image quilting, patch by patch: the set of candidates, and the cut."""

import numpy as np
from scipy.ndimage import distance_transform_cdt

import weftex
from random_cases import random_canvas, random_cases, random_exemplar
from weftex.random import draw

#: A candidate that repeats nothing may have this times the squared distance of the best one.
UNREPEATED = 1.7
#: Earlier patches of the grid around one, as rows and columns away.
AROUND = [(0, -2), (0, -1), *((-1, k) for k in range(-2, 2)), *((-2, k) for k in range(-2, 3))]


def known_strips(grid, at, window, width, canvas):
    """Where patch `grid` overlaps patches before it, also around borders (Fig. 3 and 5)."""
    known = np.zeros(window, bool)
    for axis in (0, 1):
        lines = known.swapaxes(0, axis)
        lines[:width] |= grid[axis] > 0
        around = at[axis] + window[axis] - canvas.shape[axis]
        if canvas.wrap[axis] and grid[axis] > 0 and around > 0:
            lines[-around:] = True
    return known


def marks_of(corner, places, earlier, apart, leave):
    """1 where a candidate continues an earlier patch and must not; 2 where it repeats one."""
    marks = np.zeros(len(places), int)
    for patch in earlier[::-1]:  # the first one decides
        offset = places - patch[2:4]
        continues = (offset == np.subtract(corner, patch[:2])).all(axis=1)
        marks[(abs(offset) < apart).all(axis=1) & ~continues] = 2
        marks[continues & leave] = 1
    return marks


def drawn(keys, marks, bits, energy, method):
    """Draw from Psi_B, the candidates within the tolerance that repeat least (section 2.1)."""

    def limit(best):
        if isinstance(method, weftex.Quilting):
            return best * (1 + method.tolerance) ** 2
        return energy * method.epsilon**2

    allowed = marks != 1 if (marks != 1).any() else marks >= 0
    free = marks == 0
    if free.any() and keys[free].min() <= UNREPEATED * keys[allowed].min():
        allowed = free
    best = keys[allowed].min()
    quilting = isinstance(method, weftex.Quilting)
    within = np.flatnonzero(allowed & (keys <= limit(best) if quilting else keys < limit(best)))
    if not len(within):
        return np.flatnonzero(allowed & (keys == best))[0]
    if not quilting and method.choice == "similarity" and limit(best) > 0:
        alpha = np.cumsum(1 - np.sqrt(keys[within] / limit(best)))
        return within[np.searchsorted(alpha, alpha[-1] * ((bits >> 11) / 2**53), side="right")]
    return within[(bits >> 32) * len(within) >> 32]


def cheapest(cost):
    """The cost of the cheapest path down a band, by Bellman's recursion."""
    total = np.zeros(cost.shape[1], int)
    for row in cost:
        ends = np.pad(total, 1, constant_values=2**60)
        total = row + np.minimum(np.minimum(ends[:-2], ends[1:-1]), ends[2:])
    return total.min()


def cut_out(cut, error, zone, weights, width, hole):
    """Where a patch is pasted; its path along each side is connected and has the least error.

    A hole's patch can show in a box only, and may be cut as far as the middle of it.
    """
    left, right = cut[: len(error)].astype(int), cut[len(error) : 2 * len(error)].astype(int)
    top, bottom = cut[2 * len(error) :].astype(int).reshape(2, -1)
    shown = np.argwhere(weights > 0)
    (first, left_end), (last, right_end) = shown.min(axis=0), shown.max(axis=0) + 1
    box = np.s_[first:last, left_end:right_end]
    error, there = np.where(weights == 256, 0, np.where(weights == 0, 2**44, error))[box], zone[box]
    depth = min(width, *error.shape)
    depth = max(depth, min(error.shape) // 2) if hole else depth
    rows, columns = np.s_[first:last], np.s_[left_end:right_end]
    for path, outside, band, in_zone in (
        (left[rows] - left_end, left, error, there),
        (top[columns] - first, top, error.T, there.T),
        (right_end - right[rows], right - zone.shape[1], error[:, ::-1], there[:, ::-1]),
        (last - bottom[columns], bottom - zone.shape[0], error[::-1].T, there[::-1].T),
    ):
        strip = in_zone[:, :depth]
        if not (strip.any() if hole else strip.any(axis=1).all()):
            assert not outside.any()
            continue
        assert (abs(np.diff(path)) <= 1).all()
        assert band[np.arange(len(path)), path].sum() == cheapest(band[:, :depth])
    y, x = np.indices(zone.shape)
    return (left[y] <= x) & (x < right[y]) & (top[x] <= y) & (y < bottom[x])


@random_cases(40)
def test_each_patch_is_searched_drawn_cut_and_pasted(rng):
    size = int(rng.integers(4, 10))
    width = int(rng.integers(1, size // 2 + 1))
    kind = {
        "patch_size": size,
        "boundary_width": width,
        "search": "exhaustive",
        "blend": str(rng.choice(["cut", "cut", "feather", "none"])),
        "repeat_distance": float(rng.choice([0.0, 0.5, 1.5])),
    }
    if rng.integers(2):
        method = weftex.Quilting(tolerance=float(rng.choice([0, 0.1, 1])), **kind)
    else:
        choice = str(rng.choice(["uniform", "similarity"]))
        method = weftex.PatchSampling(
            epsilon=float(rng.choice([0.0, 0.2, 1.0])), choice=choice, **kind
        )
    exemplar = random_exemplar(rng, *rng.integers(16, 22, 2))
    canvas = random_canvas(rng, *rng.integers(12, 34, 2))
    seed = int(rng.integers(2**32))
    result = method.fit(exemplar).sample(canvas, seed=seed)

    window = np.minimum(size, canvas.shape)
    width = min([width, *(window[list(canvas.wrap)] // 4)]) or 1
    pixels = np.pad(exemplar.pixels, [(0, n) for n in window] + [(0, 0)], "wrap").astype(int)
    mask = np.pad(
        exemplar.mask, [(0, n) for n in window], "wrap" if exemplar.tileable else "constant"
    )
    windows = np.lib.stride_tricks.sliding_window_view(pixels, (*window, 3))[:, :, 0]
    usable = np.lib.stride_tricks.sliding_window_view(mask, window)[
        : exemplar.shape[0], : exemplar.shape[1]
    ]
    places = np.argwhere(usable.all(axis=(2, 3)))
    windows = windows[tuple(places.T)]

    holes = canvas.hole is not None
    done = ~canvas.hole if holes else np.zeros(canvas.shape, bool)
    fixed, picture = done.copy(), np.zeros((*canvas.shape, 3), int)
    picture[done] = canvas.known[done] if holes else 0
    starts = [sorted({*result.placements[:, axis].tolist()}) for axis in (0, 1)]
    laid = {}
    for number, (*corner, v, u, zone_number) in enumerate(result.placements.tolist()):
        here = np.ix_(
            *(
                (at + np.arange(n)) % m
                for at, n, m in zip(corner, window, canvas.shape, strict=False)
            )
        )
        if holes:
            known, bits = done[here], draw(seed, "patch", number)
            near = [
                p for p in laid.values() if (abs(np.subtract(p[:2], corner)) < 2 * window).all()
            ]
            earlier = near[-len(AROUND) :]
        else:
            i, j = grid = tuple(line.index(at) for line, at in zip(starts, corner, strict=False))
            known, bits = (
                known_strips(grid, corner, window, width, canvas),
                draw(seed, "patch", i, j),
            )
            earlier = [laid[i + a, j + b] for a, b in AROUND if (i + a, j + b) in laid]
        # The boundary zone, and the weights that fall evenly through it.
        depth = distance_transform_cdt(known, "chessboard") if not known.all() else np.inf * known
        zone = known & (depth <= width)
        weights = np.floor(256 * (width + 1 - depth) / (width + 1) + 1e-9)
        weights = np.where(zone & (kind["blend"] != "none"), weights, 256 * (zone | ~known))
        weights[fixed[here]] = 0
        assert np.array_equal(result.weights[zone_number], weights)
        # Steps 1 to 4: an element of Psi_B, of all windows of the sample.
        chosen = int(bits >> np.uint64(32)) * len(places) >> 32
        if zone.any():
            old = picture[here][zone]
            keys = ((windows[:, zone] - old) ** 2).sum(axis=(1, 2))
            marks = np.zeros(len(places), int)
            if method.repeat_distance:
                apart, leave = round(method.repeat_distance * size), int(bits) % 2 == 1
                marks = marks_of(corner, places, earlier, apart, leave)
            chosen = drawn(keys, marks, int(bits), int((old**2).sum()), method)
        assert (places[chosen] == [v, u]).all()
        laid[number if holes else grid] = (*corner, v, u)
        # Steps 5 and 6: the cut, and the paste.
        new = windows[chosen]
        if kind["blend"] == "cut":
            error = ((picture[here] - new) ** 2).sum(axis=2)
            inside = cut_out(result.cuts[number], error, zone, weights, width, holes)
            part = (weights > 0) & (weights < 256)
            weights[part] = 256 * inside[part]
        share = weights[..., None].astype(int)
        picture[here] = (picture[here] * (256 - share) + new * share + 128) // 256
        done[here] |= weights > 0
    assert np.array_equal(result.image, picture)
