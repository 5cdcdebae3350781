"""The canvas: the output's size, the axes that wrap around, known pixels and the guide."""

from __future__ import annotations

import numbers
import operator
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError, is_whole, shown, size_words, wrong_value
from weftex.exemplar import Exemplar
from weftex.raster.arrays import as_mask, check_guide, check_pixels

__all__ = ["Canvas", "as_canvas"]

#: The most pixels that a canvas may have; more is taken for a mistake.
MAX_PIXELS = 2**30
#: How far from its own origin a window of an endless plane may begin, in pixels.
FAR = 2**40
MOST_WRAPPED = 7 / 8  # of a wrapped axis that one patch covers; the rest joins its ends
_WHITE = {"uint8": 255, "uint16": 65535}  # 1 in floating point
#: Canvas kinds that a method may declare in `supports`, in words for messages.
CANVAS_KINDS = {
    "wrap": "tileable output",
    "known": "hole filling",
    "guide": "following a guide",
    "many": "several samples in one picture",
    "random_access": "parts of an endless plane",
}
#: The thing that a canvas of a kind has.
CANVAS_NAMES = {"guide": "a guide", "known": "known pixels", "wrap": "tileable output"}


@dataclass(frozen=True, eq=False)
class Canvas:
    """The output: its size, which axes wrap around, known pixels and guide.

    Parameters
    ----------
    height, width : int
        Number of rows of pixels, 1 or more; number of columns, at most 2**30 pixels in all.
    wrap : (bool, bool)
        Whether the output repeats without a seam vertically and horizontally.
    known : array (H, W) or (H, W, C), optional
        Known pixels, in the sample's dtype and channels; needs `hole`.
    hole : bool array (H, W), optional
        True where `known` is to be filled.
    known_from : (int, int), optional
        Row and column of the canvas in the sample, if the known pixels are part of the sample.
    known_maps : mapping of str to array
        Maps of the known pixels, by the names of the sample's maps, if these pixels are not in it.
    origin : (int, int)
        Row and column of the canvas's corner in an endless plane, from -2**40 to 2**40.
    guide : array (H, W) or (H, W, C), optional
        Image that the output follows. It is compared with the sample's guide if there is one (see
        `Exemplar`), else with the sample's pixels, and has their dtype and channels.
    shown : int32 array (H, W), optional
        The source of each pixel that has a value already (in a part of an endless plane, or in a
        border that may change), as row * width + column in the sample; else -1. For methods.

    Raises
    ------
    InvalidInputError
        If a size is out of range, or `known`, `hole` and `guide` do not fit it.

    Examples
    --------
    >>> Canvas(4, 6, wrap=(False, True)).shape
    (4, 6)
    """

    height: int
    width: int
    wrap: tuple[bool, bool] = (False, False)
    known: NDArray[Any] | None = field(default=None, repr=False)
    hole: NDArray[np.bool_] | None = field(default=None, repr=False)
    known_from: tuple[int, int] | None = None
    guide: NDArray[Any] | None = field(default=None, repr=False)
    origin: tuple[int, int] = (0, 0)
    known_maps: Mapping[str, NDArray[Any]] = field(default_factory=dict, repr=False)
    shown: NDArray[np.int32] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        for name in ("height", "width"):
            value = getattr(self, name)
            if not is_whole(value, 1):
                raise wrong_value(name, value, "an integer of 1 or more")
            object.__setattr__(self, name, int(value))
        if self.height * self.width > MAX_PIXELS:
            raise InvalidInputError(
                f"{shown(self.width)}x{shown(self.height)} is more than {MAX_PIXELS} pixels at "
                "once; make a tileable piece and repeat it, or several pieces"
            )
        wrap = self.wrap
        if not (isinstance(wrap, tuple) and len(wrap) == 2 and {*map(type, wrap)} == {bool}):
            raise wrong_value("wrap", wrap, "two booleans (vertical, horizontal)")
        if not isinstance(self.origin, tuple) or len(self.origin) != 2:
            raise wrong_value("origin", self.origin, "(top, left)")
        for name, at in zip(("top", "left"), self.origin, strict=True):
            if not is_whole(at, -FAR, FAR):
                raise wrong_value(name, at, "an integer from -2**40 to 2**40")
        object.__setattr__(self, "origin", (int(self.origin[0]), int(self.origin[1])))
        whole = self.shown is None and self.hole is not None  # no block of a plane
        if self.origin != (0, 0) and (any(self.wrap) or whole):
            raise InvalidInputError(
                "a part of an endless plane neither wraps nor has known pixels; leave origin out"
            )
        if self.known_from is not None:
            try:
                y, x = (operator.index(part) for part in self.known_from)
            except (TypeError, ValueError):
                wanted = "(row, column) in the sample"
                raise wrong_value("known_from", self.known_from, wanted) from None
            object.__setattr__(self, "known_from", (y, x))
        if self.hole is None and self.known is not None:
            raise InvalidInputError("known pixels need a hole, the mask of the pixels to fill")
        if self.hole is not None:
            object.__setattr__(self, "hole", as_mask(self.hole, "hole"))
            if self.known is not None:
                object.__setattr__(self, "known", check_pixels(self.known, "known"))
        if self.guide is not None:
            object.__setattr__(self, "guide", check_guide(self.guide, "guide"))
        for name in ("known", "hole", "guide", "shown"):
            value = getattr(self, name)
            if value is not None and value.shape[:2] != self.shape:
                raise InvalidInputError(
                    f"{name} is {size_words(value.shape)}, the canvas is {size_words(self.shape)}"
                )

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.height, self.width

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of output that it needs, as in `Method.supports`: "wrap", "known" and others.

        Examples
        --------
        >>> Canvas(3, 4, wrap=(True, False)).kinds
        ('wrap',)
        """
        found = {
            "wrap": any(self.wrap),
            "known": self.hole is not None and not self.hole.all(),
            "guide": self.guide is not None,
            "random_access": self.origin != (0, 0) and self.shown is None,
        }
        return tuple(kind for kind, is_one in found.items() if is_one)

    def check_window(self, window: tuple[int, int, int, int] | None) -> tuple[int, int, int, int]:
        """Return (top, left, height, width) if that lies inside; None is the whole canvas."""
        if window is None:
            return (0, 0, *self.shape)
        try:
            top, left, height, width = (operator.index(part) for part in window)
        except (TypeError, ValueError):
            raise wrong_value("window", window, "(top, left, height, width)") from None
        if min(top, left) < 0 or min(height, width) < 1:
            raise wrong_value("window", window, "inside the output")
        if top + height > self.height or left + width > self.width:
            raise InvalidInputError(
                f"window {shown(window)} leaves the output, which is {self.height} high "
                f"and {self.width} wide"
            )
        return top, left, height, width

    def check_known(self, exemplar: Exemplar) -> None:
        """Raise `InvalidInputError` unless the known pixels are of the sample's kind and place."""
        if self.known is not None:
            _check_kind("known pixels are", self.known, exemplar)
        if self.known_from is not None:
            ends = [at + side for at, side in zip(self.known_from, self.shape, strict=True)]
            if min(self.known_from) < 0 or any(map(operator.gt, ends, exemplar.shape)):
                raise InvalidInputError(
                    f"known_from is {shown(self.known_from)}; the canvas must lie in the sample"
                )

    def check_guide(self, exemplar: Exemplar) -> None:
        """Raise `InvalidInputError` unless the guide is of the sample's or its guide's kind."""
        if self.guide is None:
            return
        if exemplar.guide is None:
            _check_kind("guide is", self.guide, exemplar)
            return
        kinds = [
            ("labels" if exemplar.labels is not None else p.dtype.name, p.shape[2:])
            for p in (self.guide, exemplar.guide)
        ]
        if kinds[0] != kinds[1]:
            (given, shape), (wanted, wanted_shape) = kinds
            raise InvalidInputError(
                f"guide is {given} {shape}, the guide of {exemplar.name} is {wanted} "
                f"{wanted_shape}; dtype and channels must be equal"
            )
        exemplar.as_guide(self.guide)


