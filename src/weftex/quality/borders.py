"""The border of a picture, where it wraps around, compared with its own inside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.properties import border_steps
from weftex.quality.assess import LARGEST_MEASURED
from weftex.quality.faults import as_shown
from weftex.quality.figures import FIGURES
from weftex.quality.seams import StepModel
from weftex.quality.view import view_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar

_STEPS = 2.0  # more than this many usual steps are a seam, even if no place stands out
_LIMIT = FIGURES["wrap"].limit or 1.0
_MARK = (255, 40, 0)
_AWAY = 64  # parts of the shorter side: how far marks lie from the border that they mark


@dataclass(frozen=True)
class Border:
    """How the step across a border, along one axis, compares with the steps inside.

    Attributes
    ----------
    steps : float
        The mean squared step across the border over the usual one inside; 1 is no seam.
    seam : float or None
        Share of the border at which the step is more surprising than 99 % of the steps inside;
        None where a side is shorter than 23 pixels.
    places : bool array
        Where along the border that is; everywhere if only `steps` shows a seam.
    """

    steps: float
    seam: float | None
    places: NDArray[np.bool_]

    @property
    def badness(self) -> float:
        """How near the worse of both measures is to its limit, which is at 1."""
        return max(self.steps / _STEPS, (self.seam or 0.0) / _LIMIT)

    def __str__(self) -> str:
        text = f"its step is {self.steps:g} times the usual one (at most {_STEPS:g})"
        if self.seam is not None:
            text += f" and {self.seam:.0%} of it stands out (at most {_LIMIT:.0%})"
        return text


def borders_of(picture: Exemplar) -> tuple[Border, Border]:
    """Return the borders where a picture wraps around downwards, and to the right."""
    view = view_of(picture)
    model = StepModel(view.center(LARGEST_MEASURED))
    found = []
    for axis, steps in enumerate(border_steps(picture.changed(maps=None))):
        places = np.ones(picture.shape[1 - axis], bool)
        seam = None
        if model.fits(view):
            surprising = model.border_places(view, axis)
            seam = float(surprising.mean())
            trimmed = (len(places) - len(surprising)) // 2
            if steps <= _STEPS:
                places = np.pad(surprising, trimmed, "edge")
        found.append(Border(steps, seam, places))
    return found[0], found[1]


def draw_borders(picture: Exemplar, borders: tuple[Border, Border]) -> NDArray[np.uint8]:
    """Return the picture (H, W, 3) shifted by half, with marks along borders that show a seam."""
    shown: NDArray[Any] = as_shown(picture, picture.pixels)
    height, width = picture.shape
    drawn = np.roll(shown, (height // 2, width // 2), (0, 1))
    away = max(2, min(height, width) // _AWAY)
    for axis, border in enumerate(borders):
        if border.badness <= 1:
            continue
        lines = np.moveaxis(drawn, axis, 0)
        middle = len(lines) // 2
        places = np.roll(border.places, picture.shape[1 - axis] // 2)
        for line in (middle - 1 - away, middle + away):
            if 0 <= line < len(lines):
                lines[line, places] = _MARK
    return np.ascontiguousarray(drawn)
