"""Label maps: which sample goes where (section 4 of the paper on texture fusion)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar import check_pixels
from weftex.loading import load_exemplar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

_SHOWN = 6  # colors that a message lists


def labels_of(
    picture: NDArray[Any], count: int, colors: Sequence[Any] | None = None
) -> tuple[NDArray[np.int32], list[Any]]:
    """Return labels (H, W) of the colors of a painted map, and the color of each label.

    With `colors`, other colors count as the nearest of these, so painted edges may be smooth.
    """
    if picture.ndim not in (2, 3) or picture.size == 0:
        raise InvalidInputError(f"the map has shape {picture.shape}; it must be (H, W[, C])")
    flat = picture.reshape(picture.shape[0] * picture.shape[1], -1)
    if colors is None:
        found, first, inverse = np.unique(flat, axis=0, return_index=True, return_inverse=True)
        order = np.argsort(first)
        if len(found) != count:
            shown = ", ".join(_text(c) for c in found[order][:_SHOWN])
            more = ", ..." if len(found) > _SHOWN else ""
            raise InvalidInputError(
                f"the map has {len(found)} colors ({shown}{more}) for {count} samples; there must "
                "be one for each sample, or say which to take: colors=[...], or --colors"
            )
        rank = np.empty(count, np.int32)
        rank[order] = np.arange(count, dtype=np.int32)
        labels, wanted = rank[inverse.ravel()], found[order]
    else:
        if len(colors) != count:
            raise InvalidInputError(
                f"{len(colors)} colors for {count} samples or mixed regions; give one each"
            )
        try:
            wanted = np.array([np.ravel(c) for c in colors])
            wanted = wanted if wanted.dtype.kind in "biuf" else np.zeros((0, 0))
        except (TypeError, ValueError, OverflowError):
            wanted = np.zeros((0, 0))
        if wanted.shape == (count, flat.shape[1] - 1) and (flat[:, -1] == flat[0, -1]).all():
            flat = flat[:, :-1]  # what was painted on a canvas has an alpha, which says nothing
        if wanted.shape != (count, flat.shape[1]):
            raise InvalidInputError(f"each color must have {flat.shape[1]} numbers, as in the map")
        for k in range(1, count):
            if (wanted[:k] == wanted[k]).all(axis=1).any():
                raise InvalidInputError(
                    f"the color {_text(wanted[k])} is given twice; give one each"
                )
        distance = np.stack([((flat - c.astype(np.float64)) ** 2).sum(axis=1) for c in wanted])
        labels = distance.argmin(axis=0).astype(np.int32)
        for k in range(count):
            if not (distance[k] == 0).any():
                raise InvalidInputError(f"the map has no pixel of the color {_text(wanted[k])}")
    return labels.reshape(picture.shape[:2]), [tuple(c.tolist()) for c in wanted]


def map_picture(label_map: Any) -> NDArray[Any]:
    """Return the picture of a map, or its labels: integers of any type unchanged."""
    if isinstance(label_map, np.ndarray):
        if label_map.dtype == bool:
            return label_map.astype(np.uint8)
        if label_map.dtype.kind not in "iu":
            return check_pixels(label_map, "the map")
        if label_map.size and label_map.min() < 0:
            raise InvalidInputError(
                f"the map has the label {label_map.min()}; labels are from 0 on"
            )
        return label_map
    if label_map is None:
        raise InvalidInputError("the map is None; give a picture, labels or 'gradient'")
    return load_exemplar(label_map).pixels


def _text(color: NDArray[Any]) -> str:
    return "(" + ", ".join(f"{v:g}" for v in color) + ")" if len(color) > 1 else f"{color[0]:g}"
