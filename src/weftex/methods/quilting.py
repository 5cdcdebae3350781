"""Image quilting (Efros and Freeman, 2001), over the machinery of patch-based sampling."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from weftex.exemplar import Exemplar
from weftex.methods.patches.method import PatchMethod
from weftex.methods.patches.model import Output, PatchModel
from weftex.methods.patches.orders import Run
from weftex.methods.patches.patch_kernels import Tolerance
from weftex.parameters import parameter

_PAPERS_TOLERANCE = 0.1  # section 2.1


@dataclass(frozen=True)
class Quilting(PatchMethod):
    """Image quilting.

    Blocks of the sample are pasted in scan order. Each is picked from those whose overlap with the
    blocks before is within a tolerance of the best one's, and cut along the path through the
    overlap where they differ least.

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
    boundary_width: int | None = parameter(
        None,
        "width of the overlap that must match and is cut; wider hides the cut better",
        low=1,
        unit="px",
        default_text="a sixth of the patch size, at least 4",
        hole_text="4 px",
    )
    tolerance: float = parameter(
        0.1,
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
    def looseness(self) -> float:
        """See `PatchMethod.looseness`."""
        return (1 + self.tolerance) / (1 + _PAPERS_TOLERANCE)

    @property
    def anything(self) -> bool:
        """See `PatchMethod.anything`."""
        return self.tolerance == math.inf

    def fit_exemplar(self, exemplar: Exemplar) -> PatchModel:
        """Choose the sizes of block and overlap, and analyze the sample."""
        return PatchModel(self, exemplar, quilt)


def quilt(output: Output, method: Quilting) -> None:
    """Cover an output with blocks of the sample: the algorithm of section 2.2.

    Every block depends on those pasted before it. So a compiled loop, `patch_kernels.lay_patches`,
    picks, cuts and pastes one block after the other, in runs of blocks whose overlaps have the
    same shape.
    """
    # "Within some error tolerance": at most 1 + tolerance times the error of the best block.
    # "Randomly pick one such block": each is as likely.
    tolerance = Tolerance(method.tolerance, of_best=True, by_similarity=False)

    def quilt_blocks(run: Run) -> None:
        # "Search the input texture for a set of blocks that satisfy the overlap constraints (above
        # and left)": the blocks of the sample, arranged to be searched by such an overlap. The
        # error of the overlap is `zone_kernels.zone_distance`. Beyond the paper: unless `search` is
        # exhaustive, only the `candidates` best at low resolution are compared.
        blocks = output.search_for(run)
        # Pick one within the tolerance (`patch_kernels.draw_one`). Compute the error surface
        # between it and the old blocks at the overlap, and make the minimum cost path along it the
        # block's boundary (section 2.1, `patch_kernels.cut_bands`). Paste the block.
        output.choose_and_paste(run, blocks, tolerance)

    # "In raster scan order in steps of one block (minus the overlap)": `orders.scan_patches`, which
    # spreads blocks evenly, so that overlaps may be wider.
    output.paste_in_order(quilt_blocks)
