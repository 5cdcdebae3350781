"""Best self-similar tile repetition (section 4.1 of the paper on near-regular textures)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import Around, CanvasLattice, check_lattice, found_vectors
from weftex.canvas import Canvas
from weftex.endless.boxes import Corner, PlaneRequest
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Method
from weftex.methods.lattices import LatticeModel
from weftex.parameters import length_parameter
from weftex.progress import Progress, ProgressCallback
from weftex.raster.arrays import Floats, Ints
from weftex.results.pixels import PixelSynthesis

_LIMIT = 0.05  # strain of a lattice that wraps around a canvas
_BAND = 16  # rows that are made at a time
_BORDER = 10  # pixels (section 4.1.1)


@dataclass(frozen=True)
class BestTile(Method):
    """Best self-similar tile repetition.

    A tile is a parallelogram of the sample with the translation vectors as sides. The tile whose
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
        "D. López Recas: Constrained random sampling and gap filling technique for near-regular "
        "texture synthesis. Diploma thesis, TU Berlin, 2011, section 4.1"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "random_access", "many"})

    lattice: tuple[float, ...] | None = length_parameter(
        "vectors x1,y1,x2,y2 from one cell to the next", "found in the sample", count=4
    )
    border_width: int | None = length_parameter(
        "width of the borders that are compared", "10, less for a small sample", low=1, high=1024
    )

    def fit_exemplar(self, exemplar: Exemplar) -> BestTileModel:
        """Find the lattice, if none is given, and the best tile."""
        return BestTileModel(self, exemplar)


class BestTileModel(LatticeModel):
    """A sample and its best tile; `sample` and `window` repeat it.

    Parameters
    ----------
    method : BestTile
        Parameters.
    exemplar : Exemplar
        The sample.

    Attributes
    ----------
    anchor : (int, int)
        Row and column of the best tile's corner in the sample.
    rows : int array (m, 3)
        The rows of a tile with half its borders, see `runs_of`.

    Raises
    ------
    InvalidInputError
        If the sample has no lattice, the vectors do not fit it, or no tile lies on usable pixels.
    """

    def __init__(self, method: BestTile, exemplar: Exemplar) -> None:
        """Find the best tile by section 4.1.1."""
        if method.lattice is not None:
            check_lattice(method.lattice, exemplar)
        vectors = method.lattice or found_vectors(exemplar)
        if len(vectors) != 4:
            raise InvalidInputError(
                f"{exemplar.name} has no lattice; give its translation vectors (lattice), or make "
                "it repeat by weftex tile"
            )
        # 4.1: any parallelogram with the shortest translation vectors v1, v2 as sides is a tile.
        border = border_for(method.border_width, vectors, exemplar)
        self.rows = tile_rows(vectors, border)
        # Squared differences of all pixels v1 or v2 apart, summed over a border (eq. 4.2).
        errors = tile_errors(exemplar, vectors, border)
        if (errors < 0).all():
            x1, y1, x2, y2 = vectors
            raise InvalidInputError(
                f"no tile of {abs(x1 * y2 - x2 * y1):.0f} pixels lies on usable pixels of "
                f"{exemplar.name}"
            )
        # The tile with the lowest total is the best self-similar one (Fig. 4.6).
        usable = np.where(errors < 0, np.iinfo(np.int64).max, errors)
        self.anchor = divmod(int(usable.argmin()), errors.shape[1])
        method = replace(method, lattice=vectors, border_width=border or None)
        super().__init__(method, exemplar, vectors)

    def lay(
        self, canvas: Canvas, corner: Corner, asked: PlaneRequest, progress: ProgressCallback | None
    ) -> PixelSynthesis:
        """Repeat the best tile: f(x) = f(x + a v1 + b v2) (eq. 4.1)."""
        around = canvas if asked.period is None else Around(*asked.period)
        lattice = CanvasLattice(self.vectors, around, _LIMIT)
        index = np.full(canvas.shape, -1, np.int32)
        pixels = self.exemplar.pixels.reshape(-1, *self.exemplar.pixels.shape[2:])

        def preview() -> NDArray[Any]:
            made: NDArray[Any] = pixels[index]
            made[index < 0] = 0
            return made

        # Coordinates up to 2**40 are exact to 2**-13 pixel in a float. On a canvas that wraps they
        # count from its corner.
        lines = [np.arange(n) + at for n, at in zip(canvas.shape, corner, strict=True)]
        if asked.period is not None:
            lines = [line % n for line, n in zip(lines, asked.period, strict=True)]
        down, across = (line - at for line, at in zip(lines, self.anchor, strict=True))
        bands = Progress(progress, canvas.height, "rows", preview)
        for top in range(0, canvas.height, _BAND):
            y, x = down[top : top + _BAND, None], across[None, :]
            a, b = (np.floor(along + 2.0**-20) for along in lattice.multiples(y, x))
            away = [a * lattice.canvas[0, k] + b * lattice.canvas[1, k] for k in (0, 1)]
            v, u = y - np.rint(away[0]), x - np.rint(away[1])
            # Vectors with fractions, or a stretched lattice, lead a little past the tile: there
            # the tile's border is repeated.
            row = np.clip(v - self.rows[0, 0], 0, len(self.rows) - 1).astype(np.int64)
            u = np.clip(u, self.rows[row, 1], self.rows[row, 2] - 1).astype(np.int64)
            y, x = self.rows[row, 0] + self.anchor[0], u + self.anchor[1]
            index[top : top + _BAND] = y * self.exemplar.shape[1] + x
            bands.advance(len(a))
        about: dict[str, object] = {"seed": asked.seed, "anchor": list(self.anchor)}
        if any(around.wrap):
            about["strain"] = round(lattice.strain, 6)
        about = self.method.describe() | about
        return PixelSynthesis(canvas, index, exemplar=self.exemplar, provenance=about)


