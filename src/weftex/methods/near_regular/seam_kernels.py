# mypy: ignore-errors
"""Kernels of near-regular synthesis: where blocks meet; compiled, see setup.py.

Two blocks overlap in a band, `depth` pixels deep. `state` and `known` have the canvas's pixels
around a hole, and are empty without a hole. Positions in a band are flat indices into the sample.
"""

import cython
from cython.cimports.weftex.seams.boundary_kernels import Band, least_boundary, pixel_difference

BOX = cython.declare(cython.Py_ssize_t, 3)  # half the side of what is compared at a corner
BESIDE = cython.declare(cython.int, 1)  # the state of a known pixel beside a hole; 0 in the hole
OFF = cython.declare(cython.int, 2)  # the state of any other


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
    v: cython.Py_ssize_t = at // pixels.shape[1]
    u: cython.Py_ssize_t = at % pixels.shape[1]
    weight: cython.longlong = 2 * visibility[v, u]
    return 2 * weight * pixel_difference(pixels, v, u, known, y, x)
