# mypy: ignore-errors
"""The kernel that copies pixels of any kind; compiled by Cython, see setup.py."""

import cython
from cython.cimports.libc.string import memcpy


def copy_pixels(
    out: cython.uchar[:, ::1],
    source: cython.const[cython.uchar][:, ::1],
    index: cython.const[cython.int][:, :],
    width: cython.Py_ssize_t,
    scale: cython.Py_ssize_t,
):
    """Copy blocks of `scale` x `scale` pixels from the sample, neighbors in a row at once.

    `out` and `source` are rows of bytes; `index` (H, W) is y * width + x, -1 keeps what is there.
    """
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, run=cython.Py_ssize_t)
    cython.declare(r=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(limit=cython.Py_ssize_t)
    columns: cython.Py_ssize_t = index.shape[1]
    size: cython.Py_ssize_t = source.shape[1] // width  # bytes of a block's row
    with cython.nogil:
        for v in range(index.shape[0]):
            u = 0
            while u < columns:
                if index[v, u] < 0:
                    u += 1
                    continue
                y = index[v, u] // width
                x = index[v, u] % width
                limit = min(columns - u, width - x)
                run = 1
                while run < limit and index[v, u + run] == index[v, u] + run:
                    run += 1
                for r in range(scale):
                    memcpy(
                        cython.address(out[v * scale + r, u * size]),
                        cython.address(source[y * scale + r, x * size]),
                        run * size,
                    )
                u += run
