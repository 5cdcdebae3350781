"""Patch-based sampling and image quilting, patch by patch: the set of candidates, and the cut."""

import numpy as np
from scipy.ndimage import distance_transform_cdt

import weftex
from random_cases import AROUND, centers_of, distances, random_canvas, random_cases, random_exemplar
from weftex.random import draw
from weftex.reference.image_quilting import minimum_error_boundary

#: A candidate that repeats nothing may have this times the squared distance of the best one.
UNREPEATED = 1.7


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


def drawn(keys, marks, bits, energy, method, fills=False):
    """Draw from Psi_B, the candidates within the tolerance that repeat least (section 2.1)."""

    quilting = isinstance(method, weftex.Quilting)
    if fills and not quilting and method.epsilon <= 0.02:  # as quilting, of good patches
        quilting, method = True, weftex.Quilting(tolerance=0.05)

    def limit(best):
        if quilting:
            return best * (1 + method.tolerance) * (1 + method.tolerance)
        return energy * method.epsilon * method.epsilon

    allowed = marks != 1 if (marks != 1).any() else marks >= 0
    free = marks == 0
    if free.any() and keys[free].min() <= UNREPEATED * keys[allowed].min():
        allowed = free
    best = keys[allowed].min()
    within = np.flatnonzero(allowed & (keys <= limit(best) if quilting else keys < limit(best)))
    if not len(within):
        return np.flatnonzero(allowed & (keys == best))[0]
    if not quilting and method.choice == "similarity" and limit(best) > 0:
        alpha = np.cumsum(1 - np.sqrt(keys[within] / limit(best)))
        return within[np.searchsorted(alpha, alpha[-1] * ((bits >> 11) / 2**53), side="right")]
    return within[(bits >> 32) * len(within) >> 32]


