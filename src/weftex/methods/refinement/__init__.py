"""Iterative texture refinement (the paper on refinement and fusion, sections 3, 5 and 6)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from weftex.endless.boxes import Box, PlaneRequest
from weftex.endless.grid import Sizes
from weftex.exemplar import Exemplar
from weftex.method import Method
from weftex.methods.pixels import Growth, PixelModel, WindowedMethod
from weftex.methods.refinement.defaults import Starts, resolved_method, start_text, window_width
from weftex.methods.refinement.levels import (
    Prepared,
    finish,
    levels_that_show,
    output_pyramid,
    prepare,
)
from weftex.methods.refinement.start import (
    fitted_starts,
    keep_patches,
    result_of,
    start_sources,
    start_window,
)
from weftex.methods.refinement.sweeps import Convergence, refine_texture, sweep_of
from weftex.parameters import length_parameter, parameter, window_parameter

_PITCH = 384  # pixels, at least, from one node of a plane to the next


@dataclass(frozen=True)
class Refinement(WindowedMethod):
    """Iterative refinement.

    A grid of seed points, or the result of another method, is refined again and again: every
    pixel is copied from the sample pixel whose window is most like its own. The paper's algorithm
    is `search="nearest"` and `init="seeds"`.

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
        "S. Shin, T. Nishita, S. Y. Shin: On pixel-based texture synthesis by non-parametric "
        "sampling. Computers & Graphics 30(5), 2006"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "many"})
    belt_parameters: ClassVar[frozenset[str]] = frozenset({"seed_scale", "seed_density", "matches"})

    window_width: int | None = window_parameter(
        "side of the square window that is compared, odd; wider keeps larger shapes",
        "twice the sample's scale (weftex analyze), at least 29 if coherent",
    )
    search: str = parameter(
        "coherent",
        "windows to compare: those of the neighbors' sources (coherent), or all (nearest, slow)",
        choices=("coherent", "nearest"),
    )
    iterations: int = parameter(
        10,
        "maximum number of iterations; doubled on the coarsest pyramid level, halved on the others",
        low=1,
        high=1000,
    )
    threshold: float = parameter(
        0.01, "stop when an iteration changes the image by less; higher stops earlier", low=0.0
    )
    init: str | Method = parameter(  # noqa: RUF009  (methods are frozen)
        "auto",
        "initial image: seeds, a method such as 'graphcut placement=entire', or auto (by lattice)",
        choices=Starts("auto", "seeds"),
    )
    joints: int | None = length_parameter(
        "refine only belts of this even width along the seams of the initial image; wider "
        "changes more",
        "everything is refined",
        low=2,
        parity="even",
        needs=("init", Starts("auto")),
    )
    seed_scale: float | None = length_parameter(
        "distance between seed points at a density of 1; higher places fewer",
        "the sample's scale (weftex analyze)",
        low=1.0,
        needs=("init", ("seeds",)),
    )
    seed_density: float = parameter(
        1.0,
        "number of seed points per seed scale along each axis; higher places more",
        low=0.1,
        high=10.0,
        needs=("init", ("seeds",)),
    )
    matches: int = parameter(
        5,
        "number of best matches that each seed point is drawn from; higher is more random",
        low=1,
        needs=("init", ("seeds",)),
    )
    similar: int = parameter(
        2,
        "number of similar sample pixels tried for each coherent candidate; higher is slower",
        low=0,
        high=32,
        needs=("search", ("coherent",)),
    )
    evenness: float = parameter(
        1.0,
        "penalty for overused parts of the sample; higher uses the sample more evenly",
        low=0.0,
        high=100.0,
        needs=("search", ("coherent",)),
        control="variety",
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "init", start_text(self.init))
        super().__post_init__()

    def meant(self, name: str) -> Any:
        """What `init` is, if that is left to the search, for samples without a sure lattice."""
        if name == "init" and self.init == "auto":
            return "quilting" if self.search == "coherent" or self.joints else "seeds"
        return super().meant(name)

    def for_belt(self, width: int, **parameters: Any) -> Self:
        """See `Method.for_belt`: seeds lie all over a belt (section 4)."""
        parameters |= {"joints": None}  # a belt is a joint, all of it
        if self.init in ("auto", "seeds"):
            # Patches of another start end along the belt. The sample is merged of two, and has no
            # scale of its own: seed points lie half a window apart, the scale of the larger of the
            # two. The paper has that of the smaller.
            scale = self.seed_scale or max(1, self.window_for(width) // 2)
            parameters = {"init": "seeds", "seed_scale": scale} | parameters
        return super().for_belt(width, **parameters)

    def fit_exemplar(self, exemplar: Exemplar) -> RefinementModel:
        """Analyze a sample: its dominant scale, and how to find windows like one."""
        starts = fitted_starts(self, exemplar)
        # Step 1: WindowSize.
        method = resolved_method(self, exemplar, next(iter(starts), "seeds"))
        # Step 2: SearchTree.
        prepared = prepare(method, exemplar, starts, by_canvas=self.init == "auto")
        return RefinementModel(method, exemplar, prepared, texture_synthesis)

    def window_of(self, exemplar: Exemplar) -> int:
        """See `Method.window_of`."""
        return window_width(self, exemplar)

    def resolved(self, exemplar: Exemplar) -> Self:
        """See `Method.resolved`."""
        init = next(iter(fitted_starts(self, exemplar)), "seeds")
        resolved: Self = resolved_method(self, exemplar, init)
        return resolved


class RefinementModel(PixelModel):
    """A sample prepared for iterative refinement."""

    def block_sizes(self) -> Sizes:
        """See `Model.block_sizes`; blocks begin with a plane of the start."""
        width = min(self.prepared.method.window_width, 64)
        belt = 2 * max(width, 16)
        return Sizes(pitch=max(4 * belt, _PITCH), belt=belt, around=width)

    def start_of(self, box: Box, asked: PlaneRequest) -> NDArray[np.int32] | None:
        """See `Model.start_of`: what the start's own plane shows."""
        return start_window(self.prepared.starts, box, asked)


def texture_synthesis(prepared: Prepared, growth: Growth) -> None:
    """Make an output: steps 3 to 10 of TextureSynthesis (section 3), coarse to fine.

    The paper refines seed points at one resolution. Beyond it, the result of another method may be
    refined, and the coherent search goes through coarser levels first.
    """
    start, start_map = result_of(prepared, growth)
    if start_map is not None:  # coarse levels would move it near a hole of the sample
        count = levels_that_show(start_map, prepared.levels, growth)
        rounds = (*prepared.rounds[: count - 1], prepared.rounds[-1])
        prepared = replace(prepared, levels=prepared.levels[:count], rounds=rounds)
    levels, windows, rounds = prepared.levels, prepared.windows, prepared.rounds
    growth.about |= {"init": start, "levels": len(levels)}
    if start_map is not None and prepared.belt:
        # Section 5, Fig. 13: patches stay, belts along their seams are a hole.
        keep_patches(start_map, prepared.belt, windows, growth)
        if growth.done.all():
            return
    # Section 5, Fig. 12; a block of a plane goes on with what was started all over it.
    cyclic = growth.hole is not None and (start_map is None or growth.canvas.shown is None)
    outputs = output_pyramid(windows, levels, growth)
    convergence = Convergence(prepared.method.threshold, cyclic)
    steps = [output.count * n for output, n in zip(outputs, rounds, strict=True)]
    progress = growth.progress(sum(steps), "pixels")
    for number in reversed(range(len(levels))):
        output = outputs[number]
        # Step 3: PlantSeed.
        start_from = start_sources(prepared, outputs, number, start_map, growth.seed)
        output.begin(levels[number], start_from)
        growth.coarse = (output.pixels, 2**number) if number else None  # for the preview
        sweep = sweep_of(prepared, output, growth.seed, cyclic)
        for iteration in range(rounds[number]):  # step 5: while (ContinueFlag)
            convergence.remember(output)
            changed = refine_texture(sweep, iteration, progress)  # step 6: RefineTexture
            if convergence.reached(output, iteration, changed):  # steps 7 and 8: eq. (1)
                left = rounds[number] - 1 - iteration
                progress.advance(left * output.count)
                break
    finish(outputs[0], levels[0], windows, growth)  # step 10
    growth.about["convergence"] = convergence.curve  # section 5, Fig. 7
