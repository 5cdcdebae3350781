# mypy: ignore-errors
"""Kernels of the figures: patches and windows; see setup.py.

Sums are of integers that 32 bits hold, so they are the same on every machine.
"""

import cython


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def product(
    a: cython.p_const_short, b: cython.p_const_short, count: cython.Py_ssize_t
) -> cython.int:
    """Return the dot product of two rows."""
    cython.declare(k=cython.Py_ssize_t, total=cython.int)
    total = 0
    for k in range(count):
        total += cython.cast(cython.int, a[k]) * b[k]
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def products(
    a: cython.p_const_short,
    b: cython.p_const_short,
    count: cython.Py_ssize_t,
    apart: cython.Py_ssize_t,
    found: cython.p_int,
) -> cython.void:
    """Write the dot products with four rows that are `apart` numbers apart."""
    cython.declare(k=cython.Py_ssize_t, one=cython.int)
    cython.declare(p=cython.int, q=cython.int, r=cython.int, s=cython.int)
    p = q = r = s = 0
    for k in range(count):
        one = a[k]
        p += one * b[k]
        q += one * b[apart + k]
        r += one * b[2 * apart + k]
        s += one * b[3 * apart + k]
    found[0] = p
    found[1] = q
    found[2] = r
    found[3] = s


def describe(
    pixels: cython.const[cython.uchar][:, :, ::1],
    corners: cython.const[cython.longlong][::1],
    width: cython.Py_ssize_t,
    features: cython.const[cython.short][:, ::1],
    patch: cython.short[::1],
    out: cython.int[:, ::1],
):
    """Write the weighted sums (4 * f, n) of the bytes of n square patches.

    `corners` are flat indices of the upper left pixels; `features` (4 * f, m) the weights of a
    patch's bytes, row by row; `patch` (m,) is scratch, 0 beyond the patch's bytes.
    """
    cython.declare(i=cython.Py_ssize_t, f=cython.Py_ssize_t, v=cython.Py_ssize_t)
    cython.declare(k=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(row=cython.p_const_uchar, sums=cython.int[4])
    run: cython.Py_ssize_t = width * pixels.shape[2]
    size: cython.Py_ssize_t = patch.shape[0]
    with cython.nogil:
        for i in range(corners.shape[0]):
            y = corners[i] // pixels.shape[1]
            x = corners[i] % pixels.shape[1]
            for v in range(width):
                row = cython.address(pixels[y + v, x, 0])
                for k in range(run):
                    patch[v * run + k] = row[k]
            for f in range(0, features.shape[0], 4):
                products(cython.address(patch[0]), cython.address(features[f, 0]), size, size, sums)
                for k in range(4):
                    out[f + k, i] = sums[k]


def nearest(
    first: cython.const[cython.short][:, ::1],
    second: cython.const[cython.short][:, ::1],
    places: cython.const[cython.int][:, ::1],
    others: cython.const[cython.int][:, ::1],
    least: cython.Py_ssize_t,
    best: cython.int[::1],
    which: cython.int[::1],
    squares: cython.int[::1],
):
    """Find for each window (n, m) the nearest of others, the first of equals.

    `second` (4 * k, m) may end with rows that do not count; `places` and `others` are rows and
    columns; windows less than `least` rows and columns apart are not compared. `best` gets squared
    distances, -1 for none, `which` indices; `squares` (4 * k,) is scratch.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, found=cython.int, own=cython.int)
    cython.declare(sums=cython.int[4], row=cython.p_const_short, d=cython.int)
    size: cython.Py_ssize_t = first.shape[1]
    with cython.nogil:
        for j in range(second.shape[0]):
            row = cython.address(second[j, 0])
            squares[j] = product(row, row, size)
        for i in range(first.shape[0]):
            row = cython.address(first[i, 0])
            own = product(row, row, size)
            found = -1
            which[i] = -1
            for j in range(0, second.shape[0], 4):
                products(row, cython.address(second[j, 0]), size, size, sums)
                for k in range(4):
                    if j + k >= others.shape[0]:
                        break
                    y = others[j + k, 0] - places[i, 0]
                    x = others[j + k, 1] - places[i, 1]
                    if -least < y and y < least and -least < x and x < least:
                        continue
                    d = own + squares[j + k] - 2 * sums[k]
                    if found < 0 or d < found:
                        found = d
                        which[i] = cython.cast(cython.int, j + k)
            best[i] = found
