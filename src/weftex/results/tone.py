"""The tone of a filling, matched to that of its surroundings.

The steps between each pixel inside and its neighbor outside are averaged along the border and led
on inwards, with weights that fall as the third power of the distance, as in a membrane. Steps of
both signs that cancel out are the texture's own: a mean counts in full from three times its
standard error on.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    #: First and last pixel of each axis, past the picture where it goes around.
    Span = tuple[int, int]

_CELL = 4  # pixels a side, over which steps are gathered
_REACH = 10.0  # cells along the border that are averaged, at least
_AROUND = 128  # pixels past a side around which the picture goes
_ALIKE = 16.0  # pixels of a border that say together what one says
_SURE = 3.0  # standard errors from which a step is taken off whole
_FEW = 32  # different colors: a drawing or a map of labels, which has no tones between
_GRAIN = 64  # of a level, to which shifts are rounded, as machines differ in last digits


def match_tone(
    picture: NDArray[Any],
    hole: NDArray[np.bool_],
    wrap: tuple[bool, bool] = (False, False),
    *,
    alpha: bool = False,
    scale: int = 1,
) -> NDArray[Any]:
    """Return a picture (H, W, C) with the tone inside a hole shifted to that across its border.

    `alpha` says that the last channel is alpha, which stays; `scale` is the side of a pixel of the
    sample. A picture of few colors along the border, as labels have, is returned as it is.
    """
    colors = picture[..., :-1] if alpha else picture
    flat = colors.reshape(-1, colors.shape[2])
    inside, outside = _border(hole, wrap)
    if alpha:
        opaque = picture[..., -1].ravel() > 0
        seen = opaque[inside] & opaque[outside]
        inside, outside = inside[seen], outside[seen]
    if has_few_colors(flat[outside]):
        return picture
    steps = flat[outside].astype(np.float64) - flat[inside]
    largest = float(abs(steps).max())
    if not 0 < largest < 1e100 or largest < 1e-100:  # their squares are no numbers
        return picture
    spans = [_span(np.any(hole, axis=1 - axis), wrap[axis], scale) for axis in (0, 1)]
    border = np.stack(np.divmod(inside, hole.shape[1]))
    shifts = _shifts(steps, border, hole.shape, spans, scale)
    where = np.stack(np.nonzero(hole)) - np.array(spans)[:, :1]
    result = picture.copy()
    for channel, cells in enumerate(shifts):
        shift = _between(cells, (where + 0.5) / (_CELL * scale) - 0.5)
        if picture.dtype.kind == "u":
            values = np.rint(colors[..., channel][hole] + np.rint(shift * _GRAIN) / _GRAIN)
            values = np.clip(values, 0, np.iinfo(picture.dtype).max)
        else:
            most = np.finfo(picture.dtype).max
            values = np.clip(colors[..., channel][hole] + shift, -most, most)
        result[..., channel][hole] = values.astype(picture.dtype)
    return result


def has_few_colors(colors: NDArray[Any]) -> bool:
    """Whether at most 32 of the colors (N, C) differ, as in drawings and label maps."""

    def few(left: NDArray[Any]) -> bool:
        for _ in range(_FEW):
            if not len(left):
                break
            left = left[(left != left[0]).any(axis=1)]  # not np.unique, which loads masked arrays
        return not len(left)

    return few(colors[: _FEW**2]) and few(colors)


def _border(
    hole: NDArray[np.bool_], wrap: tuple[bool, bool]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Flat indices of pixels of the hole and of their neighbors outside of it."""
    place = np.arange(hole.size).reshape(hole.shape)
    pairs = []
    for axis in (0, 1):
        for way in (-1, 1):
            across = hole & ~np.roll(hole, way, axis)
            if not wrap[axis]:
                across[(slice(None),) * axis + (0 if way == 1 else -1,)] = False
            pairs.append((place[across], np.roll(place, way, axis)[across]))
    inside, outside = (np.concatenate(part) for part in zip(*pairs, strict=True))
    return inside, outside


def _span(taken: Any, wraps: bool, scale: int) -> Span:
    if wraps:
        return -_AROUND * scale, len(taken) + _AROUND * scale
    at = np.flatnonzero(taken)
    return int(at[0]), int(at[-1]) + 1


def _shifts(
    steps: Floats,
    border: NDArray[np.intp],
    shape: tuple[int, ...],
    spans: list[Span],
    scale: int,
) -> list[Floats]:
    """What to add to the cells of a part of the picture, an array (h, w) a channel."""
    side = _CELL * scale
    cells = [-(-(end - start) // side) for start, end in spans]
    values = np.concatenate([np.ones((1, len(steps))), steps.T, steps.T**2])
    sums = np.zeros((len(values), *cells))
    copies = [[-n, 0, n] if start < 0 else [0] for n, (start, _) in zip(shape, spans, strict=True)]
    for down in copies[0]:
        for along in copies[1]:
            v, u = ((border + [[down], [along]]) - np.array(spans)[:, :1]) // side
            there = (v >= 0) & (v < cells[0]) & (u >= 0) & (u < cells[1])
            place = (v * cells[1] + u)[there]
            for total, value in zip(sums, values[:, there], strict=True):
                total += np.bincount(place, value, total.size).reshape(cells)
    size = [2 * count for count in cells]
    away = [np.minimum(np.arange(count), count - np.arange(count)) for count in size]
    weight = (np.add.outer(away[0] ** 2, away[1] ** 2) + _REACH**2) ** -1.5

    def led(total: Floats, weight: Floats) -> Floats:
        product = np.fft.rfft2(total, size) * np.fft.rfft2(weight)
        return np.fft.irfft2(product, size)[: cells[0], : cells[1]]

    count, squares = led(sums[0], weight), led(sums[0], weight**2)
    colors, found = steps.shape[1], []
    for channel in range(colors):
        mean = led(sums[1 + channel], weight) / count
        spread = np.maximum(led(sums[1 + colors + channel], weight) / count - mean**2, 0)
        error = spread * _ALIKE * scale * squares / count**2
        sure = mean**2 / np.maximum(_SURE**2 * error, 1e-200)
        found.append(mean * np.minimum(sure, 1))
    return found


def _between(values: Floats, place: Floats) -> Floats:
    """Values at places (2, n) between cells, bilinear."""
    last = np.array(values.shape)[:, None] - 1
    low = np.clip(np.floor(place).astype(np.intp), 0, np.maximum(last - 1, 0))
    (top, left), (bottom, right) = low, np.minimum(low + 1, last)
    down, along = np.clip(place - low, 0, 1)
    upper = values[top, left] * (1 - along) + values[top, right] * along
    lower = values[bottom, left] * (1 - along) + values[bottom, right] * along
    found: Floats = upper * (1 - down) + lower * down
    return found
