"""Graph-cut textures (Kwatra, Schödl, Essa, Turk and Bobick, 2003)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

from weftex.errors import InvalidInputError
from weftex.method import Method, parameter
from weftex.methods.graphcut.growth import Cutting
from weftex.methods.patches.hole_sizes import patch_size_for
from weftex.methods.pixels.growth import PixelModel
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.pixels.growth import Growth

_SHARE = 0.45  # of the sample's shorter side that a patch takes


@dataclass(frozen=True)
class GraphCut(Method):
    """Graph-cut textures.

    Patches are laid over what is there where they match it, and a minimum cut decides which of
    their pixels replace older ones. Then the worst seams are covered with further patches; older
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
        "what is laid: patches that match, the entire sample where it matches, or anywhere",
        choices=("subpatch", "entire", "random"),
    )
    patch_size: int | None = parameter(
        None,
        "side of the square patches",
        low=1,
        unit="px",
        default_text="0.45 x the sample's shorter side",
        needs=("placement", ("subpatch",)),
    )
    boundary_width: int | None = parameter(
        None,
        "how far a patch reaches over what is there",
        low=0,
        unit="px",
        default_text="a third of the patch",
        needs=("placement", ("subpatch",)),
    )
    tolerance: float = parameter(
        0.003,
        "k: how much worse matches are drawn too, as shares of the sample's variance",
        low=0.0,
        high=1000.0,
        needs=("placement", ("subpatch", "entire")),
    )
    candidates: int = parameter(
        4, "places that are drawn and cut; the one with the cheapest seam is kept", low=1, high=1000
    )
    seam_cost: str = parameter(
        "gradient",
        "what a seam costs: how much the pixels differ, or less of it where there are edges anyway",
        choices=("gradient", "difference"),
    )
    refinements: float = parameter(
        1.0, "patches over the worst seams, for each that covered the canvas", low=0.0, high=1000.0
    )
    variety: float = parameter(
        1.0,
        "how much worse a place counts for what of it is shown nearby; 0 is the paper's way",
        low=0.0,
        high=1000.0,
        needs=("placement", ("subpatch",)),
    )

    @property
    def hole_reach(self) -> int:
        """See `Method.hole_reach`."""
        return 2 * (self.patch_size or 0)

    def for_hole(
        self, hole: NDArray[np.bool_], usable: NDArray[np.bool_], given: frozenset[str] | None
    ) -> Self:
        """See `Method.for_hole`; the other placements lay the entire sample."""
        if self.patch_size is not None or self.placement != "subpatch":
            return self
        return replace(self, patch_size=patch_size_for(hole, usable, 2))

    def fit(self, exemplar: Exemplar) -> GraphCutModel:
        """Prepare a sample."""
        return GraphCutModel(self, exemplar)


class GraphCutModel(PixelModel):
    """A sample prepared for graph-cut textures; `sample` makes outputs from it."""

    method: GraphCut

    def __init__(self, method: GraphCut, exemplar: Exemplar) -> None:
        super().__init__(method, exemplar)
        self.windows = windows_of(exemplar, (0, 0, 0, 0))
        shorter = min(exemplar.shape)
        size = method.patch_size
        if size is not None and size > shorter:
            raise InvalidInputError(
                f"patch_size is {size}; {exemplar.name} is {exemplar.shape[1]}x"
                f"{exemplar.shape[0]}, which has room for {shorter}"
            )
        if method.placement != "subpatch":
            return
        settled = size or max(1, round(_SHARE * shorter))
        while not self._has_room(settled):
            if size is not None:
                raise InvalidInputError(
                    f"patch_size is {size}; no patch that large lies on usable pixels of "
                    f"{exemplar.name}, make it smaller"
                )
            settled = settled * 3 // 4
        boundary = method.boundary_width
        if boundary is not None and boundary > settled // 2:
            raise InvalidInputError(
                f"boundary_width is {boundary}; it must be at most half of the patch, "
                f"{settled // 2}"
            )
        boundary = settled // 3 if boundary is None else boundary
        self.method = replace(method, patch_size=settled, boundary_width=boundary)

    def _has_room(self, side: int) -> bool:
        try:
            windows_of(self.exemplar, (0, side - 1, 0, side - 1))
        except InvalidInputError:
            return False
        return True

    def grow(self, growth: Growth) -> None:
        """Cover the canvas, then mend the worst seams."""
        if growth.threads == 1 or self.method.candidates == 1:
            self._grow(growth, map)
            return
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(min(growth.threads, self.method.candidates)) as pool:
            self._grow(growth, pool.map)

    def _grow(self, growth: Growth, map_: Callable[..., Iterable[Any]]) -> None:
        cutting = Cutting(self.method, self.exemplar, self.windows, growth, map_)
        cutting.cover()
        cutting.refine()
