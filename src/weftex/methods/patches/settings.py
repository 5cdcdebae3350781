"""Parameters of the methods that lay patches, and their values once they are settled."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Method
from weftex.methods.patches.sizes import patch_size_for, patch_size_of, patch_size_on
from weftex.parameters import parameter
from weftex.search.zone_search import SEARCHES

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_CANDIDATES, _MOST_CANDIDATES = 40, 10000
_VARIED = 80  # candidates at least, where what is shown again counts
#: With a wider tolerance so many more windows match: with the 8th power of the distance, about.
#: (The power is 7 to 15 between the windows of bricks, grass, leaves, pebbles, tiles, weave, wood.)
_MATCHING_POWER = 8
_OF_REPEATS = ("repeat_distance", "variety")
#: What has no effect where every window matches.
_OF_MATCHING = {"search", "candidates", "variance", "choice", "tone_weight", *_OF_REPEATS}
_SHARE = 0.3  # lambda of section 2.4, where nothing else is said
_HOLE_ZONE, _HOLE_CANDIDATES = 4, 400  # boundary width in px and candidates for holes


@dataclass(frozen=True)
class PatchMethod(Method):
    """Parameters that patch-based sampling and image quilting have in common."""

    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known"})
    #: Boundary width over patch size, where no boundary width is given.
    boundary_share: ClassVar[float]

    patch_size: int | None = parameter(
        None,
        "side w_B of the square patches; 1 samples single pixels (section 2.5)",
        low=1,
        unit="px",
        default_text="0.3 x the sample's shorter side; over 512 px, of 36 x its scale or the "
        "output's shorter side where that is less, 154 or more",
    )
    randomness: float | None = parameter(
        None,
        "lambda: patch size over the sample's shorter side (section 2.4)",
        low=0.001,
        high=1.0,
        default_text="none, see patch_size",
    )
    boundary_width: int | None = parameter(
        None,
        "width w_E of the boundary zone that must match",
        low=1,
        unit="px",
        default_text="a tenth of the patch, 4 or more",
    )
    search: str = parameter(
        "pca",
        "how candidates are found: the default, or one of the paper's (Table I)",
        choices=tuple(SEARCHES),
    )
    candidates: int | None = parameter(
        None,
        "m: windows from the low resolution that are compared at the full one",
        low=1,
        high=_MOST_CANDIDATES,
        default_text="40, 80 with variety, and more where the tolerance is wide",
        needs=("search", ("quadtree", "pca", "kdtree", "kdtree-pca")),
    )
    variance: float = parameter(
        0.97,
        "share of the variance that the principal components keep",
        low=0.01,
        high=1.0,
        needs=("search", ("pca", "kdtree-pca")),
    )
    edge_weight: float = parameter(
        0.0,
        "how much outlines count beside color when zones are compared; 0 is the paper's metric",
        low=0.0,
        high=10.0,
    )

    repeat_distance: float = parameter(
        0.5,
        "sources of patches near each other keep this far apart, in patches; 0 is the papers' way",
        low=0.0,
        high=10.0,
    )
    variety: float = parameter(
        0.0,
        "cost of showing a place of the sample again in sight, or in line; 0 is the papers' way",
        low=0.0,
        high=1000.0,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.patch_size is not None and self.randomness is not None:
            raise InvalidInputError("randomness has no effect beside patch_size; give one of them")
        if self.patch_size is not None:
            self.boundary_of(self.patch_size)
        if self.anything:
            self._refuse_unmatched()

    def _refuse_unmatched(self) -> None:
        """Where every window matches, none is searched for, weighed or kept apart."""
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in _OF_REPEATS and value == 0:
                continue
            if field.name in _OF_MATCHING and value != field.default:
                raise InvalidInputError(
                    f"{field.name} has no effect where every window matches (now {value})"
                )

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

    @property
    def anything(self) -> bool:
        """Whether every window matches, so that nothing is searched (chaos mosaic)."""
        return False

    @property
    def looseness(self) -> float:
        """How many times the paper's distance a patch may have and match."""
        return 1.0

    def takes(self, name: str, canvas: Canvas | None = None) -> bool:
        """See `Method.takes`: a zone of a hole is met once, which repays no components."""
        if name == "variance" and canvas is not None and "known" in canvas.kinds:
            return self.search == "kdtree-pca"
        return super().takes(name, canvas)

    def require(self, canvas: Canvas) -> None:
        """See `Method.require`."""
        super().require(canvas)
        if self.variance != type(self).variance and not self.takes("variance", canvas):
            raise InvalidInputError(
                "variance has no effect with known pixels unless search is 'kdtree-pca'"
            )

    def candidates_for(self, usual: int) -> int:
        """Return m: that many candidates, or more, so that those that match are among them."""
        wider = min(max(self.looseness, 1.0), 4.0) ** _MATCHING_POWER
        least = _VARIED if self.variety > 0 else 0
        return min(max(round(usual * wider), least), _MOST_CANDIDATES)

    def for_part(self, whole: Exemplar) -> Self:
        """See `Method.for_part`: a share is one of the whole."""
        if self.randomness is None:
            return self
        size = max(1, round(self.randomness * min(whole.shape)))
        return replace(self, patch_size=size, randomness=None)

    @property
    def hole_reach(self) -> int:
        """See `Method.hole_reach`."""
        return 2 * (self.patch_size or 0)

    def for_hole(
        self, hole: NDArray[np.bool_], usable: NDArray[np.bool_], given: frozenset[str] | None
    ) -> Self:
        """See `Method.for_hole`.

        The wider a zone of an irregular material, the more its best match is a dull, blurred place.
        As holes take few patches, more candidates cost little. Both were chosen by eye on bricks,
        tiles, boards, pebbles, leaves and lawn.
        """
        size = self.patch_size or patch_size_for(hole, usable, 2 * (self.boundary_width or 1))
        suits: dict[str, Any] = {"patch_size": size}
        if self.boundary_width is None and size > 1:
            suits["boundary_width"] = min(_HOLE_ZONE, size // 2)
        # An exhaustive search takes no number of candidates.
        if given is not None and not self.anything and not given & {"candidates", "search"}:
            suits["candidates"] = self.candidates_for(_HOLE_CANDIDATES)
        return replace(self, **suits)


@dataclass(frozen=True)
class PatchSettings:
    """Every value that laying patches depends on, settled for one sample."""

    patch_size: int  # side w_B of the patches
    boundary_width: int  # width w_E of the boundary zone
    search: str  # one of SEARCHES
    candidates: int  # m of section 3.2
    variance: float  # that the principal components keep
    edge_weight: float  # of outlines in distances
    tone_weight: float  # of slow tones in distances
    repeat_distance: float  # how many patches the sources of near patches lie apart, at least
    variety: float  # the cost of showing a place again
    blend: str  # how patches are joined: feather, feather-at-end, cut or none
    anything: bool  # every window matches, so that nothing is searched (chaos mosaic)

    @property
    def pixelwise(self) -> bool:
        """Patches are single pixels (section 2.5)."""
        return self.patch_size == 1

    @property
    def window_side(self) -> int:
        """Side of the windows that are compared: 2 w_E + 1 around a single pixel."""
        return 2 * self.boundary_width + 1 if self.pixelwise else self.patch_size

    @property
    def keep_apart(self) -> int:
        """`repeat_distance` in pixels."""
        return round(self.repeat_distance * self.patch_size)


def settle(
    method: PatchMethod, exemplar: Exemplar, *, blend: str, tone_weight: float = 0.0
) -> PatchSettings:
    """Settle what a method leaves open for a sample (section 2.4).

    Parameters
    ----------
    method : PatchMethod
        Parameters.
    exemplar : Exemplar
        The sample; it must hold at least one whole window.
    blend : str
        See `PatchSettings`.
    tone_weight : float
        Likewise.

    Raises
    ------
    InvalidInputError
        If the boundary is wider than half of the patch, or the sample is smaller than a window;
        the largest that fits is named.
    """
    shorter = min(exemplar.shape)
    method = method.for_part(exemplar)
    size = method.patch_size or patch_size_of(exemplar, _SHARE)
    if size == 1:
        width = method.boundary_width or max(1, min(4, (shorter - 1) // 2))
    else:
        width = method.boundary_of(size)
    settings = PatchSettings(
        patch_size=size,
        boundary_width=width,
        search=method.search,
        candidates=method.candidates or method.candidates_for(_CANDIDATES),
        variance=method.variance,
        edge_weight=method.edge_weight,
        tone_weight=tone_weight,
        repeat_distance=method.repeat_distance,
        variety=method.variety,
        blend=blend,
        anything=method.anything,
    )
    if settings.pixelwise:
        _refuse_for_pixels(method)
    if settings.window_side > shorter:
        raise InvalidInputError(
            f"{exemplar.name} is {exemplar.shape[1]}x{exemplar.shape[0]}, smaller than the "
            f"window of {settings.window_side}; the largest that fits is {shorter}"
        )
    return settings


def settle_on(canvas: Canvas, method: PatchMethod, settings: PatchSettings) -> PatchSettings:
    """Settle for one output: what was left open follows its size where that is the smaller one.

    Parameters
    ----------
    canvas : Canvas
        The output.
    method : PatchMethod
        Parameters as they were given.
    settings : PatchSettings
        What they settle to for the sample.
    """
    if method.patch_size is not None or method.randomness is not None:
        return settings
    size = max(patch_size_on(canvas, _SHARE), 2 * (method.boundary_width or 0))
    if size >= settings.patch_size:
        return settings
    return replace(settings, patch_size=size, boundary_width=method.boundary_of(size))


def _refuse_for_pixels(method: PatchMethod) -> None:
    """A single pixel has no border to be joined at, and repeats nothing."""
    usual = {field.name: field.default for field in fields(method)}
    for name, done in (("blend", "none"), *((name, 0) for name in _OF_REPEATS)):
        value = getattr(method, name)
        if value not in (usual[name], done):
            raise InvalidInputError(f"{name} has no effect on patches of one pixel (now {value})")


@dataclass(frozen=True, eq=False)
class Frame:
    """How windows of the sample lie on a canvas.

    In a wrapped row the last patch has a zone at either end, and room must be left between them, so
    that the boundary may be narrower than in the settings.
    """

    canvas: Canvas
    settings: PatchSettings
    window: tuple[int, int]  # rows and columns that are compared; no more than the canvas has
    boundary_width: int  # width w_E of the boundary zone on this canvas
    margin: tuple[int, int]  # by which a single pixel's window hangs over a border without wrap

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the canvas with its margins."""
        (height, width), (top, left) = self.canvas.shape, self.margin
        return height + 2 * top, width + 2 * left

    @property
    def inside(self) -> tuple[slice, slice]:
        """The canvas inside its margins."""
        (height, width), (top, left) = self.canvas.shape, self.margin
        return slice(top, top + height), slice(left, left + width)

    @property
    def known(self) -> NDArray[Any] | None:
        """The known pixels around a hole (section 2.3); None where everything is to be made."""
        hole = self.canvas.hole
        return self.canvas.known if hole is not None and not hole.all() else None


def frame_of(settings: PatchSettings, canvas: Canvas) -> Frame:
    """Fit windows to a canvas: see `Frame`."""
    (height, width), (wraps_y, wraps_x) = canvas.shape, canvas.wrap
    side, boundary = settings.window_side, settings.boundary_width
    if settings.pixelwise:
        margin = 0 if wraps_y else boundary, 0 if wraps_x else boundary
        return Frame(canvas, settings, (side, side), boundary, margin)
    window = min(side, height), min(side, width)
    wrapped = [n // 4 for n, wraps in zip(window, canvas.wrap, strict=True) if wraps]
    return Frame(canvas, settings, window, max(1, min([boundary, *wrapped])), (0, 0))
