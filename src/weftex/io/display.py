"""Images in notebooks and as NumPy arrays."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.raster.levels import scale_to_bytes, to_bytes

LARGEST = 1024  # pixels a side; of a larger picture every second, third, ... pixel is shown


class Displayable:
    """An object with an image: an array for NumPy, the image itself in a notebook."""

    @abstractmethod
    def _displayed_picture(self) -> tuple[NDArray[Any], bool] | None:
        """The pixels, and whether the last channel is alpha; None where there are none yet."""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        found = self._displayed_picture()
        if found is None:
            raise ValueError("this result was loaded without its sample; render a map of it")
        return np.asarray(found[0], dtype) if copy is None else np.array(found[0], dtype, copy=copy)

    def _repr_png_(self) -> bytes | None:
        from weftex.io.png import png_bytes  # takes its time, and few pictures are looked at

        found = self._displayed_picture()
        return None if found is None else png_bytes(small_bytes(*found))

    def _repr_html_(self) -> str | None:
        from html import escape

        from weftex.io.png import data_url

        found = self._displayed_picture()
        if found is None:
            return None
        image = f'<img alt="" src="{data_url(small_bytes(*found))}">'
        return f"<figure>{image}<figcaption>{escape(repr(self))}</figcaption></figure>"


def small_bytes(pixels: NDArray[Any], alpha: bool = False) -> NDArray[np.uint8]:
    """The picture as uint8 gray or RGB with at most `LARGEST` pixels a side, for display."""
    step = -(-max(pixels.shape[:2]) // LARGEST)
    small = np.atleast_3d(pixels)[::step, ::step]
    shown = small[..., : 3 if small.shape[2] - alpha >= 3 else 1]
    if shown.dtype != np.uint8:
        shown = np.rint(to_bytes(shown, scale_to_bytes(shown))).astype(np.uint8)
    if alpha:
        top = {"u": 255 if small.dtype == np.uint8 else 65535, "f": 1}[small.dtype.kind]
        cover = np.rint(255 * np.clip(small[..., -1:] / top, 0, 1)).astype(np.uint8)
        shown = np.concatenate([shown, cover], axis=2)
    return np.ascontiguousarray(shown)


def size_text(pixels: NDArray[Any]) -> str:
    """Width, height, channels and dtype of a picture in words, such as '6x4, 3 x uint8'."""
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    return f"{pixels.shape[1]}x{pixels.shape[0]}, {channels} x {pixels.dtype}"
