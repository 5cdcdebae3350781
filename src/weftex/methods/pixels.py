"""What methods with one source for each pixel have in common: pixel methods and graph cut."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError, size_words
from weftex.exemplar import Exemplar
from weftex.method import Method, Model
from weftex.progress import Progress, ProgressCallback
from weftex.results.pixels import PixelSynthesis
from weftex.search.picture_kernels import Picture
from weftex.search.windows import Windows, square_windows


class Growth:
    """One output, by the source of each pixel, while it is made."""

    def __init__(
        self,
        canvas: Canvas,
        exemplar: Exemplar,
        windows: Windows,
        seed: int,
        threads: int,
        callback: ProgressCallback | None,
    ) -> None:
        self.canvas, self.exemplar, self.seed = canvas, exemplar, seed
        self.threads, self._callback = threads, callback
        # (H, W, K): the bytes that distances are taken on; 0 where unknown
        self.pixels = np.zeros((*canvas.shape, windows.pixels.shape[2]), np.uint8)
        self.done = np.zeros(canvas.shape, np.uint8)  # (H, W): 1 where a pixel is known or made
        # (H, W): flat index into the pixels of the model's windows, or -1
        self.source = np.full(canvas.shape, -1, np.int32)
        self.hole: NDArray[np.bool_] | None = None  # (H, W): the pixels to make; None for all
        self.windows = windows
        # facts about this output for its provenance; the method adds to them
        self.about: dict[str, Any] = {}
        self.tone_reach = 0.0  # see `weftex.results.Synthesis`; 0 unless the method sets it
        self.coarse: tuple[NDArray[np.uint8], int] | None = None  # for previews, and its step
        if canvas.known is None or canvas.hole is None or canvas.hole.all():
            return
        self.hole = canvas.hole
        if canvas.shown is not None:
            self.show(~self.hole)
            return
        known = exemplar.as_known(canvas.known)
        self.pixels[~self.hole] = known[~self.hole]
        self.done[~self.hole] = 1
        if canvas.known_from is not None:
            y, x = np.indices(canvas.shape) + np.reshape(canvas.known_from, (2, 1, 1))
            place = (y * exemplar.shape[1] + x).astype(np.int32)
            self.source[~self.hole] = windows.from_sample(place[~self.hole])

    @property
    def picture(self) -> Picture:
        """The output as kernels take it."""
        return Picture(self.pixels, self.done, self.source, self.canvas.wrap)

    def show(self, where: NDArray[np.bool_]) -> None:
        """Begin with what the canvas shows at some pixels."""
        assert self.canvas.shown is not None
        source = self.windows.from_sample(np.maximum(self.canvas.shown, 0))
        pixels = self.windows.pixels.reshape(-1, self.pixels.shape[2]).take(source, axis=0)
        np.copyto(self.source, source, where=where)
        np.copyto(self.pixels, pixels, where=where[..., None])
        self.done[where] = 1

    def progress(self, total: int, stage: str) -> Progress:
        """Report on `total` steps of one stage; the preview is the picture so far."""
        return Progress(self._callback, total, stage, self._preview)

    def _preview(self) -> NDArray[np.uint8]:
        pixels = self.pixels[..., : self.exemplar.channels].copy()
        if self.coarse is not None:
            (small, step), unknown = self.coarse, self.done == 0
            large = small[..., : pixels.shape[2]].repeat(step, 0).repeat(step, 1)
            pixels[unknown] = large[: len(pixels), : pixels.shape[1]][unknown]
        return pixels


class PixelModel(Model):
    """The model of a method with one source for each pixel: a prepared sample and the algorithm.

    ``grow(prepared, growth)``, which can be pickled, makes `pixels` and `source` of every unknown
    pixel. `prepared.windows` are indexed by `Growth.source`; it is immutable and picklable.
    """

    def __init__(
        self, method: Method, exemplar: Exemplar, prepared: Any, grow: Callable[[Any, Growth], None]
    ) -> None:
        self.method, self.exemplar = method, exemplar
        self.prepared, self._grow = prepared, grow

    def make(
        self, canvas: Canvas, seed: int, threads: int, progress: ProgressCallback | None
    ) -> PixelSynthesis:
        """See `Model.make`."""
        canvas.check_known(self.exemplar)
        canvas.check_guide(self.exemplar)
        windows = self.prepared.windows
        growth = Growth(canvas, self.exemplar, windows, seed, threads, progress)
        if not growth.done.all():
            self._grow(self.prepared, growth)
        index = windows.to_sample(growth.source)
        if canvas.hole is not None:
            index = np.where(canvas.hole, index, np.int32(-1))
        return PixelSynthesis(
            canvas,
            index,
            exemplar=self.exemplar,
            known_from=canvas.known_from,
            tone_reach=growth.tone_reach,
            threads=growth.threads,
            provenance=self.method.describe() | {"seed": seed} | growth.about,
        )


class WindowedMethod(Method):
    """Base of methods whose field `window_width` may be left open."""

    if TYPE_CHECKING:  # the subclasses declare it, each with its own help
        window_width: int | None

    def window_for(self, proposed: int) -> int:
        """See `Method.window_for`."""
        return self.window_width or proposed

    def for_belt(self, width: int, **parameters: Any) -> Self:
        """See `Method.for_belt`."""
        return super().for_belt(width, window_width=self.window_for(width), **parameters)

    def window_of(self, exemplar: Exemplar) -> int:
        """See `Method.window_of`."""
        return self.resolved(exemplar).window_for(0)


def width_for(given: int | None, exemplar: Exemplar, proposed: int) -> int:
    """Return an odd window width in pixels that fits the sample: `given`, or `proposed` shrunk."""
    largest = min(exemplar.shape)
    largest -= 1 - largest % 2
    if given is not None and given > largest:
        raise InvalidInputError(
            f"window_width is {given}; {exemplar.name} is {size_words(exemplar.shape)}, "
            f"so it must be at most {largest}"
        )
    return given or max(1, min(proposed - 1 + proposed % 2, largest))


def square_width(given: int | None, exemplar: Exemplar, proposed: int) -> int:
    """Return the given width, or the widest up to `proposed` of which a window is whole."""
    width = width_for(given, exemplar, proposed)
    return width if given else narrowed(width, lambda side: square_windows(exemplar, side))


def narrowed(width: int, find: Callable[[int], object]) -> int:
    """Return the widest odd width, from `width` down to 1, for which `find` raises no error."""
    while width > 1:
        try:
            find(width)
            break
        except InvalidInputError:
            width -= 2
    return width
