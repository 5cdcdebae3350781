"""Holes: the same steps, with blocks that go on with the known pixels around."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.methods.near_regular import gap_kernels
from weftex.methods.near_regular.blocks import (
    draw_constrained_blocks,
    kernel_gap,
    kernel_sample,
    kernel_search,
)
from weftex.methods.near_regular.sample import NO_FEATURES, Border, shuffled
from weftex.methods.near_regular.seams import Around, Joints, blend_linearly, cut_seams, lay_blocks
from weftex.methods.near_regular.warps import warp_gaps
from weftex.progress import Progress, ProgressCallback
from weftex.raster.masks import grown
from weftex.search.boundary_zone import runs_over

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.near_regular.layout import Layout
    from weftex.methods.near_regular.sample import BlockSample
    from weftex.methods.near_regular.settings import Settings
    from weftex.results.patches import PatchSynthesis

    Each = Callable[..., Iterable[Any]]

_HOLE, _BESIDE, _OFF = 0, 1, 2  # the kernels' states of a pixel
_KNOWN = 5  # and their wedge of pixels that are known


@dataclass(frozen=True, eq=False)
class Hole:
    """The blocks that fill a hole, and what is known around it.

    Attributes
    ----------
    missing : bool array (H, W)
        True in the hole.
    near : bool array (H, W)
        Known pixels that count: as near to the hole as a border is wide.
    around : Around
        The known pixels as seams see them.
    laid : bool array (rows, columns)
        Blocks that have some of the hole in their windows.
    bound : bool array (rows, columns)
        Those of them that would be drawn but see known pixels, so that they are not random.
    """

    missing: NDArray[np.bool_]
    near: NDArray[np.bool_]
    around: Around
    laid: NDArray[np.bool_]
    bound: NDArray[np.bool_]


def fill_hole(
    settings: Settings,
    sample: BlockSample,
    layout: Layout,
    known: NDArray[Any],
    missing: NDArray[np.bool_],
    provenance: dict[str, Any],
    each: Each,
    callback: ProgressCallback | None,
) -> PatchSynthesis:
    """Fill a hole of a canvas.

    Blocks that see known pixels take the piece that fits those best, drawn ones too; only those
    in the midst of a hole are random. Which of two blocks a pixel of the hole's border belongs to
    also hangs on how well either would go on beyond it.

    Parameters
    ----------
    known : array (H, W) or (H, W, C)
        The canvas's pixels.
    missing : bool array (H, W)
        True in the hole.

    Raises
    ------
    InvalidInputError
        If the sample has no whole piece for a block.
    """
    hole = _hole(settings, sample, layout, known, missing)
    _check(settings, sample, layout, hole)
    about = settings, sample, layout, hole
    place = _known_places(sample, layout, hole)
    place = _fit(*about, place, np.argwhere(hole.bound), "blocks", each, callback)
    free = hole.laid & ~layout.gap & ~hole.bound
    place = draw_constrained_blocks(sample, layout, place, free)
    place = _fit(*about, place, np.argwhere(layout.gap & hole.laid), "gaps", each, callback)
    warps = None
    if settings.warp:
        warps = warp_gaps(settings, sample, layout, place, each, hole.laid)
    if settings.blend == "cut":
        joints = cut_seams(sample, layout, place, each, warps, hole.around)
    else:
        joints = blend_linearly(settings, layout)
    joints = _covered(layout, hole, joints)
    return lay_blocks(sample, layout, place, joints, provenance, warps, hole.laid)


def _hole(
    settings: Settings,
    sample: BlockSample,
    layout: Layout,
    known: NDArray[Any],
    missing: NDArray[np.bool_],
) -> Hole:
    wrap = layout.canvas.wrap
    near = grown(missing, 2 * settings.margin or 1, wrap) & ~missing
    state = np.where(missing, _HOLE, _OFF).astype(np.uint8)
    state[grown(missing, 1, wrap) & ~missing] = _BESIDE
    laid = _seen(layout, missing)
    pixels = np.ascontiguousarray(sample.exemplar.as_known(known))
    bound = laid & ~layout.gap & _seen(layout, near)
    return Hole(missing, near, Around(pixels, state), laid, bound)


def _seen(layout: Layout, mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which blocks have some of these pixels in their windows."""
    result = np.zeros(layout.bits.shape, bool)
    for i in range(layout.rows.shown.start, layout.rows.shown.stop):
        y, inside = layout.rows.lines(i)
        row: NDArray[np.bool_] = np.any(mask[y[inside]], axis=0)
        for j in range(layout.columns.shown.start, layout.columns.shown.stop):
            x, within = layout.columns.lines(j)
            result[i, j] = row[x[within]].any()
    return result


