"""What methods that choose one pixel after the other have in common."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import Canvas, as_canvas
from weftex.errors import InvalidInputError
from weftex.method import Method, Model
from weftex.progress import Progress, ProgressCallback
from weftex.random import seed_number
from weftex.results.pixels import PixelSynthesis
from weftex.threads import thread_count

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.random import Seed
    from weftex.search.windows import Windows


class Growth:
    """One output in the making.

    Attributes
    ----------
    canvas : Canvas
        What to make.
    seed : int
        For `weftex.random.draw`.
    threads : int
        At most so many.
    levels : uint8 array (H, W, K)
        What distances are taken on; known pixels are there, the others 0 until they are made.
    done : uint8 array (H, W)
        1 where a pixel is known or made.
    source : int32 array (H, W)
        Flat index into the pixels of the model's windows. -1 where nothing is made, and for a
        known pixel that is not in the sample.
    hole : bool array (H, W) or None
        What is to be made, if some is known.
    about : dict
        What the method has to say about this output, for its provenance.
    """

    def __init__(
        self,
        canvas: Canvas,
        exemplar: Exemplar,
        windows: Windows,
        seed: int,
        threads: int,
        callback: ProgressCallback | None,
    ) -> None:
        self.canvas, self.seed, self.threads, self._callback = canvas, seed, threads, callback
        self._channels = exemplar.channels
        self.levels = np.zeros((*canvas.shape, windows.pixels.shape[2]), np.uint8)
        self.done = np.zeros(canvas.shape, np.uint8)
        self.source = np.full(canvas.shape, -1, np.int32)
        self.hole = None
        self.about: dict[str, Any] = {}
        if canvas.known is None or canvas.hole is None or canvas.hole.all():
            return
        self.hole = canvas.hole
        known = exemplar.as_matching(canvas.known)
        if known.shape[2] != self.levels.shape[2]:
            raise InvalidInputError("a canvas's known pixels have no maps; use weftex.fill")
        self.levels[~self.hole] = known[~self.hole]
        self.done[~self.hole] = 1
        if canvas.known_from is not None:
            y, x = np.indices(canvas.shape) + np.reshape(canvas.known_from, (2, 1, 1))
            place = (y * exemplar.shape[1] + x).astype(np.int32)
            self.source[~self.hole] = windows.from_sample(place[~self.hole])

    def progress(self, total: int, stage: str) -> Progress:
        """Report on `total` steps of one stage; the preview is the picture so far."""
        return Progress(self._callback, total, stage, self._preview)

    def _preview(self) -> NDArray[np.uint8]:
        return self.levels[..., : self._channels].copy()


class PixelModel(Model):
    """Base of the models of pixel methods: a sample prepared for choosing pixels.

    A subclass sets `windows`, and `method` to what it settled on where a parameter was left open;
    its `grow` makes every pixel that is not known.

    Parameters
    ----------
    method : Method
        Parameters.
    exemplar : Exemplar
        The sample.
    """

    windows: Windows

    def __init__(self, method: Method, exemplar: Exemplar) -> None:
        self.method, self.exemplar = method, exemplar

    def grow(self, growth: Growth) -> None:
        """Fill `levels` and `source` of what is not known."""
        raise TypeError(f"{type(self).__name__} does not define grow")

    def sample(
        self,
        size: Canvas | int | tuple[int, int],
        *,
        seed: Seed = None,
        tileable: bool | str = False,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> PixelSynthesis:
        """Make an output.

        Parameters
        ----------
        size : Canvas, int or (int, int)
            What to make: height and width, or a Canvas.
        seed : int, numpy Generator or None
            The same seed gives the same bytes, at any number of threads.
        tileable : bool or {"x", "y"}
            Axes that are to repeat without a seam.
        threads : int, optional
            At most so many; by default as many as there are processors.
        progress : callable, optional
            See `weftex.progress.ProgressCallback`.

        Returns
        -------
        PixelSynthesis
        """
        canvas = as_canvas(size, tileable)
        self.method.require(canvas)
        canvas.check_known(self.exemplar)
        canvas.check_guide(self.exemplar)
        number = seed_number(seed)
        growth = Growth(
            canvas, self.exemplar, self.windows, number, thread_count(threads), progress
        )
        if not growth.done.all():
            self.grow(growth)
        index = self.windows.to_sample(growth.source)
        if canvas.hole is not None:
            index = np.where(canvas.hole, index, np.int32(-1))
        return PixelSynthesis(
            canvas,
            index,
            sample_shape=self.exemplar.shape,
            exemplar=self.exemplar,
            known_from=canvas.known_from,
            provenance=self.method.describe() | {"seed": number} | growth.about,
        )


def settle_window(method: Any, exemplar: Exemplar, proposed: int, *, causal: bool = False) -> Any:
    """Settle the window: return the method with a `window_width` that fits the sample.

    Parameters
    ----------
    method : Method
        With a field `window_width`, odd; None takes the proposed one, shrunk to fit.
    exemplar : Exemplar
        The sample; one that tiles has room for any window up to its own size.
    proposed : int
        A width in pixels.
    causal : bool
        The window is L-shaped and needs rows above its pixel only.

    Raises
    ------
    InvalidInputError
        If a width was given that is even or does not fit; the largest that fits is named.
    """
    height, width = exemplar.shape
    if causal:
        height = 2 * height - 1
    largest = min(height, width)
    largest -= 1 - largest % 2
    given = method.window_width
    if given is not None and given % 2 == 0:
        raise InvalidInputError(f"window_width is {given}; it must be odd")
    if given is not None and given > largest:
        raise InvalidInputError(
            f"window_width is {given}; {exemplar.name} is {exemplar.shape[1]}x"
            f"{exemplar.shape[0]}, which has room for {largest}"
        )
    settled = given or max(1, min(proposed - 1 + proposed % 2, largest))
    return dataclasses.replace(method, window_width=settled)
