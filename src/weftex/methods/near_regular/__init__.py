"""Near-regular synthesis: constrained random sampling and gap filling (chapter 4 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weftex.canvas import Canvas, as_canvas
from weftex.errors import InvalidInputError
from weftex.method import Method, Model, parameter
from weftex.methods.lattices.canvas_lattice import (
    ANYWHERE,
    check_lattice,
    found_vectors,
)
from weftex.methods.lattices.mean_tile import origin_of
from weftex.methods.near_regular.block_sample import BlockSample, has_room
from weftex.methods.near_regular.blocks import Blocks
from weftex.methods.near_regular.holes import HoleBlocks
from weftex.random import seed_number

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.progress import ProgressCallback
    from weftex.random import Seed
    from weftex.results.patches import PatchSynthesis

_PAPER = 40 / 128  # block over the sample's side
_LEAST = 0.15  # the smallest block that is chosen, over the sample's shorter side
_PLACES = 6.0  # similar places that a block should have to choose from
_ROWS = 4  # rows to choose from, where nothing else repeats
_TOLERANCE = 3  # px (section 4.2.2)


@dataclass(frozen=True)
class NearRegular(Method):
    """Constrained random sampling and gap filling.

    The output is divided into blocks. Every second one shows a piece of the sample that lies a
    multiple of the translation vectors away, drawn at random; the gaps between take the piece that
    fits their four neighbours best. So the regular structure goes on however far, and what is
    irregular stays irregular.

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
        "Near-regular texture synthesis by constrained random sampling and gap filling, a thesis: "
        "chapter 4"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "random_access"})

    lattice: tuple[float, ...] | None = parameter(
        None,
        "translation vectors x1,y1,x2,y2; 1,0,0,1 is the unconstrained mode",
        count=4,
        unit="px",
        default_text="found in the sample; unconstrained if there are none",
    )
    preset: str = parameter(
        "weftex",
        "what parameters are that are not given: chosen by the sample, or the paper's",
        choices=("weftex", "paper"),
    )
    block_size: int | None = parameter(
        None,
        "side of the square blocks",
        low=1,
        unit="px",
        default_text="by tile and sample, up to 5/16 of its side as in the paper",
    )
    border_width: int | None = parameter(
        None,
        "width of the borders that must match, half of it on either side; even",
        low=0,
        unit="px",
        default_text="two thirds of the block; 10 in the paper",
    )
    blend: str = parameter(
        "auto",
        "joining blocks: cut along least error or feathered as the preset says, or pasted",
        choices=("auto", "cut", "feather", "none"),
    )
    seam_cost: str = parameter(
        "gradient",
        "where a cut shows: less where the sample has edges of its own, or everywhere alike",
        choices=("gradient", "difference"),
        needs=("blend", ("auto", "cut")),
    )
    blend_width: int | None = parameter(
        None,
        "width of the feathered area between blocks",
        low=0,
        unit="px",
        default_text="4, and 7/10 of a block where blocks would show",
        needs=("blend", ("feather",)),
    )
    tolerance: int | None = parameter(
        None,
        "how far from a multiple of the vectors a gap's piece may lie",
        low=0,
        high=64,
        unit="px",
        default_text="3, less where the tile is small",
    )
    rectify: int | None = parameter(
        None,
        "how far pixels of the sample are moved, to lie as in its mean tile; 0 is the paper's",
        low=0,
        high=64,
        unit="px",
        default_text="3, a tenth of the shorter vector at most; 0 in the paper",
    )
    warp: int = parameter(
        0,
        "how far parts of a gap's piece are moved and resampled to meet its neighbours; 0 copies",
        low=0,
        high=8,
        unit="px",
    )
    match: str = parameter(
        "difference",
        "how borders are compared: squared differences of colours, or their correlation",
        choices=("difference", "gncc"),
    )
    candidates: int | None = parameter(
        None,
        "multiples of the vectors around which a gap's piece is looked for, the best ones",
        low=1,
        high=512,
        default_text="6; all in the paper",
    )
    variety: float | None = parameter(
        None,
        "how much worse a piece counts for what of it is shown beside; 0 is the paper's way",
        low=0.0,
        high=1000.0,
        default_text="1; 0 in the paper",
    )

    def fit(self, exemplar: Exemplar) -> NearRegularModel:
        """Find the lattice, if none is given, and settle the sizes."""
        return NearRegularModel(self, exemplar)


