"""Best self-similar tile repetition (section 4.1 of the paper on near-regular textures)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import Around, CanvasLattice, check_lattice, found_vectors
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Method
from weftex.methods.best_tile.tiles import border_for, least_corner, tile_errors, tile_rows
from weftex.methods.lattices import LatticeModel
from weftex.parameters import parameter
from weftex.progress import Progress, ProgressCallback
from weftex.results.pixels import PixelSynthesis

_LIMIT = 0.05  # strain of a lattice that wraps around a canvas
_BAND = 16  # rows that are made at a time


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
        "Near-regular texture synthesis by constrained random sampling and gap filling, a thesis: "
        "section 4.1"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "random_access", "many"})

    lattice: tuple[float, ...] | None = parameter(
        None,
        "vectors x1,y1,x2,y2 from one tile to the next",
        count=4,
        unit="px",
        default_text="found in the sample",
    )
    border_width: int | None = parameter(
        None,
        "width of the borders that are compared",
        low=1,
        high=1024,
        unit="px",
        default_text="10, less for a small sample",
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
        The rows of a tile with half its borders, see `tiles.runs_of`.

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
        self.anchor = least_corner(errors)
        super().__init__(replace(method, lattice=vectors, border_width=border), exemplar, vectors)

    def lay(
        self,
        canvas: Canvas,
        origin: tuple[int, int],
        seed: int,
        threads: int,
        progress: ProgressCallback | None,
        period: tuple[int, int] | None = None,
    ) -> PixelSynthesis:
        """Repeat the best tile: f(x) = f(x + a v1 + b v2) (eq. 4.1)."""
        around = canvas if period is None else Around(*period)
        lattice = CanvasLattice(self.vectors, around, _LIMIT)
        index = np.full(canvas.shape, -1, np.int32)
        pixels = self.exemplar.pixels.reshape(-1, *self.exemplar.pixels.shape[2:])

        def preview() -> NDArray[Any]:
            made: NDArray[Any] = pixels[index]
            made[index < 0] = 0
            return made

        # Coordinates up to 2**40 are exact to 2**-13 pixel in a float. On a canvas that wraps they
        # count from its corner.
        lines = [np.arange(n) + at for n, at in zip(canvas.shape, origin, strict=True)]
        if period is not None:
            lines = [line % n for line, n in zip(lines, period, strict=True)]
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
        about: dict[str, object] = {"seed": seed, "anchor": list(self.anchor)}
        if any(around.wrap):
            about["strain"] = round(lattice.strain, 6)
        return PixelSynthesis(
            canvas,
            index,
            sample_shape=self.exemplar.shape,
            exemplar=self.exemplar,
            provenance=self.method.describe() | about,
        )
