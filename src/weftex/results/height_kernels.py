# mypy: ignore-errors
"""The kernel that compares slopes; compiled by Cython, see setup.py."""

import cython


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def led(
    sample: cython.const[cython.double][:, :, ::1],
    coordinates: cython.const[cython.int][:, :, :, ::1],
    shares: cython.const[cython.float][:, :, ::1],
    v: cython.Py_ssize_t,
    u: cython.Py_ssize_t,
    axis: cython.int,
    way: cython.int,
    slope: cython.pointer(cython.double),
) -> cython.double:
    """Add the slopes that lead on from a pixel's sources (way 1) or to them (-1).

    The sum of their shares comes back; sources at the sample's border lead nowhere.
    """
    cython.declare(k=cython.Py_ssize_t, c=cython.Py_ssize_t, sure=cython.double)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(b=cython.Py_ssize_t, a=cython.Py_ssize_t)
    sure = 0
    for k in range(shares.shape[2]):
        if shares[v, u, k] <= 0:
            continue
        y = coordinates[v, u, k, 0]
        x = coordinates[v, u, k, 1]
        b = y + way if axis == 0 else y
        a = x if axis == 0 else x + way
        if b < 0 or a < 0 or b >= sample.shape[0] or a >= sample.shape[1]:
            continue
        for c in range(sample.shape[2]):
            slope[c] += way * shares[v, u, k] * (sample[b, a, c] - sample[y, x, c])
        sure += shares[v, u, k]
    return sure


def compare_slopes(
    total: cython.double[:, :, ::1],
    made: cython.const[cython.double][:, :, ::1],
    sample: cython.const[cython.double][:, :, ::1],
    coordinates: cython.const[cython.int][:, :, :, ::1],
    shares: cython.const[cython.float][:, :, ::1],
    rows: cython.Py_ssize_t,
    around: cython.bint,
    slope: cython.double[::1],
):
    """For each edge add g - h' to the pixel that it leads to, and take it from the other.

    Parameters
    ----------
    total, made : float64 array (rows or rows + 1, columns, channels)
        What is added to, and the heights as they were laid; there may be a row below.
    sample : float64 array (H, W, channels)
    coordinates, shares : int32, float32 array
        Of `made`, as `Synthesis.layers` returns them.
    rows : int
        Those whose edges count.
    around : bool
        The last column is followed by the first.
    slope : float64 array (channels,)
        Scratch.
    """
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, c=cython.Py_ssize_t)
    cython.declare(b=cython.Py_ssize_t, a=cython.Py_ssize_t, axis=cython.int)
    cython.declare(sure=cython.double, step=cython.double)
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
                    # Within one piece slopes are the sample's.
                    if (
                        shares[v, u, 0] == 1
                        and shares[b, a, 0] == 1
                        and coordinates[b, a, 0, 0] == coordinates[v, u, 0, 0] + (axis == 0)
                        and coordinates[b, a, 0, 1] == coordinates[v, u, 0, 1] + (axis == 1)
                    ):
                        continue
                    for c in range(slope.shape[0]):
                        slope[c] = 0
                    sure = led(sample, coordinates, shares, v, u, axis, 1, cython.address(slope[0]))
                    sure += led(
                        sample, coordinates, shares, b, a, axis, -1, cython.address(slope[0])
                    )
                    if sure <= 0:
                        continue
                    for c in range(slope.shape[0]):
                        step = slope[c] / sure - (made[b, a, c] - made[v, u, c])
                        total[b, a, c] += step
                        total[v, u, c] -= step
