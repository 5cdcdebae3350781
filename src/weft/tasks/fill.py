"""Fill holes of a photo from what surrounds them, or from a sample of their own."""

from __future__ import annotations

import dataclasses
import os
from typing import TYPE_CHECKING, Any

import numpy as np

from weft.canvas import Canvas, as_canvas
from weft.errors import InvalidInputError
from weft.exemplar import Exemplar
from weft.method import Method, make_method
from weft.random import seed_number
from weft.synthesis import Synthesis
from weft.tasks.synthesize import load_exemplar

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weft.progress import ProgressCallback
    from weft.random import Seed
    from weft.tasks.synthesize import Sample

    Mask = str | os.PathLike[str] | NDArray[np.bool_] | Any

#: Usable pixels around the holes that patches are taken from; a search through more takes longer
#: and finds what looks less and less like the place.
NEIGHBOURHOOD = 2**20
_CELL = 16  # pixels a side; the neighbourhood grows by whole cells
#: Patches of a hole: a share of the photo's shorter side, from the least to the most, in pixels.
_PATCH = (1 / 10, 12, 48)


def fill(
    photo: Sample,
    mask: Mask,
    *,
    sample: Sample | None = None,
    method: str | Method = "patch-sampling",
    seed: Seed = None,
    tileable: bool | str = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    **parameters: Any,
) -> Synthesis:
    """Fill the holes of a photo; every other pixel stays exactly as it is.

    Patches come from the million pixels nearest to the holes (`NEIGHBOURHOOD`), or from `sample`.
    A photo with aligned maps is matched on all of them, and all of them are filled.

    Parameters
    ----------
    photo : path, array, PIL image or Exemplar
        What has holes; its pixels inside them do not matter but must be finite.
    mask : path or bool array (H, W)
        True, in a file white, where the photo is to be filled.
    sample : path, array, PIL image or Exemplar, optional
        Take patches from this instead of the photo; of the photo's dtype and channels.
    method : str or Method
        A name in `weft.METHODS` that supports known pixels, or a method with its parameters.
    seed : int, numpy Generator or None
        The same seed gives the same bytes.
    tileable : bool or {"x", "y"}
        Axes along which the photo repeats without a seam, so that holes may cross its border.
    threads : int, optional
        At most so many.
    progress : callable, optional
        See `weft.progress.ProgressCallback`; the preview shows the neighbourhood of the holes.
    **parameters
        Of the method. Without `patch_size` and `randomness` patches are a tenth of the photo's
        shorter side, 12 to 48 pixels, less where no such window is free of holes.

    Returns
    -------
    Synthesis
        Of the photo's size. Without holes it has no patches, and `image` is the photo.

    Raises
    ------
    InvalidInputError
        If sizes, dtypes or channels differ, or the mask leaves nothing to learn from.
    UnsupportedError
        If the method does not fill holes.
    FileError
        If a file cannot be read.

    Examples
    --------
    >>> import numpy as np, weft
    >>> photo = weft.read_image("sample:pebbles").pixels
    >>> hole = np.zeros(photo.shape[:2], bool)
    >>> hole[60:100, 70:130] = True
    >>> result = weft.fill(photo, hole, seed=7)
    >>> bool((result.image[~hole] == photo[~hole]).all())
    True
    """
    chosen = make_method(method, parameters)
    seed = seed_number(seed)
    whole = load_exemplar(photo)
    hole = _load_hole(mask, whole)
    wrap = as_canvas(whole.shape, tileable).wrap
    source = whole if sample is None else _load_sample(sample, whole)
    known_from = (0, 0) if sample is None else None
    canvas = Canvas(*whole.shape, wrap, known=whole.pixels, hole=hole, known_from=known_from)
    chosen.require(canvas)
    if not hole.any():
        return _result(canvas, source, chosen, seed)
    if sample is None and hole.all():
        raise InvalidInputError(
            f"the mask covers all of {whole.name}: nothing to learn from, give sample="
        )
    usable = ~hole if sample is None else np.ones(source.shape, bool)
    if sample is None and whole.mask is not None:
        usable &= whole.mask
    chosen = _with_patch_size(chosen, hole, usable, wrap, source)
    near, rows, columns = _neighbourhood(hole, usable if sample is None else None, wrap, chosen)
    local = np.ix_(rows, columns)
    place = Exemplar(
        _blank(whole.pixels[local], hole[local]),
        maps={k: _blank(v[local], hole[local]) for k, v in whole.maps.items()} if not sample else {},
        alpha=whole.alpha,
    )
    # Distances are taken on bytes anyway, and on bytes maps take part in known pixels too.
    if sample is None:
        levels = place.matching()
        analysed = Exemplar(
            levels, mask=usable[local] & near[local], alpha=False, name=whole.name
        )
    else:
        plain = Exemplar(source.pixels, alpha=source.alpha)
        levels = plain.as_matching(place.pixels)
        analysed = Exemplar(
            plain.matching(), mask=source.mask, tileable=source.tileable, alpha=False,
            name=source.name,
        )  # fmt: skip
    wraps = (wrap[0] and len(rows) == hole.shape[0], wrap[1] and len(columns) == hole.shape[1])
    part = Canvas(*levels.shape[:2], wraps, known=levels, hole=hole[local], known_from=known_from)
    made = chosen.fit(analysed).sample(part, seed=seed, threads=threads, progress=progress)
    placements = made.placements.copy()
    placements[:, :2] = (placements[:, :2] + (rows[0], columns[0])) % whole.shape
    if sample is None:
        placements[:, 2:4] = (placements[:, 2:4] + (rows[0], columns[0])) % whole.shape
    return _result(canvas, source, chosen, seed, placements, made.weights, made.cuts)


