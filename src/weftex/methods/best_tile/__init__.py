"""Best self-similar tile repetition (section 4.1 of the paper on near-regular textures)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weftex.canvas import Canvas, as_canvas
from weftex.errors import InvalidInputError
from weftex.method import Method, Model, parameter
from weftex.methods.lattices.canvas_lattice import (
    CanvasLattice,
    check_lattice,
    found_vectors,
)
from weftex.methods.lattices.mean_tile import origin_of
from weftex.methods.lattices.parallelogram import integrated, runs_of
from weftex.progress import Progress
from weftex.random import draw, seed_number
from weftex.results.pixels import PixelSynthesis

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.progress import ProgressCallback
    from weftex.random import Seed

_LIMIT = 0.05  # strain of a lattice that goes around a canvas
_BAND = 16  # rows that are made at a time
_CHOICE = (0.4, 0.7)  # of the sample's sides, between which a tile is chosen where nothing repeats
_TRIES = 16  # sizes that are tried there


@dataclass(frozen=True)
class BestTile(Method):
    """Best self-similar tile repetition.

    Of all parallelograms of the sample with the translation vectors as sides, the one whose
    opposite borders differ least is repeated.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> tile = np.random.default_rng(0).integers(0, 255, (12, 10), np.uint8)
    >>> model = weftex.BestTile(lattice=(10, 0, 0, 12)).fit(weftex.Exemplar(np.tile(tile, (3, 3))))
    >>> bool((model.sample((24, 30)).image == np.tile(tile, (2, 3))).all())
    True
    """

    slug: ClassVar[str] = "best-tile"
    title: ClassVar[str] = "Best tile repetition"
    paper: ClassVar[str] = (
        "Near-regular texture synthesis by constrained random sampling and gap filling, a thesis: "
        "section 4.1"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "random_access", "many"})

    lattice: tuple[float, ...] | None = parameter(
        None,
        "translation vectors x1,y1,x2,y2",
        count=4,
        unit="px",
        default_text="found in the sample; upright where there are none",
    )
    border_width: int = parameter(
        10, "width of the borders that are compared", low=1, high=1024, unit="px"
    )
    tiles: int = parameter(
        1, "repeat so many of the best tiles, in any order; 1 is the paper's way", low=1, high=1000
    )

    def fit(self, exemplar: Exemplar) -> BestTileModel:
        """Find the lattice, if none is given, and the best tile."""
        return BestTileModel(self, exemplar)


class BestTileModel(Model):
    """A sample and its best tiles; `sample` and `window` repeat them.

    Parameters
    ----------
    method : BestTile
        Parameters.
    exemplar : Exemplar
        The sample.

    Attributes
    ----------
    anchors : int array (n, 2)
        Row and column of the best tile's corner in the sample, and of the next best ones that show
        the same part of the tile.

    Raises
    ------
    InvalidInputError
        If the vectors do not fit the sample, or no tile lies on usable pixels.
    """

    method: BestTile

    def __init__(self, method: BestTile, exemplar: Exemplar) -> None:
        self.exemplar, self.levels = exemplar, exemplar.matching()
        #: Strain that a lattice takes to go around; tiles of what has none may have any size.
        self.limit = _LIMIT
        if method.lattice is not None:
            check_lattice(method.lattice, exemplar)
            vectors = method.lattice
        else:
            found = found_vectors(exemplar)
            vectors = self._chosen(found, method)
            self.limit = _LIMIT if found else float("inf")
        self.method = replace(method, lattice=vectors)
        border = method.border_width
        error = self.errors(vectors, border)
        # No room: narrower borders, at last none.
        while error is None and border > 0 and exemplar.mask is None:
            border //= 2
            error = self.errors(vectors, border)
        if error is None:
            x1, y1, x2, y2 = vectors
            raise InvalidInputError(
                f"no tile of {abs(x1 * y2 - x2 * y1):.0f} pixels lies on usable pixels of "
                f"{exemplar.name}"
            )
        self._shape = self._tile(vectors, border)
        self.anchors = self._best(error, vectors, method.tiles)

    def errors(self, vectors: tuple[float, ...], border: int) -> NDArray[np.int64] | None:
        """Accumulated differences of opposite borders, by the tile's first corner (eq. 4.2).

        Returns
        -------
        int64 array (H, W) or None
            -1 where a tile with its borders does not lie in the sample; None if none does.
        """
        height, width = self.exemplar.shape
        x1, y1, x2, y2 = vectors
        sides = np.array([[y1, x1], [y2, x2]])
        mask = np.ones((height, width), bool)
        if self.exemplar.mask is not None:
            mask = self.exemplar.mask
        total = np.zeros((height, width), np.int64)
        fits = np.ones((height, width), bool)
        fits &= integrated((~mask).astype(np.int64), self._tile(vectors, border), outside=1) == 0
        if not fits.any():
            return None
        for k in (0, 1) if border else ():
            step = np.rint(sides[k]).astype(int)
            other = runs_of(np.zeros(2), sides[1 - k], (border + 1) // 2)
            y, x = np.indices((height, width)) + step[:, None, None]
            inside = (y >= 0) & (y < height) & (x >= 0) & (x < width)
            levels = self.levels.astype(np.int64)
            there = levels[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
            error = np.where(inside, ((levels - there) ** 2).sum(axis=2), 0)
            total += integrated(error, other, outside=0)
        return np.where(fits, total, -1)

    def _tile(self, vectors: tuple[float, ...], border: int) -> NDArray[np.int64]:
        """The rows of a tile with half its borders."""
        x1, y1, x2, y2 = vectors
        return runs_of(np.array([y1, x1]), np.array([y2, x2]), border // 2)

    def _best(
        self, error: NDArray[np.int64], vectors: tuple[float, ...], wanted: int
    ) -> NDArray[np.int64]:
        order = np.argsort(
            np.where(error < 0, np.iinfo(np.int64).max, error), axis=None, kind="stable"
        )
        order = order[: int((error >= 0).sum())]
        y, x = np.divmod(order, error.shape[1])
        first = y[0], x[0]
        if wanted == 1:
            return np.array([first], np.int64)
        # The others a sum of multiples away from it, to a pixel, and not over each other.
        lattice = CanvasLattice(vectors)
        along = [
            (y - first[0]) * lattice.inverse[0, k] + (x - first[1]) * lattice.inverse[1, k]
            for k in (0, 1)
        ]
        near = np.rint(np.stack(along, axis=1))
        away = np.stack([y - first[0], x - first[1]], axis=1) - near @ lattice.sample
        found: dict[tuple[float, ...], tuple[int, int]] = {}
        for k in np.flatnonzero((np.abs(away) <= 1).all(axis=1)):
            found.setdefault(tuple(near[k]), (int(y[k]), int(x[k])))
            if len(found) == wanted:
                break
        return np.array(list(found.values()), np.int64)

    def _chosen(self, vectors: tuple[float, ...], method: BestTile) -> tuple[float, ...]:
        """Complete the vectors where a sample repeats along one direction, or not at all."""
        if len(vectors) == 4:
            return vectors
        height, width = self.exemplar.shape
        best: tuple[float, ...] = ()
        scale = 1
        while not best and scale <= min(height, width):
            best = self._least(self._tries(vectors, scale), method.border_width)
            scale *= 2
        return best or (1.0, 0.0, 0.0, 1.0)

    def _tries(self, vectors: tuple[float, ...], scale: int) -> list[tuple[float, ...]]:
        height, width = self.exemplar.shape
        if vectors:
            x, y = vectors
            length = float(np.hypot(x, y))
            aside = min(height / max(abs(x), 0.1), width / max(abs(y), 0.1)) * length
            return [(x, y, -y / length * n, x / length * n) for n in _lengths(aside, scale)]
        across, down = _lengths(width, scale), _lengths(height, scale)
        count = max(len(across), len(down))
        return [
            (float(across[k * len(across) // count]), 0.0, 0.0, float(down[k * len(down) // count]))
            for k in range(count)
        ]

    def _least(self, tries: list[tuple[float, ...]], border: int) -> tuple[float, ...]:
        """Of these vectors those whose tile fits itself best, for its circumference."""
        best: tuple[float, ...] = ()
        least = float("inf")
        for given in tries:
            error = self.errors(given, border)
            if error is None and self.exemplar.mask is None:
                error = self.errors(given, 0)
            if error is not None:
                x1, y1, x2, y2 = given
                around = float(np.hypot(x1, y1) + np.hypot(x2, y2))
                value = float(error[error >= 0].min()) / around
                if value < least:
                    best, least = given, value
        return best

    def sample(
        self,
        size: Canvas | int | tuple[int, int],
        *,
        seed: Seed = None,
        tileable: bool | str = False,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> PixelSynthesis:
        """Make an output.

        Parameters
        ----------
        size : Canvas, int or (int, int)
            What to make: height and width, or a Canvas. Where it wraps, the lattice is stretched
            until whole tiles fit; `provenance["strain"]` says how much. A hole goes on with the
            lattice of its surroundings.
        seed : int, numpy Generator or None
            Draws the order of `tiles`; of one there is none.
        tileable : bool or {"x", "y"}
            Axes that are to repeat without a seam.
        threads : int, optional
            Not needed here.
        progress : callable, optional
            See `weftex.progress.ProgressCallback`.

        Returns
        -------
        PixelSynthesis

        Raises
        ------
        InvalidInputError
            If the lattice would have to be stretched too much; a good size is named.
        """
        canvas = as_canvas(size, tileable)
        self.method.require(canvas)
        canvas.check_known(self.exemplar)
        assert self.method.lattice is not None
        origin = origin_of(canvas, self.exemplar, self.method.lattice)
        return self._made(canvas, origin, seed_number(seed), progress)

    def _made(
        self,
        canvas: Canvas,
        origin: tuple[int, int],
        seed: int,
        callback: ProgressCallback | None,
    ) -> PixelSynthesis:
        assert self.method.lattice is not None
        lattice = CanvasLattice(self.method.lattice, canvas, self.limit)
        index = np.full(canvas.shape, -1, np.int32)
        flat = self.exemplar.pixels.reshape(-1, *self.exemplar.pixels.shape[2:])

        def preview() -> NDArray[Any]:
            shown: NDArray[Any] = flat[index]
            shown[index < 0] = 0
            return shown

        width = self.exemplar.shape[1]
        # A float holds 2**40 to 2**-13 pixel, and what goes around a canvas counts from its corner.
        corner = np.asarray(origin) - self.anchors[0]
        progress = Progress(callback, canvas.height, "rows", preview)
        repeats = [np.rint(n @ lattice.inverse).astype(np.int64) for n in np.diag(canvas.shape)]
        for top in range(0, canvas.height, _BAND):
            y = np.arange(top, min(top + _BAND, canvas.height))[:, None] + corner[0]
            x = np.arange(canvas.width)[None, :] + corner[1]
            number = [
                np.floor(y * lattice.inverse[0, k] + x * lattice.inverse[1, k] + 2.0**-20)
                for k in (0, 1)
            ]
            away = [
                number[0] * lattice.canvas[0, k] + number[1] * lattice.canvas[1, k] for k in (0, 1)
            ]
            v, u = y - np.rint(away[0]), x - np.rint(away[1])
            anchors = self.anchors[0]
            if len(self.anchors) > 1:
                which = draw(seed, "tile", *_first(number, repeats, canvas.wrap))
                anchors = self.anchors[(which % np.uint64(len(self.anchors))).astype(np.int64)]
            # Where it is stretched, or vectors are no integers, what would lie past the tile.
            row = np.clip(v - self._shape[0, 0], 0, len(self._shape) - 1).astype(np.int64)
            u = np.clip(u, self._shape[row, 1], self._shape[row, 2] - 1).astype(np.int64)
            y, x = self._shape[row, 0] + anchors[..., 0], u + anchors[..., 1]
            index[top : top + _BAND] = y * width + x
            progress.advance(len(number[0]))
        if canvas.hole is not None:
            index[~canvas.hole] = -1
        about: dict[str, object] = {"seed": seed, "anchor": self.anchors[0].tolist()}
        if any(canvas.wrap):
            about["strain"] = round(lattice.strain, 6)
        return PixelSynthesis(
            canvas,
            index,
            sample_shape=self.exemplar.shape,
            exemplar=self.exemplar,
            known_from=canvas.known_from,
            provenance=self.method.describe() | about,
        )


def _lengths(side: float, scale: int) -> list[int]:
    low, high = (max(1, round(share * side / scale)) for share in _CHOICE)
    return list(range(low, high + 1, max(1, (high - low) // _TRIES)))


def _first(
    number: list[NDArray[np.float64]], repeats: list[NDArray[np.int64]], wrap: tuple[bool, bool]
) -> list[NDArray[np.int64]]:
    """Numbers of tiles; one number for those that are one and the same around the canvas."""
    found = np.stack(number, axis=-1).astype(np.int64)
    around = np.array([r for r, wraps in zip(repeats, wrap, strict=True) if wraps], np.int64)
    if len(around):
        # Those of the lattice of repeats that leads to the same numbers from any of its points.
        if len(around) == 1:
            axis = int(np.abs(around[0]).argmax())
            times = np.floor_divide(found[..., axis], around[0, axis])
            found = found - times[..., None] * around[0]
        else:
            (a, b), (c, d) = around.tolist()
            det = a * d - b * c
            i, j = found[..., 0], found[..., 1]
            times = np.floor_divide(i * d - j * c, det), np.floor_divide(j * a - i * b, det)
            found = found - times[0][..., None] * around[0] - times[1][..., None] * around[1]
    return [found[..., 0], found[..., 1]]
