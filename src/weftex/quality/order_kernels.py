# mypy: ignore-errors
"""Kernel that finds what lies at given ranks; compiled by Cython, see setup.py."""

import cython

BITS = cython.declare(cython.int, 11)  # of a digit: 2**11 counts stay in the nearest cache


def at_ranks(
    values: cython.const[cython.int][:, ::1],
    ranks: cython.const[cython.longlong][::1],
    counts: cython.int[::1],
    room: cython.uint[:, ::1],
    out: cython.int[:, ::1],
):
    """Find the values of each row that sorting would put at some places.

    Values of a narrow range are counted, others are sorted by their digits, the lowest first.

    Parameters
    ----------
    values : int32 array (n, m)
        The difference of any two of a row is less than 2**31.
    ranks : int64 array (k,)
        From 0 to m - 1, rising.
    counts : int32 array (2**11 or more,)
        Scratch: as long as the range that is counted.
    room : uint32 array (2, m)
        Scratch.
    out : int32 array (n, k)
    """
    cython.declare(row=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(low=cython.int, high=cython.int, span=cython.uint, v=cython.Py_ssize_t)
    cython.declare(seen=cython.Py_ssize_t, bits=cython.int, width=cython.int, shift=cython.int)
    cython.declare(here=cython.p_uint, there=cython.p_uint, swap=cython.p_uint)
    cython.declare(mask=cython.uint, at=cython.int, digit=cython.uint)
    size: cython.Py_ssize_t = values.shape[1]
    with cython.nogil:
        for row in range(values.shape[0]):
            low = high = values[row, 0]
            for i in range(size):
                low = min(low, values[row, i])
                high = max(high, values[row, i])
            span = cython.cast(cython.uint, high - low)
            if span < counts.shape[0]:
                for v in range(span + 1):
                    counts[v] = 0
                for i in range(size):
                    counts[values[row, i] - low] += 1
                seen = 0
                k = 0
                for v in range(span + 1):
                    seen += counts[v]
                    while k < ranks.shape[0] and ranks[k] < seen:
                        out[row, k] = low + cython.cast(cython.int, v)
                        k += 1
                continue
            bits = 0
            while bits < 32 and span >> bits:
                bits += 1
            width = (bits + BITS - 1) // BITS  # digits, and then bits of each
            width = (bits + width - 1) // width
            mask = (1 << width) - 1
            here = cython.address(room[0, 0])
            there = cython.address(room[1, 0])
            for i in range(size):
                here[i] = cython.cast(cython.uint, values[row, i] - low)
            shift = 0
            while shift < bits:
                for v in range(mask + 1):
                    counts[v] = 0
                for i in range(size):
                    counts[(here[i] >> shift) & mask] += 1
                at = 0
                for v in range(mask + 1):
                    at += counts[v]
                    counts[v] = at - counts[v]
                for i in range(size):
                    digit = (here[i] >> shift) & mask
                    there[counts[digit]] = here[i]
                    counts[digit] += 1
                swap = here
                here = there
                there = swap
                shift += width
            for k in range(ranks.shape[0]):
                out[row, k] = low + cython.cast(cython.int, here[ranks[k]])
