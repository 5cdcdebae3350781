"""Patch-based sampling (Liang, Liu, Xu, Guo and Shum, 2001)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Self

from weftex.canvas import Canvas, as_canvas
from weftex.method import Model, parameter
from weftex.methods.patches.analysis import PatchAnalysis, PatchMethod
from weftex.methods.patches.pasting import Pasting
from weftex.progress import ProgressCallback
from weftex.random import seed_number
from weftex.results.patches import PatchSynthesis

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from weftex.random import Seed

_HOLE_EPSILON = 0.02  # known pixels cannot be blended, so the best match is taken


@dataclass(frozen=True)
class PatchSampling(PatchMethod):
    """Patch-based sampling.

    Patches of the sample are pasted in scan order. Each is drawn at random from those whose
    boundary zone matches what is there already within a tolerance, and blended into it.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> sample = weftex.Exemplar(np.random.default_rng(0).integers(0, 255, (48, 48), np.uint8))
    >>> weftex.PatchSampling(patch_size=16).fit(sample).sample((60, 80), seed=7).image.shape
    (60, 80)
    """

    slug: ClassVar[str] = "patch-sampling"
    title: ClassVar[str] = "Patch-based sampling"
    paper: ClassVar[str] = (
        "L. Liang, C. Liu, Y.-Q. Xu, B. Guo, H.-Y. Shum: Real-time texture synthesis by "
        "patch-based sampling. ACM Transactions on Graphics 20(3), 2001"
    )

    epsilon: float = parameter(
        0.1,
        "relative error of a matching zone, 0.2 in the paper; inf takes anything (chaos mosaic)",
        low=0.0,
    )
    choice: str = parameter(
        "uniform",
        "draw from the matching patches evenly or by the similarity factors alpha_i",
        choices=("uniform", "similarity"),
    )
    blend: str = parameter(
        "feather",
        "joining patches: feathered after each or at the end, cut along least error, or pasted",
        choices=("feather", "feather-at-end", "cut", "none"),
    )

    def for_hole(
        self, hole: NDArray[np.bool_], usable: NDArray[np.bool_], given: frozenset[str] | None
    ) -> Self:
        """See `Method.for_hole`."""
        suited = super().for_hole(hole, usable, given)
        if given is None or "epsilon" in given:
            return suited
        return replace(suited, epsilon=_HOLE_EPSILON)

    def rule(self) -> tuple[float, bool, bool]:
        """Equation (1) with d_max of section 2.4."""
        return self.epsilon, False, self.choice == "similarity"


class PatchModel(PatchAnalysis, Model):
    """A sample prepared for patch-based sampling; `sample` makes outputs from it."""

    method: PatchMethod

    def sample(
        self,
        size: Canvas | int | tuple[int, int],
        *,
        seed: Seed = None,
        tileable: bool | str = False,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> PatchSynthesis:
        """Make an output (sections 2.2 and 2.3).

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
        PatchSynthesis
        """
        canvas = as_canvas(size, tileable)
        self.method.require(canvas)
        return Pasting(self, canvas, seed_number(seed), threads, progress).result()
