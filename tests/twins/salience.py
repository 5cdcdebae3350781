"""What the offsets of each oriented copy would repeat, cell by cell (`repeats.salience`)."""

import numpy as np


def copy_sums(penalty, boxes, pixel, first, size):
    """The six sums of `repeat_kernels.sum_copies`: (copies, 6, offsets down, offsets across)."""
    output, side, shows = penalty.output, penalty.cell, penalty.shows
    number, copy = np.divmod(shows, len(boxes))
    reach = 3 * max(boxes[0][2:]) // side  # cells, from which on nothing counts
    shown = {}  # by cell of the sample: where it is shown, in cells from the pixel, and which copy
    for step in np.ndindex(2 * reach + 1, 2 * reach + 1):
        here = pixel_at(output.canvas, pixel, side * (np.array(step) - reach))
        if here is not None and output.source[here] >= 0:
            place = divmod(int(output.source[here]), shows.shape[1])
            shown.setdefault(number[place], []).append((np.array(step) - reach, copy[place]))
    some = output.source[::side, ::side]
    often = np.bincount(number.ravel()[some[some >= 0]], minlength=number.max() + 1)
    middle, (near, close, _) = np.array(penalty.weights.shape) // 2, penalty.near
    sums = np.zeros((len(boxes), 6, *size), np.int64)
    for c, (top, left, height, width) in enumerate(boxes):
        for y, x in np.ndindex(-(-height // side), -(-width // side)):
            v, u = min(side * y + side // 2, height - 1), min(side * x + side // 2, width - 1)
            cell = number[top + v, left + u]
            salience = penalty.cells[3, cell]
            for offset in np.ndindex(*size):
                own = np.array((y, x)) - first - offset  # where the offset lays the cell
                here = pixel_at(output.canvas, pixel, side * own)
                missing = here is not None and not output.done[here]
                total = sums[(c, slice(None), *offset)]
                total[[1, 2, 4]] += missing * np.array([salience, often[cell], 1])
                for place, other in shown.get(cell, []):
                    away = place - own
                    if missing and (abs(away) <= middle).all():
                        total[0] += salience * penalty.weights[tuple(middle + away)]
                    if other != c:
                        total[3] += missing and away @ away <= near
                        opposite = penalty.mirrored[other] != penalty.mirrored[c]
                        total[5] += opposite and away @ away <= close
    return sums


def pixel_at(canvas, pixel, step):
    """The pixel of a canvas at a step from one, around its border if it wraps; or None."""
    found = []
    for at, n, wraps in zip(np.add(pixel, step).tolist(), canvas.shape, canvas.wrap, strict=True):
        if not (wraps or 0 <= at < n):
            return None
        found.append(at % n)
    return tuple(found)


def price_sums(penalty, rows, columns, from_rows, from_columns):
    """The two sums of `repeat_kernels.sum_changes`: (2, cells down, cells across)."""
    canvas, source, side = penalty.output.canvas, penalty.output.source, penalty.cell
    cell_of, salience = penalty.shows // len(penalty.mirrored), penalty.cells[3]
    shown = {}  # by cell of the sample: where it is shown
    for y, x in np.ndindex(canvas.shape):
        if y % side == x % side == 0 and source[y, x] >= 0:
            shown.setdefault(cell_of.ravel()[source[y, x]], []).append((y, x))
    middle = np.array(penalty.weights.shape) // 2
    sums = np.zeros((2, -(-len(rows) // side), -(-len(columns) // side)), np.int64)
    for i, j in np.ndindex(sums.shape[1:]):
        v = min(side * i + side // 2, len(rows) - 1)
        u = min(side * j + side // 2, len(columns) - 1)
        new, old = cell_of[from_rows[v], from_columns[u]], source[rows[v], columns[u]]
        for cell, sign in ((new, 1), (cell_of.ravel()[old] if old >= 0 else -1, -1)):
            for place in shown.get(cell, []):
                away = abs(np.subtract(place, (rows[v], columns[u])))
                around = np.where(canvas.wrap, np.subtract(canvas.shape, away), away)
                steps = np.minimum(away, around) // side
                inside = place[0] in rows and place[1] in columns
                if (steps <= middle).all() and steps.max() > 1:
                    weight = penalty.weights[tuple(middle + steps)] * (1 if inside else 2)
                    sums[0, i, j] += sign * salience[cell] * weight
                sums[1, i, j] += sign
    return sums
