"""Iterative texture refinement (the paper on refinement and fusion, sections 3, 5 and 6)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np

from weftex.analysis.scale import dominant_scale
from weftex.errors import InvalidInputError
from weftex.method import parameter
from weftex.methods.pixels.growth import PixelModel, settle_window
from weftex.methods.pixels.windowed import WindowedMethod
from weftex.methods.refinement.levels import component_level, pyramid_levels
from weftex.methods.refinement.sweeps import Refining
from weftex.registry import METHODS
from weftex.seams.belts import seam_belts
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.canvas import Canvas
    from weftex.exemplar import Exemplar
    from weftex.method import Model
    from weftex.methods.pixels.growth import Growth

_WIDEST = 29  # pixels; with less than its four levels noise decides, and the picture falls apart


@dataclass(frozen=True)
class Refinement(WindowedMethod):
    """Iterative refinement.

    A grid of seed points, or the result of another method, is refined again and again: every
    pixel takes the place of the sample whose window is most like its own.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> sample = weftex.Exemplar(np.random.default_rng(0).integers(0, 255, (48, 48), np.uint8))
    >>> weftex.Refinement(iterations=2).fit(sample).sample((60, 80), seed=7).image.shape
    (60, 80)
    """

    slug: ClassVar[str] = "refinement"
    title: ClassVar[str] = "Iterative refinement"
    paper: ClassVar[str] = (
        "Iterative texture refinement and texture fusion: window size estimation, seed point "
        "planting, iterative refinement"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "guide", "many"})

    window_width: int | None = parameter(
        None,
        "side of the square window, odd; what is wider than 7 pixels is seen in a pyramid",
        low=1,
        unit="px",
        default_text="twice the sample's dominant scale, 29 or more unless search is 'pca'",
    )
    search: str = parameter(
        "coherent",
        "from coarse to fine along the neighbours' sources, or by principal components of windows",
        choices=("coherent", "pca"),
    )
    iterations: int = parameter(
        10, "at most so many; twice that on the coarsest level, half on others", low=1, high=1000
    )
    threshold: float = parameter(
        0.01, "epsilon: stop when an iteration changes the picture by less (eq. 1)", low=0.0
    )
    init: str = parameter(
        "auto",
        "start from seed points or a method's result; auto: quilting; with a guide or 'pca' seeds",
        choices=("auto", "seeds", *(slug for slug in METHODS if slug != "refinement")),
    )
    joints: int | None = parameter(
        None,
        "refine only belts of this width along the start's seams; its patches stay",
        low=2,
        unit="px",
        default_text="everything is refined",
        needs=("init", ("auto", *(slug for slug in METHODS if slug != "refinement"))),
    )
    seed_density: float = parameter(
        1.0,
        "seed points for each dominant scale along an axis",
        low=0.1,
        high=10.0,
        needs=("init", ("seeds",)),
    )
    matches: int = parameter(
        5, "k: a seed point is drawn from so many best tiles", low=1, needs=("init", ("seeds",))
    )
    similar: int = parameter(
        2,
        "candidates beside each coherent one: the places of the sample most like it",
        low=0,
        high=32,
        needs=("search", ("coherent",)),
    )
    coherence: float = parameter(
        2.0,
        "a place like a coherent one is taken if it is so many times nearer; more: larger pieces",
        low=1.0,
        high=100.0,
        needs=("search", ("coherent",)),
    )
    evenness: float = parameter(
        1.0,
        "how much a part of the sample that has been used too often counts as worse",
        low=0.0,
        high=100.0,
        needs=("search", ("coherent",)),
    )
    guide_weight: float = parameter(
        0.3,
        "how much a guide counts beside what is made",
        low=0.01,
        high=100.0,
        needs_canvas="guide",
    )
    variance: float = parameter(
        0.97,
        "share of the variance to keep, with at most 48 components",
        low=0.01,
        high=1.0,
        needs=("search", ("pca",)),
    )
    candidates: int = parameter(
        20,
        "windows nearest by their components, of which the nearest by all pixels is taken",
        low=1,
        high=10000,
        needs=("search", ("pca",)),
    )

    def for_belt(self, width: int) -> Self:
        """See `Method.for_belt`: seeds lie all over a belt (section 4)."""
        # Patches of another start end along the belt.
        belted = super().for_belt(width)
        return replace(belted, init="seeds") if self.init == "auto" else belted

    def fit(self, exemplar: Exemplar) -> RefinementModel:
        """Analyse a sample: its dominant scale, and how to find what is like a window."""
        return RefinementModel(self, exemplar)

    def require(self, canvas: Canvas) -> None:
        """See `Method.require`."""
        super().require(canvas)
        if canvas.guide is not None and self.search == "pca":
            raise InvalidInputError("search is 'pca', which follows no guide; use 'coherent'")
        if canvas.guide is not None and self.joints is not None:
            raise InvalidInputError("joints keeps what follows no guide; leave it out")

    def settle(self, exemplar: Exemplar) -> Refinement:
        """See `Method.settle`."""
        pyramid = self.search == "coherent"
        proposed = 1 if self.window_width else dominant_scale(exemplar).window_width
        settled: Refinement = settle_window(
            self, exemplar, max(_WIDEST if pyramid else 1, proposed)
        )
        init = self.init
        if init == "auto":
            init = "quilting" if pyramid or self.joints else "seeds"
        if init != "seeds":
            try:
                METHODS[init]().settle(exemplar)
            except InvalidInputError:  # too small a sample
                if self.init != "auto" or self.joints:
                    raise
                init = "seeds"
        return dataclasses.replace(settled, init=init)


class RefinementModel(PixelModel):
    """A sample prepared for iterative refinement.

    Attributes
    ----------
    scale : int
        In pixels, half of the window.
    levels : list of Level
        From the finest to the coarsest; one where search is "pca".
    open : bool
        The start was left open; where the canvas has a guide seeds are planted.
    start : Model or None
        What makes the pictures to refine; None plants seed points.
    """

    method: Refinement
    start: Model | None

    def __init__(self, method: Refinement, exemplar: Exemplar) -> None:
        super().__init__(method.settle(exemplar), exemplar)
        self.open = method.init == "auto"
        init = self.method.init
        self.start = None if init == "seeds" else METHODS[init]().fit(exemplar)
        width: int = self.method.window_width  # type: ignore[assignment]
        self.scale = max(1, width // 2)
        if method.search == "coherent":
            # A belt is filled on one level, so that it has to see more.
            narrow = method.joints is None
            self.levels = pyramid_levels(exemplar, width, method.similar, narrow)
        else:
            self.levels = [component_level(exemplar, width // 2, method.variance)]
        self.windows = windows_of(exemplar, (0,) * 4)

    def grow(self, growth: Growth) -> None:
        """Refine a start until it stays as it is, from the coarsest level to the finest."""
        made = None
        if self.start is not None and self.method.joints is not None:
            made = self.start.sample(growth.canvas, seed=growth.seed, threads=growth.threads)
            self._keep(made.source, growth)
        if not growth.done.all():
            Refining(self, growth, made).run()

    def _keep(self, source: NDArray[np.int32], growth: Growth) -> None:
        """Keep the patches of a start; what is along their seams becomes a hole (Fig. 13)."""
        width: int = self.method.joints  # type: ignore[assignment]
        height, columns = self.exemplar.shape
        period = (height, columns) if self.exemplar.tileable else None
        belts = seam_belts(source, width // 2, growth.canvas.wrap, period)
        place = (source[..., 0] * columns + source[..., 1]).astype(np.int32)
        wanted = growth.done == 0
        growth.levels[wanted] = self.exemplar.matching().reshape(-1, growth.levels.shape[2])[
            place[wanted]
        ]
        kept = ~belts & wanted
        growth.source[kept] = self.windows.from_sample(place[kept])
        growth.done[kept] = 1
        growth.hole = None if not growth.done.any() else growth.done == 0
