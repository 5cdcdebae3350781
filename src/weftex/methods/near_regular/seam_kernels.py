# mypy: ignore-errors
"""Kernels of near-regular synthesis: where blocks meet; compiled, see setup.py.

Places are as in `block_kernels`. Seams stay within `reach` of the edges of blocks.
"""

import cython
from cython.cimports.weftex.methods.near_regular.block_kernels import Grid, around

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any path costs
BESIDE = cython.declare(cython.int, 1)  # the state of a known pixel beside a hole; 0 in the hole
OFF = cython.declare(cython.int, 2)  # the state of any other


@cython.cclass
class Shown:
    """The pixels that seams look at, how much a seam shows at each, and the blocks' places."""

    pixels: cython.const[cython.uchar][:, :, ::1]
    visibility: cython.const[cython.ushort][:, ::1]
    place: cython.const[cython.int][:, ::1]

    def __init__(self, pixels, visibility, place):
        self.pixels, self.visibility, self.place = pixels, visibility, place


@cython.cclass
class Hole:
    """The canvas's known pixels, and the state of each; both are empty without a hole."""

    known: cython.const[cython.uchar][:, :, ::1]
    state: cython.const[cython.uchar][:, ::1]

    def __init__(self, known, state):
        self.known, self.state = known, state


@cython.cclass
class Seams:
    """How far seams go, and what is found: corners, and where blocks begin on each line.

    `inset` is how far inside of a window its outermost seam is, `slack` how far corners move,
    `box` half the side of what is compared for that; block (0, 0) is a gap if `parity` is odd.
    upright[i, j] and lying[i, j] say for each line of the window of block (i, j) where in it the
    block begins, from the left and from above.
    """

    inset: cython.Py_ssize_t
    reach: cython.Py_ssize_t
    slack: cython.Py_ssize_t
    box: cython.Py_ssize_t
    parity: cython.Py_ssize_t
    corners: cython.int[:, :, ::1]
    upright: cython.int[:, :, ::1]
    lying: cython.int[:, :, ::1]

    def __init__(self, inset, reach, slack, box, parity, corners, upright, lying):
        self.inset, self.reach, self.slack, self.box = inset, reach, slack, box
        self.parity, self.corners, self.upright, self.lying = parity, corners, upright, lying


@cython.cclass
class Scratch:
    """What a thread works on along one band: costs of pixels and places, sums, and the path."""

    error: cython.longlong[:, ::1]
    beyond: cython.longlong[:, ::1]
    total: cython.longlong[:, ::1]
    came: cython.int[:, ::1]
    path: cython.int[::1]

    def __init__(self, error, beyond, total, came, path):
        self.error, self.beyond, self.total, self.came = error, beyond, total, came
        self.path = path


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def squared(
    one: cython.const[cython.uchar][:, :, ::1],
    ay: cython.Py_ssize_t,
    ax: cython.Py_ssize_t,
    other: cython.const[cython.uchar][:, :, ::1],
    by: cython.Py_ssize_t,
    bx: cython.Py_ssize_t,
) -> cython.longlong:
    """Squared difference of two pixels."""
    cython.declare(k=cython.Py_ssize_t, d=cython.int)
    total: cython.longlong = 0
    for k in range(one.shape[2]):
        d = cython.cast(cython.int, one[ay, ax, k]) - other[by, bx, k]
        total += d * d
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def differ(
    shown: Shown,
    ay: cython.Py_ssize_t,
    ax: cython.Py_ssize_t,
    by: cython.Py_ssize_t,
    bx: cython.Py_ssize_t,
) -> cython.longlong:
    """Squared difference of two pixels of the sample, by how much a step shows at them."""
    shows: cython.longlong = shown.visibility[ay, ax] + shown.visibility[by, bx]
    return shows * squared(shown.pixels, ay, ax, shown.pixels, by, bx)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def state_of(hole: Hole, grid: Grid, y: cython.longlong, x: cython.longlong) -> cython.int:
    """HOLE, BESIDE a hole or OFF, which is also all that is not on the canvas."""
    if grid.wrap[0]:
        y = y % grid.wrap[0]
        y = y + grid.wrap[0] if y < 0 else y
    if grid.wrap[1]:
        x = x % grid.wrap[1]
        x = x + grid.wrap[1] if x < 0 else x
    if y < 0 or x < 0 or y >= hole.state.shape[0] or x >= hole.state.shape[1]:
        return OFF
    return hole.state[y, x]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def leaves(
    shown: Shown,
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    hole: Hole,
    v: cython.longlong,
    u: cython.longlong,
) -> cython.longlong:
    """Squared difference, counted twice, of a pixel of the sample and a known one of the canvas."""
    v = v % hole.known.shape[0]
    u = u % hole.known.shape[1]
    v = v + hole.known.shape[0] if v < 0 else v
    u = u + hole.known.shape[1] if u < 0 else u
    shows: cython.longlong = 2 * shown.visibility[y, x]
    return 2 * shows * squared(shown.pixels, y, x, hole.known, v, u)