class NearRegularModel(Model):
    """A sample prepared for near-regular synthesis; `sample` and `window` make outputs from it.

    Parameters
    ----------
    method : NearRegular
        Parameters.
    exemplar : Exemplar
        The sample.

    Raises
    ------
    InvalidInputError
        If the vectors or a block do not fit the sample.
    """

    method: NearRegular

    def __init__(self, method: NearRegular, exemplar: Exemplar) -> None:
        self.exemplar = exemplar
        self.method, rows = _settled(method, exemplar)
        self.blocks = BlockSample(self.method, exemplar, rows)
        self.method = self.blocks.method

    def sample(
        self,
        size: Canvas | int | tuple[int, int],
        *,
        seed: Seed = None,
        tileable: bool | str = False,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> PatchSynthesis:
        """Make an output.

        Parameters
        ----------
        size : Canvas, int or (int, int)
            What to make: height and width, or a Canvas. Where it wraps, the lattice is stretched
            until whole tiles fit; `provenance["strain"]` says how much. A hole goes on with the
            lattice of its surroundings.
        seed : int, numpy Generator or None
            The same seed gives the same bytes, at any number of threads.
        tileable : bool or {"x", "y"}
            Axes that are to repeat without a seam.
        threads : int, optional
            At most so many; by default as many as there are processors.
        progress : callable, optional
            See `weftex.progress.ProgressCallback`.

        Returns
        -------
        PatchSynthesis

        Raises
        ------
        InvalidInputError
            If the lattice would have to be stretched too much; a good size is named. If a hole
            leaves no whole piece that lies right.
        """
        canvas = as_canvas(size, tileable)
        self.method.require(canvas)
        canvas.check_known(self.exemplar)
        origin = canvas.origin
        if not self.blocks.free:
            origin = origin_of(canvas, self.exemplar, self.blocks.vectors)
        return self._made(canvas, origin, seed, threads, progress)

    def _made(
        self,
        canvas: Canvas,
        origin: tuple[int, int],
        seed: Seed,
        threads: int | None,
        progress: ProgressCallback | None,
    ) -> PatchSynthesis:
        kind = Blocks if canvas.known is None else HoleBlocks
        return kind(self.blocks, canvas, origin, seed_number(seed), threads, progress).result()


def _settled(method: NearRegular, exemplar: Exemplar) -> tuple[NearRegular, bool]:
    """Fill in what follows from the sample and the preset; and whether it repeats by rows only."""
    paper = method.preset == "paper"
    vectors, rows = method.lattice, False
    if vectors is not None:
        check_lattice(vectors, exemplar)
    else:
        vectors, rows = _found(exemplar)
    settled: dict[str, Any] = {
        "lattice": vectors,
        "blend": ("feather" if paper else "cut") if method.blend == "auto" else method.blend,
        "candidates": method.candidates or (512 if paper else 6),
        "variety": (0.0 if paper else 1.0) if method.variety is None else method.variety,
    }
    x1, y1, x2, y2 = vectors
    if method.tolerance is None:
        # Where the tile is hardly larger, a few pixels are another place in it.
        small = int(abs(x1 * y2 - x2 * y1) ** 0.5 / 4)
        near = paper or vectors == ANYWHERE
        settled["tolerance"] = _TOLERANCE if near else min(_TOLERANCE, small)
    if method.rectify is None:
        # Little beside the tile, or one thing would be taken for the next.
        shortest = float(min(np.hypot(x1, y1), np.inf if rows else np.hypot(x2, y2)))
        settled["rectify"] = 0 if paper else min(_TOLERANCE, round(shortest / 10))
    shorter = min(exemplar.shape)
    size, border = method.block_size, method.border_width
    if border is not None and border % 2:
        raise InvalidInputError(f"border_width is {border}; it must be even")
    if size is None:
        size = max(1, int(_PAPER * shorter))
        if not paper:
            size = _block_size(vectors, exemplar, border, rows)
    if border is None:
        border = 10 if paper else size // 3 * 2
        border = min(border, (size - 1) // 2 * 2, max(0, shorter - size) // 2 * 2)
    if method.warp and border < 2:
        raise InvalidInputError(f"warp is {method.warp}; it needs a border_width of 2 or more")
    if border >= size:
        raise InvalidInputError(f"border_width is {border}; it must be less than the block, {size}")
    if size + border > shorter:
        raise InvalidInputError(
            f"block_size is {size} and border_width {border}; {exemplar.name} is "
            f"{exemplar.shape[1]}x{exemplar.shape[0]}, which has room for {shorter} together"
        )
    if not has_room(exemplar, size + border):
        raise InvalidInputError(
            f"no block of {size} pixels with a border of {border} lies on usable pixels of "
            f"{exemplar.name}; make them smaller"
        )
    return replace(method, block_size=size, border_width=border, **settled), rows


def _found(exemplar: Exemplar) -> tuple[tuple[float, ...], bool]:
    """The sample's own vectors, or the unconstrained mode's; and whether there is but one."""
    vectors = found_vectors(exemplar)
    if not vectors:
        return ANYWHERE, False
    if len(vectors) == 4:
        return vectors, False
    # Along the other direction any place is as good, as far on as the tolerance reaches.
    x, y = vectors
    step = (2 * _TOLERANCE + 1) / float(np.hypot(x, y))
    return (x, y, -y * step, x * step), True


def _block_size(
    vectors: tuple[float, ...], exemplar: Exemplar, border: int | None, rows: bool
) -> int:
    """The largest block, up to the paper's, that has a choice of places."""
    x1, y1, x2, y2 = vectors
    area = abs(x1 * y2 - x2 * y1)
    shorter = min(exemplar.shape)
    size, least = int(_PAPER * shorter), max(1, round(_LEAST * shorter))
    while size > least:
        height, width = (max(0, n - _window(size, border)) for n in exemplar.shape)
        room = height * abs(y1) + width * abs(x1)
        few = rows and room < (_ROWS - 1) * (x1 * x1 + y1 * y1)
        if height * width >= _PLACES * area and not few:
            break
        size -= 1
    if exemplar.mask is None:
        while size > 1 and _window(size, border) > shorter:
            size -= 1
        return max(size, 1)
    # What a mask leaves must have a place for every part of the tile.
    low, high = 0, max(size, 1)
    while low < high:
        size = (low + high + 1) // 2
        if has_room(exemplar, _window(size, border), vectors):
            low = size
        else:
            high = size - 1
    return max(low, 1)


def _window(size: int, border: int | None) -> int:
    return size + (size // 3 * 2 if border is None else border)
