"""The models of methods that repeat a sample by its lattice."""

from __future__ import annotations

from abc import abstractmethod

from weftex.analysis.canvas_lattice import VISIBLE_STRAIN, Around, CanvasLattice
from weftex.canvas import Canvas
from weftex.endless.boxes import Box, Corner, PlaneRequest, canvas_of
from weftex.errors import UnsupportedError
from weftex.exemplar import Exemplar
from weftex.method import Method, Model
from weftex.progress import ProgressCallback
from weftex.results.synthesis import Synthesis


class LatticeModel(Model):
    """Base of the models of methods over a lattice; a subclass defines `make`.

    `vectors` are x1, y1, x2, y2 of the lattice in pixels.
    """

    def __init__(self, method: Method, exemplar: Exemplar, vectors: tuple[float, ...]) -> None:
        if exemplar.pieces:
            raise UnsupportedError(
                f"{method.slug} needs one lattice, which several samples or rotated copies do "
                "not have; use one sample without turn, or another method"
            )
        self.method, self.exemplar, self.vectors = method, exemplar, vectors

    @abstractmethod
    def lay(
        self, canvas: Canvas, corner: Corner, asked: PlaneRequest, progress: ProgressCallback | None
    ) -> Synthesis:
        """Return an output whose corner is at `corner` in the plane of the sample's lattice.

        Where the canvas wraps, or the plane has a period, the lattice is stretched until whole
        tiles fit; `provenance["strain"]` says how much.
        """

    def make(
        self, canvas: Canvas, seed: int, threads: int, progress: ProgressCallback | None
    ) -> Synthesis:
        """See `Model.make`; errors name a good size if the lattice would be strained too much."""
        return self.lay(canvas, canvas.origin, PlaneRequest(seed, None, threads), progress)

    def make_window(
        self, box: Box, asked: PlaneRequest, progress: ProgressCallback | None = None
    ) -> Synthesis:
        """See `Model.make_window`."""
        corner = box.rows.first, box.columns.first
        found = self.lay(canvas_of(box), corner, asked, progress)
        found.is_window = True
        found.provenance |= asked.told
        return found


def is_strained(model: Model, around: Canvas | Around) -> bool:
    """Whether a model's lattice would have to be stretched visibly to wrap."""
    if not isinstance(model, LatticeModel) or not any(around.wrap):
        return False
    return CanvasLattice(model.vectors, around).strain > VISIBLE_STRAIN
