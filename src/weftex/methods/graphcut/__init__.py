"""Graph-cut textures (Kwatra, Schödl, Essa, Turk and Bobick, 2003)."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Self

from weftex.errors import InvalidInputError
from weftex.method import Method
from weftex.methods.graphcut.cutting import Picture
from weftex.methods.graphcut.placement import placement_of
from weftex.methods.graphcut.seams import CanvasSeams
from weftex.methods.graphcut.settings import Settings, check_boundary, settle
from weftex.methods.patches.sizes import patch_size_for
from weftex.methods.pixels.growth import PixelModel
from weftex.parameters import parameter
from weftex.planes.grid import Sizes
from weftex.threads import quick_map
from weftex.turns import turned

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.graphcut.places import Place
    from weftex.methods.pixels.growth import Growth

_LARGE = 2**14  # pixels of a patch from which on candidates are priced in threads
_PATCHES = 2  # in a row between two belts of a plane
_IDLE = 4  # refinements that mend nothing, for each patch that covered the canvas, end it


@dataclass(frozen=True)
class GraphCut(Method):
    """Graph-cut textures.

    A patch of the sample is placed where it matches the pixels before it, and a minimum cut decides
    which of its pixels replace older ones. Further patches may be placed over the worst seams. Old
    seams count in every cut, so the picture only gets better.

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
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known"})

    placement: str = parameter(
        "subpatch",
        "patches: squares that match, the entire sample where it matches, or anywhere",
        choices=("subpatch", "entire", "random"),
    )
    patch_size: int | None = parameter(
        None,
        "side of the square patches",
        low=1,
        unit="px",
        default_text="0.45 x the sample's shorter side; over 512 px, of 36 x its scale or the "
        "output's shorter side where that is less, 230 or more",
        needs=("placement", ("subpatch",)),
    )
    boundary_width: int | None = parameter(
        None,
        "reach of a patch over the pixels before it",
        low=0,
        unit="px",
        default_text="a third of the patch",
        needs=("placement", ("subpatch",)),
    )
    tolerance: float | None = parameter(
        None,
        "k: matches may be so much worse than the best, as shares of the sample's variance",
        low=0.0,
        high=1000.0,
        default_text="0.003, for entire patches 0: the best ones",
        needs=("placement", ("subpatch", "entire")),
    )
    candidates: int | None = parameter(
        None,
        "places of a patch that are drawn and cut; the one with the cheapest seam is kept",
        low=1,
        high=1000,
        default_text="4, of entire patches 24",
    )
    seam_cost: str = parameter(
        "gradient",
        "cost of a seam: the difference of its pixels, or that divided by gradients across it",
        choices=("gradient", "difference"),
    )
    refinements: float | None = parameter(
        None,
        "patches over the worst seams, for each that covered the canvas",
        low=0.0,
        high=1000.0,
        default_text="1 after random placement, else 0",
    )
    variety: float = parameter(
        1.0,
        "cost of showing a place of the sample again nearby, or in line; 0 is the paper's way",
        low=0.0,
        high=1000.0,
        needs=("placement", ("subpatch", "entire")),
    )
    halvings: int | None = parameter(
        None,
        "matches and cuts begin on copies halved up to so many times; 0 is the paper's way",
        low=0,
        high=8,
        default_text="up to 4, so that a patch has 24 pixels a side or more",
    )
    tone_reach: float = parameter(
        16.0,
        "pixels in which steps of tone across seams are spread; 0 is the paper's way",
        low=0.0,
        high=256.0,
        unit="px",
        idle_canvas="known",
    )
    lattice: tuple[float, ...] | None = parameter(
        None,
        "translation vectors x1,y1,x2,y2 that the entire sample is shifted by; 1,0,0,P are rows",
        count=4,
        unit="px",
        default_text="any place",
        needs=("placement", ("entire",)),
    )

    orientations: str = parameter(
        "upright",
        "ways that the entire sample lies: as it is, or upside down too, so there is more of it",
        choices=("upright", "half-turns"),
        needs=("placement", ("entire",)),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.patch_size is not None and self.boundary_width is not None:
            check_boundary(self.patch_size, self.boundary_width)

    @property
    def hole_reach(self) -> int:
        """See `Method.hole_reach`."""
        return 2 * (self.patch_size or 0)

    def for_hole(
        self, hole: NDArray[np.bool_], usable: NDArray[np.bool_], given: frozenset[str] | None
    ) -> Self:
        """See `Method.for_hole`; the other placements lay the entire sample."""
        if self.orientations != "upright":
            raise InvalidInputError(
                f"orientations is {self.orientations!r}; holes are filled from a photo as it is"
            )
        if self.patch_size is not None or self.placement != "subpatch":
            return self
        return replace(self, patch_size=patch_size_for(hole, usable, 1))

    def fit_exemplar(self, exemplar: Exemplar) -> GraphCutModel:
        """Prepare a sample, and perhaps a copy of it upside down."""
        if self.orientations == "half-turns":
            if self.lattice is not None:
                raise InvalidInputError("copies that are turned share no lattice")
            exemplar = turned(exemplar, "half")
        given = asdict(self)
        del given["orientations"]
        settings = settle(exemplar, **given)
        method = replace(self, candidates=settings.candidates, refinements=settings.refinements)
        if self.placement != "random":
            method = replace(method, tolerance=settings.tolerance)
        if self.placement == "subpatch":  # the others lay the entire sample
            sizes = settings.sizes()
            method = replace(
                method, patch_size=sizes.get("patch_size"), boundary_width=sizes["boundary_width"]
            )
        return GraphCutModel(method, exemplar, settings, synthesize)


class GraphCutModel(PixelModel):
    """A sample prepared for graph-cut textures."""

    def block_sizes(self) -> Sizes:
        """See `Model.block_sizes`: a corner is a patch, and cuts go on in what is there.

        Between belts is room for so many patches that the last ones lie on belts as far as the
        first ones do; entire patches are cut anywhere.
        """
        settings: Settings = self.prepared
        side, boundary = min(settings.patch_shape), settings.boundary_width
        belt = 2 * max(side // 2 if boundary else side // 4, 8)
        gap = _PATCHES * (side - boundary) - boundary if boundary else 2 * belt
        return Sizes(pitch=belt + max(gap, belt), belt=belt, loose=belt // 3)


def synthesize(settings: Settings, growth: Growth) -> None:
    """Cover the canvas with patches, then put more patches over its worst seams.

    Sections are those of the paper.
    """
    settings = settings.on(growth.canvas)
    if growth.canvas.shown is not None:  # a block of a plane: its border may be cut again
        growth.show(growth.canvas.shown >= 0)
    placement = placement_of(settings, growth)  # random, entire patch or sub-patch (section 4)
    picture = Picture(settings, growth, placement.size, placement.reduction)
    growth.tone_reach = settings.tone_reach
    growth.about["patch_shape"] = list(placement.size)
    if settings.placement == "subpatch":
        growth.about |= settings.sizes()

    threads = min(growth.threads, settings.candidates) if math.prod(placement.size) >= _LARGE else 1
    with quick_map(threads) as map_:

        def place(pixel: tuple[int, int], number: int, *, centered: bool) -> Place:
            # Places that match, drawn by P(t) = exp(-C(t) / (k sigma**2)) (section 4); C(t) by FFT
            # (section 5): `search.translation`.
            places = placement.candidates(pixel, number, centered, map_)
            if len(places) == 1:
                return places[0]
            # The minimum cut between old and new pixels; old seams are in the graph (section 3).
            return picture.cheapest(places, map_)

        # Patches that each cover the first missing pixel, until none is missing (section 4).
        laid = 0
        progress = growth.progress(int((growth.done == 0).sum()), "pixels")
        for pixel in picture.missing():
            progress.advance(picture.paste(place(pixel, laid, centered=False)))
            laid += 1

        # Patches over the worst seams: an old seam goes where the cut is cheaper (section 4).
        count = round(settings.refinements * laid)
        if not count:
            return
        seams = CanvasSeams(picture, growth.canvas, placement.size)
        progress = growth.progress(count, "repairs")
        for number in range(laid, laid + count):
            worst = seams.worst()
            # Not in the paper: what many patches did not mend cannot be mended.
            if worst is None or seams.idle > _IDLE * laid:
                progress.advance(progress.total - progress.done)
                break
            best = place(worst, number, centered=True)
            picture.paste(best)
            seams.price_around(best)
            progress.advance(1)
