"""The values of the parameters of iterative refinement that depend on the sample."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from weftex.analysis.scale import structure_scale
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Method
from weftex.methods.pixels import narrowed, width_for
from weftex.naming import parse_method, text_of
from weftex.raster.boxes import whole_windows
from weftex.raster.pyramids import mask_pyramid
from weftex.registry import METHODS
from weftex.search.windows import square_windows

_NARROWEST_PYRAMID = 29  # pixels; with less than its four levels the picture falls apart
_LARGEST_REACH = 3  # pixels from the middle of a window of the pyramid to its side
_SMALLEST_LEVEL = 24  # pixels; a coarser sample has too few windows left
_FARTHEST = 2.0**30  # pixels between seed points; past the width of any output there is one


class Starts(Sequence[str]):
    """The values of `init`: its own names, then all other methods with parameters.

    The registry is read at each access, so methods registered later count.
    """

    def __init__(self, *own: str) -> None:
        self._own = own

    def __contains__(self, name: object) -> bool:
        if name in self._own:
            return True
        slug = name.split(" ")[0] if isinstance(name, str) else ""
        return slug != "refinement" and slug in METHODS

    def __iter__(self) -> Iterator[str]:
        yield from self._own
        yield from (slug for slug in METHODS if slug != "refinement")

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __bool__(self) -> bool:
        return True  # to count them takes a look at every package that is installed

    def __getitem__(self, index: Any) -> Any:
        return tuple(iter(self))[index]


def start_text(init: object) -> object:
    """Return a method with its parameters as text, and anything else unchanged."""
    try:
        if isinstance(init, str) and " " in init:
            init = parse_method(init)
    except InvalidInputError as error:
        raise InvalidInputError(f"init: {error}") from None
    return text_of(init) if isinstance(init, Method) else init


def resolved_method(method: Any, exemplar: Exemplar, init: str) -> Any:
    """Return the method with `window_width`, `init` and `seed_scale` resolved for a sample."""
    width, scale = window_width(method, exemplar), method.seed_scale
    if init == "seeds" and scale is None:
        scale = structure_scale(exemplar).scale
    return dataclasses.replace(method, window_width=width, init=init, seed_scale=scale)


def window_width(method: Any, exemplar: Exemplar) -> int:
    """Return the width of windows in pixels: as given, or from the sample's scale.

    Where a mask leaves no room for it at any level, the widest width that fits.
    """
    if method.window_width:
        return width_for(method.window_width, exemplar, 1)
    proposed, widest = structure_scale(exemplar).window_width, min(exemplar.shape)
    if method.search == "coherent":
        proposed, widest = max(_NARROWEST_PYRAMID, proposed), 2 * _LARGEST_REACH + 1
    width = width_for(None, exemplar, proposed)
    if exemplar.mask is None:
        return width
    whole = narrowed(min(width, widest), lambda side: square_windows(exemplar, side))
    return width if whole == min(width, widest) else whole


def reach_and_level_count(method: Any, exemplar: Exemplar) -> tuple[int, int]:
    """Return the reach in pixels of the windows of a level, and the number of pyramid levels.

    `method` is resolved for the sample. The search "nearest" has one level.
    """
    reach: int = method.window_width // 2
    if method.search == "nearest":
        return reach, 1
    reach = min(_LARGEST_REACH, reach)
    return reach, _level_count(exemplar, method.window_width, reach)


def seed_spacing(method: Any, exemplar: Exemplar, *, by_canvas: bool) -> float:
    """Return the distance of seed points in pixels of the sample.

    `method` is resolved. With `by_canvas`, seeds may be planted although its `init` is a method.
    """
    scale = method.seed_scale
    if scale is None:
        scale = structure_scale(exemplar).scale if by_canvas else 1.0
    return min(float(scale / method.seed_density), _FARTHEST)


def _level_count(exemplar: Exemplar, width: int, reach: int) -> int:
    """How many levels make a window of the coarsest `width` pixels wide; fewer by size and mask."""
    count = 1
    while (2 * reach + 1) << (count - 1) < width and min(
        exemplar.shape
    ) >> count >= _SMALLEST_LEVEL:
        count += 1
    if exemplar.mask is None:
        return count
    for number, mask in enumerate(mask_pyramid(exemplar.mask, count, (exemplar.tileable,) * 2)):
        usable = np.pad(mask, reach, mode="wrap") if exemplar.tileable else mask
        if number and not whole_windows(usable, (reach,) * 4).any():
            return number
    return count
