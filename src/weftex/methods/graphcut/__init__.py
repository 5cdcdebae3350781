"""Graph-cut textures (Kwatra, Schödl, Essa, Turk and Bobick, 2003)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from weftex.analysis import patch_sizes
from weftex.analysis.canvas_lattice import check_lattice, fitted_sample, given_lattice
from weftex.canvas import Canvas
from weftex.endless.grid import Sizes, loose_in
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.exemplar.turns import turned
from weftex.guides import Guiding, materials
from weftex.method import Method
from weftex.methods.graphcut.cutting import CutCanvas, WorstSeams
from weftex.methods.graphcut.entire import EntirePatchMatching, holes_of
from weftex.methods.graphcut.placement import Patch, Placement, draw_offsets
from weftex.methods.graphcut.sample import CutSample
from weftex.methods.graphcut.subpatch import SubPatchMatching
from weftex.methods.pixels import Growth, PixelModel
from weftex.parameters import guide_parameter, length_parameter, parameter
from weftex.progress import ProgressCallback
from weftex.raster.arrays import Mask
from weftex.repeats import Repetition
from weftex.repeats.salience import SaliencePenalty, cell_side
from weftex.results.joining import with_mask
from weftex.results.pixels import PixelSynthesis
from weftex.search.windows import windows_of
from weftex.threads import quick_map

_LARGE = 2**15  # pixels of a patch whose candidates are cut in threads; a larger hole has fewer
_LEAST, _MOST = 128, 512  # pixels between lines of nodes of a plane; most for entire samples
_TURNS = {"half-turns": "half", "all": "8"}  # orientations, as `turned` names them
_GUIDED, _LEAST_GUIDED = 0.15, 48  # side of a patch that follows a guide: a share, pixels
_IDLE = 4  # refinements that improve nothing, for each patch that covered the canvas, end it
_OF_ROWS = 3.2  # strength of repeats nearby in long outputs of rows, see `Repetition`


@dataclass(frozen=True)
class GraphCut(Method):
    """Graph-cut textures.

    A patch of the sample is placed where it matches the pixels before it, and a minimum cut decides
    which of its pixels replace older ones. Further patches may be placed over the worst seams. The
    cost of old seams is part of every cut, so these patches never make seams worse.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> sample = weftex.Exemplar(np.random.default_rng(0).integers(0, 255, (48, 48), np.uint8))
    >>> weftex.GraphCut(patch_size=16).fit(sample).sample((60, 80), seed=7).image.shape
    (60, 80)
    """

    slug: ClassVar[str] = "graphcut"
    title: ClassVar[str] = "Graph-cut textures"
    paper: ClassVar[str] = (
        "V. Kwatra, A. Schödl, I. Essa, G. Turk, A. Bobick: Graphcut textures: image and video "
        "synthesis using graph cuts. ACM Transactions on Graphics 22(3), 2003"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "guide"})
    cuts_known: ClassVar[bool] = True

    placement: str = parameter(
        "subpatch",
        "what is placed: squares (subpatch), or the entire sample: best match, by rows, or random",
        choices=("subpatch", "entire", "rows", "random"),
    )
    patch_size: int | None = length_parameter(
        "side of the square patches; larger keeps larger features whole",
        "0.45 x the sample's shorter side; a smaller share above 512 px",
        low=1,
        hole_text=patch_sizes.HOLE_PATCHES,
        needs=("placement", ("subpatch",)),
        control="size",
    )
    boundary_width: int | None = length_parameter(
        "width of the overlap with patches placed before; wider hides the seam better",
        "a third of the patch size",
        low=0,
        needs=("placement", ("subpatch",)),
    )
    tolerance: float | None = parameter(
        None,
        "randomness of the choice among matches, in sample variances; 0 takes the best matches",
        low=0.0,
        high=1000.0,
        default_text="0.003; 0 if placement is entire",
        needs=("placement", ("subpatch", "entire", "rows")),
    )
    candidates: int | None = parameter(
        None,
        "number of placements tried for each patch; the cheapest seam wins; higher is slower",
        low=1,
        high=1000,
        default_text="4; entire: 12, in holes 48 (large: 16); rows or lattice: 24, in holes 96",
    )
    seam_cost: str = parameter(
        "gradient",
        "cost of a seam: color difference (difference), or that divided by gradients (gradient)",
        choices=("gradient", "difference"),
    )
    refinements: float | None = parameter(
        None,
        "number of patches placed over the worst seams, per patch of the first pass; "
        "higher is slower",
        low=0.0,
        high=1000.0,
        default_text="random: 1; entire without a lattice, in holes: 2 (large: 0.5); else 0",
    )
    variety: float = parameter(
        1.0,
        "penalty for repeating a part of the sample nearby; higher repeats less (0 in the paper)",
        low=0.0,
        high=1000.0,
        needs=("placement", ("subpatch", "entire", "rows")),
        control="variety",
    )
    halvings: int | None = parameter(
        None,
        "number of pyramid levels for matching and cutting; 0 is full resolution (the paper)",
        low=0,
        high=8,
        default_text="as many as leave patches at least 24 pixels wide, at most 4; "
        "2 in holes, if placement is entire without a lattice",
    )
    tone_reach: float = parameter(
        16.0,
        "distance over which tone steps at seams are spread; higher is smoother (0 in the paper)",
        low=0.0,
        high=256.0,
        unit="px",
        idle_canvas="known",
        control="softness",
    )
    guide_weight: float = guide_parameter(
        "weight of the guide against the image so far; higher follows the guide more closely", 2.0
    )
    lattice: tuple[float, ...] | None = length_parameter(
        "shift only by multiples of the lattice vectors x1,y1,x2,y2; for rows P apart: 0,P,1,0",
        "any shift",
        count=4,
        needs=("placement", ("entire",)),
    )
    orientations: str = parameter(
        "upright",
        "orientations of the entire sample: upright, also rotated by 180 degrees, or all eight",
        choices=("upright", *_TURNS),
        needs=("placement", ("entire",)),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.patch_size is not None and self.boundary_width is not None:
            patch_sizes.check_boundary(self.patch_size, self.boundary_width)

    def require(self, canvas: Canvas) -> None:
        """See `Method.require`."""
        super().require(canvas)
        if canvas.guide is not None and self.placement != "subpatch":
            raise InvalidInputError(f"a guide needs placement 'subpatch', not {self.placement!r}")

    @property
    def hole_reach(self) -> int:
        """See `Method.hole_reach`."""
        return 2 * (self.patch_size or 0)

    def for_hole(self, hole: Mask, usable: Mask, given: frozenset[str] | None) -> Self:
        """See `Method.for_hole`; few entire samples fit on all sides, as only fine cuts tell."""
        if self.orientations != "upright":
            raise InvalidInputError(
                f"orientations is {self.orientations!r}; holes are filled with upright copies only"
            )
        best: dict[str, Any] = {}
        if self.placement == "subpatch":
            best = {"patch_size": patch_sizes.patch_size_for(hole, usable, 1)}
        elif self.lattice is not None or self.placement == "rows":
            best = {"candidates": 96}  # finer cuts and refinements break its joints
        elif self.placement == "entire":
            fine = 2 if min(usable.shape) >= 96 else None
            # In large holes they take most of the time; in small ones few leave seeds no choice.
            count, more = (16, 0.5) if hole.sum() > _LARGE else (48, 2.0)
            best = {"candidates": count, "refinements": more, "halvings": fine}
        return replace(self, **{k: n for k, n in best.items() if getattr(self, k) is None})

    def resolved(self, exemplar: Exemplar) -> Self:
        """See `Method.resolved`; `patch_size` stays open for thin samples, see `patch_shape`."""
        way = self.placement
        if self.lattice is not None:
            check_lattice(self.lattice, exemplar)
        count = self.candidates or {"entire": 24 if self.lattice else 12, "rows": 24}.get(way, 4)
        refinements = _given(self.refinements, 1.0 if way == "random" else 0.0)
        tolerance = _given(self.tolerance, {"subpatch": 0.003, "entire": 0.0, "rows": 0.0}.get(way))
        found = replace(self, candidates=count, refinements=refinements, tolerance=tolerance)
        return found.for_patches(self.patch_shape(exemplar)) if way == "subpatch" else found

    def patch_shape(self, exemplar: Exemplar) -> tuple[int, int]:
        """Height and width of patches: squares, but for thin samples; or the entire sample."""
        if self.placement != "subpatch":
            return exemplar.shape
        return patch_sizes.patch_shape_for(exemplar, self.patch_size)

    def for_patches(self, shape: tuple[int, int]) -> Self:
        """Return this method for sub-patches of a shape, with the boundary that suits them."""
        side = max(shape)
        boundary = _given(self.boundary_width, side // 3)
        patch_sizes.check_boundary(side, boundary)
        square = side if shape[0] == shape[1] else None
        return replace(self, patch_size=square, boundary_width=boundary)

    def fit_exemplar(self, exemplar: Exemplar) -> GraphCutModel:
        """Prepare a sample, and perhaps copies of it that are turned."""
        if self.orientations in _TURNS:
            if self.lattice is not None:
                raise InvalidInputError("give lattice or orientations, not both")
            exemplar = turned(exemplar, _TURNS[self.orientations])
        return GraphCutModel(self, exemplar)


class GraphCutModel(PixelModel):
    """A sample prepared for graph-cut textures."""

    def __init__(self, given: GraphCut, exemplar: Exemplar) -> None:
        windows = windows_of(exemplar, (0, 0, 0, 0))
        self.method: GraphCut = given.resolved(exemplar)
        side = self.method.patch_size
        self.given, self.patch_shape = given, (side, side) if side else given.patch_shape(exemplar)
        sample = CutSample(exemplar, windows, given.seam_cost == "gradient", given.halvings)
        super().__init__(self.method, exemplar, sample, self.synthesize)

    def block_sizes(self) -> Sizes:
        """See `Model.block_sizes`: in narrow belts seams would run straight."""
        patch = min(self.exemplar.copy_shape or self.patch_shape)
        belt = 2 * max(8, patch // 2 if self.method.boundary_width else min(patch, _MOST) // 4)
        return Sizes(max(2 * belt, _LEAST), belt, loose_in(belt))

    def on(self, canvas: Canvas) -> tuple[GraphCut, tuple[int, int]]:
        """The method and the shape of patches for one output.

        Patches take no larger share of it than of the sample, unless their size was given.
        """
        method, shape, given = self.method, self.patch_shape, self.given
        if canvas.guide is not None:
            count, more = given.candidates or 12, _given(given.refinements, 1.0)
            method = replace(method, candidates=count, refinements=more)
        if given.placement != "subpatch" or given.patch_size is not None:
            return method, shape
        if canvas.guide is not None:
            side = max(_LEAST_GUIDED, round(_GUIDED * min(*self.exemplar.shape, *canvas.shape)))
            shape = min(shape[0], side), min(shape[1], side)
        most = max(
            patch_sizes.patch_size_on(canvas, patch_sizes.PATCH_SHARE),
            2 * (given.boundary_width or 0) + 1,
        )
        shape = min(shape[0], most), min(shape[1], most)
        return replace(method, boundary_width=given.boundary_width).for_patches(shape), shape

    def make(
        self, canvas: Canvas, seed: int, threads: int, progress: ProgressCallback | None
    ) -> PixelSynthesis:
        """See `Model.make`; not in the paper: outputs are stretched to whole rows or a lattice."""
        fitting, fitted = fitted_sample(self.exemplar, self.method.lattice, canvas)
        if self.method.placement == "rows" and self.prepared.boards is not None:
            fitting = self.prepared.boards.fitted(canvas, seed)
        if fitted is None:
            made = super().make(fitting, seed, threads, progress)
            if canvas.guide is not None:
                made.parts = with_mask(materials(self.exemplar), self.exemplar.mask)
            return made.stretched(canvas)
        index, vectors, sample = fitted
        model = GraphCutModel(replace(self.given, lattice=None), sample)
        model.method = replace(model.method, lattice=vectors)
        made = model.make(fitting, seed, threads, progress)
        return made.through(index, self.exemplar, self.method.describe()).stretched(canvas)

    def synthesize(self, sample: CutSample, growth: Growth) -> None:
        """Cover the canvas with patches, then put more patches over its worst seams."""
        if growth.canvas.shown is not None:  # of a plane's block or a hole, whose border may change
            growth.show(growth.canvas.shown >= 0)
        method, shape = self.on(growth.canvas)
        placement = placement_of(method, shape, sample, growth)
        growth.tone_reach = method.tone_reach
        growth.about |= method.describe() | {"patch_shape": list(placement.size)}
        cut_and_paste(method, placement, sample, growth)


def placement_of(
    method: GraphCut, shape: tuple[int, int], sample: CutSample, growth: Growth
) -> Placement:
    """Random placement, entire patch matching or sub-patch matching (section 4).

    Oriented copies, the lattice and the repetition penalty are not in the paper.
    """
    entire, lattice, penalty = method.placement != "subpatch", method.lattice, None
    boxes = (sample.boxes if entire else []) or [(0, 0, *sample.exemplar.shape)]
    if method.variety > 0 and method.placement != "random":
        # Things shown both ways up look less alike. High prices would cut joints of a lattice.
        nearby, use = (0.3 if sample.boxes else 0.4, 0.05) if entire else (1.0, 0.25)
        long = (np.divide(growth.canvas.shape, sample.exemplar.shape) > 2).any()
        if lattice and long and len(given_lattice(lattice).vectors) == 1:
            nearby = _OF_ROWS  # else one match may be the best again and again
        policy = Repetition(method.variety, nearby, use)
        small = sample.part(boxes[0]).levels(cell_side(boxes))[-1]
        cells, cost = (small.pixels, small.mask), sample.usual_cost * (0.5 if lattice else 1.0)
        penalty = SaliencePenalty(policy, sample.exemplar, growth, boxes, cells, cost)
    if not entire:
        guiding, boundary = None, method.boundary_width or 0
        if growth.canvas.guide is not None:
            guiding = Guiding(sample.exemplar, growth, method.guide_weight, sample.usual_cost)
        return SubPatchMatching(sample, growth, shape, boundary, penalty, guiding)
    return EntirePatchMatching(sample, growth, method.placement, lattice, penalty)


def cut_and_paste(
    method: GraphCut, placement: Placement, sample: CutSample, growth: Growth
) -> None:
    """Cover an output with patches of the sample: sections 3 to 5 of Kwatra et al. (2003)."""
    assert method.candidates is not None and method.refinements is not None
    count, tolerance = method.candidates, _given(method.tolerance, 1.0)  # random: all match
    copies = method.placement in ("entire", "rows") and bool(sample.boxes)
    threads = min(growth.threads, count) if math.prod(placement.size) >= _LARGE else 1
    canvas = CutCanvas(sample, growth, placement, threads, copies=copies)
    lattice = given_lattice(method.lattice) if method.lattice else None
    strict = lattice is not None and (any(growth.canvas.wrap) or len(lattice.vectors) == 1)
    if strict or method.placement == "rows":
        canvas.penalty = None  # bricks of any length, or of tileable outputs, would be cut
    hole = np.ptp(holes_of(growth), axis=2).max(axis=0)
    with quick_map(threads) as map_:

        def best_patch(pixel: tuple[int, int], number: int, *, centered: bool) -> Patch:
            # C(t) for all offsets t (section 4), by FFT (section 5): `search.fft_mismatch`.
            matches = placement.matches(pixel, number, centered, map_)
            # Some of them, drawn by P(t) = exp(-C(t) / (k sigma**2)) (section 4).
            drawn = draw_offsets(matches, placement, tolerance, (growth.seed, number, count))
            patches = matches.patches(drawn, map_)
            if len(patches) == 1:
                return patches[0]
            # Not in the paper: of several, the patch whose seams cost least for each new pixel.
            return canvas.cheapest(patches, map_)

        # Patches that each cover the first missing pixel (section 4), cut with old seams (3.1).
        pasted = 0
        progress = growth.progress(int((growth.done == 0).sum()), "pixels")
        for pixel in canvas.missing():
            progress.advance(canvas.paste(best_patch(pixel, pasted, centered=False)))
            pasted += 1

        # Patches over the worst seams (section 4), surrounded by old pixels (section 3.2).
        more = round(method.refinements * pasted)
        if not more:
            return
        canvas.penalty = canvas.penalty if canvas.guiding else None  # only seams, and a guide
        seams = WorstSeams(canvas, growth.canvas, np.minimum(placement.size, hole).tolist())
        progress = growth.progress(more, "repairs")
        for number in range(pasted, pasted + more):
            worst = seams.worst()
            # Not in the paper: seams that many patches did not improve cannot be improved.
            if worst is None or seams.idle > _IDLE * pasted:
                progress.advance(progress.total - progress.done)
                break
            best = best_patch(worst, number, centered=True)
            canvas.paste(best)
            seams.update_around(best)
            progress.advance(1)


def _given(value: Any, default: Any) -> Any:
    return default if value is None else value