def runs_of(first: Floats, second: Floats, reach: int) -> Ints:
    """Runs of pixels within `reach` of a parallelogram or, with a zero side, of a segment.

    Rows of (n, 3): row, first column and the column after the last, counted from its corner.
    """
    corners = np.stack([0 * first, first, first + second, second])
    low = np.ceil(corners[:, 0].min()).astype(int) - reach
    high = max(np.ceil(corners[:, 0].max()).astype(int) + reach, low + 1)
    runs = []
    for row in range(low, high):
        # The parallelogram's part within reach of this row lies between its sides there.
        near = np.clip([row - reach, row + reach], corners[:, 0].min(), corners[:, 0].max())
        crossed = []
        for k in range(4):
            (y, x), (v, u) = corners[k], corners[(k + 1) % 4]
            crossed += [x] if near[0] <= y <= near[1] else []
            for at in near:
                if min(y, v) <= at <= max(y, v) and y != v:
                    crossed.append(x + (at - y) / (v - y) * (u - x))
        # The nudge decides where a side leads through pixels, whatever was rounded.
        first_column, end = np.ceil(np.array([min(crossed), max(crossed)]) - 2.0**-20).astype(int)
        left = int(first_column) - reach
        runs.append((row, left, max(int(end) + reach, left + 1)))
    return np.array(runs, np.int64).reshape(-1, 3)


def integrated(values: Ints, runs: Ints, outside: int) -> Ints:
    """Sum over the runs at every place; `outside` is the value of pixels that are not there."""
    height, width = values.shape
    low = min(0, int(runs[:, 0].min())), min(0, int(runs[:, 1].min()))
    high = max(0, int(runs[:, 0].max())), max(0, int(runs[:, 2].max()))
    pads = ((-low[0], high[0]), (-low[1], high[1]))
    wide = np.pad(values, pads, constant_values=outside)
    sums = np.zeros((wide.shape[0], wide.shape[1] + 1), np.int64)
    np.cumsum(wide, axis=1, out=sums[:, 1:])
    total = np.zeros((height, width), np.int64)
    for row, left, right in runs.tolist():
        lines = sums[row - low[0] : row - low[0] + height]
        total += lines[:, right - low[1] : right - low[1] + width]
        total -= lines[:, left - low[1] : left - low[1] + width]
    return total


def tile_rows(vectors: tuple[float, ...], border: int) -> Ints:
    """The rows of a tile with the outer halves of its borders, see `runs_of`."""
    x1, y1, x2, y2 = vectors
    return runs_of(np.array([y1, x1]), np.array([y2, x2]), (border + 1) // 2)


def tile_fits(shape: tuple[int, int], rows: Ints) -> bool:
    """Whether a tile of these rows and its corner fit into a picture.

    >>> rows = tile_rows((4, 0, 0, 3), 0)
    >>> tile_fits((3, 4), rows), tile_fits((2, 4), rows)
    (True, False)
    """
    lowest, ends = -rows[:, :2].min(axis=0), rows[:, [0, 2]].max(axis=0) + (1, 0)
    places = np.minimum(np.array(shape) - 1, shape - ends) - np.maximum(lowest, 0)
    return bool((places >= 0).all())


def tile_errors(exemplar: Exemplar, vectors: tuple[float, ...], border: int) -> Ints:
    """Accumulated squared differences of opposite borders of every tile (eq. 4.2, Fig. 4.4, 4.5).

    int64 (H, W), by the tile's first corner; -1 where a tile with its borders is not on usable
    pixels. Borders of no width make all tiles equal.

    >>> stripes = np.tile(np.uint8([10, 90]), (8, 4))
    >>> errors = tile_errors(Exemplar(stripes), (2, 0, 0, 2), 1)
    >>> int(errors.max()), int((errors == 0).sum())
    (0, 25)
    """
    height, width = shape = exemplar.shape
    unusable = (~exemplar.usable).astype(np.int64)
    fits = integrated(unusable, tile_rows(vectors, border), outside=1) == 0
    total = np.zeros(shape, np.int64)
    if not fits.any():
        return total - 1
    sides = np.reshape(vectors, (2, 2))[:, ::-1].astype(np.float64)  # rows first
    pixels = exemplar.matching().astype(np.int64)
    for k in (0, 1) if border else ():
        step = np.rint(sides[k]).astype(int)
        other = runs_of(np.zeros(2), sides[1 - k], (border + 1) // 2)
        y, x = np.indices(shape) + step[:, None, None]
        inside = (y >= 0) & (y < height) & (x >= 0) & (x < width)
        there = pixels[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
        error = np.where(inside, ((pixels - there) ** 2).sum(axis=2), 0)
        total += integrated(error, other, outside=0)
    return np.where(fits, total, -1)


def border_for(given: int | None, vectors: tuple[float, ...], exemplar: Exemplar) -> int:
    """The width of borders: the given one, or at most 10 if the sample is large enough.

    Raises `InvalidInputError` if the sample has no room for the given one.
    """

    def fits(width: int) -> bool:
        return width == 0 or tile_fits(exemplar.shape, tile_rows(vectors, width))

    border = _BORDER if given is None else given
    if exemplar.mask is not None or fits(border):
        return border
    if given is not None:
        better = next(width for width in range(min(given, *exemplar.shape), -1, -1) if fits(width))
        raise InvalidInputError(f"border_width is {given}; {exemplar.name} allows at most {better}")
    while not fits(border):
        border //= 2
    return border
