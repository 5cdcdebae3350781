# mypy: ignore-errors
# cython: infer_types=True
"""Kernels that compare slopes and shift values; compiled by Cython, see setup.py."""

import cython
from cython.cimports.libc.math import rint
from cython.cimports.weftex.results.paste_kernels import value


def difference(one, other):
    """How much more the one is."""
    return cython.cast(cython.double, one) - cython.cast(cython.double, other)


def led(sample, coordinates, shares, part, v, u, axis, way, slope):
    """Add the slopes from a pixel's sources (way 1) or to them (-1); return the sum of shares."""
    sure: cython.double = 0
    for k in range(shares.shape[2]):
        if shares[v, u, k] <= 0:
            continue
        y = coordinates[v, u, k, 0]
        x = coordinates[v, u, k, 1]
        b = y + way if axis == 0 else y
        a = x if axis == 0 else x + way
        if b < 0 or a < 0 or b >= sample.shape[0] or a >= sample.shape[1]:
            continue
        if part[b, a] != part[y, x]:
            continue
        for c in range(sample.shape[2]):
            slope[c] += way * shares[v, u, k] * difference(sample[b, a, c], sample[y, x, c])
        sure += shares[v, u, k]
    return sure


def compare_slopes(
    total: cython.double[:, :, ::1],
    made: cython.const[value][:, :, ::1],
    sample: cython.const[value][:, :, ::1],
    coordinates: cython.const[cython.int][:, :, :, ::1],
    shares: cython.const[cython.float][:, :, ::1],
    rows: cython.Py_ssize_t,
    around: cython.bint,
    scale: cython.int,
    slope: cython.double[::1],
    part: cython.const[cython.ushort][:, :],
):
    """For each edge, add g - h' to the pixel it leads to and subtract it from the other one.

    `total` is (channels, rows[+1], columns), `made` (rows[+1], columns, channels), `coordinates`
    and `shares` are the layers of `made`, `scale` times as fine as the output. With `around` the
    last column is followed by the first. Pixels of another `part` are not compared.
    """
    with cython.nogil:
        for v in range(rows):
            for u in range(made.shape[1]):
                for axis in range(2):
                    b = v + 1 if axis == 0 else v
                    a = u if axis == 0 else u + 1
                    if b == made.shape[0] or (a == made.shape[1] and not around):
                        continue
                    if a == made.shape[1]:
                        a = 0
                    # Within one piece slopes are the sample's, also where a line of pixels is left
                    # out, doubled or shifted by a pixel.
                    gap = coordinates[b, a, 0, axis] - coordinates[v, u, 0, axis] - 1
                    off = coordinates[b, a, 0, 1 - axis] - coordinates[v, u, 0, 1 - axis]
                    if (
                        shares[v, u, 0] == 1
                        and shares[b, a, 0] == 1
                        and (gap == 0 or gap == scale or gap == -scale)
                        and (off == 0 or off == scale or off == -scale)
                    ):
                        continue
                    here = cython.address(coordinates[v, u, 0, 0])
                    there = cython.address(coordinates[b, a, 0, 0])
                    if part[here[0], here[1]] != part[there[0], there[1]]:
                        continue
                    for c in range(slope.shape[0]):
                        slope[c] = 0
                    to = cython.address(slope[0])
                    sure = led(sample, coordinates, shares, part, v, u, axis, 1, to)
                    sure += led(sample, coordinates, shares, part, b, a, axis, -1, to)
                    if sure <= 0:
                        continue
                    for c in range(slope.shape[0]):
                        step = slope[c] / sure - difference(made[b, a, c], made[v, u, c])
                        total[c, b, a] += step
                        total[c, v, u] -= step


def add_shifts(
    result: value[:, :, :],
    shifts: cython.const[cython.double][:, :, :],
    least: cython.const[cython.double][::1],
    most: cython.const[cython.double][::1],
    grain: cython.double,
):
    """Add shifts (channels, H, W) to values (H, W, channels) and clip each channel to its range.

    For integers the shifts are rounded to 1 / `grain` first.
    """
    number: cython.double
    with cython.nogil:
        for c in range(result.shape[2]):
            for v in range(result.shape[0]):
                for u in range(result.shape[1]):
                    number = shifts[c, v, u]
                    if value is cython.uchar or value is cython.ushort:
                        number = rint(result[v, u, c] + rint(number * grain) / grain)
                        number = min(max(number, least[c]), most[c])
                        result[v, u, c] = cython.cast(cython.int, number)
                    else:
                        number = min(max(result[v, u, c] + number, least[c]), most[c])
                        result[v, u, c] = number


def solve_screened(
    shifts: cython.double[:, ::1],
    steps: cython.const[cython.double][:, ::1],
    beside: cython.const[cython.int][:, ::1],
    diagonal: cython.const[cython.double][::1],
    relaxation: cython.double,
    sweeps: cython.Py_ssize_t,
):
    """Solve diagonal x shifts - shifts beside = steps by successive over-relaxation, in place.

    `beside` has the numbers of neighbors, -1 for none; `shifts` and `steps` are (channels, n).
    """
    total: cython.double
    with cython.nogil:
        for c in range(steps.shape[0]):
            for sweep in range(sweeps):
                for i in range(steps.shape[1]):
                    total = steps[c, i]
                    for k in range(4):
                        if beside[i, k] >= 0:
                            total += shifts[c, beside[i, k]]
                    shifts[c, i] += relaxation * (total / diagonal[i] - shifts[c, i])
