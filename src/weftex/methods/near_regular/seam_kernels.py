# mypy: ignore-errors
"""Kernels of near-regular synthesis: where blocks meet; compiled, see setup.py.

Two blocks overlap in a band, `depth` pixels deep. `state` and `known` have the canvas's pixels
around a hole, and are empty without a hole. Positions in a band are flat indices into the sample.
"""

import cython

BOX = cython.declare(cython.Py_ssize_t, 3)  # half the side of what is compared at a corner
BESIDE = cython.declare(cython.int, 1)  # the state of a known pixel beside a hole; 0 in the hole
OFF = cython.declare(cython.int, 2)  # the state of any other
NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any boundary costs


@cython.cclass
class Band:
    """The costs of a band: `error` (lines, depth), `beyond` (lines or 0, depth + 1) of crossings.

    `total`, `came` are scratch; `path` (lines,) receives the boundary.
    """

    error: cython.longlong[:, ::1]
    beyond: cython.longlong[:, ::1]
    total: cython.longlong[:, ::1]
    came: cython.int[:, ::1]
    path: cython.int[::1]

    def __init__(self, error, beyond, total, came, path):
        self.error, self.beyond, self.total, self.came = error, beyond, total, came
        self.path = path


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def compare(
    pixels: cython.const[cython.uchar][:, :, ::1],
    visibility: cython.const[cython.ushort][:, ::1],
    one: cython.Py_ssize_t,
    other: cython.Py_ssize_t,
    along: cython.Py_ssize_t,
    across: cython.Py_ssize_t,
    length: cython.Py_ssize_t,
    band: Band,
) -> cython.void:
    """Set the band's errors: squared differences of two blocks, weighted by visibility.

    The blocks begin at `one` and `other`; the next line is `along` on, the next pixel `across`.
    """
    cython.declare(n=cython.Py_ssize_t, k=cython.Py_ssize_t, c=cython.Py_ssize_t)
    cython.declare(p=cython.Py_ssize_t, q=cython.Py_ssize_t, d=cython.int)
    cython.declare(total=cython.longlong, errors=cython.p_longlong)
    values: cython.p_const_uchar = cython.address(pixels[0, 0, 0])
    weights: cython.pointer(cython.const[cython.ushort]) = cython.address(visibility[0, 0])
    channels: cython.Py_ssize_t = pixels.shape[2]
    for n in range(length):
        errors = cython.address(band.error[n, 0])
        p = one + n * along
        q = other + n * along
        for k in range(band.error.shape[1]):
            total = 0
            for c in range(channels):
                d = cython.cast(cython.int, values[p * channels + c]) - values[q * channels + c]
                total += d * d
            errors[k] = (cython.cast(cython.longlong, weights[p]) + weights[q]) * total
            p += across
            q += across