def _result(
    canvas: Canvas,
    source: Exemplar,
    method: Method,
    seed: int,
    placements: NDArray[np.int32] | None = None,
    weights: NDArray[np.uint16] | None = None,
    cuts: NDArray[np.uint16] | None = None,
) -> Synthesis:
    return Synthesis(
        canvas,
        np.zeros((0, 5), np.int32) if placements is None else placements,
        np.zeros((1, 1, 1), np.uint16) if weights is None else weights,
        np.zeros((0, 0), np.uint16) if cuts is None else cuts,
        sample_shape=source.shape,
        exemplar=source,
        known_from=canvas.known_from,
        provenance=method.describe() | {"seed": seed},
    )


def _load_hole(mask: Mask, photo: Exemplar) -> NDArray[np.bool_]:
    if isinstance(mask, (str, os.PathLike)):
        from weft.io import read_mask

        mask = read_mask(mask)
    hole = np.asarray(mask)
    if hole.ndim != 2 or hole.dtype != bool:
        raise InvalidInputError(
            f"mask is {hole.dtype} with {hole.ndim} dimensions; it must be boolean with 2, "
            "True where the photo is to be filled"
        )
    if hole.shape != photo.shape:
        raise InvalidInputError(
            f"mask is {hole.shape[1]}x{hole.shape[0]}, {photo.name} is "
            f"{photo.shape[1]}x{photo.shape[0]}; they must be equal"
        )
    return hole


def _load_sample(sample: Sample, photo: Exemplar) -> Exemplar:
    if photo.maps:
        raise InvalidInputError(
            f"{photo.name} has maps, which are filled from itself alone; leave out sample"
        )
    source = load_exemplar(sample)
    kinds = [f"{e.pixels.dtype} with {e.channels} channels" for e in (source, photo)]
    if kinds[0] != kinds[1] or source.pixels.ndim != photo.pixels.ndim:
        raise InvalidInputError(
            f"{source.name} is {kinds[0]}, {photo.name} is {kinds[1]}; they must be equal"
        )
    return source


def _with_patch_size(
    method: Method,
    hole: NDArray[np.bool_],
    usable: NDArray[np.bool_],
    wrap: tuple[bool, bool],
    source: Exemplar,
) -> Method:
    """Settle the patch size of a method that has one and was not given it."""
    fields = {field.name: field.default for field in dataclasses.fields(method)}
    if "patch_size" not in fields or getattr(method, "patch_size", None) is not None:
        return method
    share: float = getattr(method, "randomness", 0.0)
    if share != fields.get("randomness", 0.0):
        size = max(1, round(share * min(source.shape)))
        return dataclasses.replace(method, patch_size=size)  # type: ignore[call-arg]
    least = 2 * (getattr(method, "boundary_width", None) or 1)
    size = round(min(max(_PATCH[0] * min(hole.shape), _PATCH[1]), _PATCH[2]))
    size = min(size, *source.shape, *hole.shape)
    while size > max(least, 2) and not _has_window(usable, size):
        size = max(size * 2 // 3, least)
    return dataclasses.replace(method, patch_size=max(size, least))  # type: ignore[call-arg]
