"""Patch-based sampling (Liang, Liu, Xu, Guo and Shum, 2001)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.methods.patches.method import PatchMethod
from weftex.methods.patches.model import Output, PatchModel
from weftex.methods.patches.orders import Run
from weftex.methods.patches.patch_kernels import Tolerance
from weftex.parameters import parameter

_PAPERS_EPSILON = 0.2  # section 2.4
_HOLE_EPSILON = 0.02  # known pixels cannot be blended, so the best match is taken
_FILLING = 0.05  # how much worse than the best a match may be where another seed fills a hole


@dataclass(frozen=True)
class PatchSampling(PatchMethod):
    """Patch-based sampling.

    Patches of the sample are pasted in scan order. Each is drawn at random from those whose
    boundary zone matches the overlap with the patches before within a tolerance, and blended into
    it.

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

    boundary_share: ClassVar[float] = 0.1
    epsilon: float = parameter(
        0.1,
        "how much a match may differ; higher is more random, inf takes any (0.2 in the paper)",
        low=0.0,
        hole_text=f"{_HOLE_EPSILON}",
        control="variety",
    )
    choice: str = parameter(
        "uniform",
        "how a match is drawn: all equally often, or more similar ones more often",
        choices=("uniform", "similarity"),
    )

    @property
    def looseness(self) -> float:
        """See `PatchMethod.looseness`."""
        return self.epsilon / _PAPERS_EPSILON

    @property
    def anything(self) -> bool:
        """See `PatchMethod.anything`; section 2.5: patch pasting."""
        return self.epsilon == math.inf

    def for_hole(
        self, hole: NDArray[np.bool_], usable: NDArray[np.bool_], given: frozenset[str] | None
    ) -> Self:
        """See `Method.for_hole`."""
        suited = super().for_hole(hole, usable, given)
        if given is None or "epsilon" in given:
            return suited
        return replace(suited, epsilon=_HOLE_EPSILON)

    def fit_exemplar(self, exemplar: Exemplar) -> PatchModel:
        """Choose w_B and w_E (section 2.4) and analyze the sample (section 3)."""
        return PatchModel(self, exemplar, sample_by_patches)


def sample_by_patches(output: Output, method: PatchSampling) -> None:
    """Cover an output with patches of the sample: steps 1 to 6 of section 2.2.

    Every patch depends on those pasted before it. So a compiled loop, `patch_kernels.lay_patches`,
    takes steps 1 to 4 for one patch after the other, in runs of patches whose boundary zones have
    the same shape.
    """
    # Psi_B, eq. (1), has the patches within d_max = epsilon (1/A sum of p_out^2)^1/2 by the
    # distance of eq. (2); if it is empty, the patch with the smallest distance (step 3).
    # The weights alpha_i of section 2.1 are by similarity, or all alike.
    psi_b = Tolerance(method.epsilon, of_best=False, by_similarity=method.choice == "similarity")
    canvas = output.frame.canvas
    fills = canvas.known is not None and canvas.shown is None and method.epsilon <= _HOLE_EPSILON
    if fills and output.seed != 1:  # not in the paper: each seed fills a hole differently
        psi_b = Tolerance(_FILLING, of_best=True, by_similarity=False)

    def paste(run: Run) -> None:
        # E_out, the boundary zone of the patches already pasted: Fig. 3 (b) to (d), Fig. 5 for
        # tileable output, any shape at a hole. Of the sample's patches a kd-tree, the quadtree
        # pyramid or principal components find candidates for it (section 3:
        # `patches.zone_search`, `zone_kernels.nearest_by_blocks` and `nearest_by_features`).
        candidates = output.search_for(run)
        # Step 1 where nothing is pasted yet, else steps 2 to 4: draw B_k from Psi_B
        # (`patch_kernels.draw_one`), paste it.
        # Step 6, feathering (weights: `boundary_zone`; `paste_kernels.blend`), follows each patch,
        # or the last where blend is feather-at-end.
        output.choose_and_paste(run, candidates, psi_b)

    # Step 5: until I_out is covered, in the order of Fig. 3 (a) (`orders.scan_patches`); holes in
    # spiral order (section 2.3), single pixels in scan order (section 2.5).
    output.paste_in_order(paste)
