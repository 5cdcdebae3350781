"""Patch-based sampling (Liang, Liu, Xu, Guo and Shum, 2001)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from weftex.exemplar import Exemplar
from weftex.methods.patches.method import PatchMethod
from weftex.methods.patches.model import PatchCanvas, PatchModel
from weftex.methods.patches.orders import Run
from weftex.methods.patches.patch_kernels import Tolerance
from weftex.parameters import parameter
from weftex.raster.arrays import Mask

_PAPERS_EPSILON = 0.2  # section 2.4
_HOLE_EPSILON = 0.02  # known pixels cannot be blended, so the best match is taken
_FILLING = 0.05  # how much worse than the best a match may be where another seed fills a hole
_SEED_OF_BEST = 1  # which fills holes with the best matches; others draw among good ones


@dataclass(frozen=True)
class PatchSampling(PatchMethod):
    """Patch-based sampling.

    Patches of the sample are pasted in scan order. The candidates are patches whose boundary zone
    matches the earlier patches within a tolerance. One of them is drawn at random, and blended
    into the earlier patches.

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
    def tolerance_ratio(self) -> float:
        """See `PatchMethod.tolerance_ratio`."""
        return self.epsilon / _PAPERS_EPSILON

    @property
    def accepts_all(self) -> bool:
        """See `PatchMethod.accepts_all`; section 2.5: patch pasting."""
        return self.epsilon == math.inf

    def for_hole(self, hole: Mask, usable: Mask, given: frozenset[str] | None) -> Self:
        """See `Method.for_hole`."""
        suited = super().for_hole(hole, usable, given)
        if given is None or "epsilon" in given:
            return suited
        return replace(suited, epsilon=_HOLE_EPSILON)

    def fit_exemplar(self, exemplar: Exemplar) -> PatchModel:
        """Choose w_B and w_E (section 2.4) and analyze the sample (section 3)."""
        return PatchModel(self, exemplar, sample_by_patches)


def sample_by_patches(output: PatchCanvas, method: PatchSampling) -> None:
    """Cover an output with patches of the sample: steps 1 to 6 of section 2.2.

    Sections, figures and symbols are of Liang et al. (2001). Each patch depends on those before it,
    so compiled code, `patch_kernels.lay_patches`, takes the steps for a run of patches.
    """

    def paste(run: Run) -> None:
        # Step 1, where nothing is pasted yet, is any patch; see `patch_kernels.choose_window`.
        # Step 2: E_out is the boundary zone of the patches already pasted, `boundary_zone`: Fig. 3
        # (b) to (d), Fig. 5 for tileable output, any shape at a hole. A kd-tree, the quadtree
        # pyramid or principal components (section 3, `search.approximate_nearest`) list the m
        # patches whose zones may be nearest to it.
        search = output.search_for(run)
        # Of these, Psi_B has those nearer than d_max. Steps 3 and 4: draw B_k from Psi_B, or take
        # the nearest patch if it is empty (`patch_kernels.draw_one`); paste it.
        # Step 6, feathering (`boundary_zone`, `paste_kernels.blend`), follows each patch, or the
        # last one where `blend` is feather-at-end.
        output.choose_and_paste(run, search, tolerance_of(output, method))

    # Step 5: until I_out is covered, in the order of Fig. 3 (a) (`orders.scan_patches`); holes in
    # spiral order (section 2.3), single pixels in scan order (section 2.5).
    output.paste_in_order(paste)


def tolerance_of(output: PatchCanvas, method: PatchSampling) -> Tolerance:
    """Return d_max, eq. (1) and section 2.4, and whether the alpha_i of section 2.1 are all alike.

    Not in the paper: with seed 1 a hole takes the best match; other seeds fill it differently.
    """
    canvas = output.frame.canvas
    fills = canvas.known is not None and canvas.shown is None and method.epsilon <= _HOLE_EPSILON
    if fills and output.seed != _SEED_OF_BEST:
        return Tolerance(_FILLING, of_best=True, by_similarity=False)
    return Tolerance(method.epsilon, of_best=False, by_similarity=method.choice == "similarity")
