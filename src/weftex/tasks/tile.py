"""Make an existing photo tileable by changing a border of it."""

from __future__ import annotations

import numbers
from typing import Any

import numpy as np

from weftex.analysis.canvas_lattice import CanvasLattice, is_sure
from weftex.analysis.lattice import find_lattice
from weftex.canvas import Canvas, as_canvas
from weftex.errors import InvalidInputError, shown, size_words, wrong_value
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.method import Method
from weftex.naming import is_auto, method_for_task
from weftex.progress import ProgressCallback, listening
from weftex.random import Seed
from weftex.registry import AUTO, FOR_TILES
from weftex.results.synthesis import Synthesis
from weftex.tasks.fill import fill

_SHARE = 8  # the border that may change is 1 / 8 of the shorter side
_LEAST = 3  # borders that must fit into a side, so that most of it is kept
_STRAIN = 0.015  # strain of a lattice up to which no fault is visible
_ANEW = 8  # pixels at each side that are always filled if a width is given, or half that width


def tile(
    photo: Sample,
    *,
    axes: bool | str = True,
    border: int | None = None,
    method: str | Method = AUTO,
    seed: Seed = None,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    **parameters: Any,
) -> Synthesis:
    """Make a photo tileable; its middle stays byte for byte.

    A narrow frame at the edges is filled like a hole, maps included; see `weftex.fill`. The
    boundary between photo and filling is cut within the border. A regular pattern, such as bricks,
    needs a size that holds whole periods; otherwise `provenance["warnings"]` names such a size.

    Parameters
    ----------
    photo : path, array, PIL image or Exemplar
        The photo, at the size that it keeps.
    axes : True or {"x", "y"}
        The axes along which it wraps around.
    border : int, optional
        Pixels at each side that may change; an eighth of the shorter side by default, at most a
        third of a side. If it is given, the outermost (half of it, at most 8) always change.
    method, seed, threads, progress, **parameters
        As for `weftex.fill`, but "auto" is always `graphcut`.

    Returns
    -------
    Synthesis
        The tileable photo, of the same size.

    Raises
    ------
    InvalidInputError
        If the border is wider than a third of a side, or no axis is named.
    FileError
        If the photo cannot be read.
    CancelledError
        If `progress` returned False.

    Examples
    --------
    >>> import weftex
    >>> photo = weftex.load_exemplar("sample:pebbles")
    >>> made = tile(photo, border=32, seed=1).image
    >>> bool((made[32:-32, 32:-32] == photo.pixels[32:-32, 32:-32]).all())
    True
    """
    exemplar = load_exemplar(photo)
    if not isinstance(axes, (bool, str)) or axes not in (True, "x", "y"):
        raise wrong_value("axes", axes, "True, 'x' or 'y'")
    wrap = as_canvas(exemplar.shape, axes).wrap
    sides = [side for side, wraps in zip(exemplar.shape, wrap, strict=True) if wraps]
    most = min(sides) // _LEAST
    wxh = size_words(exemplar.shape)
    if not most:
        raise InvalidInputError(
            f"{exemplar.name} is {wxh}; sides that wrap around must be {_LEAST} pixels or more"
        )
    if border is None:
        border, anew = max(1, min(exemplar.shape) // _SHARE), 1
    elif isinstance(border, numbers.Integral) and not isinstance(border, bool):
        anew = min(_ANEW, (border + 1) // 2)
    else:
        raise wrong_value("border", border, "a whole number of pixels")
    if not 1 <= border <= most:
        raise InvalidInputError(f"border is {shown(border)}; for {wxh} it must be from 1 to {most}")
    inside = [slice(anew * w, n - anew * w) for n, w in zip(exemplar.shape, wrap, strict=True)]
    frame = np.ones(exemplar.shape, bool)
    frame[tuple(inside)] = False
    how: dict[str, Any] = {"seed": seed, "threads": threads, "progress": progress}
    how |= {"tileable": axes, "overlap": border - anew}
    if is_auto(method):
        how["match_tone"] = True
        method, parameters = method_for_task("tile", FOR_TILES, method, parameters), {}
    with listening(progress):
        result = fill(exemplar, frame, method=method, **how, **parameters)
        warning = _ill_fitting(exemplar, Canvas(*exemplar.shape, wrap))
    if warning is not None:
        result.provenance["warnings"] = [*result.provenance.get("warnings", ()), warning]
    return result


def _ill_fitting(exemplar: Exemplar, canvas: Canvas) -> str | None:
    """Return why whole tiles of a sure lattice do not fit into the photo; None if they do."""
    found = find_lattice(exemplar)
    if found is None or not is_sure(found, exemplar.shape[0] * exemplar.shape[1]):
        return None
    try:
        CanvasLattice(tuple(found), canvas, _STRAIN)
    except InvalidInputError as error:
        return f"crop the photo first: {error}"
    return None
