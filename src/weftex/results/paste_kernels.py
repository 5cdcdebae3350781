# mypy: ignore-errors
# cython: infer_types=True
"""Kernels that paste patches over each other and copy pixels; see the .pxd.

Weights are in 1/256, from 0 (the older pixel stays) to 256 (the new one replaces it), so constant
in is constant out and integer pictures round once a patch. A picture, a map of the same sample at
a multiple of its resolution and the buffer that matching looks at all pass through `paste`.
"""

import cython
from cython.cimports.libc.math import floor, sqrt
from cython.cimports.libc.string import memcpy

ALPHA, VECTORS, LABELS = 1, 2, 3  # of `weftex.raster.mixing.Kind`


class Layout:
    """Patches on a canvas, in the order in which they cover each other, and how they are rendered.

    `placements` (n, 5) is y, x, source y, source x and row of `weights` (zones, rows, columns), in
    1/256. `cuts` (n, 2 * (rows + columns)) or (0, 0) is, of each patch, the first column that shows
    in each row and the one past the last; then likewise rows. Arrays show the canvas from `top` and
    `left` in sample pixels on. `scale` is pixels per sample pixel, `mixing` a `Kind`, `middle` the
    zero of float vectors.
    """

    def __init__(
        self, placements, weights, cuts, height, width,
        top=0, left=0, scale=1, mixing=0, middle=0.0,
    ):  # fmt: skip
        self.placements, self.weights, self.cuts = placements, weights, cuts
        self.height, self.width = height, width
        self.top, self.left, self.scale = top, left, scale
        self.mixing, self.middle = mixing, middle


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def effective(
    weight: cython.int, cut: cython.p_const_ushort, v: cython.Py_ssize_t, u: cython.Py_ssize_t,
    rows: cython.Py_ssize_t, columns: cython.Py_ssize_t,
) -> cython.int:  # fmt: skip
    """Weight of a patch's pixel: the feathered one, or with cuts all or nothing.

    Where sides are cut, the pixel shows if it is inside the cuts of all sides. The cuts on the left
    and at the top are the L-shaped boundary of a block (Efros and Freeman, section 2).
    """
    if cut == cython.NULL or weight == 0 or weight == 256:
        return weight
    left, right = start_of(LEFT, rows, columns), start_of(RIGHT, rows, columns)
    top, bottom = start_of(TOP, rows, columns), start_of(BOTTOM, rows, columns)
    return 256 if cut[left + v] <= u < cut[right + v] and cut[top + u] <= v < cut[bottom + u] else 0


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def between(old: real, new: real, share: cython.double) -> real:
    """The mean of two numbers, of which the new one has this share."""
    apart: real = new - old
    if apart - apart == 0:
        return old + apart * share
    return old * (1 - share) + new * share  # so far apart that no number is the difference


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def opacity(alpha: real) -> real:
    """Alpha as `Exemplar.as_matching` takes it, from 0 to 1."""
    return 0 if alpha < 0 else 1 if alpha > 1 else alpha


def length(vector, middle):
    """How long a vector is, stored in three channels around `middle`."""
    x: cython.double = vector[0] - middle
    y: cython.double = vector[1] - middle
    z: cython.double = vector[2] - middle
    return sqrt(x * x + y * y + z * z)


def stretch(vector, to, middle, out):
    """Write a vector of this direction and length; false, and nothing, if it has no direction."""
    k: cython.Py_ssize_t
    number: cython.double
    largest: cython.double = 2 * middle
    own: cython.double = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])
    if not own > 1e-3 * to:
        return False
    for k in range(3):
        number = middle + vector[k] * (to / own)
        if value is cython.uchar or value is cython.ushort:
            out[k] = cython.cast(cython.int, min(max(floor(number + 0.5), 0.0), largest))
        else:
            out[k] = number
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def blend_vectors(
    new: cython.pointer(cython.const[value]),
    old: cython.pointer(value),
    weight: cython.int,
    middle: cython.double,
) -> cython.void:
    """Mix directions and lengths apart, so that no vector is shorter than those it is made of."""
    k: cython.Py_ssize_t
    share: cython.double = weight / 256.0
    to: cython.double = (1 - share) * length(old, middle) + share * length(new, middle)
    mixed = cython.declare(cython.double[3])
    for k in range(3):
        mixed[k] = (1 - share) * (old[k] - middle) + share * (new[k] - middle)
    if not stretch(mixed, to, middle, old) and weight >= 128:  # opposite ones
        for k in range(3):
            old[k] = new[k]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def middle_of(sort: cython.pointer(value), given: cython.double) -> cython.double:
    """What stands for 0 in a vector of these numbers."""
    if value is cython.uchar:
        return 127.5
    elif value is cython.ushort:
        return 32767.5
    else:
        return given


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def blend(
    new: cython.pointer(cython.const[value]),
    old: cython.pointer(value),
    channels: cython.Py_ssize_t,
    weight: cython.int,
    layout: Layout,
) -> cython.void:
    """Mix one pixel into `old`; straight alpha weighs colors, so clear pixels bleed nothing."""
    cython.declare(k=cython.Py_ssize_t, mixed=cython.int, share=cython.double)
    cython.declare(num=cython.longlong, den=cython.longlong)
    cython.declare(part_old=cython.longlong, part_new=cython.longlong)
    if layout.mixing == LABELS:
        if weight >= 128:
            for k in range(channels):
                old[k] = new[k]
        return
    if layout.mixing != ALPHA:
        for k in range(3 if layout.mixing == VECTORS else 0, channels):
            if value is cython.uchar or value is cython.ushort:
                mixed = old[k] * (256 - weight) + new[k] * weight + 128
                old[k] = mixed >> 8
            else:
                old[k] = between(old[k], new[k], weight / 256.0)
        if layout.mixing == VECTORS:
            blend_vectors(new, old, weight, middle_of(old, layout.middle))
        return
    if value is cython.uchar or value is cython.ushort:
        part_old = (256 - weight) * cython.cast(cython.longlong, old[channels - 1])
        part_new = weight * cython.cast(cython.longlong, new[channels - 1])
        den = part_old + part_new
        for k in range(channels - 1):
            if den == 0:
                old[k] = new[k]
            else:
                num = part_old * old[k] + part_new * new[k]
                old[k] = (2 * num + den) // (2 * den)
        old[channels - 1] = (den + 128) >> 8
    else:
        share = (256 - weight) * opacity(old[channels - 1]) + weight * opacity(new[channels - 1])
        share = weight * opacity(new[channels - 1]) / share if share != 0 else 1.0
        for k in range(channels - 1):
            old[k] = between(old[k], new[k], share)
        k = channels - 1
        old[k] = between(old[k], new[k], weight / 256.0)