def cheapest(cost):
    """The cost of the cheapest path down a band, by the reference."""
    return cost[np.arange(len(cost)), minimum_error_boundary(cost)].sum()


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
        "blend": str(rng.choice(["cut", "cut", "feather", "feather-at-end", "none"])),
        "repeat_distance": float(rng.choice([0.0, 0.5, 1.5])),
    }
    tolerance = float(rng.choice([0, 0.02, 0.1, 0.2, 1, np.inf]))
    if tolerance == np.inf:  # everything matches: the chaos mosaic
        kind = {name: kind[name] for name in ("patch_size", "boundary_width", "blend")}
    if rng.integers(2):
        method = weftex.Quilting(tolerance=tolerance, **kind)
    else:
        choice = (
            {} if tolerance == np.inf else {"choice": str(rng.choice(["uniform", "similarity"]))}
        )
        method = weftex.PatchSampling(epsilon=tolerance, **choice, **kind)
    exemplar = random_exemplar(rng, *rng.integers(16, 22, 2))
    canvas = random_canvas(rng, *rng.integers(3, 34, 2))
    seed = int(rng.integers(1, 4))
    result = method.fit(exemplar).sample(canvas, seed=seed)

    window = np.minimum(size, canvas.shape)
    width = min([width, *(window[list(canvas.wrap)] // 4)]) or 1
    around, view = [(0, n) for n in window], np.lib.stride_tricks.sliding_window_view
    sample = exemplar.matching()
    pixels = np.pad(sample, [*around, (0, 0)], "wrap").astype(int)
    mask = np.pad(exemplar.mask, around, "wrap" if exemplar.tileable else "constant")
    windows = np.moveaxis(view(pixels, window, (0, 1)), 2, -1)
    usable = view(mask, window)[: exemplar.shape[0], : exemplar.shape[1]]
    places = np.argwhere(usable.all(axis=(2, 3)))
    windows = windows[tuple(places.T)]

    holes = canvas.hole is not None
    done = ~canvas.hole if holes else np.zeros(canvas.shape, bool)
    fixed, picture = done.copy(), np.zeros((*canvas.shape, sample.shape[2]), int)
    if holes:
        picture[done] = exemplar.as_matching(canvas.known)[done]
    unblended = picture.copy()  # which is matched, until all is blended at the end
    starts = [sorted({*result.placements[:, axis].tolist()}) for axis in (0, 1)]
    laid, matched = {}, unblended if method.blend == "feather-at-end" else picture
    for number, (*corner, v, u, zone_number) in enumerate(result.placements.tolist()):
        lines = zip(corner, window, canvas.shape, strict=True)
        here = np.ix_(*((at + np.arange(n)) % length for at, n, length in lines))
        if holes:
            known, bits = done[here], draw(seed, "patch", number)
            near = [p for p in laid.values() if (abs(p[:2] - np.array(corner)) < 2 * window).all()]
            earlier = near[-len(AROUND) :]
        else:
            i, j = grid = starts[0].index(corner[0]), starts[1].index(corner[1])
            known = known_strips(grid, corner, window, width, canvas)
            bits = draw(seed, "patch", i, j)
            earlier = [laid[i + a, j + b] for a, b in AROUND if (i + a, j + b) in laid]
        # The boundary zone, and the weights that fall evenly through it.
        depth = distance_transform_cdt(known, "chessboard") if not known.all() else np.inf * known
        zone = known & (depth <= width)
        weights = np.floor(256 * (width + 1 - depth) / (width + 1) + 1e-9)
        weights = np.where(zone & (method.blend != "none"), weights, 256 * (zone | ~known))
        weights[fixed[here]] = 0
        assert np.array_equal(result.weights[zone_number], weights)
        # Steps 1 to 4: an element of Psi_B, of all windows of the sample.
        chosen = int(bits >> np.uint64(32)) * len(places) >> 32
        if zone.any() and tolerance < np.inf:
            old = matched[here][zone]
            keys = ((windows[:, zone] - old) ** 2).sum(axis=(1, 2))
            marks = np.zeros(len(places), int)
            if method.repeat_distance:
                apart, leave = round(method.repeat_distance * size), int(bits) % 2 == 1
                marks = marks_of(corner, places, earlier, apart, leave)
            chosen = drawn(keys, marks, int(bits), int((old**2).sum()), method, holes and seed != 1)
        assert (places[chosen] == [v, u]).all()
        laid[number if holes else grid] = (*corner, v, u)
        # Steps 5 and 6: the cut, and the paste.
        new = windows[chosen]
        if method.blend == "cut":
            error = ((matched[here] - new) ** 2).sum(axis=2)
            inside = cut_out(result.cuts[number], error, zone, weights, width, holes)
            part = (weights > 0) & (weights < 256)
            weights[part] = 256 * inside[part]
        share = weights[..., None].astype(int)
        unblended[here] = np.where(share > 0, new, unblended[here])
        picture[here] = (picture[here] * (256 - share) + new * share + 128) // 256
        done[here] |= weights > 0
    assert np.array_equal(result.image, picture[..., :3])


@random_cases(20)
def test_patches_of_one_pixel(rng):
    """Section 2.5: pixel by pixel in scan order, each with a window of 2 w_E + 1."""
    exemplar = random_exemplar(rng, *rng.integers(12, 18, 2))
    size = rng.integers(1, 12, 2).tolist()
    canvas = weftex.Canvas(*size, tuple(map(bool, rng.integers(0, 2, 2))))
    width, seed = int(rng.integers(1, 4)), int(rng.integers(2**32))
    method = weftex.PatchSampling(patch_size=1, boundary_width=width, search="exhaustive")
    result = method.fit(exemplar).sample(canvas, seed=seed)
    corners = (centers_of(exemplar, width) - width) % exemplar.shape
    centers = np.array(sorted(corners.tolist())) + width
    done, square = np.zeros(canvas.shape, bool), np.argwhere(np.ones([2 * width + 1] * 2)) - width
    picture, marks = np.zeros((*canvas.shape, 3), int), np.zeros(len(centers), int)
    for pixel in np.ndindex(canvas.shape):
        there = ((pixel + square >= 0) & (pixel + square < canvas.shape) | canvas.wrap).all(axis=1)
        steps = square[there & done[tuple(((pixel + square) % canvas.shape).T)]]
        bits = draw(seed, "patch", *pixel)
        chosen = int(bits >> np.uint64(32)) * len(centers) >> 32
        if len(steps):
            keys = distances(exemplar, centers, picture, pixel, steps)
            energy = int((picture[tuple(((pixel + steps) % canvas.shape).T)] ** 2).sum())
            chosen = drawn(keys, marks, int(bits), energy, method)
        place = centers[chosen] % exemplar.shape
        assert (result.source[pixel] == place).all()
        picture[pixel], done[pixel] = exemplar.pixels[tuple(place)], True
