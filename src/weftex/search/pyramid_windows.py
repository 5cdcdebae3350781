"""Windows over two levels of a sample's pyramid, as vectors (Wei and Levoy, 2000, section 3).

The vector of a pixel is the bytes of the N x N window around its parent, then those of its own
S x S window in scan order without the pixel itself. So the L-shaped window is the vector's first
part, and one table of offsets serves the sample and the canvas.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.random import draw
from weftex.raster.arrays import Bytes
from weftex.raster.pyramids import gaussian_pyramid, mask_pyramid
from weftex.search.windows import Windows, windows_of

_CHUNK = 4096  # windows that are copied at a time


def sample_pyramid(exemplar: Exemplar, count: int) -> list[Exemplar]:
    """Return the levels of a sample, finest first: `count`, or fewer if its mask leaves no more.

    Pixels are bytes, as of `Exemplar.matching`. A tileable sample is tileable at every level.
    """
    wrap = (exemplar.tileable, exemplar.tileable)
    return [
        Exemplar(pixels, mask=usable, tileable=exemplar.tileable, alpha=False, name=exemplar.name)
        for pixels, usable in zip(
            gaussian_pyramid(exemplar.matching(), count, wrap),
            mask_pyramid(exemplar.usable, count, wrap),
            strict=True,
        )
        if usable.any()
    ]


def window_offsets(width: int, causal: bool) -> NDArray[np.int32]:
    """Return (n, 2) dy and dx of a window's pixels, in scan order, without the center."""
    around = parent_offsets(width)
    return np.delete(around, len(around) // 2, axis=0)[: len(around) // 2 if causal else None]


def parent_offsets(width: int) -> NDArray[np.int32]:
    """Rows and columns of a window around the parent: (n, 2); none for a width of 0."""
    every = np.indices((width, width)).reshape(2, -1).T - width // 2
    return np.ascontiguousarray(every, np.int32)


def interior_windows(
    sample: Exemplar, parent: Exemplar | None, width: int, parent_width: int, *, causal: bool
) -> list[tuple[Windows, NDArray[np.int32], NDArray[np.int32]]]:
    """Return (windows, centers, offsets) at the parent's level, if any, and at the own.

    Windows are whole. Centers are flat indices into them. `width` and `parent_width` are S and N,
    odd, in pixels.
    """
    reach = width // 2
    own = windows_of(sample, (reach, 0 if causal else reach, reach, reach))
    offsets = window_offsets(width, causal)
    if parent is None:
        return [(own, own.centers, offsets)]
    reach = parent_width // 2
    above = windows_of(parent, (reach, reach, reach, reach))
    y, x = np.divmod(own.to_sample(own.centers), sample.shape[1])
    at = above.from_sample((y // 2 * parent.shape[1] + x // 2).astype(np.int32))
    whole = above.usable.reshape(-1)[at] > 0
    if not whole.any():
        raise InvalidInputError(f"no window of {sample.name} is whole at two levels")
    return [(above, at[whole], parent_offsets(parent_width)), (own, own.centers[whole], offsets)]


def window_vectors(
    sample: Exemplar,
    parent: Exemplar | None,
    width: int,
    parent_width: int,
    *,
    causal: bool,
    most: int = 0,
) -> tuple[NDArray[np.uint8], NDArray[np.int32]]:
    """Return uint8 (n, D) vectors of a level's pixels, and (n,) flat indices of them in scan order.

    They are a random part of `most` pixels if there are more; 0 takes all. For the other parameters
    see `interior_windows`.
    """
    parts = interior_windows(sample, parent, width, parent_width, causal=causal)
    places = parts[-1][0].to_sample(parts[-1][1])
    kept = np.arange(len(places))
    if 0 < most < len(kept):
        kept = np.sort(np.argsort(draw(0, "windows", places), kind="stable")[:most])
    vectors = [_bytes_at(windows, at[kept], offsets) for windows, at, offsets in parts]
    return np.concatenate(vectors, axis=1), places[kept]


def _bytes_at(windows: Windows, centers: NDArray[np.int32], offsets: NDArray[np.int32]) -> Bytes:
    pixels = windows.pixels.reshape(-1, windows.pixels.shape[2])
    away = offsets[:, 0] * windows.pixels.shape[1] + offsets[:, 1]
    result = np.empty((len(centers), len(away) * pixels.shape[1]), np.uint8)
    for start in range(0, len(centers), _CHUNK):
        part = slice(start, start + _CHUNK)
        result[part] = pixels[centers[part, None] + away].reshape(-1, result.shape[1])
    return result
