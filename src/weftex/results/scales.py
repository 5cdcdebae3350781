"""Maps that a result is rendered from, with more or fewer pixels than the sample."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from weftex.errors import InvalidInputError, size_words
from weftex.exemplar import Exemplar
from weftex.exemplar.exemplar import as_map
from weftex.raster.arrays import check_pixels
from weftex.raster.levels import resized, scale_between
from weftex.results.sources import Window
from weftex.roles import as_role

if TYPE_CHECKING:
    from fractions import Fraction


class RenderedMaps(Mapping[str, NDArray[Any]]):
    """Maps by name, each rendered on access, so that a set of large maps is never all in memory."""

    def __init__(self, names: Iterable[str], render: Callable[[str], NDArray[Any]]) -> None:
        self._names, self._render = tuple(names), render

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._names:
            raise KeyError(name)
        return self._render(name)

    def __contains__(self, name: object) -> bool:
        return name in self._names  # without rendering it

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<maps: {', '.join(self._names) or 'none'}>"


def check_map_scales(exemplar: Exemplar, shape: tuple[int, int]) -> None:
    """Raise if a side is no multiple of the pixels that one pixel of a coarser map covers."""
    for name in exemplar.maps:
        check_window((0, 0, *shape), exemplar.scale_of(name), name)


def as_rendered(given: Any, role: str | None) -> Exemplar:
    """The picture as an Exemplar; an array takes its role from `role`."""
    if role is None:
        return as_map(given, "map")
    if isinstance(given, Exemplar):
        raise InvalidInputError("role has no effect with an Exemplar; give it to the Exemplar")
    return as_map(given, as_role(role).name)


def scale_to(given: Exemplar, sample: tuple[int, int]) -> Fraction | int:
    """Pixels of a map per pixel of the sample; raises unless an integer or 1 / integer."""
    scale = scale_between(given.shape, sample)
    if scale is None:
        raise InvalidInputError(
            f"map is {size_words(given.shape)}; it must be the sample's {size_words(sample)} "
            "or an integer multiple or fraction of it"
        )
    return scale


def shape_of(
    given: Exemplar, sample: tuple[int, int], turn: str | None, copy_shape: tuple[int, int] | None
) -> tuple[int, int]:
    """Return the size of what a map is of: a picture of copies, or the sample that was turned."""
    if copy_shape is None or given.turn == turn or scale_between(given.shape, copy_shape) is None:
        return sample
    # Quarter turns of a single pixel are 3x3, which is also a map of it in three times as many.
    return sample if (scale_between(given.shape, sample) or 0) >= 1 else copy_shape


def background_of(
    pixels: NDArray[Any],
    shape: tuple[int, int],
    scale: int,
    known_from: tuple[int, int] | None,
    given: NDArray[Any] | None,
) -> NDArray[Any]:
    """Return the pixels under the patches where the canvas is known: given, or of the sample.

    `shape` is the output's, in pixels of the sample; `scale` is pixels per pixel of the sample.
    """
    height, width = (side * scale for side in shape)
    if given is not None:
        background = check_pixels(given, "background")
    elif known_from is not None:
        y, x = (k * scale for k in known_from)
        background = pixels[y : y + height, x : x + width]
    else:
        raise InvalidInputError("the known pixels are of a photo; give their map as background")
    wanted = (height, width, *pixels.shape[2:])
    if background.shape != wanted or background.dtype != pixels.dtype:
        raise InvalidInputError(
            f"background is {background.shape} {background.dtype}; it must be {wanted} "
            f"{pixels.dtype}"
        )
    return background


def check_window(window: Window, scale: Fraction | int, name: str) -> None:
    """`check_map_scales` for a part of the output."""
    if any(side * scale % 1 for side in window):
        raise InvalidInputError(
            f"map '{name}' has a pixel for {scale.denominator}x{scale.denominator} of the sample, "
            f"so the output's {window[3]}x{window[2]} must be multiples of {scale.denominator}"
        )


def in_few_pixels(
    lay: Callable[[Exemplar, NDArray[Any] | None], NDArray[Any]],
    given: Exemplar,
    background: NDArray[Any] | None,
    scale: Fraction | int,
) -> NDArray[Any]:
    """Render a map with fewer pixels than the sample at its own size.

    It is rendered with repeated pixels, then each block becomes its mean, or its middle pixel for
    vectors, labels and colors with alpha.
    """
    large = given.changed(pixels=resized(given.pixels, 1 / scale), maps={}, mask=None, guide=None)
    made = lay(large, None if background is None else resized(background, 1 / scale))
    if given.alpha or given.role.kind in ("normal", "labels"):
        middle, step = scale.denominator // 2, scale.denominator
        return made[middle::step, middle::step]
    return resized(made, scale)
