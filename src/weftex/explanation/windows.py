"""Stages of methods that compare windows: known pixels, errors, candidates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.explanation.drawing import colors, enlarged, framed, heat, made, marked
from weftex.explanation.stages import Stage

if TYPE_CHECKING:
    from numpy.typing import NDArray


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
    *,
    tileable: bool = False,
) -> NDArray[np.float64]:
    """Return the squared differences of a partly known window to all windows of a sample."""
    height, width = sample.shape[:2]
    total = np.zeros((height, width))
    rows, columns = np.arange(height)[:, None], np.arange(width)
    for v, u in np.argwhere(known).tolist():
        y, x = rows + v - window.shape[0] // 2, columns + u - window.shape[1] // 2
        apart = sample[y % height, x % width].astype(np.int64) - window[v, u]
        total += (apart**2).sum(axis=2) * (1 if weights is None else int(weights[v, u]))
        if not tileable:
            outside = (y < 0) | (y >= height) | (x < 0) | (x >= width)
            total[outside] = np.inf
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
    tileable: bool = False,
    at: str = "",
) -> list[Stage]:
    """Return the stages of one pixel: its neighborhood, the errors, the candidates."""
    errors = error_surface(sample, window, known, weights, tileable=tileable)
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
