"""Iterative refinement (sections 3, 5 and 6 of the paper on texture refinement and fusion)."""

import itertools
import math

import numpy as np

from twins.pyramids import coarser, coarser_mask, pyramid, stacked
from twins.randomness import random_bits
from twins.seed_points import seed_points
from twins.similar import registered_similar
from twins.windows import by_rows, known_steps, nearest_center, steps_away, window_centers
from weftex.analysis.scale import structure_scale


class RefinedLevel:
    """A sample at one resolution, for `refinement`; places are of the sample on all levels."""

    def __init__(self, pixels, mask, tileable, number, reach, side):
        self.pixels, self.mask, self.tileable = pixels, mask, tileable
        self.shape, self.number, self.reach, self.side = mask.shape, number, reach, side
        self.similar = {}
        self.rows, self.columns = self._steps(mask.shape[0]), self._steps(mask.shape[1])
        there = self.rows[:, None, :, None], self.columns[None, :, None, :]
        self.centers = [tuple(at) for at in np.argwhere(mask[there].all(axis=(2, 3))).tolist()]
        self.center_set = set(self.centers)

    def _steps(self, length):
        """Where each step from each place of an axis leads; mirrored beyond a border."""
        step = np.arange(-self.reach, self.reach + 1)
        first, start = np.divmod(np.arange(length)[:, None], 2**self.number)
        count = -(-(length - start) // 2**self.number)
        at = first + step
        inside = at % count if self.tileable else at % (2 * count)
        inside = np.minimum(inside, 2 * count - 1 - inside) if not self.tileable else inside
        return start + inside * 2**self.number

    def at(self, place, dy, dx):
        """The pixel beside a place, 2**number pixels for a step; mirrored beyond a border."""
        steps = self.rows[place[0], dy + self.reach], self.columns[place[1], dx + self.reach]
        return tuple(map(int, steps))

    def around(self, places, steps):
        """Rows and columns of the pixels at some steps from each place, to index with."""
        y, x = np.array(places, int).reshape(-1, 2, 1).transpose(1, 0, 2)
        dy, dx = np.array(steps, int).reshape(-1, 2).T + self.reach
        return self.rows[y, dy], self.columns[x, dx]

    def beside(self, place, dy, dx):
        """Where a source goes on, or None."""
        inside = self.tileable or all(
            0 <= k + d * 2**self.number < n
            for k, d, n in zip(place, (dy, dx), self.shape, strict=True)
        )
        place = self.at(place, dy, dx) if inside else None
        return place if place in self.center_set else None

    def cell(self, place):
        """The square of the sample that a place lies in."""
        return place[0] // self.side, place[1] // self.side


def turned_lines(unknown, turn, cyclic):
    """Pixels line by line in the order of an iteration."""
    height, width = unknown.shape
    if cyclic and turn % 2:
        lines = [[(y, x) for y in range(height)] for x in range(width)]
    else:
        lines = [[(y, x) for x in range(width)] for y in range(height)]
    lines = [[at for at in line if unknown[at]] for line in lines]
    lines = [line for line in lines if line]
    backwards = turn % 4 > 1 if cyclic else turn % 2
    return [line[::-1] for line in lines[::-1]] if backwards else lines


def refinement(method, exemplar, canvas, seed, start=None):
    """Refine a canvas coherently, from coarse to fine; (H, W, 2) sources, -1 for known pixels.

    `method` is settled; `start` the sources of the other method's result.
    """
    width = method.window_width
    reach = min(3, width // 2)
    depth = 1
    while (2 * reach + 1) * 2 ** (depth - 1) < width:
        if min(exemplar.shape) // 2**depth < 24:
            break
        depth += 1
    tiles = (exemplar.tileable,) * 2
    masks = [np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask]
    pictures = [exemplar.matching()]
    for _ in range(depth - 1):
        mask = coarser_mask(masks[-1], tiles)
        if not window_centers(mask, reach, exemplar.tileable):
            break  # the mask leaves nothing
        masks.append(mask)
        pictures.append(coarser(pictures[-1], tiles))
    levels = []
    for number in range(len(masks)):
        fine = not number and len(masks) > 1 and method.joints is None
        levels.append(
            RefinedLevel(
                stacked(pictures[0], number, tiles),
                stacked(masks[0], number, tiles, coarser_mask),
                exemplar.tileable, number, min(reach, 1) if fine else reach, max(1, width // 2),
            )
        )  # fmt: skip
    similar = registered_similar(pictures, masks, exemplar.tileable, reach, method.similar)
    for level in levels:
        level.similar = {
            place: [p for p in places if p in level.center_set] for place, places in similar.items()
        }
    picture = np.zeros((*canvas.shape, exemplar.matching().shape[2]), np.uint8)
    hole = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    picture[~hole] = exemplar.as_matching(canvas.known)[~hole] if not hole.all() else 0
    kept = np.zeros(canvas.shape, bool)
    if method.joints is not None:
        for y, x in np.argwhere(hole):
            picture[y, x] = exemplar.matching()[tuple(start[y, x])]
        kept = hole & ~seam_belts(start, method.joints // 2, canvas.wrap, exemplar)
        hole = hole & ~kept
        levels = levels[:1]
    stack = list(zip(*pyramid(picture, ~hole, canvas.wrap, len(levels)), strict=True))
    while start is not None and len(levels) > 1:
        step = 2 ** levels[-1].number
        shown = [tuple(at) for at in start[::step, ::step][~stack[-1][1]].tolist() if at[0] >= 0]
        if sum(at not in levels[-1].center_set for at in shown) <= 0.15 * len(shown):
            break
        levels, stack = levels[:-1], stack[:-1]
    below = None
    for level, (picture, known) in list(zip(levels, stack, strict=True))[::-1]:
        coarsest, rows = below is None, by_rows(level.centers)
        step = 2**level.number
        source = [[None] * known.shape[1] for _ in range(known.shape[0])]
        seeds = coarsest and start is None
        if seeds:
            scale = method.seed_scale or structure_scale(exemplar).scale
            spacing = max(1, round(scale / method.seed_density / step))
            points = seed_points(
                level.pixels[::step, ::step], level.mask[::step, ::step], known.shape, canvas.wrap,
                spacing, method.matches, seed,
            )  # fmt: skip
            for (y, x), (v, u) in points.items():
                source[y][x] = nearest_center(rows, v * step, u * step)
        for y, x in np.ndindex(known.shape):
            if coarsest and not seeds:
                v, u = (int(k) for k in start[y * step, x * step])
                source[y][x] = None if v < 0 else (v, u)
            elif not coarsest and not known[y, x]:  # whose parents are not known either
                v, u = below[y // 2][x // 2]
                v, u = v + y % 2 * step, u + x % 2 * step
                if exemplar.tileable:
                    v, u = v % exemplar.shape[0], u % exemplar.shape[1]
                source[y][x] = v, u
            if known[y, x]:
                source[y][x] = None
                if kept[y * step, x * step]:
                    source[y][x] = tuple(int(k) for k in start[y * step, x * step])
                elif canvas.known_from is not None:
                    v, u = y * step + canvas.known_from[0], x * step + canvas.known_from[1]
                    source[y][x] = v, u
            if source[y][x] is not None and (not seeds or known[y, x]):
                source[y][x] = nearest_center(rows, *source[y][x])
        done = np.array([[s is not None for s in row] for row in source]) | known
        for y, x in np.argwhere(done & ~known):
            picture[y, x] = level.pixels[source[y][x]]
        rounds = 2 * method.iterations if coarsest else max(1, method.iterations // 2)
        cyclic = not hole.all()
        usage, room = {}, _room(level, ~known)
        for y, x in np.argwhere(done & ~known):
            usage[level.cell(source[y][x])] = usage.get(level.cell(source[y][x]), 0) + 1
        above = len(levels) - 1 - levels.index(level)
        settled = bool(done.all()) and (above > 0 or not cyclic or method.joints is not None)
        for turn in range(rounds):
            before, there = picture.copy(), done.copy()
            for line in turned_lines(~known, turn, cyclic):
                _sweep(
                    method, level, canvas, seed, picture, done, source, ~known, line, turn,
                    usage, room, above, settled,
                )  # fmt: skip
            if turn >= (3 if cyclic else 1):
                ratios = []
                for at in zip(*np.nonzero(~known), strict=True):
                    old, new = before[at].astype(int), picture[at].astype(int)
                    away = math.sqrt(((new - old) ** 2).sum() / max((old**2).sum(), 1))
                    ratios.append(round(away * 2**20) if there[at] else 2**20)
                if sum(ratios) / 2**20 / len(ratios) < method.threshold:
                    break
        below = source
    result = np.full((*canvas.shape, 2), -1)
    result[kept] = start[kept] if kept.any() else -1
    for y, x in np.argwhere(hole):
        result[y, x] = below[y][x]
    return result


def seam_belts(source, reach, wrap, exemplar):
    """What lies less than `reach` pixels from one beside which another source goes on."""
    height, width = source.shape[:2]
    seams = []
    for y, x in np.ndindex(height, width):
        for axis in (0, 1):
            at = [y, x]
            at[axis] += 1
            if at[axis] >= source.shape[axis] and not wrap[axis]:
                continue
            at = at[0] % height, at[1] % width
            step = [int(source[at][k]) - int(source[y, x][k]) - (k == axis) for k in (0, 1)]
            if exemplar.tileable:
                step = [s % n for s, n in zip(step, exemplar.shape, strict=True)]
            if any(step):
                seams += [(y, x), at]
    belts = np.zeros((height, width), bool)
    for y, x in seams:
        for dy, dx in itertools.product(range(1 - reach, reach), repeat=2):
            v, u = y + dy, x + dx
            if (wrap[0] or 0 <= v < height) and (wrap[1] or 0 <= u < width):
                belts[v % height, u % width] = True
    return belts


def _known_distances(level, here, known, places):
    """Sums of squared differences over the known pixels of a window, which are `here`."""
    return ((level.pixels[level.around(places, known)] - here) ** 2).sum(axis=(1, 2)).tolist()


def _settle(level, picture, done, source, y, x, place):
    source[y][x], done[y, x], picture[y, x] = place, True, level.pixels[place]


def _room(level, unknown):
    """How often the sources of each square of the sample are to be used."""
    wanted, count, room = int(unknown.sum()), len(level.centers), {}
    for place in level.centers:
        room[level.cell(place)] = room.get(level.cell(place), 0) + 1
    wanted = max(wanted, count // 4**level.number)
    return {cell: 2 * n * wanted // count for cell, n in room.items()}


def _sweep(
    method, level, canvas, seed, picture, done, source, unknown, line, turn, usage, room, above,
    settled,
):  # fmt: skip
    weight = round(1024 * method.evenness / 2**above)

    def factor(cell):
        """What the distances of a square that is used more than it should be are multiplied by."""
        capacity = max(1, room[cell])
        over = usage.get(cell, 0) - capacity
        return 256 + min(weight * over // capacity, 2**14) if over > 0 else 256

    tried = []
    if not settled and turn == 0:
        count = max(2**23 // int(unknown.sum()), 64)
        first = line[0][0] * picture.shape[1] + line[0][1]
        tried = [
            level.centers[random_bits(seed, "tried place", first, k) % len(level.centers)]
            for k in range(count if count < len(level.centers) else 0)
        ] or level.centers
    for y, x in line:
        own = source[y][x]
        beside = known_steps(done, (y, x), min(1, level.reach), canvas.wrap)
        places = [own] if own in level.center_set else []
        for dy, dx in beside[::-1].tolist():
            other = source[(y + dy) % len(source)][(x + dx) % len(source[0])]
            place = None if other is None else level.beside(other, -dy, -dx)
            places += [place] if place is not None and place not in places else []
        near = len(places)
        places += [other for p in places for other in level.similar[p]]
        places += tried
        if not places:
            continue
        known = known_steps(done, (y, x), level.reach, canvas.wrap)
        costs = _known_distances(level, steps_away(picture, y, x, known), known, places)
        factors = {cell: factor(cell) for cell in {level.cell(place) for place in places}}
        for k, place in enumerate(places):
            more = 512 if k >= near else 256
            costs[k] *= factors[level.cell(place)] * more // 256
        best = places[costs.index(min(costs))]
        if own is not None:
            usage[level.cell(own)] = usage.get(level.cell(own), 0) - 1
        usage[level.cell(best)] = usage.get(level.cell(best), 0) + 1
        _settle(level, picture, done, source, y, x, best)
