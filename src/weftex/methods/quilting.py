"""Image quilting (Efros and Freeman, 2001), over the machinery of patch-based sampling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from weftex.method import parameter
from weftex.methods.patches.analysis import PatchMethod


@dataclass(frozen=True)
class Quilting(PatchMethod):
    """Image quilting.

    It differs from patch-based sampling in two places: the candidates are those whose distance is
    within a tolerance of the best one's, and patches are joined along the path through their
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

    zone_share: ClassVar[float] = 1 / 6

    boundary_width: int | None = parameter(
        None,
        "width of the overlap that must match and that is cut",
        low=1,
        unit="px",
        default_text="a sixth of the patch, 4 or more",
    )
    tolerance: float = parameter(
        0.1, "candidates may be this much worse than the best, relatively", low=0.0
    )
    blend: str = parameter(
        "cut",
        "joining patches: cut along least error, feathered after each or at the end, or pasted",
        choices=("cut", "feather", "feather-at-end", "none"),
    )

    def rule(self) -> tuple[float, bool, bool]:
        """Within (1 + tolerance) of the best distance, all equally likely."""
        return self.tolerance, True, False
