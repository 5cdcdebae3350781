# mypy: ignore-errors
"""Kernels of near-regular synthesis: where blocks meet; compiled, see setup.py.

Two blocks overlap in a band, `depth` pixels deep. Positions in it are flat indices into the sample.
"""

import cython

BOX = cython.declare(cython.Py_ssize_t, 3)  # half the side of what is compared at a corner
NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any boundary costs


#: Where two drawn blocks begin, in the sample, that a corner is compared by.
Vertex = cython.struct(one=cython.longlong, other=cython.longlong)
#: Where two blocks begin, the first line of their edge and the number of lines, and where the path
#: begins and ends.
Edge = cython.struct(
    one=cython.longlong,
    other=cython.longlong,
    start=cython.longlong,
    length=cython.longlong,
    begin=cython.longlong,
    end=cython.longlong,
)


@cython.cclass
class Band:
    """The costs of a band: `error` (lines, depth).

    `total`, `came` are scratch; `path` (lines,) receives the boundary.
    """

    error: cython.longlong[:, ::1]
    total: cython.longlong[:, ::1]
    came: cython.int[:, ::1]
    path: cython.int[::1]

    def __init__(self, error, total, came, path):
        self.error, self.total, self.came, self.path = error, total, came, path


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
    vertices: cython.const[Vertex][::1],
    band: Band,
    corners: cython.int[:, ::1],
):
    """Find where four blocks meet: at most `slack` from their common vertex, either way.

    A row of `corners` gets (dy, dx) of the box that differs least.
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
                pixels, visibility, vertices[n].one, vertices[n].other, pixels.shape[1], 1, depth,
                band,
            )  # fmt: skip
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
    k = end
    for i in range(length - 1, -1, -1):
        band.path[i] = cython.cast(cython.int, k)
        k = band.came[i, k]


def cut_edges(
    pixels: cython.const[cython.uchar][:, :, ::1],
    visibility: cython.const[cython.ushort][:, ::1],
    upright: cython.bint,
    edges: cython.const[Edge][::1],
    band: Band,
    paths: cython.int[:, ::1],
):
    """Cut along edges: `paths` gets the pixel of each line of a window where the second begins."""
    cython.declare(e=cython.Py_ssize_t, t=cython.Py_ssize_t)
    cython.declare(start=cython.Py_ssize_t, length=cython.Py_ssize_t)
    width: cython.Py_ssize_t = pixels.shape[1]
    along: cython.Py_ssize_t = width if upright else 1
    across: cython.Py_ssize_t = 1 if upright else width
    depth: cython.Py_ssize_t = band.error.shape[1]
    with cython.nogil:
        for e in range(edges.shape[0]):
            start = edges[e].start
            length = edges[e].length
            compare(pixels, visibility, edges[e].one, edges[e].other, along, across, length, band)
            least_boundary(band, length, depth, edges[e].begin, edges[e].end)
            for t in range(paths.shape[1]):
                if t < start:
                    paths[e, t] = cython.cast(cython.int, edges[e].begin)
                elif t >= start + length:
                    paths[e, t] = cython.cast(cython.int, edges[e].end)
                else:
                    paths[e, t] = band.path[t - start]
