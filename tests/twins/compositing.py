"""Pixels that are blended, and patches that are pasted."""

import itertools

import numpy as np

from twins.seams import cut_weights


def blend_pixel(old, new, weight, alpha=False):
    """Mix two pixels, (channels,), of one dtype; whole numbers round halves up."""
    if weight == 0:
        return old.copy()
    if weight == 256:
        return new.copy()
    result = old.copy()
    whole = old.dtype.kind == "u"
    colors = len(old) - 1 if alpha else len(old)
    if whole:
        o, n = [int(k) for k in old], [int(k) for k in new]
        for k in range(len(old)):
            result[k] = (o[k] * (256 - weight) + n[k] * weight + 128) // 256
        if alpha:
            a, b = (256 - weight) * o[-1], weight * n[-1]
            for k in range(colors):
                result[k] = (2 * (a * o[k] + b * n[k]) + a + b) // (2 * (a + b)) if a + b else n[k]
        return result
    for k in range(len(old)):
        result[k] = float(old[k]) + float(new[k] - old[k]) * (weight / 256)
    if alpha:
        a, b = (256 - weight) * float(old[-1]), weight * float(new[-1])
        share = b / (a + b) if a + b else 1.0
        for k in range(colors):
            result[k] = float(old[k]) + float(new[k] - old[k]) * share
    return result


def blend_vectors(old, new, weight, middle=0.0):
    """Mix two pixels whose first three channels are a vector: its length is mixed by itself."""
    result = blend_pixel(old, new, weight)
    if weight in (0, 256):
        return result
    if old.dtype.kind == "u":
        middle = np.iinfo(old.dtype).max / 2
    a, b, share = old[:3].astype(float) - middle, new[:3].astype(float) - middle, weight / 256
    between, (long, short) = (1 - share) * a + share * b, map(np.linalg.norm, (a, b))
    length = (1 - share) * long + share * short
    if np.linalg.norm(between) <= 1e-3 * length:
        result[:3] = new[:3] if weight >= 128 else old[:3]
        return result
    vector = middle + between / np.linalg.norm(between) * length
    if old.dtype.kind == "u":
        vector = np.clip(np.floor(vector + 0.5), 0, 2 * middle)
    result[:3] = vector
    return result


def take_label(old, new, weight):
    """The label that has the larger share."""
    return (new if weight >= 128 else old).copy()


def paste_all(
    out, source, top, left, shape, placements, weights, cuts, scale=1, alpha=False, blend=None
):
    """Replay placements over `out`, (rows, columns, channels), in place."""
    blend = blend or (lambda old, new, weight: blend_pixel(old, new, weight, alpha))
    height, width = shape
    sample_height, sample_width = source.shape[0] // scale, source.shape[1] // scale
    for p, (y, x, sy, sx, zone) in enumerate(placements.tolist()):
        mask = weights[zone].astype(int)
        if len(cuts):
            mask = cut_weights(mask, cuts[p])
        for v, u in itertools.product(*map(range, mask.shape)):
            cy, cx = (y + v) % height - top, (x + u) % width - left
            fy, fx = (sy + v) % sample_height, (sx + u) % sample_width
            for r, q in itertools.product(range(scale), repeat=2):
                row, column = cy * scale + r, cx * scale + q
                if 0 <= row < out.shape[0] and 0 <= column < out.shape[1]:
                    new = source[fy * scale + r, fx * scale + q]
                    out[row, column] = blend(out[row, column], new, int(mask[v, u]))


def layers(window, shape, placements, weights, cuts, most=4):
    """{(row, column): [(patch, share), …]}, heaviest first, of what shows in a window."""
    top, left, rows, columns = window
    found = {(i, j): [] for i in range(rows) for j in range(columns)}
    for p, (y, x, _, _, zone) in enumerate(placements.tolist()):
        mask = weights[zone].astype(int)
        if len(cuts):
            mask = cut_weights(mask, cuts[p])
        for v, u in itertools.product(*map(range, mask.shape)):
            at = ((y + v) % shape[0] - top, (x + u) % shape[1] - left)
            if at not in found or mask[v, u] == 0:
                continue
            new = np.float32(mask[v, u]) / np.float32(256)
            older = [(k, np.float32(s * (np.float32(1) - new))) for k, s in found[at]]
            older = older[: most - 1]
            ahead = [entry for entry in older if entry[1] >= new]
            found[at] = ahead + [(p, new)] + older[len(ahead) :]
    return {at: [e for e in entries if e[1] > 0] for at, entries in found.items()}
