# mypy: ignore-errors
# cython: infer_types=True
"""Kernels that compare the known pixels around a pixel with every window of a sample, with weights.

The distance is a sum of w d**2 over known pixels, w from 1 to 127, in integers. The template has
rows as long as the window, with the weight 0 where nothing is known, so that no loop has holes.
Compiled by Cython, see setup.py and the .pxd.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weftex.raster.difference_kernels import weighted_squares
from cython.cimports.weftex.search.picture_kernels import (
    Picture,
    SampleWindows,
    around,
    coherent_places,
    known_runs,
    portion,
)

#: For Python, the constants of the .pxd.
block_windows = int(BLOCK_WINDOWS)
step_terms = int(STEP_TERMS)


class WeightedWindows:
    """The windows of a sample and the weights of their pixels."""

    def __init__(self, flat, weights, stride, shape, planes, starts, allowed, order):
        self.flat, self.weights, self.stride = flat, weights, stride
        self.width, self.channels, self.reach = shape[1], shape[2], len(weights) // 2
        self.planes, self.starts, self.allowed, self.order = planes, starts, allowed, order


class Template:
    """Scratch: the known part of a window, the bytes that bounds are made of, and the search."""

    def __init__(self, query, values, weights, rows, terms, lower, least, places, distances):
        self.query, self.values, self.weights, self.rows = query, values, weights, rows
        self.at, self.value, self.weight, self.cap = terms
        self.lower, self.least = lower, least
        self.places, self.distances = places, distances


def copy_known(picture, windows, y, x, template):
    """Copy the known pixels around a pixel, with their weights; return the sum of the weights."""
    cython.declare(at=cython.Py_ssize_t, row=cython.Py_ssize_t, total=cython.longlong)
    total = 0
    height, width, reach = picture.done.shape[0], picture.done.shape[1], windows.reach
    n = known_runs(
        picture.done, y, x, picture.wrap_y, picture.wrap_x, reach,
        template.query.runs,
    )  # fmt: skip
    memset(
        cython.address(template.weights[0]), 0,
        cython.cast(cython.size_t, template.weights.shape[0]) * 2,
    )  # fmt: skip
    for r in range(n):
        row = template.query.runs[r, 0] + reach
        column = template.query.runs[r, 1] + reach
        cy = around(y + template.query.runs[r, 0], height)
        cx = around(x + template.query.runs[r, 1], width)
        at = row * windows.stride + column * windows.channels
        for i in range(template.query.runs[r, 2]):
            weight = windows.weights[row, column + i]
            total += weight
            for k in range(windows.channels):
                template.values[at] = picture.pixels[cy, cx, k]
                template.weights[at] = weight
                at += 1
            cx = cx + 1 if cx + 1 < width else 0
    # The rows with anything known, from the middle outwards: 0, 1, -1, 2 and so on.
    count = 0
    for i in range(2 * reach + 1):
        row = reach + ((i + 1) // 2 if i % 2 else -(i // 2))
        for r in range(n):
            if template.query.runs[r, 0] + reach == row:
                count += 1
                template.rows[count] = row
                break
    template.rows[0] = count
    return total


def window_distance(windows, place, template, bound):
    """Distance to the window at a flat index; stops past `bound` (negative: never)."""
    cython.declare(row=cython.Py_ssize_t, total=cython.longlong)
    total = 0
    corner = place - windows.reach * windows.width - windows.reach
    for r in range(1, template.rows[0] + 1):
        row = template.rows[r]
        total += weighted_squares(
            cython.address(windows.flat[(corner + row * windows.width) * windows.channels]),
            cython.address(template.values[row * windows.stride]),
            cython.address(template.weights[row * windows.stride]),
            windows.stride,
        )
        if total > bound and bound >= 0:
            break
    return total


def pick_terms(windows, template, limit):
    """Choose the heaviest known bytes for `bounds`; return the scale of their weights.

    The limit becomes about 2**13, so 16 bits resolve small differences.
    """
    scale: cython.longlong
    lead = windows.reach * windows.width + windows.reach
    wanted = template.at.shape[0]
    n = 0
    for o in range(windows.order.shape[0]):
        dy, dx = windows.order[o, 0], windows.order[o, 1]
        place = (dy + windows.reach) * windows.stride + (dx + windows.reach) * windows.channels
        if template.weights[place] == 0:
            continue
        for k in range(windows.channels):
            if n < wanted:
                template.at[n] = k * windows.planes.shape[1] + lead + dy * windows.width + dx
                template.value[n] = template.values[place + k]
                template.weight[n] = template.weights[place]
                n += 1
        if n >= wanted:
            break
    scale = 1
    if limit >= 0:
        scale = (cython.cast(cython.longlong, 1) << 29) // max(limit, 1)
    scale = max(1, min(511, scale))  # 127 * 511 < 2**16
    for k in range(wanted):
        if k < n:
            template.weight[k] *= scale
            template.cap[k] = min(65535, (LARGEST_TERM << 16) // template.weight[k])
        else:
            template.at[k] = lead
            template.value[k] = template.weight[k] = template.cap[k] = 0
    return scale


def term(byte, value, weight, cap):
    """floor(w d**2 / 2**16), the squared difference of two bytes capped."""
    cython.declare(d=cython.short, square=cython.ushort)
    d = byte - value
    square = cython.cast(cython.ushort, d * d)
    square = square if square < cap else cap
    return cython.cast(cython.ushort, (cython.cast(cython.uint, square) * weight) >> 16)


def bounds(planes, template, first, last, out):
    """Add terms to the lower bounds of a block of neighboring windows; return the smallest bound.

    A bound is a sum of terms in 16 bits, which doubles the lanes of 32. No term passes
    LARGEST_TERM, as squares are capped; sums stop at LARGEST_BOUND. A pass adds four terms.
    """
    cython.declare(sum=cython.ushort, least=cython.ushort)
    row = cython.declare(cython.p_const_uchar[4])
    value = cython.declare(cython.short[4])
    weight = cython.declare(cython.ushort[4])
    cap = cython.declare(cython.ushort[4])
    for t in range(first, last, 4):
        for i in range(4):
            row[i] = planes + template.at[t + i]
            value[i] = template.value[t + i]
            weight[i] = template.weight[t + i]
            cap[i] = template.cap[t + i]
        for j in range(BLOCK_WINDOWS):
            sum = out[j]
            sum += term(row[0][j], value[0], weight[0], cap[0])
            sum += term(row[1][j], value[1], weight[1], cap[1])
            sum += term(row[2][j], value[2], weight[2], cap[2])
            sum += term(row[3][j], value[3], weight[3], cap[3])
            out[j] = sum if sum < LARGEST_BOUND else LARGEST_BOUND
    least = 65535
    for j in range(BLOCK_WINDOWS):
        least = out[j] if out[j] < least else least
    return least


def largest_bound(limit, scale):
    """The lower bound that a distance of `limit` may have; without a limit, any."""
    if limit < 0 or limit >= cython.cast(cython.longlong, 1) << 40:
        return 65535
    return (limit * scale) >> 16


def largest_accepted(best, tolerance):
    """The largest distance within (1 + tolerance) of the best: (1 + epsilon) in the paper."""
    return cython.cast(cython.longlong, cython.cast(cython.double, best) * (1 + tolerance))


def nearest_coherent(picture, sample, windows, y, x, template):
    """The least distance to where the sources of the 8 neighbors continue; -1 without any.

    An upper limit that ends comparisons early; it changes no result.
    """
    best: cython.longlong = -1
    template.query.count = known_runs(
        picture.done, y, x, picture.wrap_y, picture.wrap_x, 1 if windows.reach > 0 else 0,
        template.query.runs,
    )  # fmt: skip
    for j in range(coherent_places(picture, sample, y, x, template.query, template.places, 0)):
        if template.places[j] >= 0:
            d = window_distance(windows, template.places[j], template, best)
            if best < 0 or d < best:
                best = d
    return best


def list_within(windows, template, best, tolerance):
    """List the windows within the tolerance of the best; return their number.

    `best` is an upper limit of the best distance. Other windows have too large a lower bound or are
    dropped when a better one is found.
    """
    cython.declare(nearest=cython.Py_ssize_t, limit=cython.longlong)
    size = template.at.shape[0]
    step = min(STEP_TERMS, size)
    limit = largest_accepted(best, tolerance) if best >= 0 else -1
    scale = pick_terms(windows, template, limit)
    nearest = 0
    for b in range(windows.starts.shape[0]):
        memset(cython.address(template.lower[b, 0]), 0, BLOCK_WINDOWS * 2)
        template.least[b] = bounds(
            cython.address(windows.planes[0, windows.starts[b]]), template, 0, step,
            cython.address(template.lower[b, 0]),
        )  # fmt: skip
        if template.least[b] < template.least[nearest]:
            nearest = b
    # The distance of the window with the least bound limits the others further.
    for j in range(BLOCK_WINDOWS):
        if template.lower[nearest, j] == template.least[nearest]:
            place = windows.starts[nearest] + j
            if windows.allowed[place]:
                d = window_distance(windows, place, template, limit)
                if best < 0 or d < best:
                    best = d
                    limit = largest_accepted(best, tolerance)
            break
    cut = largest_bound(limit, scale)
    count = 0
    for b in range(windows.starts.shape[0]):
        n = step
        while template.least[b] <= cut and n < size:
            template.least[b] = bounds(
                cython.address(windows.planes[0, windows.starts[b]]), template, n, n + step,
                cython.address(template.lower[b, 0]),
            )  # fmt: skip
            n += step
        if template.least[b] > cut:
            continue
        for j in range(BLOCK_WINDOWS):
            if template.lower[b, j] > cut:
                continue
            place = windows.starts[b] + j
            if not windows.allowed[place]:
                continue
            d = window_distance(windows, place, template, limit)
            if d > limit and limit >= 0:
                continue
            template.places[count] = place
            template.distances[count] = d
            count += 1
            if best < 0 or d < best:
                best = d
                limit = largest_accepted(best, tolerance)
                cut = largest_bound(limit, scale)
    n = 0
    for j in range(count):
        if template.distances[j] <= limit:
            template.places[n] = template.places[j]
            template.distances[n] = template.distances[j]
            n += 1
    return n


def find_matches(
    sample: SampleWindows,
    windows: WeightedWindows,
    picture: Picture,
    template: Template,
    pixels: cython.const[cython.int][::1],
    bits: cython.const[cython.ulonglong][::1],
    tolerance: cython.double,
    out: cython.longlong[:, ::1],
):
    """Pick a window for each pixel, evenly among those within the tolerance of the best.

    A column of `out` has the window's flat index, its distance, and the sum of the weights of the
    known pixels.
    """
    with cython.nogil:
        for i in range(pixels.shape[0]):
            y, x = pixels[i] // picture.done.shape[1], pixels[i] % picture.done.shape[1]
            out[2, i] = copy_known(picture, windows, y, x, template)
            best = nearest_coherent(picture, sample, windows, y, x, template)
            j = portion(bits[i], list_within(windows, template, best, tolerance))
            out[0, i] = template.places[j]
            out[1, i] = template.distances[j]
