# mypy: ignore-errors
"""What boxes of an output repeat of the sample; compiled by Cython, see setup.py and the .pxd."""

import cython


def exclude_repeats(placements, around, p, apart, leave, places, width, excluded):
    """Mark places that box `p` must not show: nearer than `apart` to the source of a box around.

    `placements` are y, x and source y, x; `around` numbers boxes, -1 for none. A place that
    continues one repeats nothing; it is marked, too, where the box is to `leave` what it continues.
    """
    this: cython.p_const_int = cython.address(placements[p, 0])
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, repeated=cython.longlong)
    cython.declare(other=cython.p_const_int, mark=cython.uchar)
    for i in range(places.shape[0]):
        mark = 0
        for k in range(around.shape[0]):
            if around[k] < 0:
                continue
            other = cython.address(placements[around[k], 0])
            repeated = repeated_pixels(
                places[i] // width - other[2], places[i] % width - other[3],
                this[0] - other[0], this[1] - other[1], apart, apart,
            )  # fmt: skip
            if repeated > 0:
                mark = REPEATS
                break
            if repeated < 0 and leave:
                mark = CONTINUES
                break
        excluded[i] = mark


def best_unrepeated(keys, excluded, dearer):
    """Return the best place without a mark, unless its key is above `dearer` times the best of all.

    If it is, places that continue no box are freed; if there are none, all are.
    """
    best: cython.Py_ssize_t = -1
    near: cython.Py_ssize_t = -1
    free: cython.Py_ssize_t = -1
    i: cython.Py_ssize_t
    for i in range(keys.shape[0]):
        if best < 0 or keys[i] < keys[best]:
            best = i
        if excluded[i] < CONTINUES and (near < 0 or keys[i] < keys[near]):
            near = i
        if not excluded[i] and (free < 0 or keys[i] < keys[free]):
            free = i
    if near >= 0:
        best = near
    if free >= 0 and keys[free] <= dearer * keys[best]:
        return free
    for i in range(keys.shape[0]):
        excluded[i] = 0 if excluded[i] < CONTINUES or near < 0 else CONTINUES
    return best
