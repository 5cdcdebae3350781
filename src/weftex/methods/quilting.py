"""Image quilting (Efros and Freeman, 2001), with the search of patch-based sampling.

The texture transfer of section 3 is not here; `graphcut` and `ashikhmin` follow a guide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from weftex.exemplar import Exemplar
from weftex.methods.patches.method import PatchMethod
from weftex.methods.patches.model import PatchCanvas, PatchModel
from weftex.methods.patches.orders import Run
from weftex.methods.patches.patch_kernels import Tolerance
from weftex.parameters import length_parameter, parameter

_PAPERS_TOLERANCE = 0.1  # section 2.2


@dataclass(frozen=True)
class Quilting(PatchMethod):
    """Image quilting.

    Patches of the sample are pasted in scan order. Each is drawn from those whose error in the
    overlap with earlier patches is at most 1 + tolerance times the least error. It is cut along
    the path through the overlap where it differs least from the earlier patches.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> sample = weftex.Exemplar(np.random.default_rng(0).integers(0, 255, (48, 48), np.uint8))
    >>> weftex.Quilting(patch_size=16).fit(sample).sample((60, 80), seed=7).image.shape
    (60, 80)
    """

    slug: ClassVar[str] = "quilting"
    title: ClassVar[str] = "Image quilting"
    paper: ClassVar[str] = (
        "A. A. Efros, W. T. Freeman: Image quilting for texture synthesis and transfer. "
        "Proceedings of SIGGRAPH 2001"
    )

    boundary_share: ClassVar[float] = 1 / 6  # section 2.2
    boundary_width: int | None = length_parameter(
        "width of the overlap that must match and is cut; wider hides the cut better",
        "a sixth of the patch size, at least 4",
        low=1,
        hole_text="4 px",
    )
    tolerance: float = parameter(
        _PAPERS_TOLERANCE,
        "how much worse than the best match a patch may be, as a share; higher is more random",
        low=0.0,
        control="variety",
    )
    blend: str = parameter(
        "cut",
        "how patches join: cut along the least error, feathered at once or at the end, or pasted",
        choices=("cut", "feather", "feather-at-end", "none"),
    )

    @property
    def tolerance_ratio(self) -> float:
        """See `PatchMethod.tolerance_ratio`."""
        return (1 + self.tolerance) / (1 + _PAPERS_TOLERANCE)

    @property
    def accepts_all(self) -> bool:
        """See `PatchMethod.accepts_all`."""
        return self.tolerance == math.inf

    def fit_exemplar(self, exemplar: Exemplar) -> PatchModel:
        """Choose the sizes of block and overlap, and analyze the sample."""
        return PatchModel(self, exemplar, quilt)


def quilt(output: PatchCanvas, method: Quilting) -> None:
    """Cover an output with blocks of the sample: the algorithm of section 2.2.

    Sections and quotations are of Efros and Freeman (2001). Each block depends on those before it,
    so compiled code, `lay_patches` of `patch_kernels`, takes steps 1 to 3 for a run of blocks.
    """
    tolerance = Tolerance(method.tolerance, of_best=True, by_similarity=False)

    # "Go through the image to be synthesized in raster scan order in steps of one block (minus the
    # overlap)": `orders.scan_patches`. It spreads blocks evenly, so that overlaps may be wider.
    def quilt_blocks(run: Run) -> None:
        # 1. "For every location, search the input texture for a set of blocks that satisfy the
        #    overlap constraints (above and left) ...", by `zone_distance`. Not in the paper: unless
        #    `search` is exhaustive, only the `candidates` best at a low resolution are compared;
        #    unless `repeat_distance` is 0, repeats of a block nearby are left out (`free_repeats`).
        # 2. "... within some error tolerance. Randomly pick one such block": each block with at
        #    most 1 + tolerance times the error of the best is as likely (`draw_one`).
        # 3. "Compute the error surface between the newly chosen block and the old blocks at the
        #    overlap region. Find the minimum cost path along this surface and make that the
        #    boundary of the new block. Paste the block": `cut_kernels.cut_bands` (section 2.1) and
        #    `paste_kernels.paste`, where two paths meet in an L (`effective`).
        output.choose_and_paste(run, output.search_for(run), tolerance)

    output.paste_in_order(quilt_blocks)  # "Repeat."
