"""Results of pixel methods: each pixel of the output has one of the sample as its source."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.exemplar import Exemplar
from weftex.io.npz import DamageError
from weftex.raster.arrays import Indices, Ints
from weftex.raster.mixing import Mixing
from weftex.results import paste_kernels
from weftex.results.joining import spans_of
from weftex.results.saved import ABOUT
from weftex.results.sources import Place, Span, Window
from weftex.results.synthesis import Synthesis


class PixelSynthesis(Synthesis):
    """A result with one source per pixel: `index` (H, W) is y * width + x, -1 for a known pixel.

    Of a part of a plane it has whole `cells` with the lines around them, see `spans_of`.
    """

    ARRAYS = {"index": np.int32}  # noqa: RUF012
    OPTIONAL = {"parts": np.uint16, "cells": np.int64}  # noqa: RUF012

    def __init__(
        self, canvas: Canvas, index: Indices, cells: Ints | None = None, **about: Any
    ) -> None:
        super().__init__(canvas, **about)
        self.index, self.cells = index, cells

    def _indices(self, window: Window) -> Indices:
        """The index in a window."""
        frame = frame_of(self.cells, self.shape)
        top, left = (at - first for at, (first, _) in zip(window, frame, strict=False))
        return self.index[top : top + window[2], left : left + window[3]]

    def stretched(self, canvas: Canvas) -> PixelSynthesis:
        """Return this result in another size: lines are left out or doubled evenly.

        Lines beside few seams are left out, as pieces that fit would be off by a pixel there.
        """
        index = self.index
        for axis, (n, count) in enumerate(zip(self.shape, canvas.shape, strict=True)):
            lines = np.arange(count) * n // count
            if count < n:
                on = (self.sample_shape[1], 1)[axis]
                cut = (np.roll(index, -1, axis) - index != on).sum(axis=1 - axis)
                seams, ends = cut + np.roll(cut, 1), np.arange(n - count + 1) * n // (n - count)
                out = [a + seams[a : (a + b + 1) // 2].argmin() for a, b in pairwise(ends)]
                lines = np.delete(np.arange(n), out)
            if count != n:
                index = index.take(lines, axis)
        return self._again(canvas, index)

    def through(self, index: Indices, exemplar: Exemplar, by: dict[str, Any]) -> PixelSynthesis:
        """Return this result of a rearranged sample as one of the sample itself, made `by`."""
        about = {"exemplar": exemplar, "provenance": self.provenance | by, "parts": None}
        return self._again(self.canvas, index.ravel()[self.index], **about)

    def enlarged(self, canvas: Canvas, exemplar: Exemplar, step: int) -> PixelSynthesis:
        """Return this filling of a copy of a photo, smaller by whole `step`s, for the photo."""
        assert canvas.hole is not None and self.canvas.hole is not None
        sides = zip(canvas.shape, self.shape, strict=True)
        cells = [np.minimum(np.arange(n) // step, count - 1) for n, count in sides]
        y, x = (np.minimum(np.arange(len(cell)) - cell * step, step - 1) for cell in cells)
        places = np.ix_(*cells)
        down, along = np.divmod(self.index[places], self.sample_shape[1])
        index = (down * step + y[:, None]) * exemplar.shape[1] + along * step + x
        hole = canvas.hole & self.canvas.hole[places]
        index = np.where(hole, index, -1).astype(np.int32)
        return self._again(replace(canvas, hole=hole), index, exemplar=exemplar)

    def _again(self, canvas: Canvas, index: Indices, **changes: Any) -> PixelSynthesis:
        names = (*ABOUT, "exemplar", "threads", "parts")
        about: dict[str, Any] = {name: getattr(self, name) for name in names}
        return PixelSynthesis(canvas, index, **about | changes)

    def _layers(self, window: Window) -> tuple[Indices, NDArray[np.float32]]:
        index = self._indices(window)
        made = index >= 0
        coordinates = np.empty((*index.shape, 1, 2), np.int32)
        np.floor_divide(index, self.sample_shape[1], out=coordinates[:, :, 0, 0])
        before = coordinates[:, :, 0, 0] * np.int32(self.sample_shape[1])
        np.subtract(index, before, out=coordinates[:, :, 0, 1])
        if not made.all():
            coordinates[~made] = -1
        return coordinates, made[..., None].astype(np.float32)

    def _lay(self, out: NDArray[Any], pixels: NDArray[Any], window: Window, mixing: Mixing) -> None:
        """Copy: nothing is mixed."""
        index, scale = self._indices(window), out.shape[0] // window[2]
        lines, sample = (a.view(np.uint8).reshape(len(a), -1) for a in (out, pixels))
        paste_kernels.copy_pixels(lines, sample, index, self.sample_shape[1], scale)

    def _moved_arrays(
        self, shape: tuple[int, int], sample: tuple[int, int], to: Place, source_to: Place
    ) -> dict[str, NDArray[Any]]:
        index = np.full(shape, -1, np.int32)
        y, x = np.nonzero(self.index >= 0)
        source_y, source_x = np.divmod(self.index[y, x], self.sample_shape[1])
        source_y, source_x = (source_y + source_to[0]) % sample[0], source_x + source_to[1]
        places = source_y * sample[1] + source_x % sample[1]
        index[(y + to[0]) % shape[0], (x + to[1]) % shape[1]] = places
        return {"index": index}

    @classmethod
    def _check(cls, canvas: Canvas, sample: tuple[int, int], arrays: dict[str, Any]) -> None:
        index, cells = arrays["index"], arrays.get("cells")
        for spans, n in zip(() if cells is None else spans_of(cells), canvas.shape, strict=False):
            ends = [first for first, _ in spans] + [last for _, last in spans[-1:]]
            if not len(spans) % 2 or ends != sorted({*ends}) or not ends[0] <= 0 < n <= ends[-1]:
                raise DamageError("its cells are invalid")
        if index.shape != tuple(end - first for first, end in frame_of(cells, canvas.shape)):
            raise DamageError("its sources do not fit its size")
        least = 0 if canvas.hole is None else -1  # only known pixels come from nowhere
        if ((index < least) | (index >= sample[0] * sample[1])).any():
            raise DamageError("its sources lie outside")


def frame_of(cells: Ints | None, shape: tuple[int, int]) -> list[Span]:
    """The rows and the columns of the index of a result of a shape."""
    spans = [[], []] if cells is None else spans_of(cells)
    return [(one[0][0], one[-1][1]) if one else (0, n) for one, n in zip(spans, shape, strict=True)]


def rearranged(exemplar: Exemplar, index: Indices, **parts: Any) -> Exemplar:
    """Return a sample and maps of other pixels, y * width + x, and other `parts`."""
    made = PixelSynthesis(Canvas(*index.shape), index, exemplar=exemplar)
    maps = {k: exemplar.map(k).changed(pixels=one) for k, one in made.maps.items()}
    return exemplar.changed(pixels=made.image, maps=maps, **parts)
