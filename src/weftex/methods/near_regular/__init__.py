"""Near-regular synthesis: constrained random sampling and gap filling (chapter 4 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from weftex.canvas import Canvas
from weftex.endless.boxes import Corner, PlaneRequest
from weftex.exemplar import Exemplar
from weftex.method import Method
from weftex.methods.lattices import LatticeModel
from weftex.methods.near_regular.blending import blend_linearly, paste_blocks
from weftex.methods.near_regular.blocks import Plan, draw_constrained_blocks, fill_gaps
from weftex.methods.near_regular.layout import divide
from weftex.methods.near_regular.sample import check_block, margin_of, prepare, resolve
from weftex.parameters import length_parameter, parameter
from weftex.progress import ProgressCallback
from weftex.results.patches import PatchSynthesis
from weftex.threads import thread_map


@dataclass(frozen=True)
class NearRegular(Method):
    """Constrained random sampling and gap filling.

    The output is divided into square patches. Every second patch is copied from the sample, from a
    place that differs from its own by a random multiple of the lattice vectors. Each gap between
    them is copied from where the sample fits its four neighbors best. Irregularities vary.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> tile = np.random.default_rng(0).integers(0, 255, (12, 10), np.uint8)
    >>> sample = weftex.Exemplar(np.tile(tile, (5, 6)))
    >>> model = weftex.NearRegular(lattice=(10, 0, 0, 12)).fit(sample)
    >>> bool((model.sample((90, 80), seed=7).image == np.tile(tile, (8, 8))[:90, :80]).all())
    True
    """

    slug: ClassVar[str] = "near-regular"
    title: ClassVar[str] = "Near-regular synthesis"
    paper: ClassVar[str] = (
        "D. López Recas: Constrained random sampling and gap filling technique for near-regular "
        "texture synthesis. Diploma thesis, TU Berlin, 2011, section 4.2"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "random_access"})

    lattice: tuple[float, ...] | None = length_parameter(
        "vectors x1,y1,x2,y2 from one cell to the next; rows P apart: 0,P,1,0; any shift: 1,0,0,1",
        "found in the sample",
        count=4,
    )
    defaults: str = parameter(
        "weftex",
        "defaults of the other parameters: chosen for the sample, or the paper's",
        choices=("weftex", "paper"),
    )
    block_size: int | None = length_parameter(
        "side of the square patches; larger has fewer seams, smaller repeats less",
        "by cell and sample, up to 5/16 of the sample's side as in the paper",
        low=1,
        control="size",
    )
    border_width: int | None = length_parameter(
        "even width of the borders that must match, half of it on either side",
        "two thirds of the patch; 10 in the paper",
        low=0,
        parity="even",
    )
    blend: str = parameter(
        "feather",
        "how patches are joined: blended into each other, or pasted",
        choices=("feather", "none"),
    )
    blend_width: int | None = length_parameter(
        "width of the feathered area between patches; wider hides the seams better",
        "12, at most that of the borders; 4 in the paper",
        low=0,
        needs=("blend", ("feather",)),
        control="softness",
    )
    tolerance: int | None = length_parameter(
        "maximum distance of a patch in a gap from a multiple of the vectors",
        "3, less where the cell is small",
        low=0,
        high=64,
    )
    match: str = parameter(
        "difference",
        "how borders are compared: squared differences of colors, or their correlation",
        choices=("difference", "gncc"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.block_size is not None:
            check_block(self.block_size, self.border_width, self.blend_width)

    @property
    def margin(self) -> int:
        """How far a block's window reaches beyond the block."""
        return margin_of(self.border_width, self.blend_width)

    @property
    def window_side(self) -> int:
        """The side of a block's window."""
        return (self.block_size or 0) + 2 * self.margin

    def fit_exemplar(self, exemplar: Exemplar) -> NearRegularModel:
        """Find the lattice, if none is given, and choose the sizes."""
        return NearRegularModel(self, exemplar)


class NearRegularModel(LatticeModel):
    """A sample prepared for near-regular synthesis; `blocks` are taken from it as `BlockSample`."""

    method: NearRegular

    def __init__(self, method: NearRegular, exemplar: Exemplar) -> None:
        method = resolve(method, exemplar)
        self.blocks = prepare(method, exemplar)
        super().__init__(method, exemplar, method.lattice or ())

    def lay(
        self, canvas: Canvas, corner: Corner, asked: PlaneRequest, progress: ProgressCallback | None
    ) -> PatchSynthesis:
        """Make an output by section 4.2, with the improvements that chapter 6 proposes."""
        method, sample = self.method, self.blocks
        with thread_map(asked.threads) as each:
            # 4.2: split the output into square blocks; f[x] = f[x + a v1 + b v2] (eq. 4.3) says
            # which windows of the sample are similar to each.
            layout = divide(method, sample, canvas, corner, asked)
            plan = Plan(method, sample, layout, each)
            # 4.2.1: every second block gets a similar window, drawn at random (Fig. 4.7):
            # `block_kernels.draw_blocks`.
            sources = draw_constrained_blocks(plan)
            # 4.2.2: each gap gets the window that best matches the wedge-shaped borders of its
            # neighbors (Fig. 4.8 and 4.9: `sample.wedges_of`; eq. 4.4), within a tolerance around
            # similar ones: `block_kernels.fill_gaps`.
            sources = fill_gaps(plan, sources, progress)
            # 4.2.3: blend blocks linearly where they overlap (eqs. 4.6 to 4.10).
            return paste_blocks(plan, sources, blend_linearly(plan), method.describe())
