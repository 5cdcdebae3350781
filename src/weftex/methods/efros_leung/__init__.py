"""Texture synthesis by non-parametric sampling (Efros and Leung, 1999).

Functions have the names of the pseudocode that the authors published; quotes are from section III.A
of the survey in docs/background/fidelity/non-parametric-sampling-and-tsvq.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from weftex.exemplar import Exemplar
from weftex.methods.efros_leung.layers import Waves, in_threads, seed_piece, unfilled_neighbors
from weftex.methods.efros_leung.weighted_search import ExactSearch, gaussian_weights
from weftex.methods.pixels import Growth, PixelModel, WindowedMethod, square_width
from weftex.parameters import parameter, window_parameter
from weftex.search.windows import Windows, square_windows

_PROPOSED_WIDTH, _SEED_WIDTH = 15, 3  # pixels
_SIGMAS = 6.4  # standard deviations of the Gaussian in a window's width
_THRESHOLD = 0.3  # of a pixel's mean squared difference; 1 is black against white
_RISE = 1.1  # of the threshold when a layer makes no progress
_TRIES = 8  # for each pixel on average; then the threshold rises with every layer


@dataclass(frozen=True)
class EfrosLeung(WindowedMethod):
    """Non-parametric sampling.

    The picture grows in layers from a seed, or into a hole from its border. Each pixel is drawn
    from the sample pixels whose windows match its known neighbors about as well as the best window.

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

    window_width: int | None = window_parameter(
        "side of the square window that is compared, odd; wider keeps larger shapes and is "
        "less random",
        "15, less for a small sample",
    )
    tolerance: float = parameter(
        0.1,
        "how much larger than the smallest error others may be, as a share; higher is more random",
        low=0.0,
        high=1000.0,
        control="variety",
    )

    def resolved(self, exemplar: Exemplar) -> Self:
        """See `Method.resolved`."""
        width = square_width(self.window_width, exemplar, _PROPOSED_WIDTH)
        return replace(self, window_width=width)

    def fit_exemplar(self, exemplar: Exemplar) -> PixelModel:
        """Find the sample's windows, and weigh their pixels."""
        method = self.resolved(exemplar)
        width = method.window_for(0)
        windows = square_windows(exemplar, width)
        search = ExactSearch(windows, gaussian_weights(width, width / _SIGMAS))
        return PixelModel(method, exemplar, Prepared(method, windows, search), grow_in_layers)


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for non-parametric sampling."""

    method: EfrosLeung  # resolved
    windows: Windows  # the sample's whole windows
    search: ExactSearch  # finds the windows that match the known pixels around a pixel


def grow_in_layers(prepared: Prepared, growth: Growth) -> None:
    """Grow the texture around a seed, or around the known pixels, in layers (GrowImage)."""
    method, wrap = prepared.method, growth.canvas.wrap
    assert method.window_width  # resolved
    sample = prepared.windows.pixels.reshape(-1, prepared.windows.pixels.shape[2])
    source, done = growth.source.reshape(-1), growth.done.reshape(-1)
    pixels = growth.pixels.reshape(done.size, -1)
    # "... grown in layers taken randomly from the sample image": a random piece of it is the seed.
    if not done.any():
        side = min(_SEED_WIDTH, method.window_width)
        at, piece = seed_piece(prepared.windows, side, growth.canvas.shape, growth.seed)
        source[at], pixels[at], done[at] = piece, sample[piece], 1
    progress = growth.progress(int((done == 0).sum()), "pixels")
    threshold, tries_left = _THRESHOLD, _TRIES * progress.total
    waves = Waves(growth.canvas.shape, wrap, method.window_width, growth.seed)
    # The context is the "already synthesized pixels in a square window"; similarity is the
    # "Gaussian weighted sum of differences": "find the best match [...] and take all samples
    # within some distance from that match", one of which is picked: FindMatches, RandomPick.
    matchers = [prepared.search.on(growth.picture, method.tolerance) for _ in range(growth.threads)]
    with in_threads(matchers) as find_matches:
        while (layer := unfilled_neighbors(growth.done, wrap)).size:
            lowest = np.inf
            for wave, bits in waves.of(layer, growth.done):
                chosen, distances, weights = find_matches(wave, bits)
                # "... normalizing the error by the total number of known pixels"; it is 1
                # between black and white.
                errors = distances / (255.0**2 * pixels.shape[1] * np.maximum(weights, 1))
                # A pixel without a good match waits for the next layer.
                filled = errors <= threshold
                at = wave[filled]
                source[at] = chosen[filled]
                pixels[at] = sample[chosen[filled]]
                done[at] = 1
                lowest = min(lowest, errors.min())
                progress.advance(len(at))
            # If none of a layer has one, the threshold rises; beyond the paper, also after so many
            # tries that a low threshold and a wide tolerance would go on for ever.
            progressed = lowest <= threshold
            tries_left -= len(layer) if progressed else 0
            if progressed and tries_left < 0:
                threshold *= _RISE
            # A round that fills nothing would pick the same windows again, so it is skipped.
            while threshold < lowest:
                threshold *= _RISE
