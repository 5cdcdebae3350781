# mypy: ignore-errors
"""Kernels of near-regular synthesis: where blocks meet; compiled, see setup.py.

Places are as in `block_kernels`. Seams stay within `reach` of the edges of blocks.
"""

import cython
from cython.cimports.weftex.methods.near_regular.block_kernels import Grid, around
from cython.cimports.weftex.seams.boundary_kernels import Band, least_boundary, pixel_difference

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
    block begins, from the left and from above; columns `left` to `right` of blocks show.
    """

    inset: cython.Py_ssize_t
    reach: cython.Py_ssize_t
    slack: cython.Py_ssize_t
    box: cython.Py_ssize_t
    parity: cython.Py_ssize_t
    corners: cython.int[:, :, ::1]
    upright: cython.int[:, :, ::1]
    lying: cython.int[:, :, ::1]
    left: cython.Py_ssize_t
    right: cython.Py_ssize_t

    def __init__(
        self, inset, reach, slack, box, parity, corners, upright, lying, left, right
    ):  # fmt: skip
        self.left, self.right = left, right
        self.inset, self.reach, self.slack, self.box = inset, reach, slack, box
        self.parity, self.corners, self.upright, self.lying = parity, corners, upright, lying


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def compare(
    shown: Shown,
    one: cython.Py_ssize_t,
    other: cython.Py_ssize_t,
    along: cython.Py_ssize_t,
    across: cython.Py_ssize_t,
    length: cython.Py_ssize_t,
    band: Band,
) -> cython.void:
    """Squared differences of two pieces along a band, by how much a step shows there.

    The pieces begin at flat indices `one` and `other`; a line on is `along`, a pixel on `across`.
    """
    cython.declare(n=cython.Py_ssize_t, k=cython.Py_ssize_t, c=cython.Py_ssize_t)
    cython.declare(p=cython.Py_ssize_t, q=cython.Py_ssize_t, d=cython.int)
    cython.declare(total=cython.longlong, errors=cython.p_longlong)
    pixels: cython.p_const_uchar = cython.address(shown.pixels[0, 0, 0])
    shows: cython.pointer(cython.const[cython.ushort]) = cython.address(shown.visibility[0, 0])
    channels: cython.Py_ssize_t = shown.pixels.shape[2]
    depth: cython.Py_ssize_t = band.error.shape[1]
    for n in range(length):
        errors = cython.address(band.error[n, 0])
        p = one + n * along
        q = other + n * along
        for k in range(depth):
            total = 0
            for c in range(channels):
                d = cython.cast(cython.int, pixels[p * channels + c]) - pixels[q * channels + c]
                total += d * d
            errors[k] = (cython.cast(cython.longlong, shows[p]) + shows[q]) * total
            p += across
            q += across


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
    at: cython.Py_ssize_t,
    hole: Hole,
    v: cython.longlong,
    u: cython.longlong,
) -> cython.longlong:
    """Squared difference, counted twice, of a pixel of the sample and a known one of the canvas."""
    v = v % hole.known.shape[0]
    u = u % hole.known.shape[1]
    v = v + hole.known.shape[0] if v < 0 else v
    u = u + hole.known.shape[1] if u < 0 else u
    y: cython.Py_ssize_t = at // shown.pixels.shape[1]
    x: cython.Py_ssize_t = at % shown.pixels.shape[1]
    shows: cython.longlong = 2 * shown.visibility[y, x]
    return 2 * shows * pixel_difference(shown.pixels, y, x, hole.known, v, u)


def meet(
    shown: Shown,
    grid: Grid,
    hole: Hole,
    seams: Seams,
    band: Band,
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
    cython.declare(a=cython.int, b=cython.int, one=cython.Py_ssize_t)
    cython.declare(other=cython.Py_ssize_t, drawn=cython.bint)
    cython.declare(height=cython.longlong, breadth=cython.longlong)
    cython.declare(total=cython.longlong, least=cython.longlong)
    width: cython.Py_ssize_t = shown.pixels.shape[1]
    reach: cython.Py_ssize_t = seams.reach
    box: cython.Py_ssize_t = seams.box
    with cython.nogil:
        for i in range(first, last):
            for j in range(seams.left, seams.right + 1):
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
                one = a + (seams.inset + height) * width + seams.inset + (breadth if drawn else 0)
                other = b + seams.inset * width + seams.inset + (0 if drawn else breadth)
                compare(shown, one, other, width, 1, 2 * reach, band)
                for v in range(2 * reach if hole.state.shape[0] else 0):
                    for u in range(2 * reach):
                        y = grid.rows[i] - reach + v
                        x = grid.columns[j] - reach + u
                        if state_of(hole, grid, y, x) == OFF:
                            band.error[v, u] = 0
                least = -1
                for y in range(-seams.slack, seams.slack + 1):
                    for x in range(-seams.slack, seams.slack + 1):
                        total = 0
                        for v in range(reach + y - box, reach + y + box):
                            for u in range(reach + x - box, reach + x + box):
                                total += band.error[v, u]
                        # Of equal ones the nearest to the corner.
                        total = total * 1024 + y * y + x * x
                        if least < 0 or total < least:
                            least = total
                            seams.corners[i, j, 0] = cython.cast(cython.int, y)
                            seams.corners[i, j, 1] = cython.cast(cython.int, x)


def cut_edges(
    shown: Shown,
    grid: Grid,
    hole: Hole,
    seams: Seams,
    upright: cython.bint,
    band: Band,
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
):
    """Cut along the left edges of blocks (`upright`) or their upper ones, rows `first` to `last`.

    Where there is a hole, differences that do not show do not count, but those to known pixels
    beside it do, as if the block went on there.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, p=cython.Py_ssize_t)
    cython.declare(q=cython.Py_ssize_t, s=cython.Py_ssize_t, t=cython.Py_ssize_t)
    cython.declare(n=cython.Py_ssize_t, k=cython.Py_ssize_t, at=cython.Py_ssize_t)
    cython.declare(start=cython.Py_ssize_t, stop=cython.Py_ssize_t)
    cython.declare(begin=cython.Py_ssize_t, end=cython.Py_ssize_t)
    cython.declare(size=cython.longlong, length=cython.longlong, a=cython.int, b=cython.int)
    cython.declare(one=cython.Py_ssize_t, other=cython.Py_ssize_t, kind=cython.int)
    cython.declare(y=cython.longlong, x=cython.longlong)
    paths: cython.int[:, :, ::1] = seams.upright if upright else seams.lying
    width: cython.Py_ssize_t = shown.pixels.shape[1]
    along: cython.Py_ssize_t = width if upright else 1
    across: cython.Py_ssize_t = 1 if upright else width
    inset: cython.Py_ssize_t = seams.inset
    reach: cython.Py_ssize_t = seams.reach
    with cython.nogil:
        for i in range(first, last):
            for j in range(seams.left, seams.right + 1 if upright else seams.right):
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
                one = a + (
                    start * width + inset + size if upright else (inset + size) * width + start
                )
                other = b + (start * width + inset if upright else inset * width + start)
                compare(shown, one, other, along, across, stop - start, band)
                for n in range(stop - start if hole.state.shape[0] else 0):
                    band.beyond[n, 0] = 0
                    for k in range(2 * reach):
                        y = grid.rows[i] - reach + (start - inset + n if upright else k)
                        x = grid.columns[j] - reach + (k if upright else start - inset + n)
                        kind = state_of(hole, grid, y, x)
                        band.beyond[n, k + 1] = band.beyond[n, k]
                        if kind == OFF:
                            band.error[n, k] = 0
                        if kind == BESIDE:
                            # A boundary past this pixel leaves it to the block before.
                            at = n * along + k * across
                            band.beyond[n, k + 1] += leaves(shown, one + at, hole, y, x)
                            band.beyond[n, k + 1] -= leaves(shown, other + at, hole, y, x)
                least_boundary(band, stop - start, 2 * reach, begin, end)
                for t in range(paths.shape[2]):
                    if t < start:
                        n = begin
                    elif t >= stop:
                        n = end
                    else:
                        n = band.path[t - start]
                    paths[i, j, t] = cython.cast(cython.int, inset + n)
