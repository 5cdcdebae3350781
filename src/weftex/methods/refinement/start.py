"""The start of refinement: seed points (section 3, Fig. 5), or the result of another method."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import Around
from weftex.analysis.scale import sure_lattice
from weftex.canvas import Canvas
from weftex.endless.boxes import Box, PlaneRequest
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Model
from weftex.methods.lattices import is_strained
from weftex.methods.pixels import Growth
from weftex.methods.refinement.levels import (
    OutputLevel,
    Prepared,
    sources_of_children,
    sources_shown,
)
from weftex.naming import parse_method, text_of
from weftex.random import draw
from weftex.raster.arrays import Indices, Mask
from weftex.raster.masks import grown
from weftex.registry import METHODS
from weftex.search.windows import Windows


def start_sources(
    prepared: Prepared,
    outputs: list[OutputLevel],
    number: int,
    start_map: Indices | None,
    seed: int,
) -> Indices:
    """Return the sources (H, W) that refinement of a level begins with; -1 for none.

    The coarsest level shows the start's source map or, without, seed points: the paper's step 3.
    Each finer one continues the next coarser.
    """
    level, output = prepared.levels[number], outputs[number]
    if number + 1 < len(outputs):
        coarser = outputs[number + 1], prepared.levels[number + 1]
        return sources_of_children(*coarser, output.known.shape, level)
    if start_map is not None:
        return sources_shown(start_map, number, level)
    return seed_sources(prepared, output, seed)


def seed_sources(prepared: Prepared, output: OutputLevel, seed: int) -> Indices:
    """Return sources for a grid of seed points of an output (PlantSeed, Fig. 5), -1 elsewhere."""
    level, step = prepared.levels[output.number], 2**output.number
    pyramid, matches = level.pyramid, prepared.method.matches
    spacing = max(1, round(prepared.seed_spacing / step))
    places, y, x = plant_seeds(pyramid, output.known.shape, output.wrap, spacing, matches, seed)
    source = np.full(output.known.shape, -1, np.int32)
    v, u = np.divmod(pyramid.to_sample(places), pyramid.shape[1])
    source[np.ix_(y, x)] = level.at(v * step, u * step)
    return source


def plant_seeds(
    pyramid: Windows,
    shape: tuple[int, ...],
    wrap: tuple[bool, bool],
    spacing: int,
    matches: int,
    seed: int,
) -> tuple[Indices, NDArray[np.intp], NDArray[np.intp]]:
    """Sample seed points by stochastic tiling with unit tiles (section 3, Fig. 5).

    Returns places (rows, columns), flat indices into `pyramid.pixels`, and the y and x of points
    `spacing` pixels apart. Each slot takes one of the `matches` tiles with the best corners.
    """
    y, x = (_grid(*axis, spacing) for axis in zip(shape, wrap, strict=True))
    bits = draw(seed, "seed point", *np.indices((len(y), len(x))))
    tiles = _unit_tiles(pyramid, spacing)
    if not len(tiles):
        return pyramid.centers[bits % np.uint64(len(pyramid.centers))], y, x
    flat = pyramid.pixels.reshape(-1, pyramid.pixels.shape[2])
    colors = flat[tiles].astype(np.int64)
    # Beyond the end of an axis lies one more row of points, or the first one again.
    rows, columns = (len(n) + (not wraps) for n, wraps in zip((y, x), wrap, strict=True))
    points = np.full((rows, columns), -1, np.int32)
    for i, j in np.ndindex(bits.shape):
        corners = [(v % rows, u % columns) for v in (i, i + 1) for u in (j, j + 1)]
        slot = np.array([points[corner] for corner in corners])
        there = slot >= 0
        distance = ((colors - flat[slot]) ** 2).sum(axis=2) @ there
        # At the first slot nothing tells tiles apart.
        best = np.argsort(distance, kind="stable")[: matches if there.any() else None]
        tile = tiles[best[int(bits[i, j] % np.uint64(len(best)))]]
        for corner, place in zip(corners, tile, strict=True):
            if points[corner] < 0:
                points[corner] = place
    return points[: len(y), : len(x)], y, x


def _grid(length: int, wraps: bool, spacing: int) -> NDArray[np.intp]:
    """Places of the points along an axis."""
    if not wraps:
        return np.arange(0, length, spacing)
    count = max(1, round(length / spacing))
    return np.arange(count) * length // count


def _unit_tiles(pyramid: Windows, spacing: int) -> Indices:
    """Corners (n, 4) of the sample's unit tiles: upper left and right, lower left and right."""
    width = pyramid.usable.shape[1]
    if spacing >= min(pyramid.usable.shape):  # padding by it may not fit in memory
        return np.empty((0, 4), np.int32)
    usable = np.pad(pyramid.usable, (0, spacing))
    y, x = np.divmod(pyramid.centers, width)
    on_grid = ((y - y.min()) % spacing == 0) & ((x - x.min()) % spacing == 0)
    y, x = y[on_grid], x[on_grid]
    whole = usable[y + spacing, x] & usable[y, x + spacing] & usable[y + spacing, x + spacing]
    corner = (y * width + x)[whole > 0]
    steps = np.array([0, spacing, spacing * width, spacing * width + spacing], np.int32)
    tiles: Indices = (corner[:, None] + steps).astype(np.int32)
    return tiles


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
                starts[name] = parse_method(name).fit(exemplar)
        except InvalidInputError as error:
            failure = error
    if failure is not None and not (starts or may_fail):
        raise InvalidInputError(f"init: {failure}")
    return starts


def _by_lattice(exemplar: Exemplar) -> list[str]:
    """Near-regular synthesis with the sample's lattice, if that is sure."""
    lattice = sure_lattice(exemplar)
    return [] if lattice is None else [text_of(METHODS["near-regular"](lattice=tuple(lattice)))]


def starts_for(prepared: Prepared, canvas: Canvas) -> list[str]:
    """Name the starts for a canvas, the one that suits it best first; none plants seed points."""
    starts, names = prepared.starts, list(prepared.starts)
    if prepared.by_canvas and names and is_strained(starts[names[0]], canvas):
        names.reverse()
    return names


def result_of(prepared: Prepared, growth: Growth) -> tuple[str, Indices | None]:
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


def hole_start(name: str, hole: Mask, exemplar: Exemplar) -> Model:
    """Return the start's model, with parameters that suit a hole where `init` leaves them open."""
    given = None if " " in name else frozenset[str]()
    return parse_method(name).for_hole(hole, exemplar.usable, given).fit(exemplar)


def start_window(starts: dict[str, Model], box: Box, asked: PlaneRequest) -> Indices | None:
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


def keep_patches(sources: Indices, belt: int, windows: Windows, growth: Growth) -> None:
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
    source: Indices, reach: int, wrap: tuple[bool, bool], period: tuple[int, int] | None = None
) -> Mask:
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
