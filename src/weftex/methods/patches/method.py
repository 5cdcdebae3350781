"""The parameters that patch-based sampling and image quilting have in common."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Self

from weftex.analysis.patch_sizes import HOLE_PATCHES, patch_size_for, patch_size_of, patch_size_on
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError, size_words
from weftex.exemplar import Exemplar
from weftex.method import Method
from weftex.methods.patches.patch_kernels import FINDERS, LARGEST_M
from weftex.parameters import length_parameter, parameter
from weftex.raster.arrays import Mask

_ALL, _SQUARES, _COMPONENTS, _TREE = FINDERS
#: Kinds of search, and how the kernel finds the candidates; sections are of Liang et al. (2001).
SEARCHES = {
    "exhaustive": _ALL,
    "quadtree": _SQUARES,  # section 3.2
    "pca": _COMPONENTS,  # the default, which is ours: section 3.3 with a scan in place of a tree
    "kdtree": _TREE,  # section 3.1, over the squares of section 3.2
    "kdtree-pca": _TREE,  # section 3.1, over the components of section 3.3
}
_LAMBDA = 0.3  # patch size over the sample's shorter side (Liang et al., section 2.4)
_CANDIDATES = 40
#: The number of windows that match grows about with this power of the tolerated distance.
#: (The power is 7 to 15 between the windows of bricks, grass, leaves, pebbles, tiles, weave, wood.)
_MATCHING_POWER = 8
#: Parameters without effect where every window matches.
_OF_MATCHING = {"search", "candidates", "choice"}
_HOLE_ZONE, _HOLE_CANDIDATES = 4, 400  # boundary width in px and candidates for holes


@dataclass(frozen=True)
class PatchMethod(Method):
    """Parameters that patch-based sampling and image quilting have in common."""

    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known"})
    #: Boundary width over patch size, where no boundary width is given.
    boundary_share: ClassVar[float]

    patch_size: int | None = length_parameter(
        "side of the square patches; larger keeps larger features whole",
        "0.3 x the sample's shorter side; a smaller share above 512 px",
        low=1,
        hole_text=HOLE_PATCHES,
        control="size",
    )
    boundary_width: int | None = length_parameter(
        "width of the border that must match the neighboring patches; wider matches better",
        "a tenth of the patch size, at least 4",
        low=1,
        hole_text=f"{_HOLE_ZONE} px",
        control="softness",
    )
    search: str = parameter(
        "pca",
        "how matching patches are found; exhaustive compares all of them",
        choices=tuple(SEARCHES),
    )
    candidates: int | None = parameter(
        None,
        "number of patches compared at full resolution; higher matches better and is slower",
        low=1,
        high=LARGEST_M,
        default_text="40, more for a wide tolerance",
        hole_text=f"{_HOLE_CANDIDATES}",
        needs=("search", ("quadtree", "pca", "kdtree", "kdtree-pca")),
    )
    repeat_distance: float = parameter(
        0.5,
        "minimum distance between sources of neighboring patches, in patch sizes (0 in the papers)",
        low=0.0,
        high=10.0,
    )
    blend: str = parameter(
        "feather",
        "how patches join: feathered at once or at the end, cut along the least error, or pasted",
        choices=("feather", "feather-at-end", "cut", "none"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.patch_size is not None:
            self.boundary_of(self.patch_size)
        if self.accepts_all:
            self._refuse(_OF_MATCHING, "where every window matches")
            self._refuse({"repeat_distance"}, "where every window matches", unless=0)

    def _refuse(self, names: set[str], where: str, unless: object = None) -> None:
        """Refuse parameters that are neither at their default nor `unless`."""
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in names and value not in (field.default, unless):
                raise InvalidInputError(f"{field.name} has no effect {where} (now {value})")

    @property
    def accepts_all(self) -> bool:
        """Whether every window matches, so that nothing is searched (chaos mosaic)."""
        return False

    @property
    def tolerance_ratio(self) -> float:
        """How many times the paper's distance a patch may have and match."""
        return 1.0

    @property
    def pixelwise(self) -> bool:
        """Whether patches are single pixels (Liang et al., section 2.5)."""
        return self.patch_size == 1

    @property
    def window_side(self) -> int:
        """Side of the windows that a resolved method compares: 2 w_E + 1 around a single pixel."""
        assert self.patch_size and self.boundary_width
        return 2 * self.boundary_width + 1 if self.pixelwise else self.patch_size

    @property
    def keep_apart(self) -> int:
        """`repeat_distance` of a resolved method in pixels."""
        assert self.patch_size
        return round(self.repeat_distance * self.patch_size)

    def boundary_of(self, size: int) -> int:
        """Return w_E for patches of a size; refuse a given one that leaves no patch."""
        width = self.boundary_width
        if width is None:
            return min(max(4, round(self.boundary_share * size)), size // 2)
        if 1 < size < 2 * width:
            raise InvalidInputError(
                f"boundary_width is {width}; it must be at most half of the patch, {size // 2}"
            )
        return width

    def candidates_for(self, usual: int) -> int:
        """Return m: the usual number, or more, so that the windows that match are among them."""
        wider = min(max(self.tolerance_ratio, 1.0), 4.0) ** _MATCHING_POWER
        return min(round(usual * wider), LARGEST_M)

    def resolved(self, exemplar: Exemplar) -> Self:
        """See `Method.resolved`: w_B, w_E and m (Liang et al., sections 2.4 and 3.2)."""
        shorter = min(exemplar.shape)
        size = self.patch_size or patch_size_of(exemplar, _LAMBDA)
        width = self.boundary_of(size)
        if size == 1:
            width = self.boundary_width or max(1, min(4, (shorter - 1) // 2))
        candidates = self.candidates
        if candidates is None and self.search != "exhaustive" and not self.accepts_all:
            candidates = self.candidates_for(_CANDIDATES)
        method = replace(self, patch_size=size, boundary_width=width, candidates=candidates)
        if method.pixelwise:
            method._refuse({"blend"}, "on patches of one pixel", unless="none")
            method._refuse({"repeat_distance"}, "on patches of one pixel", unless=0)
        if method.window_side > shorter:
            raise InvalidInputError(
                f"{exemplar.name} is {size_words(exemplar.shape)}, smaller than the "
                f"patch of {method.window_side}; the largest that fits is {shorter}"
            )
        return method

    def resolved_on(self, canvas: Canvas, resolved: Self) -> Self:
        """Return the resolved method with smaller patches where a small output asks for them."""
        assert resolved.patch_size
        size = max(patch_size_on(canvas, _LAMBDA), 2 * (self.boundary_width or 0))
        if self.patch_size is not None or size >= resolved.patch_size:
            return resolved
        return replace(resolved, patch_size=size, boundary_width=self.boundary_of(size))

    @property
    def hole_reach(self) -> int:
        """See `Method.hole_reach`."""
        return 2 * (self.patch_size or 0)

    def for_hole(self, hole: Mask, usable: Mask, given: frozenset[str] | None) -> Self:
        """See `Method.for_hole`.

        A narrow zone and many candidates: the wider a zone of an irregular material, the more its
        best match is a dull, blurred place. Both were chosen by eye on six materials.
        """
        size = self.patch_size or patch_size_for(hole, usable, 2 * (self.boundary_width or 1))
        suits: dict[str, Any] = {"patch_size": size}
        if self.boundary_width is None and size > 1:
            suits["boundary_width"] = min(_HOLE_ZONE, size // 2)
        # An exhaustive search takes no number of candidates.
        if given is not None and not self.accepts_all and not given & {"candidates", "search"}:
            suits["candidates"] = self.candidates_for(_HOLE_CANDIDATES)
        return replace(self, **suits)
