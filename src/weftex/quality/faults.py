"""Pictures of where a result fails."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar.turns import as_made_from
from weftex.quality.assess import LARGEST_MEASURED
from weftex.quality.seams import StepModel, seam_map
from weftex.quality.view import middle, views
from weftex.results.drawing import draw_sources

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.results.synthesis import Synthesis

    Bytes = NDArray[np.uint8]

_SEAM = 0.5  # surprise beyond the usual that is drawn at full strength


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
            f"the source makes {_size(source.shape)} from {_size(source.sample_shape)}, but result "
            f"and sample are {_size(sizes[1])} and {_size(sizes[0])}"
        )
    height, width = pixels.shape[:2]
    pixels = middle(pixels, (min(height, LARGEST_MEASURED), min(width, LARGEST_MEASURED)))
    own, made = views(exemplar, pixels)
    maps = {}
    seams = seam_map(StepModel(own), made)
    if seams is not None:
        picture = as_shown(exemplar, pixels)
        maps["seams"] = _marked(picture, np.minimum(seams / _SEAM, 1), (255, 40, 0))
    if source is not None:
        places = source.pictured_source()
        if source.canvas.hole is not None:
            places[~source.canvas.hole] = -1
        places = middle(places, made.shape)
        known = places[..., 0] >= 0
        maps["source"] = draw_sources(places, pictured.shape)
        count = np.zeros(pictured.shape)
        np.add.at(count, (places[known][:, 0], places[known][:, 1]), 1)
        usual = max(float(count.mean()), 1e-9)
        often = np.clip(np.log2((count + usual / 8) / usual) / 3, -1, 1)
        shown = as_shown(pictured, pictured.pixels)
        seldom = _marked(shown, np.maximum(-often, 0), (0, 90, 255))
        maps["use"] = _marked(seldom, np.maximum(often, 0), (255, 150, 0), 1.0)
    return maps


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]}x{shape[0]}"


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
    marked: Bytes = np.rint(base * (1 - share) + np.array(color) * share).astype(np.uint8)
    return marked