def meet(
    shown: Shown,
    grid: Grid,
    hole: Hole,
    seams: Seams,
    scratch: Scratch,
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
):
    """Find where four blocks meet: near their common corner, where the two drawn ones agree.

    `seams.corners` gets (dy, dx) for each vertex of rows `first` to `last`, at most the slack
    either way: the place whose box differs least between the two. Pixels off a hole do not count.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, v=cython.Py_ssize_t)
    cython.declare(u=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(above=cython.Py_ssize_t, below=cython.Py_ssize_t)
    cython.declare(left=cython.Py_ssize_t, right=cython.Py_ssize_t)
    cython.declare(a=cython.int, b=cython.int, ay=cython.Py_ssize_t, ax=cython.Py_ssize_t)
    cython.declare(by=cython.Py_ssize_t, bx=cython.Py_ssize_t, drawn=cython.bint)
    cython.declare(height=cython.longlong, breadth=cython.longlong)
    cython.declare(total=cython.longlong, least=cython.longlong)
    width: cython.Py_ssize_t = shown.pixels.shape[1]
    reach: cython.Py_ssize_t = seams.reach
    box: cython.Py_ssize_t = seams.box
    with cython.nogil:
        for i in range(first, last):
            for j in range(seams.corners.shape[1]):
                seams.corners[i, j, 0] = 0
                seams.corners[i, j, 1] = 0
                above = around(grid, 0, i, -1)
                below = around(grid, 0, i, 0)
                left = around(grid, 1, j, -1)
                right = around(grid, 1, j, 0)
                if above < 0 or below < 0 or left < 0 or right < 0 or seams.slack == 0:
                    continue
                height = grid.rows[above + 1] - grid.rows[above]
                breadth = grid.columns[left + 1] - grid.columns[left]
                drawn = (i + j + seams.parity) % 2 == 0  # the one below and to the right
                a = shown.place[above, left] if drawn else shown.place[above, right]
                b = shown.place[below, right] if drawn else shown.place[below, left]
                if a < 0 or b < 0:
                    continue
                ay = a // width + seams.inset + height
                ax = a % width + seams.inset + (breadth if drawn else 0)
                by = b // width + seams.inset
                bx = b % width + seams.inset + (0 if drawn else breadth)
                for v in range(2 * reach):
                    for u in range(2 * reach):
                        scratch.error[v, u] = differ(shown, ay + v, ax + u, by + v, bx + u)
                        if hole.state.shape[0]:
                            y = grid.rows[i] - reach + v
                            x = grid.columns[j] - reach + u
                            if state_of(hole, grid, y, x) == OFF:
                                scratch.error[v, u] = 0
                least = -1
                for y in range(-seams.slack, seams.slack + 1):
                    for x in range(-seams.slack, seams.slack + 1):
                        total = 0
                        for v in range(reach + y - box, reach + y + box):
                            for u in range(reach + x - box, reach + x + box):
                                total += scratch.error[v, u]
                        # Of equal ones the nearest to the corner.
                        total = total * 1024 + y * y + x * x
                        if least < 0 or total < least:
                            least = total
                            seams.corners[i, j, 0] = cython.cast(cython.int, y)
                            seams.corners[i, j, 1] = cython.cast(cython.int, x)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def least_path(
    scratch: Scratch,
    length: cython.Py_ssize_t,
    depth: cython.Py_ssize_t,
    begin: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
) -> cython.void:
    """Find the cheapest boundary along a band between two given places.

    Line i of the band belongs to one side up to path[i] and to the other from there on. Both
    pixels beside every piece of the boundary count, also where it runs across from line to line,
    and for each place on a line what is `beyond`, if anything.
    The path moves at most one place a line, and every place on it can reach both ends in that way,
    so that no two paths of a corner cross.
    """
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, low=cython.Py_ssize_t)
    cython.declare(high=cython.Py_ssize_t, left=cython.longlong)
    for k in range(depth + 1):
        scratch.total[0, k] = NEVER
    scratch.total[0, begin] = 0
    scratch.came[0, begin] = cython.cast(cython.int, begin)
    for i in range(1, length):
        low = max(1, begin - i, end - (length - 1 - i))
        high = min(depth - 1, begin + i, end + (length - 1 - i))
        for k in range(depth + 1):
            scratch.total[i, k] = scratch.total[i - 1, k]
            scratch.came[i, k] = cython.cast(cython.int, k)
        for k in range(1, depth + 1):  # across to the right, then to the left
            if scratch.total[i, k - 1] < NEVER:
                left = scratch.total[i, k - 1]
                left += scratch.error[i - 1, k - 1] + scratch.error[i, k - 1]
                if left < scratch.total[i, k]:
                    scratch.total[i, k] = left
                    scratch.came[i, k] = scratch.came[i, k - 1]
        for k in range(depth - 1, -1, -1):
            if scratch.total[i, k + 1] < NEVER:
                left = scratch.total[i, k + 1] + scratch.error[i - 1, k] + scratch.error[i, k]
                if left < scratch.total[i, k]:
                    scratch.total[i, k] = left
                    scratch.came[i, k] = scratch.came[i, k + 1]
        for k in range(depth + 1):
            if k < low or k > high:
                scratch.total[i, k] = NEVER
            elif scratch.total[i, k] < NEVER:
                scratch.total[i, k] += scratch.error[i, k - 1] + scratch.error[i, k]
                if scratch.beyond.shape[0]:
                    scratch.total[i, k] += scratch.beyond[i, k]
    k = end
    for i in range(length - 1, -1, -1):
        scratch.path[i] = cython.cast(cython.int, k)
        k = scratch.came[i, k]


def cut_edges(
    shown: Shown,
    grid: Grid,
    hole: Hole,
    seams: Seams,
    upright: cython.bint,
    scratch: Scratch,
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
):
    """Cut along the left edges of blocks (`upright`) or their upper ones, rows `first` to `last`.

    Where there is a hole, differences that do not show do not count, but those to known pixels
    beside it do, as if the block went on there.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, p=cython.Py_ssize_t)
    cython.declare(q=cython.Py_ssize_t, s=cython.Py_ssize_t, t=cython.Py_ssize_t)
    cython.declare(n=cython.Py_ssize_t, k=cython.Py_ssize_t, v=cython.Py_ssize_t)
    cython.declare(u=cython.Py_ssize_t, start=cython.Py_ssize_t, stop=cython.Py_ssize_t)
    cython.declare(begin=cython.Py_ssize_t, end=cython.Py_ssize_t)
    cython.declare(size=cython.longlong, length=cython.longlong, a=cython.int, b=cython.int)
    cython.declare(ay=cython.Py_ssize_t, ax=cython.Py_ssize_t)
    cython.declare(by=cython.Py_ssize_t, bx=cython.Py_ssize_t)
    cython.declare(y=cython.longlong, x=cython.longlong, kind=cython.int)
    paths: cython.int[:, :, ::1] = seams.upright if upright else seams.lying
    width: cython.Py_ssize_t = shown.pixels.shape[1]
    inset: cython.Py_ssize_t = seams.inset
    reach: cython.Py_ssize_t = seams.reach
    with cython.nogil:
        for i in range(first, last):
            for j in range(paths.shape[1]):
                for t in range(paths.shape[2]):
                    paths[i, j, t] = cython.cast(cython.int, inset + reach)
                p = around(grid, 0, i, 0 if upright else -1)
                q = around(grid, 1, j, -1 if upright else 0)
                s = around(grid, 0, i, 0)
                t = around(grid, 1, j, 0)
                if p < 0 or q < 0 or s < 0 or t < 0 or reach == 0:
                    continue
                a = shown.place[p, q]
                b = shown.place[s, t]
                if a < 0 or b < 0:
                    continue
                if upright:
                    size = grid.columns[q + 1] - grid.columns[q]
                    length = grid.rows[s + 1] - grid.rows[s]
                    begin = seams.corners[i, j, 1]
                    end = seams.corners[i + 1, j, 1]
                    start = seams.corners[i, j, 0]
                    stop = length + seams.corners[i + 1, j, 0]
                else:
                    size = grid.rows[p + 1] - grid.rows[p]
                    length = grid.columns[t + 1] - grid.columns[t]
                    begin = seams.corners[i, j, 0]
                    end = seams.corners[i, j + 1, 0]
                    start = seams.corners[i, j, 1]
                    stop = length + seams.corners[i, j + 1, 1]
                begin += reach
                end += reach
                start += inset + reach
                stop += inset + reach
                if stop <= start:
                    continue
                ay = a // width + (start if upright else inset + size)
                ax = a % width + (inset + size if upright else start)
                by = b // width + (start if upright else inset)
                bx = b % width + (inset if upright else start)
                for n in range(stop - start):
                    if hole.state.shape[0]:
                        scratch.beyond[n, 0] = 0
                    for k in range(2 * reach):
                        v = n if upright else k
                        u = k if upright else n
                        scratch.error[n, k] = differ(shown, ay + v, ax + u, by + v, bx + u)
                        if hole.state.shape[0] == 0:
                            continue
                        y = grid.rows[i] - reach + v + (start - inset if upright else 0)
                        x = grid.columns[j] - reach + u + (0 if upright else start - inset)
                        kind = state_of(hole, grid, y, x)
                        scratch.beyond[n, k + 1] = scratch.beyond[n, k]
                        if kind == OFF:
                            scratch.error[n, k] = 0
                        if kind == BESIDE:
                            # A boundary past this pixel leaves it to the block before.
                            scratch.beyond[n, k + 1] += leaves(shown, ay + v, ax + u, hole, y, x)
                            scratch.beyond[n, k + 1] -= leaves(shown, by + v, bx + u, hole, y, x)
                least_path(scratch, stop - start, 2 * reach, begin, end)
                for t in range(paths.shape[2]):
                    if t < start:
                        n = begin
                    elif t >= stop:
                        n = end
                    else:
                        n = scratch.path[t - start]
                    paths[i, j, t] = cython.cast(cython.int, inset + n)


def path_through(scratch: Scratch, begin, end):
    """Fill `scratch.path` with the cheapest boundary through a whole band."""
    least_path(scratch, scratch.error.shape[0], scratch.error.shape[1], begin, end)
