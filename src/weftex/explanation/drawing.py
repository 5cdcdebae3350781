"""Drawings of intermediate values of methods, and the stages of methods that compare windows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.explanation.stages import Stage

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

MAGENTA = (255, 0, 255)
GREEN = (0, 255, 0)
UNKNOWN = (72, 72, 96)  # what is not made yet
_ENLARGED = 96  # pixels that a small picture is enlarged to, or more


def colors(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    """Return bytes (H, W, K) that methods match on as RGB: the first three, or one for all."""
    pixels = np.atleast_3d(pixels)
    shown = pixels[..., :3] if pixels.shape[2] >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    return np.array(shown, np.uint8)


def made(pixels: NDArray[Any], done: NDArray[Any]) -> NDArray[np.uint8]:
    """Draw a canvas; unknown pixels are dark blue."""
    picture = colors(pixels)
    picture[np.asarray(done) == 0] = UNKNOWN
    return picture


def enlarged(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Enlarge a small picture by a whole number, so that its pixels can be seen."""
    times = max(1, _ENLARGED // max(picture.shape[:2]))
    return picture.repeat(times, 0).repeat(times, 1)


def framed(
    picture: NDArray[np.uint8],
    box: tuple[int, int, int, int],
    color: tuple[int, int, int] = MAGENTA,
) -> NDArray[np.uint8]:
    """Draw a frame around a box (top, left, height, width), one pixel outside of it."""
    picture = picture.copy()
    top, left, height, width = box
    rows, columns = np.arange(top - 1, top + height + 1), np.arange(left - 1, left + width + 1)
    for y, x in (
        (np.full_like(columns, top - 1), columns),
        (np.full_like(columns, top + height), columns),
        (rows, np.full_like(rows, left - 1)),
        (rows, np.full_like(rows, left + width)),
    ):
        inside = (y >= 0) & (y < picture.shape[0]) & (x >= 0) & (x < picture.shape[1])
        picture[y[inside], x[inside]] = color
    return picture


def heat(values: NDArray[Any], there: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Draw errors, the lowest bright yellow, the highest dark; invalid positions are blue.

    The scale is that of their roots, from the best to the median.
    """
    picture = np.empty((*values.shape, 3), np.uint8)
    picture[:] = UNKNOWN
    if there.any():
        roots = np.sqrt(np.maximum(values[there].astype(np.float64), 0))
        low, high = float(roots.min()), float(np.median(roots))
        good = 1 - np.clip((roots - low) / max(high - low, 1e-12), 0, 1)
        picture[there] = np.stack([40 + 215 * good, 20 + 200 * good**2, 40 * good**4], axis=-1)
    return picture


def marked(
    picture: NDArray[np.uint8],
    places: Sequence[tuple[int, int]] | NDArray[Any],
    chosen: tuple[int, int] | None = None,
    size: tuple[int, int] = (1, 1),
) -> NDArray[np.uint8]:
    """Mark places, or the corners of boxes, in green, and the chosen one in magenta."""
    picture = picture // 2 + 48
    for y, x in np.asarray(places).reshape(-1, 2).tolist():
        if size == (1, 1):
            picture[y % picture.shape[0], x % picture.shape[1]] = GREEN
        else:
            picture = framed(picture, (y, x, *size), GREEN)
    return picture if chosen is None else framed(picture, (*chosen, *size))


def window_around(
    pixels: NDArray[np.uint8],
    done: NDArray[Any],
    pixel: tuple[int, int],
    half: int,
    wrap: tuple[bool, bool] = (False, False),
) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Return the window around a pixel: its bytes, and which are known; the pixel is not."""
    lines, inside = [], []
    for at, n, around in zip(pixel, done.shape, wrap, strict=True):
        line = at + np.arange(-half, half + 1)
        lines.append(line % n)
        inside.append(np.ones(len(line), bool) if around else (line >= 0) & (line < n))
    here = np.ix_(*lines)
    known = (done[here] != 0) & inside[0][:, None] & inside[1]
    known[half, half] = False
    return pixels[here].copy(), known


def error_surface(
    sample: NDArray[np.uint8],
    window: NDArray[np.uint8],
    known: NDArray[np.bool_],
    weights: NDArray[Any] | None = None,
) -> NDArray[np.float64]:
    """Return the squared differences of a partly known window to all windows of a sample."""
    height, width = sample.shape[:2]
    total = np.zeros((height, width))
    rows, columns = np.arange(height)[:, None], np.arange(width)
    for v, u in np.argwhere(known).tolist():
        y, x = rows + v - window.shape[0] // 2, columns + u - window.shape[1] // 2
        apart = sample[y % height, x % width].astype(np.int64) - window[v, u]
        total += (apart**2).sum(axis=2) * (1 if weights is None else int(weights[v, u]))
        total[(y < 0) | (y >= height) | (x < 0) | (x >= width)] = np.inf
    return total


def choice_stages(
    sample: NDArray[np.uint8],
    window: NDArray[np.uint8],
    known: NDArray[np.bool_],
    candidates: NDArray[Any],
    chosen: tuple[int, int],
    *,
    words: tuple[str, str, str],
    weights: NDArray[Any] | None = None,
    at: str = "",
) -> list[Stage]:
    """Return the stages of one pixel: its neighborhood, the errors, the candidates."""
    errors = error_surface(sample, window, known, weights)
    neighborhood = enlarged(made(window, known))
    times = neighborhood.shape[0] // window.shape[0]
    middle = [n // 2 * times for n in window.shape[:2]]
    neighborhood = framed(neighborhood, (middle[0], middle[1], times, times))
    there = np.isfinite(errors)
    surface = framed(heat(errors, there), (*chosen, 1, 1))
    return [
        Stage("neighborhood" + at, words[0], np.where(known[..., None], window, 0), neighborhood),
        Stage("error surface" + at, words[1], errors, enlarged(surface)),
        Stage(
            "candidates" + at,
            words[2],
            np.asarray(candidates),
            enlarged(marked(colors(sample), candidates, chosen)),
        ),
    ]