def find_corners(
    pixels: cython.const[cython.uchar][:, :, ::1],
    visibility: cython.const[cython.ushort][:, ::1],
    slack: cython.Py_ssize_t,
    state: cython.const[cython.uchar][:, ::1],
    vertices: cython.const[cython.longlong][:, ::1],
    band: Band,
    corners: cython.int[:, ::1],
):
    """Find where four blocks meet: at most `slack` from their common vertex, either way.

    A row of `vertices` has where the two drawn blocks begin, and y and x in `state`. A row of
    `corners` gets (dy, dx) of the box that differs least. Pixels off a hole do not count.
    """
    cython.declare(n=cython.Py_ssize_t, v=cython.Py_ssize_t, u=cython.Py_ssize_t)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(total=cython.longlong, least=cython.longlong)
    depth: cython.Py_ssize_t = band.error.shape[1]
    reach: cython.Py_ssize_t = depth // 2
    box: cython.Py_ssize_t = min(BOX, reach - slack)
    with cython.nogil:
        for n in range(vertices.shape[0]):
            compare(
                pixels, visibility, vertices[n, 0], vertices[n, 1], pixels.shape[1], 1, depth, band
            )
            for v in range(depth if state.shape[0] else 0):
                for u in range(depth):
                    if state[vertices[n, 2] + v, vertices[n, 3] + u] == OFF:
                        band.error[v, u] = 0
            least = -1
            for y in range(-slack, slack + 1):
                for x in range(-slack, slack + 1):
                    total = 0
                    for v in range(reach + y - box, reach + y + box):
                        for u in range(reach + x - box, reach + x + box):
                            total += band.error[v, u]
                    total = total * 1024 + y * y + x * x  # of equal ones the nearest to the vertex
                    if least < 0 or total < least:
                        least = total
                        corners[n, 0] = cython.cast(cython.int, y)
                        corners[n, 1] = cython.cast(cython.int, x)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def least_boundary(
    band: Band, length: cython.Py_ssize_t, depth: cython.Py_ssize_t,
    begin: cython.Py_ssize_t, end: cython.Py_ssize_t,
) -> cython.void:  # fmt: skip
    """Find the cheapest boundary along a band between two given positions.

    Line i belongs to one side up to path[i]. The pixels on both sides of each piece count, also
    where it crosses lines; it moves one position a line, and can always reach both ends.
    """
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, low=cython.Py_ssize_t)
    cython.declare(high=cython.Py_ssize_t, left=cython.longlong)
    for k in range(depth + 1):
        band.total[0, k] = NEVER
    band.total[0, begin] = 0
    band.came[0, begin] = cython.cast(cython.int, begin)
    for i in range(1, length):
        low = max(1, begin - i, end - (length - 1 - i))
        high = min(depth - 1, begin + i, end + (length - 1 - i))
        for k in range(depth + 1):
            band.total[i, k] = band.total[i - 1, k]
            band.came[i, k] = cython.cast(cython.int, k)
        for k in range(1, depth + 1):  # across to the right, then to the left
            if band.total[i, k - 1] < NEVER:
                left = band.total[i, k - 1]
                left += band.error[i - 1, k - 1] + band.error[i, k - 1]
                if left < band.total[i, k]:
                    band.total[i, k] = left
                    band.came[i, k] = band.came[i, k - 1]
        for k in range(depth - 1, -1, -1):
            if band.total[i, k + 1] < NEVER:
                left = band.total[i, k + 1] + band.error[i - 1, k] + band.error[i, k]
                if left < band.total[i, k]:
                    band.total[i, k] = left
                    band.came[i, k] = band.came[i, k + 1]
        for k in range(depth + 1):
            if k < low or k > high:
                band.total[i, k] = NEVER
            elif band.total[i, k] < NEVER:
                band.total[i, k] += band.error[i, k - 1] + band.error[i, k]
                if band.beyond.shape[0]:
                    band.total[i, k] += band.beyond[i, k]
    k = end
    for i in range(length - 1, -1, -1):
        band.path[i] = cython.cast(cython.int, k)
        k = band.came[i, k]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def continues(
    pixels: cython.const[cython.uchar][:, :, ::1],
    visibility: cython.const[cython.ushort][:, ::1],
    at: cython.Py_ssize_t,
    known: cython.const[cython.uchar][:, :, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
) -> cython.longlong:
    """Twice the weighted difference of a pixel of the sample and a known pixel of the canvas."""
    cython.declare(k=cython.Py_ssize_t, d=cython.longlong)
    v: cython.Py_ssize_t = at // pixels.shape[1]
    u: cython.Py_ssize_t = at % pixels.shape[1]
    total: cython.longlong = 0
    for k in range(pixels.shape[2]):
        d = cython.cast(cython.int, pixels[v, u, k]) - known[y, x, k]
        total += d * d
    return 4 * total * visibility[v, u]


def cut_edges(
    pixels: cython.const[cython.uchar][:, :, ::1],
    visibility: cython.const[cython.ushort][:, ::1],
    upright: cython.bint,
    known: cython.const[cython.uchar][:, :, ::1],
    state: cython.const[cython.uchar][:, ::1],
    edges: cython.const[cython.longlong][:, ::1],
    band: Band,
    paths: cython.int[:, ::1],
):
    """Cut along edges of blocks: for each line of a window the pixel where the second one begins.

    A row of `edges` has where the two blocks begin, the first line and the number of lines, the
    first and last place of the path, and y and x in `state`. In a hole, differences of known
    pixels do not count, but how well either block continues into those beside the hole does.
    """
    cython.declare(e=cython.Py_ssize_t, n=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(t=cython.Py_ssize_t, start=cython.Py_ssize_t, length=cython.Py_ssize_t)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, kind=cython.int)
    width: cython.Py_ssize_t = pixels.shape[1]
    along: cython.Py_ssize_t = width if upright else 1
    across: cython.Py_ssize_t = 1 if upright else width
    depth: cython.Py_ssize_t = band.error.shape[1]
    with cython.nogil:
        for e in range(edges.shape[0]):
            start = edges[e, 2]
            length = edges[e, 3]
            compare(pixels, visibility, edges[e, 0], edges[e, 1], along, across, length, band)
            for n in range(length if state.shape[0] else 0):
                band.beyond[n, 0] = 0
                for k in range(depth):
                    y = edges[e, 6] + (n if upright else k)
                    x = edges[e, 7] + (k if upright else n)
                    kind = state[y, x]
                    band.beyond[n, k + 1] = band.beyond[n, k]
                    if kind == OFF:
                        band.error[n, k] = 0
                    if kind == BESIDE:  # a path past this pixel leaves it to the first block
                        t = n * along + k * across
                        band.beyond[n, k + 1] += continues(
                            pixels, visibility, edges[e, 0] + t, known, y, x
                        ) - continues(pixels, visibility, edges[e, 1] + t, known, y, x)
            least_boundary(band, length, depth, edges[e, 4], edges[e, 5])
            for t in range(paths.shape[1]):
                if t < start:
                    paths[e, t] = cython.cast(cython.int, edges[e, 4])
                elif t >= start + length:
                    paths[e, t] = cython.cast(cython.int, edges[e, 5])
                else:
                    paths[e, t] = band.path[t - start]