def _check(settings: Settings, sample: BlockSample, layout: Layout, hole: Hole) -> None:
    """Refuse a hole for a block of which the sample has no whole piece."""
    if settings.unconstrained:
        return
    for i, j in np.argwhere(hole.laid).tolist():
        if not _whole(sample, (layout.phase[i, j] + sample.steps + 2**15) >> 16).any():
            y, x = max(int(layout.rows.edges[i]), 0), max(int(layout.columns.edges[j]), 0)
            side, name = settings.side, sample.exemplar.name
            raise InvalidInputError(
                f"no whole piece of {side}x{side} pixels that the lattice leads to from x {x}, "
                f"y {y} lies on usable pixels of {name}; make block_size and border_width "
                "smaller, cover less with the mask, or give a sample to fill it from"
            )


def _whole(sample: BlockSample, places: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether whole windows lie at these places."""
    windows = sample.windows
    if windows.period[2]:
        places = places % windows.period[2:]
    inside: NDArray[np.bool_] = np.all((places >= 0) & (places < windows.usable.shape), axis=-1)
    inside[inside] = windows.usable[places[inside, 0], places[inside, 1]] > 0
    return inside


def _known_places(sample: BlockSample, layout: Layout, hole: Hole) -> NDArray[np.int32]:
    """Places of blocks beside the hole that are part of the sample: they are not shown again."""
    result = np.full(layout.bits.shape, -1, np.int32)
    if layout.canvas.known_from is None:
        return result
    beside = grown(hole.laid, 1, (layout.rows.period > 0, layout.columns.period > 0)) & ~hole.laid
    cells = np.argwhere(beside)
    place = np.stack([layout.rows.edges[cells[:, 0]], layout.columns.edges[cells[:, 1]]], axis=1)
    place += np.array(layout.canvas.known_from) - layout.rows.margin
    windows = sample.windows
    there = _whole(sample, place)
    if windows.period[2]:
        place = place % windows.period[2:]
    flat = place[:, 0] * windows.pixels.shape[1] + place[:, 1]
    result[cells[there, 0], cells[there, 1]] = flat[there]
    return result


def _fit(
    settings: Settings,
    sample: BlockSample,
    layout: Layout,
    hole: Hole,
    place: NDArray[np.int32],
    cells: NDArray[np.int64],
    stage: str,
    each: Each,
    callback: ProgressCallback | None,
) -> NDArray[np.int32]:
    """Choose these blocks by all that is there around them (section 4.2.2)."""
    place = place.copy()
    bundle, grid = kernel_sample(sample), layout.grid(place)
    search = kernel_search(settings, NO_FEATURES)
    progress = Progress(callback, len(cells), stage, lambda: layout.preview(sample, place))

    def fit(cell: NDArray[np.int64]) -> None:
        i, j = cell.tolist()
        border, known = _border(settings, sample, layout, hole, i, j)
        if settings.unconstrained and len(border.runs) == 0:
            centers = sample.windows.centers
            place[i, j] = centers[int(layout.bits[i, j] % np.uint64(len(centers)))]
            return
        gap = kernel_gap(settings, NO_FEATURES, border, known)
        own = np.array([[i, j]], np.int32)
        gap_kernels.fill_gaps(bundle, grid, sample.steps, own, search, gap)

    for _ in each(fit, cells):
        progress.advance(1)
    return place


def _border(
    settings: Settings, sample: BlockSample, layout: Layout, hole: Hole, i: int, j: int
) -> tuple[Border, NDArray[np.uint8]]:
    """The border of a block: that of a gap in the hole, and all known pixels; and those."""
    height, width, margin = int(layout.rows.sizes[i]), int(layout.columns.sizes[j]), settings.margin
    wedges = np.zeros((height + 2 * margin, width + 2 * margin), np.uint8)
    if layout.gap[i, j]:
        wedges[:] = sample.border(height, width, margin, layout.reach).wedges
    y, inside = layout.rows.lines(i, wedges.shape[0])
    x, within = layout.columns.lines(j, wedges.shape[1])
    there, at = inside[:, None] & within, np.ix_(y, x)
    wedges[~there | ~hole.missing[at]] = 0
    wedges[there & hole.near[at]] = _KNOWN
    known = np.ascontiguousarray(hole.around.known[at])
    return Border(wedges, shuffled(runs_over(wedges > 0))), known


def _covered(layout: Layout, hole: Hole, joints: Joints) -> Joints:
    """Known pixels stay: blocks have no weight there."""
    lines, first = layout.rows.laid(layout.reach)
    across, begin = layout.columns.laid(layout.reach)
    zones, found = joints.zones.copy(), dict[bytes, int]()
    weights = [np.zeros_like(joints.weights[0])]
    rows, columns = layout.rows.shown, layout.columns.shown
    for i, j in np.argwhere(hole.laid[rows, columns]).tolist():
        y, inside = layout.rows.lines(i + rows.start)
        x, within = layout.columns.lines(j + columns.start)
        shown = hole.missing[np.ix_(y, x)] & inside[:, None] & within
        v, u = int(first[i]), int(begin[j])
        weight = joints.weights[zones[i, j]] * shown[v : v + lines, u : u + across]
        key = weight.tobytes()
        if key not in found:
            found[key] = len(weights)
            weights.append(weight)
        zones[i, j] = found[key]
    return Joints(joints.cuts, zones, np.stack(weights))
