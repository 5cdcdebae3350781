"""Heights that are joined, as one system of linear equations."""

import numpy as np

REACH = 24


def joined(made, sample, coordinates, shares, wrap, scale=1, given=None, within=None):
    """The heights (H, W) with the least sum of (f' - g)^2 + ((f - h) / reach)^2.

    Those `given` stay (NaN: not given); slopes count between pixels `within` a part.
    """
    height, width = made.shape
    made = made.astype(float)
    matrix = np.eye(made.size) / (REACH * scale) ** 2
    right = made.ravel() / (REACH * scale) ** 2
    places, alone = (
        a[:, :, 0].repeat(scale, 0).repeat(scale, 1) for a in (scale * coordinates, shares == 1)
    )
    places += np.moveaxis(np.indices(made.shape) % scale, 0, 2)

    def told(v, u, step):
        """What the sources of pixel (v, u) say of a step from there: the sum, and its shares."""
        total = share = 0.0
        for at, part in zip(
            coordinates[v // scale, u // scale], shares[v // scale, u // scale], strict=True
        ):
            y, x = at[0] * scale + v % scale, at[1] * scale + u % scale
            b, a = y + step[0], x + step[1]
            if part > 0 and 0 <= b < sample.shape[0] and 0 <= a < sample.shape[1]:
                total += part * (float(sample[b, a]) - float(sample[y, x]))
                share += part
        return total, share

    for v in range(height):
        for u in range(width):
            for step in ((1, 0), (0, 1)):
                b, a = v + step[0], u + step[1]
                if (b == height and not wrap[0]) or (a == width and not wrap[1]):
                    continue
                b, a = b % height, a % width
                if within is not None and not (within[v, u] and within[b, a]):
                    continue
                ahead, one = told(v, u, step)
                behind, other = told(b, a, (-step[0], -step[1]))
                slope = made[b, a] - made[v, u]
                # One piece has its own slopes, also where a line is left out or doubled.
                off = abs(places[b, a] - places[v, u] - step).tolist()
                whole = alone[v, u] and alone[b, a] and off in ([0, 0], [scale * k for k in step])
                if one + other > 0 and not whole:
                    slope = (ahead - behind) / (one + other)
                p, q = v * width + u, b * width + a
                for k, sign in ((p, -1), (q, 1)):
                    matrix[k, q] += sign
                    matrix[k, p] -= sign
                    right[k] += sign * slope
    if given is not None:
        fixed = np.isfinite(given.ravel())
        matrix[fixed], right[fixed] = np.eye(made.size)[fixed], given.ravel()[fixed]
    return np.linalg.solve(matrix, right).reshape(made.shape)
