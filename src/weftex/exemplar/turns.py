"""Mirrored and rotated copies beside a sample."""

from __future__ import annotations

import numpy as np

from weftex.errors import InvalidInputError, wrong_value
from weftex.exemplar.exemplar import Exemplar
from weftex.exemplar.material import Sample, load_exemplar
from weftex.raster.turning import TURNS, Box, boxes_of, turned_pixels


def turned(sample: Sample, turn: str) -> Exemplar:
    """Add mirrored or rotated copies to a sample, so that methods choose from more pixels.

    All copies are in one image. A masked line of pixels separates any two, so that no patch is
    copied from two at once. The vectors of normal maps are rotated too, with y up (OpenGL) or down
    (DirectX), as the name of the map says.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        A material without an up direction, or without a difference of left and right.
    turn : {"flip", "half", "4", "8"}
        Copies beside the sample: mirrored left to right; rotated by 180 degrees; rotated by 90,
        180 and 270 degrees; or these and all mirrored.

    Returns
    -------
    Exemplar
        Two, four or eight copies, with maps, mask and guide; the first is the sample.

    Raises
    ------
    FileError, InvalidInputError
        If the sample cannot be read; if it already has such copies, or `turn` is unknown.

    Notes
    -----
    Results have the coordinates of the sample itself, not of a copy. `Synthesis.render` takes maps
    of the sample, and rotates them in the same way.

    Examples
    --------
    >>> row = turned(np.array([[1, 2, 3]], np.uint8), "flip")
    >>> row.pixels.tolist(), row.mask.tolist()
    ([[1, 2, 3, 1, 3, 2, 1]], [[True, True, True, False, True, True, True]])
    """
    exemplar = load_exemplar(sample)
    if not isinstance(turn, str) or turn not in TURNS:
        raise wrong_value("turn", turn, f"one of {', '.join(TURNS)}")
    if exemplar.turn is not None:
        raise InvalidInputError(f"{exemplar.name} already consists of rotated copies")
    return exemplar.changed(
        pixels=turned_pixels(exemplar.pixels, turn, exemplar.role),
        maps={name: _turned_map(exemplar, name, turn) for name in exemplar.maps},
        mask=turned_pixels(exemplar.usable, turn, between=np.False_),
        guide=None if exemplar.guide is None else turned_pixels(exemplar.guide, turn),
        tileable=False,
        turn=turn,
        copy_shape=exemplar.shape,
        pieces=True,
    )


def as_made_from(exemplar: Exemplar, turn: str | None) -> Exemplar:
    """Return the sample, or the picture of its copies that a result was made from."""
    return exemplar if turn is None or exemplar.turn == turn else turned(exemplar, turn)


def as_it_was(exemplar: Exemplar) -> Exemplar:
    """Return the sample that a picture of copies was made from, without its maps; or the sample."""
    if exemplar.copy_shape is None:
        return exemplar
    height, width = exemplar.copy_shape
    assert exemplar.mask is not None
    pixels, mask = (a[:height, :width] for a in (exemplar.pixels, exemplar.mask))
    return exemplar.changed(pixels=pixels, mask=mask, maps={}, guide=None, pieces=False)


def copies_in(exemplar: Exemplar) -> list[Box]:
    """Return where the copies lie in a picture of them (see `turned`), the sample first."""
    assert exemplar.turn is not None and exemplar.copy_shape is not None
    return [box for _, box in boxes_of(exemplar.turn, exemplar.copy_shape)]


def as_copies(given: Exemplar, turn: str, scale: int) -> Exemplar:
    """Return a map of a sample, `scale` times as fine, as one of its picture of copies."""
    pixels = turned_pixels(given.pixels, turn, given.role, gap=scale)
    return given.changed(pixels=pixels, maps={}, mask=None, guide=None)


def _turned_map(exemplar: Exemplar, name: str, turn: str) -> Exemplar:
    """A map at its own resolution, or where that is a fraction of the sample's, at the sample's."""
    scale, given = exemplar.scale_of(name), exemplar.map(name)
    pixels = exemplar.aligned(name) if scale < 1 else given.pixels
    made = turned_pixels(pixels, turn, given.role, gap=max(1, int(scale)))
    return given.changed(pixels=made, turn=turn, copy_shape=pixels.shape[:2])