def _check_kind(what: str, pixels: NDArray[Any], exemplar: Exemplar) -> None:
    """Raise `InvalidInputError` unless dtype and channels are the sample's."""
    kinds = [(p.dtype.name, p.shape[2:]) for p in (pixels, exemplar.pixels)]
    if kinds[0] == kinds[1]:
        return
    (given, _), (wanted, _) = kinds
    fix = ""
    if given != wanted:
        factor = _WHITE.get(wanted, 1) / _WHITE.get(given, 1)
        fix = f"; multiply by {factor:.6g} and make it {wanted}"
    raise InvalidInputError(
        f"{what} {given} {kinds[0][1]}, the sample is {wanted} {kinds[1][1]}; "
        f"dtype and channels must be equal{fix}"
    )


def as_canvas(size: Canvas | int | tuple[int, int], tileable: bool | str = False) -> Canvas:
    """Make a Canvas from a size (height, width), or one number for a square.

    Parameters
    ----------
    size : Canvas, int or (int, int)
        A Canvas is returned as it is, and then `tileable` must not be given.
    tileable : bool or {"x", "y"}
        Which axes are to repeat without a seam.

    Examples
    --------
    >>> as_canvas((4, 6), tileable="x").wrap
    (False, True)
    """
    wraps = {False: (False, False), True: (True, True), "x": (False, True), "y": (True, False)}
    if not isinstance(tileable, (bool, np.bool_, str)) or tileable not in wraps:
        raise wrong_value("tileable", tileable, "True, False, 'x' or 'y'")
    if isinstance(size, Canvas):
        if tileable:
            raise InvalidInputError("tileable has no effect with a Canvas; give wrap to the Canvas")
        return size
    if isinstance(size, numbers.Integral) and not isinstance(size, bool):
        size = (int(size), int(size))
    try:
        pair: Any = size if isinstance(size, (list, tuple, np.ndarray)) else ()
        height, width = pair
    except (TypeError, ValueError):
        raise wrong_value("size", size, "(height, width)") from None
    return Canvas(height, width, wraps[tileable])