def paste(out, source, layout, k, zone):
    """Paste patch `k` with the weights of `zone`; positions in sample pixels wrap at borders."""
    y, x = layout.placements[k, 0], layout.placements[k, 1]
    source_y, source_x = layout.placements[k, 2], layout.placements[k, 3]
    height, width, scale = layout.height, layout.width, layout.scale
    top, left, channels = layout.top, layout.left, out.shape[2]
    rows, columns = layout.weights.shape[1], layout.weights.shape[2]
    source_height, source_width = source.shape[0] // scale, source.shape[1] // scale
    cut: cython.p_const_ushort = cython.NULL
    if layout.cuts.shape[0] > 0:
        cut = cython.address(layout.cuts[k, 0])
    for v in range(rows):
        cy = (y + v) % height - top
        fy = (source_y + v) % source_height
        if cy < 0 or cy * scale >= out.shape[0]:
            continue
        weight = cython.address(layout.weights[zone, v, 0])
        u = 0
        while u < columns:
            w = effective(weight[u], cut, v, u, rows, columns)
            cx = (x + u) % width - left
            if w == 0 or cx < 0 or cx * scale >= out.shape[1]:
                u += 1
                continue
            fx = (source_x + u) % source_width
            if w < 256:
                for r in range(scale):
                    for q in range(scale):
                        old = cython.address(out[cy * scale + r, cx * scale + q, 0])
                        new = cython.address(source[fy * scale + r, fx * scale + q, 0])
                        blend(new, old, channels, w, layout)
                u += 1
                continue
            limit = min(
                columns - u, width - left - cx, source_width - fx, out.shape[1] // scale - cx
            )
            run = 1
            while run < limit and effective(weight[u + run], cut, v, u + run, rows, columns) == 256:
                run += 1
            for r in range(scale):
                memcpy(
                    cython.address(out[cy * scale + r, cx * scale, 0]),
                    cython.address(source[fy * scale + r, fx * scale, 0]),
                    run * scale * out.strides[1],
                )
            u += run


def paste_all(out: value[:, :, ::1], source: cython.const[value][:, :, ::1], layout: Layout):
    """Replay the patches of a layout in their order."""
    with cython.nogil:
        for k in range(layout.placements.shape[0]):
            paste(out, source, layout, k, layout.placements[k, 4])


def layer_all(patch: cython.int[:, :, ::1], share: cython.float[:, :, ::1], layout: Layout):
    """Write which patches show at each pixel and their shares, heaviest first; -1 is none.

    Both arrays are (rows, columns, layers).
    """
    rows, columns, layers = layout.weights.shape[1], layout.weights.shape[2], patch.shape[2]
    cut: cython.p_const_ushort = cython.NULL
    new: cython.float
    i: cython.Py_ssize_t
    with cython.nogil:
        for k in range(layout.placements.shape[0]):
            y, x = layout.placements[k, 0], layout.placements[k, 1]
            if layout.cuts.shape[0] > 0:
                cut = cython.address(layout.cuts[k, 0])
            for v in range(rows):
                cy = (y + v) % layout.height - layout.top
                if cy < 0 or cy >= patch.shape[0]:
                    continue
                weight = cython.address(layout.weights[layout.placements[k, 4], v, 0])
                for u in range(columns):
                    cx = (x + u) % layout.width - layout.left
                    w = effective(weight[u], cut, v, u, rows, columns)
                    if w == 0 or cx < 0 or cx >= patch.shape[1]:
                        continue
                    new = w / cython.cast(cython.float, 256)
                    for i in range(layers):
                        share[cy, cx, i] *= 1 - new
                    i = layers - 1  # the lightest gives way
                    while i > 0 and share[cy, cx, i - 1] < new:
                        share[cy, cx, i] = share[cy, cx, i - 1]
                        patch[cy, cx, i] = patch[cy, cx, i - 1]
                        i -= 1
                    share[cy, cx, i] = new
                    patch[cy, cx, i] = cython.cast(cython.int, k)


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
    columns = index.shape[1]
    size = source.shape[1] // width  # bytes of a block's row
    u: cython.Py_ssize_t
    with cython.nogil:
        for v in range(index.shape[0]):
            u = 0
            while u < columns:
                if index[v, u] < 0:
                    u += 1
                    continue
                y, x = index[v, u] // width, index[v, u] % width
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
