"""Label maps of `weftex.fuse`, which say which sample goes where (section 4 of the paper).

A map is a painted picture or an array of labels, or a `Gradient`, which makes one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError, is_number
from weftex.exemplar import load_exemplar
from weftex.exemplar.exemplar import color_text
from weftex.random import draw
from weftex.raster.arrays import Indices, check_pixels

__all__ = ["Gradient"]

_SHOWN = 6  # colors that a message lists
# The paper's sigma is 80 on a picture of 200 pixels, whose transition takes all of it.
_SIGMAS = 2.5
_CIRCLES = 8  # the canvas's shorter side over the largest radius of a circle, per transition


@dataclass(frozen=True)
class Gradient:
    """A label map with evenly spaced transitions from the first sample to the last.

    Samples mix in circles as large as their features.

    Parameters
    ----------
    direction : float
        Where the last sample lies, in degrees: 0 is right, 90 is down.
    width : float, optional
        Length of one transition, above 0 and at most 1, as a share of the image's extent along
        `direction`. By default the transitions fill the canvas, as in the paper.

    Raises
    ------
    InvalidInputError
        If a value is out of range.

    Examples
    --------
    >>> labels, _ = Gradient(direction=0, width=0.3).label_map((60, 200), [9, 7], seed=1)
    >>> labels[:, 0].max().item(), labels[:, -1].min().item()
    (0, 1)
    """

    direction: float = 90.0
    width: float | None = None

    def __post_init__(self) -> None:
        if not is_number(self.direction) or not -360 <= self.direction <= 360:
            raise InvalidInputError(f"direction is {self.direction!r}; it must be from -360 to 360")
        if self.width is not None and not (is_number(self.width) and 0 < self.width <= 1):
            raise InvalidInputError(f"width is {self.width!r}; it must be above 0 and at most 1")

    def label_map(
        self, size: tuple[int, int], scales: Sequence[int], seed: int
    ) -> tuple[Indices, list[tuple[int, int]]]:
        """Place circles at random until the canvas is covered; return labels and the mixed pairs.

        At x beyond the start of a transition a circle is of a sample before it with probability
        exp(-x^2 / 2 sigma^2), sigma being the width / 2.5. Where it meets another sample's circle,
        that becomes a region of both mixed.
        """
        count, (height, width) = len(scales), size
        starts, sigma = self._transitions(count)
        most = max(1, min(size) // (_CIRCLES * max(1, count - 1)))
        radii = [max(1, min(scale, most)) for scale in scales]
        pairs = [(a, b) for a in range(count) for b in range(a + 1, count)]
        mixed = np.full((count, count), -1, np.int32)
        for n, (a, b) in enumerate(pairs):
            mixed[a, b] = mixed[b, a] = count + n
        labels = np.full(size, -1, np.int32)
        left, number = height * width, 0
        while left:
            # The last gaps are aimed at, or they would take for ever.
            bits = draw(seed, "circle", number, np.arange(4))
            if number % 2:
                gaps = np.flatnonzero(labels < 0)
                y, x = divmod(int(gaps[int(bits[0] % np.uint64(len(gaps)))]), width)
            else:
                y, x = int(bits[0] % np.uint64(height)), int(bits[1] % np.uint64(width))
            chance = int(bits[2] >> np.uint64(11)) / 2**53
            way = self._way(y, x, size)
            beyond = [max(0.0, way - start) for start in starts]
            label = sum(chance >= math.exp(-(b**2) / (2 * sigma**2)) for b in beyond)
            number, radius = number + 1, radii[label]
            if int(bits[3] >> np.uint64(11)) * radius**2 >= min(radii) ** 2 << 53:
                continue  # fewer of the larger ones, so that they cover no more
            rows = slice(max(0, y - radius), min(y + radius + 1, height))
            columns = slice(max(0, x - radius), min(x + radius + 1, width))
            v, u = np.ogrid[rows, columns]
            inside = (v - y) ** 2 + (u - x) ** 2 <= radius**2
            part = labels[rows, columns]
            left -= int((inside & (part < 0)).sum())
            met = inside & (part >= 0) & (part < count) & (part != label)
            part[inside & (part < 0)] = label
            part[met] = mixed[label, part[met]]
        used = [n for n in range(len(pairs)) if (labels == count + n).any()]
        for new, old in enumerate(used):
            labels[labels == count + old] = count + new
        return labels, [pairs[n] for n in used]

    def _transitions(self, count: int) -> tuple[list[float], float]:
        """Return the position at which each transition begins, and its sigma."""
        wide = self.width if self.width is not None else 1 / max(1, count - 1)
        middles = [(k + 0.5) / (count - 1) for k in range(count - 1)]
        # A billionth of the way is less than a pixel, and its square is still a number.
        return [middle - wide / 2 for middle in middles], max(wide / _SIGMAS, 1e-9)

    def _way(self, y: int, x: int, size: tuple[int, int]) -> float:
        """Return the position of a pixel, 0 to 1."""
        v, u = y + 0.5, x + 0.5
        height, width = size
        angle = math.radians(self.direction)
        down, right = round(math.sin(angle), 12), round(math.cos(angle), 12)
        length = abs(down) * height + abs(right) * width
        return ((v - height / 2) * down + (u - width / 2) * right) / length + 0.5


def labels_of(picture: NDArray[Any], count: int, colors: Sequence[Any] | None = None) -> Indices:
    """Return labels (H, W) of the colors of a painted map, in the order in which they appear.

    With `colors`, other colors count as the nearest of these, so painted edges may be smooth.
    """
    if picture.ndim not in (2, 3) or picture.size == 0:
        raise InvalidInputError(f"the label map has shape {picture.shape}; it must be (H, W[, C])")
    flat = picture.reshape(picture.shape[0] * picture.shape[1], -1)
    labels = _by_appearance(flat, count) if colors is None else _by_nearest(flat, count, colors)
    return labels.reshape(picture.shape[:2])


def _by_appearance(flat: NDArray[Any], count: int) -> Indices:
    """Label the colors (N, C) of a map in the order in which they appear."""
    found, first, inverse = np.unique(flat, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    if len(found) != count:
        listed = ", ".join(map(color_text, found[order][:_SHOWN])) + ", ..." * (len(found) > _SHOWN)
        raise InvalidInputError(
            f"the label map has {len(found)} colors ({listed}) for {count} samples; it needs "
            "one for each sample, or a list of the colors: colors=[...], or --colors"
        )
    return np.argsort(order)[inverse.ravel()].astype(np.int32)


def _by_nearest(flat: NDArray[Any], count: int, colors: Sequence[Any]) -> Indices:
    """Label each color (N, C) of a map by the nearest of the given ones."""
    if len(colors) != count:
        raise InvalidInputError(
            f"{len(colors)} colors for {count} samples or mixed regions; give one each"
        )
    try:
        wanted = np.array([np.ravel(c) for c in colors])
        wanted = wanted if wanted.dtype.kind in "biuf" else np.zeros((0, 0))
    except (TypeError, ValueError, OverflowError):
        wanted = np.zeros((0, 0))
    if wanted.shape == (count, flat.shape[1] - 1) and (flat[:, -1] == flat[0, -1]).all():
        flat = flat[:, :-1]  # the alpha of a canvas that was painted on
    if wanted.shape != (count, flat.shape[1]):
        raise InvalidInputError(f"each color must have {flat.shape[1]} numbers, as in the map")
    distance = np.stack([((flat - c.astype(np.float64)) ** 2).sum(axis=1) for c in wanted])
    for k, color in enumerate(wanted):
        if (wanted[:k] == color).all(axis=1).any():
            raise InvalidInputError(f"the color {color_text(color)} is given twice; give one each")
    for k, color in enumerate(wanted):
        if not (distance[k] == 0).any():
            raise InvalidInputError(f"the label map has no pixel of the color {color_text(color)}")
    nearest: Indices = distance.argmin(axis=0).astype(np.int32)
    return nearest


def map_picture(label_map: Any) -> NDArray[Any]:
    """Return the picture of a map, or its labels: integers of any type unchanged."""
    if isinstance(label_map, np.ndarray):
        if label_map.dtype == bool:
            return label_map.astype(np.uint8)
        if label_map.dtype.kind not in "iu":
            return check_pixels(label_map, "the label map")
        if label_map.size and label_map.min() < 0:
            raise InvalidInputError(f"the label map has {label_map.min()}; labels are from 0 on")
        return label_map
    if label_map is None:
        raise InvalidInputError("the label map is None; give an image, labels or 'gradient'")
    return load_exemplar(label_map).pixels
