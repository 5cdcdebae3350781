"""A result beside its sample, with the source of its pixels as far as that is known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weftex.errors import InvalidInputError, shown
from weftex.exemplar import Exemplar
from weftex.exemplar.turns import as_made_from
from weftex.quality.copying import check_source
from weftex.raster.arrays import check_pixels
from weftex.results.synthesis import Synthesis

if TYPE_CHECKING:
    from numpy.typing import NDArray

LARGEST_MEASURED = 2048
"""Pixels a side: of a larger result the middle is measured, except for the wrap."""


class Pair(NamedTuple):
    """A sample and a result.

    `source` (H, W, 2) refers to `pictured`: the sample, or a picture of its oriented copies.
    """

    exemplar: Exemplar
    pixels: NDArray[Any]
    source: NDArray[Any] | None
    pictured: Exemplar
    wrap: tuple[bool, bool]


def pair_of(
    sample: Exemplar | NDArray[Any],
    result: Synthesis | NDArray[Any],
    source: Synthesis | NDArray[Any] | None = None,
    tileable: bool | tuple[bool, bool] | None = None,
) -> Pair:
    """Return a pair as `weftex.assess` takes it, checked."""
    exemplar = sample if isinstance(sample, Exemplar) else Exemplar(sample)
    tiles = False if tileable is None else tileable
    wrap: Any = tiles if isinstance(tiles, tuple) else (tiles,) * 2
    if len(wrap) != 2 or not all(isinstance(axis, (bool, np.bool_)) for axis in wrap):
        raise InvalidInputError(
            f"tileable is {shown(tileable)}; it must be True, False or two of them"
        )
    pixels: Any = result
    pictured = exemplar
    if isinstance(result, Synthesis):
        pixels = result.image if result.exemplar is not None else result.render(exemplar)
    pixels = check_pixels(pixels, "result")
    origin = source if isinstance(source, Synthesis) else result
    if isinstance(origin, Synthesis):
        pictured = as_made_from(exemplar, origin.turn)
        if origin.sample_shape != pictured.shape or origin.shape != pixels.shape[:2]:
            raise InvalidInputError(
                f"the source makes {_size(origin.shape)} from {_size(origin.sample_shape)}, but "
                f"result and sample are {_size(pixels.shape)} and {_size(pictured.shape)}"
            )
        source = made_from(origin) if source is None or source is origin else source
        wrap = origin.canvas.wrap if tileable is None else wrap
    rows: Any = source
    if rows is not None:
        rows = check_source(rows, pictured.shape, pixels.shape[:2])
    return Pair(exemplar, pixels, rows, pictured, wrap)


def made_from(result: Synthesis) -> NDArray[np.int32]:
    """Return the source of a result, -1 where pixels were known before."""
    source = result.pictured_source()
    if result.canvas.hole is not None:
        source[~result.canvas.hole] = -1
    return source


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]}x{shape[0]}"
