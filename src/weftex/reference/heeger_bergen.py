"""Pyramid-based texture analysis and synthesis (Heeger and Bergen, 1995).

weftex has no such method: the paper on patch-based sampling compares itself with it (Table I). The
steerable pyramid is written here, as 40 lines are less than what a library of it would install.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from weftex.random import draw
from weftex.reference.common import Made, checked, made


def heeger_bergen(
    sample: Any,
    size: Any,
    levels: int = 4,
    orientations: int = 4,
    iterations: int = 5,
    seed: int = 0,
) -> Made:
    """Give noise the histograms of a texture and of the subbands of its steerable pyramid.

    D. J. Heeger, J. R. Bergen: Pyramid-based texture analysis/synthesis, SIGGRAPH 1995: sections 2
    and 3, with colors as in section 5.

    Parameters
    ----------
    sample : uint8 array (h, w) or (h, w, channels)
        The input texture.
    size : int or (int, int)
        Height and width of the output in pixels.
    levels : int
        Levels of the pyramid, an octave each.
    orientations : int
        Orientation bands of each level.
    iterations : int
        How often the pyramid is matched.
    seed : int
        Seed of the noise.

    Returns
    -------
    Made
        The picture; sources are -1, as no pixel is copied.

    Notes
    -----
    Subbands are not subsampled, so pictures may have any size. Borders wrap around, those of the
    sample too. Values beyond 0 and 255 are clipped.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.reference import heeger_bergen
    >>> sample = np.random.default_rng(0).integers(0, 255, (32, 32), np.uint8)
    >>> heeger_bergen(sample, (24, 40), levels=2, seed=1).image.shape
    (24, 40)
    """
    pixels, shape = checked(sample, size, seed)
    # Section 5: color channels are decorrelated, and each is treated on its own.
    mean = pixels.mean(axis=(0, 1))
    covariance = np.cov((pixels - mean).reshape(-1, len(mean)).T)
    axes = np.linalg.eigh(np.atleast_2d(covariance)).eigenvectors
    texture = (pixels - mean) @ axes
    cells = np.arange(shape[0] * shape[1])
    result = np.zeros((*shape, len(mean)))
    for channel in range(len(mean)):
        noise = (draw(seed, "noise", channel, cells) / 2.0**64).reshape(shape)
        result[..., channel] = match_texture(
            noise, texture[..., channel], levels, orientations, iterations
        )
    image = np.clip(np.rint(result @ axes.T + mean), 0, 255)
    return made(sample, image, np.full((*shape, 2), -1))


def match_texture(noise: Any, texture: Any, levels: int, orientations: int, iterations: int) -> Any:
    """Match-texture of section 3: the noise, modified to look like the texture."""
    noise = match_histogram(noise, texture)
    analysis = make_pyramid(texture, pyramid_masks(texture.shape, levels, orientations))
    masks = pyramid_masks(noise.shape, levels, orientations)
    for _ in range(iterations):
        synthesis = make_pyramid(noise, masks)
        matched = [match_histogram(s, a) for s, a in zip(synthesis, analysis, strict=True)]
        noise = match_histogram(collapse_pyramid(matched, masks), texture)
    return noise


def match_histogram(image: Any, like: Any) -> Any:
    """Match-histogram of section 3: values in the order of the image's, distributed like another's.

    Examples
    --------
    >>> match_histogram(np.array([3.0, 9.0, 5.0]), np.array([20.0, 0.0, 10.0])).tolist()
    [0.0, 20.0, 10.0]
    """
    rank = np.argsort(np.argsort(image, axis=None, kind="stable"))
    share = (rank + 0.5) / rank.size  # of values below: the cumulative distribution
    values = np.interp(share * like.size - 0.5, np.arange(like.size), np.sort(like, axis=None))
    return values.reshape(image.shape)


def pyramid_masks(shape: tuple[int, ...], levels: int, orientations: int) -> list[Any]:
    """The steerable pyramid's filters by frequency: high, oriented and low bands (Fig. 4)."""
    v, u = np.fft.fftfreq(shape[0])[:, None], np.fft.fftfreq(shape[1])
    radius, angle = np.hypot(v, u), np.arctan2(v, u)

    def low_pass(level: int) -> Any:
        """Cutoff f halves with each level: 1 below f / 2, 0 above f, a cosine between."""
        octave = np.log2(np.maximum(radius, 1e-9) * 2 ** (level + 1))  # 0 where it ends
        return np.cos(np.pi / 2 * np.clip(octave + 1, 0, 1))

    order = orientations - 1
    scale = 2**order * math.factorial(order)
    scale /= math.sqrt(orientations * math.factorial(2 * order))  # squares sum to 1
    masks = [np.sqrt(np.maximum(1 - low_pass(0) ** 2, 0))]
    for level in range(levels):
        band = np.sqrt(np.maximum(low_pass(level) ** 2 - low_pass(level + 1) ** 2, 0))
        for k in range(orientations):
            direction = scale * np.cos(angle - np.pi * k / orientations) ** order
            masks.append((-1j) ** order * band * direction)
    return [*masks, low_pass(levels)]


def make_pyramid(image: Any, masks: list[Any]) -> list[Any]:
    """Make-pyramid: the subbands of an image."""
    spectrum = np.fft.fft2(image)
    return [np.fft.ifft2(spectrum * mask).real for mask in masks]


def collapse_pyramid(subbands: list[Any], masks: list[Any]) -> Any:
    """Collapse-pyramid: the image of some subbands, by the same filters reversed."""
    parts = (np.fft.fft2(s) * np.conj(mask) for s, mask in zip(subbands, masks, strict=True))
    return np.fft.ifft2(sum(parts)).real
