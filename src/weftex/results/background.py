"""What is known around a filled hole, in the kind of picture that is rendered."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar.checks import check_pixels

if TYPE_CHECKING:
    from numpy.typing import NDArray


def background_of(
    pixels: NDArray[Any],
    size: tuple[int, int],
    scale: int,
    known_from: tuple[int, int] | None,
    given: NDArray[Any] | None,
) -> NDArray[Any]:
    """Pixels (H, W[, C]) under the patches where the canvas is known: given, or from the sample.

    Raises `InvalidInputError` if neither is there. `scale` is pixels per pixel of the sample.
    """
    if given is not None:
        background = check_pixels(given, "background")
    elif known_from is not None:
        y, x = (k * scale for k in known_from)
        background = pixels[y : y + size[0], x : x + size[1]]
    else:
        raise InvalidInputError(
            "the known pixels are not part of the sample; give their map as background"
        )
    if background.shape != (*size, *pixels.shape[2:]) or background.dtype != pixels.dtype:
        raise InvalidInputError(
            f"background is {background.shape} {background.dtype}; it must be "
            f"{(*size, *pixels.shape[2:])} {pixels.dtype}"
        )
    return background


def show_known(
    coordinates: NDArray[np.int32],
    shares: NDArray[np.float32],
    hole: NDArray[np.bool_],
    window: tuple[int, int, int, int],
    known_from: tuple[int, int] | None,
) -> None:
    """Set the coordinates and shares of known pixels of a window, which patches may overlap."""
    top, left, height, width = window
    known = ~hole[top : top + height, left : left + width]
    coordinates[known], shares[known] = -1, 0
    if known_from is not None:
        own = np.indices((height, width)).transpose(1, 2, 0) + (top, left) + known_from
        coordinates[known, 0] = own[known]
        shares[known, 0] = 1
