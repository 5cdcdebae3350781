"""The start of iterative refinement where it is the result of another method."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import Around, four_numbers, is_sure
from weftex.analysis.scale import dominant_scale
from weftex.canvas import Canvas
from weftex.endless.boxes import Box, PlaneRequest
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Model
from weftex.methods.lattices import is_strained
from weftex.methods.pixels import Growth
from weftex.methods.refinement.levels import Prepared
from weftex.naming import method_of, text_of
from weftex.raster.masks import grown
from weftex.registry import METHODS
from weftex.search.windows import Windows


def fitted_starts(method: Any, exemplar: Exemplar) -> dict[str, Model]:
    """Return the models that make the start, by slug; none for seed points.

    If `init` was not given: near-regular synthesis for a confident lattice (graph cut in holes),
    then quilting. A later model makes the canvases that an earlier one refuses.
    """
    names, may_fail = [method.init], False
    if method.init == "auto":
        usual = method.meant("init")
        names = ["seeds"] if usual == "seeds" else [*_by_lattice(exemplar), usual]
        may_fail = not method.joints
    starts, failure = {}, None
    for name in names:
        try:
            if name != "seeds":
                starts[name] = method_of(name).fit(exemplar)
        except InvalidInputError as error:
            failure = error
    if failure is not None and not (starts or may_fail):
        raise InvalidInputError(f"init: {failure}")
    return starts


def _by_lattice(exemplar: Exemplar) -> list[str]:
    """Near-regular synthesis with the sample's lattice, if that is sure."""
    lattice = dominant_scale(exemplar).lattice
    mask = exemplar.mask
    pixels = math.prod(exemplar.shape) if mask is None else int(np.count_nonzero(mask))
    if lattice is None or not is_sure(lattice, pixels):
        return []
    return [text_of(METHODS["near-regular"](lattice=four_numbers(lattice)))]


def starts_for(prepared: Prepared, canvas: Canvas) -> list[str]:
    """Name the starts for a canvas, the one that suits it best first; none plants seed points."""
    starts, names = prepared.starts, list(prepared.starts)
    if prepared.by_canvas and canvas.guide is not None:
        return []
    if prepared.by_canvas and names and is_strained(starts[names[0]], canvas):
        names.reverse()
    return names


def result_of(prepared: Prepared, growth: Growth) -> tuple[str, NDArray[np.int32] | None]:
    """Return the start's name and its source map (H, W, 2); no map for seed points.

    A start that refuses the canvas is replaced by the next one. If `init` was not given and all
    refuse, seed points are planted.
    """
    starts, canvas, failure = prepared.starts, growth.canvas, None
    if canvas.shown is not None and starts:
        place = np.divmod(canvas.shown, growth.exemplar.shape[1])
        return next(iter(starts)), np.stack(place, axis=-1)
    for name in starts_for(prepared, canvas):
        start = starts[name]
        if "guide" not in start.method.supports:
            canvas = dataclasses.replace(canvas, guide=None)
        try:
            if canvas.hole is not None:
                if prepared.by_canvas:  # near-regular synthesis fills no holes
                    name = name.replace("near-regular", "graphcut")
                start = hole_start(name, canvas.hole, growth.exemplar)
            return name, start.sample(canvas, seed=growth.seed, threads=growth.threads).source
        except InvalidInputError as error:
            failure = failure or error
    if failure is None or (prepared.by_canvas and not prepared.belt):
        return "seeds", None
    raise InvalidInputError(f"init: {failure}")


def hole_start(name: str, hole: NDArray[np.bool_], exemplar: Exemplar) -> Model:
    """Return the start's model, with parameters that suit a hole where `init` leaves them open."""
    usable = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    given = None if " " in name else frozenset[str]()
    return method_of(name).for_hole(hole, usable, given).fit(exemplar)


def start_window(
    starts: dict[str, Model], box: Box, asked: PlaneRequest
) -> NDArray[np.int32] | None:
    """Return flat indices of the sources of a box of the start's plane, None without a start.

    The next start serves planes whose period would strain the first one's lattice visibly.
    """
    if not starts:
        return None
    start, *others = starts.values()
    if others and asked.period is not None and is_strained(start, Around(*asked.period)):
        start = others[0]
    source = start.make_window(box, asked).source
    return source[..., 0] * np.int32(start.exemplar.shape[1]) + source[..., 1]


def keep_patches(sources: NDArray[np.int32], belt: int, windows: Windows, growth: Growth) -> None:
    """Keep the patches of another method's result; belts along their seams become a hole."""
    height, width = growth.exemplar.shape
    period = (height, width) if growth.exemplar.tileable else None
    belts = seam_belts(sources, belt // 2, growth.canvas.wrap, period)
    place = (sources[..., 0] * width + sources[..., 1]).astype(np.int32)
    wanted = growth.done == 0
    flat = growth.exemplar.matching().reshape(-1, growth.pixels.shape[2])
    growth.pixels[wanted] = flat[place[wanted]]
    kept = ~belts & wanted
    growth.source[kept] = windows.from_sample(place[kept])
    growth.done[kept] = 1
    growth.hole = None if not growth.done.any() else growth.done == 0


def seam_belts(
    source: NDArray[np.int32],
    reach: int,
    wrap: tuple[bool, bool],
    period: tuple[int, int] | None = None,
) -> NDArray[np.bool_]:
    """Mask (H, W) of the pixels within `reach` of a seam, where neighbors have no adjacent sources.

    `source` is (H, W, 2); `period` is the size of a tileable sample.
    """
    belts = np.zeros(source.shape[:2], bool)
    for axis in (0, 1):
        step = np.roll(source, -1, axis) - source - np.eye(2, dtype=np.int32)[axis]
        broken = ((step if period is None else step % np.array(period)) != 0).any(axis=2)
        if not wrap[axis]:
            broken.swapaxes(0, axis)[-1] = False
        belts |= broken | np.roll(broken, 1, axis)
    return grown(belts, reach - 1, wrap)
