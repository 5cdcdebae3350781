# mypy: ignore-errors
"""Kernels that find connected pieces and look at their joints; compiled by Cython, see setup.py."""

import cython


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def root(parents: cython.p_int, i: cython.int) -> cython.int:
    """The first pixel of what is known to hang together with a pixel."""
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def join(parents: cython.p_int, i: cython.int, j: cython.int) -> cython.void:
    i = root(parents, i)
    j = root(parents, j)
    if i < j:
        parents[j] = i
    else:
        parents[i] = j


def number_pieces(
    shift: cython.const[cython.int][:, :, ::1],
    known: cython.const[cython.uchar][:, ::1],
    names: cython.int[:, ::1],
) -> cython.Py_ssize_t:
    """Number the connected areas of one shift in the order of their first pixels.

    Parameters
    ----------
    shift : int32 array (H, W, 2)
    known : uint8 array (H, W)
        0 where a pixel is an area of its own.
    names : int32 array (H, W)
        The numbers.

    Returns
    -------
    int
        How many there are.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, i=cython.int, count=cython.int)
    width: cython.int = cython.cast(cython.int, shift.shape[1])
    size: cython.int = cython.cast(cython.int, shift.shape[0] * shift.shape[1])
    parents: cython.p_int = cython.address(names[0, 0])
    count = 0
    with cython.nogil:
        for i in range(size):
            parents[i] = i
        for y in range(shift.shape[0]):
            for x in range(shift.shape[1]):
                if not known[y, x]:
                    continue
                i = cython.cast(cython.int, y * width + x)
                if (
                    x > 0
                    and known[y, x - 1]
                    and shift[y, x, 0] == shift[y, x - 1, 0]
                    and shift[y, x, 1] == shift[y, x - 1, 1]
                ):
                    join(parents, i - 1, i)
                if (
                    y > 0
                    and known[y - 1, x]
                    and shift[y, x, 0] == shift[y - 1, x, 0]
                    and shift[y, x, 1] == shift[y - 1, x, 1]
                ):
                    join(parents, i - width, i)
        # A pixel's parent is never after it, so it has its number already.
        for i in range(size):
            if parents[i] == i:
                parents[i] = count
                count += 1
            else:
                parents[i] = parents[parents[i]]
    return count


def differ_at_joints(
    own: cython.const[cython.uchar][:, :, ::1],
    made: cython.const[cython.uchar][:, :, ::1],
    source: cython.const[cython.int][:, :, ::1],
    found: cython.longlong[::1],
):
    """Add up the squared differences of colors where two pieces meet.

    Each of the two pixels is compared with the one that would continue the other's piece in the
    sample; the lesser difference counts.

    Parameters
    ----------
    own : uint8 array (h, w, K)
        The sample.
    made : uint8 array (H, W, K)
    source : int32 array (H, W, 2)
        Where in the sample its pixels are from; negative for nowhere.
    found : int64 array (2,)
        Zeros, to which the sum and the number of joints are added.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(axis=cython.Py_ssize_t, way=cython.Py_ssize_t, v=cython.Py_ssize_t)
    cython.declare(u=cython.Py_ssize_t, b=cython.Py_ssize_t, a=cython.Py_ssize_t)
    cython.declare(d=cython.int, differs=cython.longlong, least=cython.longlong)
    with cython.nogil:
        for y in range(made.shape[0]):
            for x in range(made.shape[1]):
                if source[y, x, 0] < 0:
                    continue
                for axis in range(2):
                    b = y + 1 - axis
                    a = x + axis
                    if b == made.shape[0] or a == made.shape[1] or source[b, a, 0] < 0:
                        continue
                    if (
                        source[b, a, 0] == source[y, x, 0] + 1 - axis
                        and source[b, a, 1] == source[y, x, 1] + axis
                    ):
                        continue
                    least = -1
                    for way in range(2):
                        if way == 0:  # on from the first pixel's source
                            v = source[y, x, 0] + 1 - axis
                            u = source[y, x, 1] + axis
                        else:
                            v = source[b, a, 0] - 1 + axis
                            u = source[b, a, 1] - axis
                        if v < 0 or u < 0 or v >= own.shape[0] or u >= own.shape[1]:
                            continue
                        differs = 0
                        for k in range(own.shape[2]):
                            d = cython.cast(cython.int, own[v, u, k])
                            d -= made[b, a, k] if way == 0 else made[y, x, k]
                            differs += d * d
                        if least < 0 or differs < least:
                            least = differs
                    if least >= 0:
                        found[0] += least
                        found[1] += 1


def count_different(
    index: cython.const[cython.int][:, ::1],
    boxes: cython.const[cython.longlong][:, ::1],
    seen: cython.int[::1],
    counts: cython.longlong[:, ::1],
):
    """Count different numbers in parts of a picture.

    Parameters
    ----------
    index : int32 array (H, W)
        Numbers; negative ones do not count.
    boxes : int64 array (n, 4)
        First row and column of each part, and those after its last.
    seen : int32 array (m,)
        Scratch, of zeros; all numbers are below m.
    counts : int64 array (n, 2)
        Different numbers, and all that count.
    """
    cython.declare(n=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(name=cython.int, different=cython.longlong, every=cython.longlong)
    with cython.nogil:
        for n in range(boxes.shape[0]):
            different = every = 0
            for y in range(boxes[n, 0], boxes[n, 2]):
                for x in range(boxes[n, 1], boxes[n, 3]):
                    name = index[y, x]
                    if name < 0:
                        continue
                    every += 1
                    if seen[name] != n + 1:
                        seen[name] = cython.cast(cython.int, n + 1)
                        different += 1
            counts[n, 0] = different
            counts[n, 1] = every
