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
