"""Places of a sample that are like each other."""

import numpy as np

from twins.windows import by_rows, nearest_center, window_centers, windows_at


def similar_places(pixels, centers, reach, count, candidates):
    """For each center the places most like it; `candidates` says which are compared with it.

    Nothing within two pixels of it; of places so near to each other the best.
    """

    def near(one, other):
        return max(abs(one[0] - other[0]), abs(one[1] - other[1])) <= 2

    result, number = {}, {center: k for k, center in enumerate(centers)}
    windows = windows_at(pixels, centers, reach)
    for center in centers:
        places = [p for p in (candidates(center) if count else []) if not near(p, center)]
        apart = windows[[number[p] for p in places]] - windows[number[center]]
        found = []
        for entry in zip((apart**2).sum(axis=1).tolist(), places, strict=True):
            if len(found) == count and entry[0] >= found[-1][0]:
                continue
            rivals = [k for k, (_, other) in enumerate(found) if near(entry[1], other)]
            if rivals:
                if entry[0] >= found[rivals[0]][0]:
                    continue
                del found[rivals[0]]
            found = sorted([*found, entry], key=lambda e: e[0])[:count]
        result[center] = [place for _, place in found]
    return result


def registered_similar(pictures, masks, tileable, reach, count):
    """The places like each: exactly on the coarsest level, then around parents' similar places."""
    parents, parents_similar = None, None
    for pixels, mask in list(zip(pictures, masks, strict=True))[::-1]:
        centers = window_centers(mask, reach, tileable)
        center_set = set(centers)
        step = -(-(len(centers) ** 2) // 2**24)

        def candidates(center, every=centers[::step], among=center_set, older=parents,
                       older_similar=parents_similar):  # fmt: skip
            if older is None:
                return every
            y, x = center
            around = [
                (2 * v + y % 2 + dy, 2 * u + x % 2 + dx)
                for v, u in older_similar[nearest_center(older, y // 2, x // 2)]
                for dy in (-1, 0, 1)
                for dx in (-1, 0, 1)
            ]
            return [place for place in around if place in among]

        parents_similar = similar_places(pixels, centers, reach, count, candidates)
        parents = by_rows(centers)
    places = np.ndindex(masks[0].shape)
    return {(y, x): parents_similar[nearest_center(parents, y, x)] for y, x in places}
