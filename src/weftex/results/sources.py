"""The answer to the question which sample pixel goes where."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.raster.turning import in_first_copy

#: (top, left, height, width) in output pixels.
Window = tuple[int, int, int, int]
Span = tuple[int, int]  # of lines: the first, and the one after the last
Place = tuple[int, int]

_BAND = 256  # rows whose layers are in memory at once


class SourceMap(ABC):
    """The source of each pixel of a canvas; see `Synthesis` for the parameters."""

    #: The arrays that say where pixels come from, by the name of the parameter, and their types.
    ARRAYS: ClassVar[Mapping[str, type]] = {}
    #: Arrays that only some results have; None without them.
    OPTIONAL: ClassVar[Mapping[str, type]] = {}

    canvas: Canvas
    sample_shape: tuple[int, int]
    known_from: tuple[int, int] | None
    turn: str | None
    copy_shape: tuple[int, int] | None

    @abstractmethod
    def _layers(self, window: Window) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Coordinates and weights as `layers` returns them, -1 and 0 for known pixels."""

    @abstractmethod
    def _moved_arrays(
        self, shape: tuple[int, int], sample: tuple[int, int], to: Place, source_to: Place
    ) -> dict[str, NDArray[Any]]:
        """The arrays of the same result on a larger canvas and sample; see `moved`."""

    @classmethod
    @abstractmethod
    def _check(cls, canvas: Canvas, sample: tuple[int, int], arrays: dict[str, Any]) -> None:
        """Raise `npz.DamageError` unless kernels may trust these arrays, read from a file."""

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays that `save` writes, by the name of the parameter."""
        found = {name: getattr(self, name) for name in (*self.ARRAYS, *self.OPTIONAL)}
        return {name: array for name, array in found.items() if array is not None}

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the output."""
        return self.canvas.shape

    @property
    def source(self) -> NDArray[np.int32]:
        """Where each pixel comes from: (H, W, 2), row and column in the sample.

        A blended pixel has the source with the largest share. A known pixel that is not in the
        sample has (-1, -1): leave it out before you index with `source`. If a pixel was copied
        from a rotated or mirrored copy, `source` names that pixel of the sample itself. Where
        `tone_reach` spreads steps of tone, pixels of `image` differ slightly from their sources.

        Examples
        --------
        >>> import numpy as np, weftex
        >>> labels = np.arange(192 * 192).reshape(192, 192) // 5000
        >>> result = weftex.synthesize("sample:pebbles", 64, method="quilting", seed=7)
        >>> row, column = np.moveaxis(result.source, 2, 0)
        >>> labels[row, column].shape
        (64, 64)
        """
        return in_first_copy(self.pictured_source(), self.turn, self.copy_shape)

    def pictured_source(self) -> NDArray[np.int32]:
        """Return `source`, but as coordinates in the picture of copies if the sample was turned."""
        height, width = self.shape
        source = np.empty((height, width, 2), np.int32)
        for top in range(0, height, _BAND):
            part = source[top : top + _BAND]
            part[:] = self._pictured_layers((top, 0, len(part), width))[0][:, :, 0]
        return source

    def layers(self, window: Window | None = None) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return all sources of each pixel and their shares, also where patches are blended.

        Parameters
        ----------
        window : (top, left, height, width), optional
            In output pixels; the whole output by default.

        Returns
        -------
        coordinates : int32 array (h, w, layers, 2)
            Row and column in the sample, largest share first; -1 where there is none. Up to four
            layers where patches are blended, one where pixels are copied.
        shares : float32 array (h, w, layers)
            Share of each source. They sum to 1; all are 0 for a known pixel not in the sample.
        """
        coordinates, share = self._pictured_layers(self.canvas.check_window(window))
        return in_first_copy(coordinates, self.turn, self.copy_shape), share

    def _pictured_layers(self, window: Window) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return `layers` with coordinates in the picture of copies."""
        coordinates, share = self._layers(window)
        if self.canvas.hole is not None:  # patches may overlap known pixels
            top, left, height, width = window
            known = ~self.canvas.hole[top : top + height, left : left + width]
            coordinates[known], share[known] = -1, 0
            if self.known_from is not None:
                own = np.indices((height, width)).transpose(1, 2, 0) + (top, left) + self.known_from
                coordinates[known, 0] = own[known]
                share[known, 0] = 1
        return coordinates, share
