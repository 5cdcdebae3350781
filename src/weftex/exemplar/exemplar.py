"""The sample of a material that everything is made from."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError, shown, size_words, wrong_value
from weftex.io.display import Displayable, size_text
from weftex.raster.arrays import (
    as_mask,
    check_guide,
    check_layout,
    check_pixels,
    owned,
    without_mask,
)
from weftex.raster.levels import resized, scale_between, scale_to_bytes, to_bytes
from weftex.raster.mixing import Mixing, mixing_of
from weftex.roles import COLOR, Role, as_role, checked_weights, role_of

if TYPE_CHECKING:
    from fractions import Fraction

    from numpy.typing import NDArray

_PARTS = ("pixels", "mask", "guide", "tileable", "alpha", "icc", "name", "role")
_MADE_OF = ("pieces", "turn", "copy_shape")
_LABELS = 32  # a sample's guide with at most so many colors is a map of labels


class Exemplar(Displayable):
    """A sample: its pixels, maps, mask and guide.

    Parameters
    ----------
    pixels : array (H, W) or (H, W, C)
        uint8, uint16, float32 or float64; any number of channels. Copied, never rescaled. If it is
        a NumPy masked array, its masked pixels are not used.
    maps : mapping of str to array or Exemplar, optional
        Aligned maps (normal, roughness, height …), of any of these dtypes, any number of channels,
        and the same height and width, or an integer multiple or fraction of both. They take part in
        matching, so that no map shows seams. An array's role follows from its name.
    mask : bool array (H, W), optional
        True where a pixel may be used; everywhere by default.
    guide : array (H, W) or (H, W, C), optional
        Image that a canvas's guide is compared with: a map of at most 32 labels (colors or whole
        numbers), or any other image. By default the sample's own pixels.
    tileable : bool, optional
        The sample repeats without a seam, so patches can cross its borders.
    alpha : bool, optional
        Whether the last channel is straight alpha; by default with 2 and 4 channels. Arrays with
        channels first, such as (3, 64, 64), are refused. Pass `alpha` if 64 are the channels.
    icc : bytes, optional
        Color profile, written to files.
    name : str, optional
        Name for messages.
    role : Role or str, optional
        By default from `name` if that means normals or "id" (classes, never mixed), else "color".
    weights : mapping of str to float, optional
        Weight of each map in matching, 1 by default, 0 to ignore the map. With weights of 1, all
        maps together count as much as the pixels; a map of weight 3 counts three times as much.

    Attributes
    ----------
    pixels : array (H, W) or (H, W, C)
        The pixels.
    shape : tuple of int
        Height and width in pixels.
    maps : dict of str to array
        The pixels of its maps.
    pieces : bool
        Whether the sample consists of parts that are masked off from each other, such as copies.
    turn, copy_shape : str or None, (int, int) or None
        Which copies `weftex.prepare.turned` added, None if it was not used; height and width of
        one of these copies, None without them.

    Raises
    ------
    InvalidInputError
        If the image is empty, its dtype is not supported, it contains NaN or infinity, or the size
        of a mask or map does not fit.

    Examples
    --------
    >>> import numpy as np
    >>> Exemplar(np.zeros((4, 6, 3), np.uint8)).shape
    (4, 6)
    """

    pieces: bool = False
    turn: str | None = None
    copy_shape: tuple[int, int] | None = None

    def __init__(
        self,
        pixels: NDArray[Any],
        *,
        maps: Mapping[str, NDArray[Any] | Exemplar] | None = None,
        mask: NDArray[np.bool_] | None = None,
        guide: NDArray[Any] | None = None,
        tileable: bool = False,
        alpha: bool | None = None,
        icc: bytes | None = None,
        name: str = "sample",
        role: Role | str | None = None,
        weights: Mapping[str, float] | None = None,
    ) -> None:
        if not isinstance(name, str):
            raise wrong_value("name", name, "a string")
        self.name, self.tileable, self.icc = name, bool(tileable), icc
        pixels, usable = without_mask(pixels)
        named = role_of(name)
        by_name = named if named is not None and named.kind in ("normal", "labels") else COLOR
        self.role = by_name if role is None else as_role(role)
        if alpha is None:
            check_layout(pixels, name)
        self.pixels = owned(check_pixels(pixels, name))
        self.shape: tuple[int, int] = self.pixels.shape[:2]
        self.channels: int = 1 if self.pixels.ndim == 2 else self.pixels.shape[2]
        self.alpha: bool = self.channels in (2, 4) if alpha is None else bool(alpha)
        if self.alpha and self.channels < 2:
            raise InvalidInputError(f"{name} has one channel, so it cannot be color with alpha")
        if maps is not None and not isinstance(maps, Mapping):
            raise InvalidInputError(f"maps is {shown(maps)}; it must map names to arrays")
        for key in maps or ():
            if not isinstance(key, str):
                raise InvalidInputError(f"maps has the name {shown(key)}; it must be a string")
        own = {key: as_map(value, key) for key, value in (maps or {}).items()}
        self._maps = {k: one if one.name == k else one.changed(name=k) for k, one in own.items()}
        self.maps = {key: one.pixels for key, one in self._maps.items()}
        for key in self.maps:
            self.scale_of(key)
        self.weights = checked_weights(weights, self.maps)
        self.mask = usable if mask is None else owned(as_mask(mask, "mask"))
        if self.mask is not None and self.mask.shape != self.shape:
            raise InvalidInputError(
                f"mask is {size_words(self.mask.shape)}, {name} is {size_words(self.shape)}; scale "
                "or crop the mask to the size of the sample"
            )
        if self.mask is not None and usable is not None:
            self.mask = owned(self.mask & usable)
        if self.mask is not None and not self.mask.any():
            raise InvalidInputError(f"the mask of {name} leaves no usable pixel")
        self.guide = None if guide is None else owned(check_guide(guide, f"the guide of {name}"))
        if self.guide is not None and self.guide.shape[:2] != self.shape:
            raise InvalidInputError(
                f"the guide of {name} is {size_words(self.guide.shape)}, {name} is "
                f"{size_words(self.shape)}; they must be equal"
            )
        self._matching: NDArray[np.uint8] | None = None

    def __repr__(self) -> str:
        maps = f", maps: {', '.join(self.maps)}" if self.maps else ""
        return f"<Exemplar {self.name!r}: {size_text(self.pixels)}{maps}>"

    def _displayed_picture(self) -> tuple[NDArray[Any], bool]:
        return self.pixels, self.alpha

    def changed(self, **parts: Any) -> Exemplar:
        """Return a copy with other values for some parameters, such as `guide`."""
        made_of = {name: parts.pop(name) for name in _MADE_OF if name in parts}
        given = {name: getattr(self, name) for name in _PARTS} | {"maps": self._maps} | parts
        weights = {name: k for name, k in self.weights.items() if name in (given["maps"] or ())}
        found = Exemplar(**{"weights": weights} | given)
        found.pieces = self.pieces
        if found.shape == self.shape:
            found.turn, found.copy_shape = self.turn, self.copy_shape
        for name, value in made_of.items():
            setattr(found, name, value)
        return found

    def map(self, name: str) -> Exemplar:
        """Return one of the maps with its role, as an `Exemplar`."""
        return self._maps[name]

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Return which pixels may be used, bool (H, W): the mask, or all without one."""
        return np.ones(self.shape, bool) if self.mask is None else self.mask

    @property
    def roles(self) -> dict[str, Role]:
        """What each of the maps shows."""
        return {name: one.role for name, one in self._maps.items()}

    def scale_of(self, name: str) -> Fraction | int:
        """Return how many pixels of a map lie along one of the sample: an integer or 1 / integer.

        Raises
        ------
        InvalidInputError
            If sizes are no multiples of each other.
        """
        scale = scale_between(self._maps[name].shape, self.shape)
        if scale is None:
            raise InvalidInputError(
                f"map '{name}' is {size_words(self.maps[name].shape)}, {self.name} is "
                f"{size_words(self.shape)}; both sides must be equal, or the same integer multiple "
                "or fraction"
            )
        return scale

    def aligned(self, name: str) -> NDArray[Any]:
        """Return a map at the sample's own size: means of blocks, or pixels repeated."""
        return resized(self.maps[name], 1 / self.scale_of(name))

    @cached_property
    def mixing(self) -> Mixing:
        """How its pixels are mixed where two patches show."""
        return mixing_of(self.pixels, self.role.kind, self.alpha)

    def matching(self) -> NDArray[np.uint8]:
        """Return what distances are taken on: bytes (H, W, K), so that they are exact integers.

        Plain 8-bit pixels without maps are themselves.
        """
        if self._matching is None:
            self._matching = self.matching_of(self)
        return self._matching

    def matching_of(self, other: Exemplar) -> NDArray[np.uint8]:
        """Return another picture, with maps of the same names, in bytes as the sample's own are."""
        own = [self.as_matching(other.pixels)]
        # All maps of weight 1 together weigh as much as the picture.
        factors = {
            name: (len(self.maps) / w) ** -0.5 * (self.channels / self._maps[name].channels) ** 0.5
            for name, w in self.weights.items()
            if w > 0
        }
        largest = max(factors.values(), default=0)
        if largest > 1 and max(self.weights.values()) > 1:  # all of them are to fit into bytes
            own = [np.rint(own[0] / largest).astype(np.uint8)]
            factors = {name: factor / largest for name, factor in factors.items()}
        for name, factor in factors.items():
            values = to_bytes(other.aligned(name), scale_to_bytes(self.aligned(name)[self.usable]))
            own.append(np.rint(np.minimum(values * factor, 255)).astype(np.uint8))
        return np.ascontiguousarray(own[0] if len(own) == 1 else np.concatenate(own, axis=2))

    def as_matching(self, pixels: NDArray[Any]) -> NDArray[np.uint8]:
        """Map pixels of this sample's dtype and channels to bytes as the sample's own are.

        Brightness ratios survive (a tolerance relative to the canvas means the same at any bit
        depth) unless the values lie in a narrow band, which is then stretched. Alpha is multiplied
        in and kept beside the colors, so that the color of clear pixels does not count.
        """
        pixels = pixels.reshape(*pixels.shape[:2], -1)
        own = self.pixels if self.mask is None else self.pixels[self.mask]
        if self.alpha:
            top = {"u": 255 if pixels.dtype == np.uint8 else 65535, "f": 1}[pixels.dtype.kind]
            clear = np.clip(pixels[..., -1:] / top, 0, 1)
            values = to_bytes(pixels[..., :-1], scale_to_bytes(own[..., :-1])) * clear
            values = np.concatenate([values, clear * 255], axis=2)
            result = np.rint(values).astype(np.uint8)
        elif pixels.dtype == np.uint8:
            result = pixels
        else:
            result = np.rint(to_bytes(pixels, scale_to_bytes(own))).astype(np.uint8)
        return np.ascontiguousarray(result)

    @cached_property
    def labels(self) -> NDArray[Any] | None:
        """The colors (n, C) of a guide that is a map of labels; None for any other picture."""
        if self.guide is None:
            return None
        found = np.unique(self.guide.reshape(self.shape[0] * self.shape[1], -1), axis=0)
        return found if len(found) <= _LABELS else None

    def as_known(self, known: NDArray[Any]) -> NDArray[np.uint8]:
        """Return a canvas's known pixels as `as_matching` does; refuse them if maps matter."""
        found = self.as_matching(known)
        if found.shape[2] != self.matching().shape[2]:
            raise InvalidInputError("a canvas's known pixels have no maps; use weftex.fill")
        return found

    def as_guide(self, pixels: NDArray[Any]) -> NDArray[np.uint8]:
        """Map a guide to bytes, so that it can be compared with the sample's own.

        Labels become as many channels, so that any two of them are equally far apart; those that
        the sample's guide lacks are refused.
        """
        if self.guide is None:
            return self.as_matching(pixels)
        if self.labels is None:
            values = to_bytes(pixels, scale_to_bytes(self.guide))
            return np.ascontiguousarray(np.rint(values), np.uint8)
        flat = pixels.reshape(pixels.shape[0] * pixels.shape[1], -1)
        same = np.stack([(flat == label).all(axis=1) for label in self.labels], axis=1)
        unknown = np.flatnonzero(~same.any(axis=1))
        if len(unknown):
            there = ", ".join(map(color_text, self.labels[:6])) + ", ..." * (len(self.labels) > 6)
            raise InvalidInputError(
                f"the guide has the color {color_text(flat[unknown[0]])}, which the guide of "
                f"{self.name} lacks; that is a map of labels and has {there}"
            )
        same = same[:, -1:] if len(self.labels) <= 2 else same
        return np.ascontiguousarray(255 * same.reshape(*pixels.shape[:2], -1), np.uint8)


def as_map(given: Any, name: str) -> Exemplar:
    """Return a map with the role that its name gives; plain numbers where it gives none."""
    if isinstance(given, Exemplar):
        return given
    check_layout(given, f"map '{name}'")
    pixels, role = check_pixels(given, name), role_of(name) or Role(name)
    alpha = pixels.ndim == 3 and pixels.shape[2] in (2, 4) and not role.channels
    return Exemplar(pixels, alpha=alpha, name=name, role=role)


def color_text(values: NDArray[Any]) -> str:
    """Return a color as messages show it."""
    text = ", ".join(f"{v:g}" for v in values)
    return f"({text})" if len(values) > 1 else text
