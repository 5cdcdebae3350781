"""Texture synthesis by non-parametric sampling (Efros and Leung, 1999)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weftex.errors import InvalidInputError
from weftex.method import parameter
from weftex.methods.efros_leung import draw_kernels as kernels
from weftex.methods.pixels.growth import PixelModel, settle_window
from weftex.methods.pixels.windowed import WindowedMethod
from weftex.random import draw
from weftex.raster.masks import grown
from weftex.search.exhaustive import ExhaustiveSearch, gaussian_weights
from weftex.search.half_known import HalfKnownSearch
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.pixels.growth import Growth
    from weftex.search.exhaustive import WindowSearch
    from weftex.search.windows import Windows

_WIDTH = 15
_SEED = 3
_SIGMA = 6.4  # window widths in a standard deviation
_RISE = 1.1  # of the threshold when a layer makes no progress
_PIECE = 8  # pixels; fewer are not worth another thread


@dataclass(frozen=True)
class EfrosLeung(WindowedMethod):
    """Non-parametric sampling.

    The picture grows in layers from a seed, or into a hole from its border. A pixel is drawn from
    those of the sample whose window matches what is known around it nearly as well as the best.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> sample = weftex.Exemplar(np.random.default_rng(0).integers(0, 255, (24, 24), np.uint8))
    >>> weftex.EfrosLeung(window_width=5).fit(sample).sample((20, 30), seed=7).image.shape
    (20, 30)
    """

    slug: ClassVar[str] = "efros-leung"
    title: ClassVar[str] = "Non-parametric sampling"
    paper: ClassVar[str] = (
        "A. A. Efros, T. K. Leung: Texture synthesis by non-parametric sampling. "
        "Proceedings of ICCV 1999"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "many"})

    window_width: int | None = parameter(
        None,
        "side of the window that pixels are chosen by; wider is less random, odd",
        low=1,
        unit="px",
        default_text="15, or less where the sample has no room for it",
    )
    tolerance: float = parameter(
        0.1, "candidates may be this much worse than the best, relatively", low=0.0, high=1000.0
    )
    threshold: float = parameter(
        0.3,
        "mean squared difference, of 1 between black and white, above which a pixel has to wait",
        low=1e-6,
        high=1.0,
    )
    seed_size: int | None = parameter(
        None,
        "side of the piece of the sample that growth starts from",
        low=1,
        unit="px",
        default_text="3, or the window if that is smaller",
    )

    search: str = parameter(
        "full",
        "all windows, or those that principal components make likely",
        choices=("full", "pca"),
    )
    candidates: int = parameter(
        32, "windows that pca offers for each pixel", low=1, needs=("search", ("pca",))
    )
    variance: float = parameter(
        0.9,
        "share of the variance that pca keeps, in 16 components at most",
        low=0.0,
        high=1.0,
        needs=("search", ("pca",)),
    )

    def fit(self, exemplar: Exemplar) -> EfrosLeungModel:
        """Prepare a sample."""
        return EfrosLeungModel(self, exemplar)


class EfrosLeungModel(PixelModel):
    """A sample prepared for non-parametric sampling; `sample` makes outputs from it."""

    method: EfrosLeung

    def __init__(self, method: EfrosLeung, exemplar: Exemplar) -> None:
        width, self.windows = _settle_window(method, exemplar)
        self.reach = width // 2
        self.seed_size = min(_SEED, width) if method.seed_size is None else method.seed_size
        if self.seed_size > width:
            raise InvalidInputError(
                f"seed_size is {self.seed_size}; it must be from 1 to the window_width of {width}"
            )
        settled = dataclasses.replace(method, window_width=width, seed_size=self.seed_size)
        super().__init__(settled, exemplar)
        weights = gaussian_weights(width, width / _SIGMA)
        self.search: WindowSearch = (
            ExhaustiveSearch(self.windows, weights)
            if method.search == "full"
            else HalfKnownSearch(self.windows, weights, method.candidates, method.variance)
        )

    def grow(self, growth: Growth) -> None:
        """Grow from a seed, or from what is known, layer by layer (section III.A)."""
        if not growth.done.any():
            self._plant(growth)
        progress = growth.progress(int((growth.done == 0).sum()), "pixels")
        threshold = self.method.threshold
        source, done = growth.source.reshape(-1), growth.done.reshape(-1)
        levels = growth.levels.reshape(done.size, -1)
        pixels = self.windows.pixels.reshape(-1, levels.shape[1])
        with _Waves(self, growth) as waves:
            while (layer := _front(growth)).size:
                lowest = np.inf
                for wave, bits in waves.of(layer):
                    chosen, errors = waves.search(wave, bits)
                    filled = errors <= threshold
                    at = wave[filled]
                    source[at] = chosen[filled]
                    levels[at] = pixels[chosen[filled]]
                    done[at] = 1
                    lowest = min(lowest, errors.min())
                    progress.advance(len(at))
                while threshold < lowest:
                    threshold *= _RISE

    def _plant(self, growth: Growth) -> None:
        """Lay a random piece of the sample into the middle."""
        side, centres = self.seed_size, self.windows.centres
        bits = draw(growth.seed, "efros-leung seed")
        centre = centres[(int(bits) >> 32) * len(centres) >> 32]
        height, width = (min(side, n) for n in growth.canvas.shape)
        away = np.arange(side) - side // 2
        piece = centre + away[:height, None] * self.windows.pixels.shape[1] + away[:width]
        piece = self.windows.from_sample(self.windows.to_sample(piece.astype(np.int32)))
        top, left = (growth.canvas.height - height) // 2, (growth.canvas.width - width) // 2
        at = slice(top, top + height), slice(left, left + width)
        growth.source[at], growth.done[at] = piece, 1
        growth.levels[at] = self.windows.pixels.reshape(-1, growth.levels.shape[2])[piece]


def _front(growth: Growth) -> NDArray[np.int32]:
    """Unfilled pixels with filled neighbors."""
    filled = growth.done > 0
    return np.flatnonzero(grown(filled, 1, growth.canvas.wrap) & ~filled).astype(np.int32)


class _Waves:
    """A layer's pixels in the order of growth, as far as possible at the same time.

    A pixel depends on the earlier ones in its window. Those of one wave do not see each other, so
    threads share them and the picture is that of one pixel after the other.
    """

    def __init__(self, model: EfrosLeungModel, growth: Growth) -> None:
        self.model, self.growth = model, growth
        self._listed = np.zeros(growth.canvas.shape, np.uint8)
        self._numbers = np.empty(growth.canvas.shape, np.int32)
        self._pool: Any = None
        self._scratch = [model.search.scratch() for _ in range(growth.threads)]

    def __enter__(self) -> _Waves:
        if self.growth.threads > 1:
            from concurrent.futures import ThreadPoolExecutor

            self._pool = ThreadPoolExecutor(self.growth.threads)
        return self

    def __exit__(self, *failure: object) -> None:
        if self._pool:
            self._pool.shutdown()

    def of(self, layer: NDArray[np.int32]) -> Iterator[tuple[NDArray[Any], NDArray[Any]]]:
        """Places and random bits of each wave: most known neighbours first, ties at random."""
        growth, wrap = self.growth, self.growth.canvas.wrap
        known, waves = (np.empty(len(layer), np.int32) for _ in range(2))
        runs = self._scratch[0][0]
        kernels.count_known(growth.done, *wrap, self.model.reach, layer, runs, known)
        at = np.divmod(layer, growth.canvas.width)
        order = np.lexsort((draw(growth.seed, "efros-leung order", *at), -known))
        kernels.wave_numbers(
            *wrap, self.model.reach, layer[order], self._listed, self._numbers, runs, waves
        )
        order = order[np.argsort(waves, kind="stable")]
        ends = np.cumsum(np.bincount(waves))
        places, bits = layer[order], draw(growth.seed, "efros-leung", *at)[order]
        for start, end in zip((0, *ends), ends, strict=False):
            yield places[start:end], bits[start:end]

    def search(
        self, wave: NDArray[np.int32], bits: NDArray[np.uint64]
    ) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """Draw the source of each pixel; return it and its error, from 0 to 1."""
        growth, model = self.growth, self.model
        count = min(growth.threads, -(-len(wave) // _PIECE))
        ends = np.linspace(0, len(wave), count + 1).astype(int)

        def piece(k: int) -> tuple[NDArray[Any], ...]:
            part = slice(ends[k], ends[k + 1])
            return model.search.draw(
                growth.levels, growth.done, growth.source, growth.canvas.wrap,
                wave[part], bits[part], model.method.tolerance, self._scratch[k],
            )  # fmt: skip

        pieces = map(piece, range(count)) if count == 1 else self._pool.map(piece, range(count))
        chosen, distances, weights = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
        most = 255.0**2 * growth.levels.shape[2] * np.maximum(weights, 1)
        return chosen, distances / most


def _settle_window(method: EfrosLeung, exemplar: Exemplar) -> tuple[int, Windows]:
    """The window's width, less than usual where the usable pixels have no room, and all windows."""
    width = settle_window(method, exemplar, _WIDTH).window_width
    while True:
        reach = width // 2
        try:
            return width, windows_of(exemplar, (reach, reach, reach, reach))
        except InvalidInputError:
            if method.window_width is not None or width == 1:
                raise
            width -= 2
