"""The size of a tileable output into which whole tiles of the sample's lattice fit."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from weftex.analysis.canvas_lattice import (
    FITTING_STRAIN,
    VISIBLE_STRAIN,
    fitting_sizes,
    four_numbers,
)
from weftex.errors import InvalidInputError
from weftex.methods.lattices.model import LatticeModel
from weftex.tasks.auto import Auto, AutoModel

if TYPE_CHECKING:
    from weftex.canvas import Canvas
    from weftex.exemplar import Exemplar
    from weftex.method import Method


def fitting_canvas(canvas: Canvas, exemplar: Exemplar, method: Method) -> Canvas:
    """Return the canvas in the nearest size that fits; as it is if the sample has no lattice."""
    if not any(canvas.wrap):
        raise InvalidInputError("fit has no effect without tileable")
    if canvas.guide is not None or canvas.known is not None:
        raise InvalidInputError("fit has no effect on a size that a guide or a photo has")
    model = method.fit(exemplar)
    if not isinstance(model, LatticeModel):
        lattice = AutoModel(Auto(), exemplar).lattice
        if lattice is None:
            return canvas
        vectors = four_numbers(lattice)
    else:
        vectors = model.vectors
    for limit in (FITTING_STRAIN, VISIBLE_STRAIN):
        for height, width in fitting_sizes(vectors, canvas, limit)[:1]:
            return replace(canvas, height=height, width=width)
    return canvas
