"""Pictures of where a result fails, and the border of a picture that should wrap around."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.properties import border_steps
from weftex.errors import InvalidInputError, size_words
from weftex.exemplar import Exemplar
from weftex.exemplar.turns import as_it_was, as_made_from
from weftex.progress import counted
from weftex.quality.assess import LARGEST_MEASURED
from weftex.quality.figures import FIGURES
from weftex.quality.score import Scorer
from weftex.quality.seams import StepModel
from weftex.quality.view import middle, view_of
from weftex.raster.arrays import Bytes
from weftex.results.drawing import draw_sources
from weftex.results.synthesis import Synthesis

_BROKEN = 0.6  # of the distance between the sample's halves, from which windows are marked
_STEPS = 2.0  # more than this many usual steps are a seam, even if no place stands out
_LIMIT = FIGURES["wrap"].limit or 1.0
_MARK = (255, 40, 0)
_AWAY = 64  # parts of the shorter side: how far marks lie from the border that they mark


def fault_maps(
    exemplar: Exemplar, pixels: NDArray[Any], source: Synthesis | None
) -> dict[str, Bytes]:
    """Return pictures of where a result fails, uint8 (h, w, 3), by name; see `Report.maps`.

    `source` is what the pixels are a picture of; one that cannot be is refused. Of large results
    the middle is drawn.
    """
    pictured = exemplar if source is None else as_made_from(exemplar, source.turn)
    sizes = pictured.shape, pixels.shape[:2]
    if source is not None and (source.sample_shape, source.shape) != sizes:
        raise InvalidInputError(
            f"the source makes {size_words(source.shape)} from {size_words(source.sample_shape)}, "
            f"but result and sample are {size_words(sizes[1])} and {size_words(sizes[0])}"
        )
    pixels = middle(pixels, LARGEST_MEASURED)
    maps, scorer = {}, Scorer(as_it_was(exemplar))
    broken = scorer.broken_map(scorer.view(pixels))
    if broken is not None:
        picture = as_shown(exemplar, pixels)
        maps["broken"] = _marked(picture, np.clip(broken / _BROKEN - 1, 0, 1), _MARK)
    if source is not None:
        places = source.pictured_source()
        if source.canvas.hole is not None:
            places[~source.canvas.hole] = -1
        places = middle(places, LARGEST_MEASURED)
        known = places[..., 0] >= 0
        maps["source"] = draw_sources(places, pictured.shape)
        count = np.zeros(pictured.shape)
        np.add.at(count, (places[known][:, 0], places[known][:, 1]), 1)
        usual = max(float(count.mean()), 1e-9)
        often = np.clip(np.log2((count + usual / 8) / usual) / 3, -1, 1)
        seldom = _marked(as_shown(pictured, pictured.pixels), np.maximum(-often, 0), (0, 90, 255))
        maps["use"] = _marked(seldom, np.maximum(often, 0), (255, 150, 0), 1.0)
    return maps


def as_shown(exemplar: Exemplar, pixels: NDArray[Any]) -> Bytes:
    """Return three channels of bytes, for display."""
    pixel_bytes = exemplar.as_matching(pixels)
    colors = pixel_bytes.shape[2] - exemplar.alpha
    return pixel_bytes[..., :3] if colors >= 3 else np.repeat(pixel_bytes[..., :1], 3, axis=2)


def _marked(
    picture: Bytes, strength: NDArray[Any], color: tuple[int, int, int], keep: float = 0.6
) -> Bytes:
    """Return the picture, in gray for `keep` below 1, with a color blended in by strength."""
    base = picture.astype(np.float64)
    if keep < 1:
        base = np.repeat(255 - (255 - base.mean(axis=2, keepdims=True)) * keep, 3, axis=2)
    share = 0.85 * strength[..., None]
    return np.rint(base * (1 - share) + np.array(color) * share).astype(np.uint8)


@dataclass(frozen=True)
class Border:
    """How the step across a border, along one axis, compares with the steps inside."""

    steps: float  # the mean squared step across it over the usual one inside; 1 is no seam
    #: Share of the border at which the step is more surprising than 99 % of the steps inside; None
    #: where a side is shorter than 23 pixels.
    seam: float | None
    places: NDArray[np.bool_]  # where along it that is; everywhere if only `steps` shows a seam
    #: What both are at most where no seam shows.
    most: ClassVar[tuple[float, float]] = _STEPS, _LIMIT

    @property
    def badness(self) -> float:
        """How near the worse of both measures is to its limit, which is at 1."""
        return max(self.steps / _STEPS, (self.seam or 0.0) / _LIMIT)

    def __str__(self) -> str:
        text = f"values change {self.steps:g} times as much there as inside (at most {_STEPS:g})"
        if self.seam is not None:
            text += f", and {self.seam:.0%} of the border shows a seam (at most {_LIMIT:.0%})"
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
            if steps <= _STEPS:
                places = np.pad(surprising, (len(places) - len(surprising)) // 2, "edge")
        found.append(Border(steps, seam, places))
    return found[0], found[1]


def borders_of_each(maps: Mapping[str, Exemplar]) -> dict[str, tuple[Border, Border]]:
    """Return the `borders_of` each map, and count them."""
    found = {}
    with counted(len(maps), "borders") as advance:
        for name, one in maps.items():
            found[name] = borders_of(one)
            advance(1)
    return found


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
