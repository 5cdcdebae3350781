"""Joining blocks: seams along least error, or blending (section 4.2.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weftex.methods.near_regular import seam_kernels as kernels
from weftex.results.patches import PatchSynthesis, RectifiedSynthesis
from weftex.seams.boundary_kernels import Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.near_regular.holes import Hole
    from weftex.methods.near_regular.layout import Axis, Layout
    from weftex.methods.near_regular.sample import BlockSample
    from weftex.methods.near_regular.settings import Settings

    Each = Callable[..., Iterable[Any]]

_LINES = 4  # of blocks that a thread cuts at a time
_BOX = 3  # half the side of what is compared where four blocks meet


class Joints(NamedTuple):
    """How the blocks that can show are laid over each other, see `PatchSynthesis`.

    Attributes
    ----------
    cuts : uint16 array (rows, columns, n) or (0, 0)
        Of each block.
    zones : int64 array (rows, columns)
        Its row of `weights`.
    weights : uint16 array (zones, lines, columns)
        In 1/256.
    """

    cuts: NDArray[np.uint16]
    zones: NDArray[np.int64]
    weights: NDArray[np.uint16]


def cut_seams(
    sample: BlockSample,
    layout: Layout,
    hole: Hole,
    place: NDArray[np.int32],
    each: Each,
) -> Joints:
    """Cut blocks along the paths of least error through their overlaps (chapter 6).

    Which of two blocks a pixel at a hole's border belongs to also hangs on how well either would go
    on beyond it.
    """
    (lines, _), (across, _) = (a.laid(layout.reach) for a in (layout.rows, layout.columns))
    upright, lying = _paths(sample, layout, hole, place, each)
    zones = np.zeros(_shown_shape(layout), np.int64)
    weights = np.full((1, lines, across), 128, np.uint16)
    return Joints(_cuts(layout, upright, lying), zones, weights)


def _paths(
    sample: BlockSample,
    layout: Layout,
    hole: Hole,
    place: NDArray[np.int32],
    each: Each,
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Where blocks begin, for each line of their windows: from the left, and from above."""
    rows, columns = place.shape
    side, margin, reach = layout.rows.side, layout.rows.margin, layout.reach
    upright = np.full((rows, columns + 1, side), margin, np.int32)
    lying = np.full((rows + 1, columns, side), margin, np.int32)
    if reach == 0:
        return upright, lying
    least = min(int(axis.sizes.min()) for axis in (layout.rows, layout.columns))
    slack = min(reach // 2, (least - 1) // 4)
    seams = kernels.Seams(
        inset=margin - reach,
        reach=reach,
        slack=slack,
        box=min(_BOX, reach - slack),
        parity=int(layout.rows.numbers[0] + layout.columns.numbers[0]) % 2,
        corners=np.zeros((rows + 1, columns + 1, 2), np.int32),
        upright=upright,
        lying=lying,
        left=layout.columns.shown.start,
        right=layout.columns.shown.stop,
    )
    grid, around = layout.grid(place), kernels.Hole(hole.known, hole.state)
    still = kernels.Shown(sample.pixels, sample.visibility, place)

    def band() -> Band:
        return Band(
            np.empty((side, 2 * reach), np.int64),
            np.empty((side if len(hole.state) else 0, 2 * reach + 1), np.int64),
            np.empty((side, 2 * reach + 1), np.int64),
            np.empty((side, 2 * reach + 1), np.int32),
            np.empty(side, np.int32),
        )

    def meet(i: int) -> None:
        kernels.meet(still, grid, around, seams, band(), i, i + 1)

    def cut(lines: range) -> None:
        stop, own = min(lines.stop, layout.rows.shown.stop), band()
        kernels.cut_edges(still, grid, around, seams, True, own, lines.start, stop)
        kernels.cut_edges(still, grid, around, seams, False, own, lines.start, lines.stop)

    shown = range(layout.rows.shown.start, layout.rows.shown.stop + 1)
    list(each(meet, shown))
    list(each(cut, (shown[k : k + _LINES] for k in range(0, len(shown), _LINES))))
    return upright, lying


def _cuts(
    layout: Layout, upright: NDArray[np.int32], lying: NDArray[np.int32]
) -> NDArray[np.uint16]:
    """First and last own columns and rows of each block, as `PatchSynthesis` keeps them."""
    rows, columns = layout.rows.shown, layout.columns.shown
    after = [slice(s.start + 1, s.stop + 1) for s in (rows, columns)]
    left = upright[rows, columns]
    right = upright[rows, after[1]] + layout.columns.sizes[columns][None, :, None]
    top = lying[rows, columns]
    bottom = lying[after[0], columns] + layout.rows.sizes[rows][:, None, None]
    lines, first = layout.rows.laid(layout.reach)
    across, begin = layout.columns.laid(layout.reach)
    down = first[:, None, None] + np.arange(lines)
    along = begin[None, :, None] + np.arange(across)
    left, right = (
        np.clip(np.take_along_axis(c, np.broadcast_to(down, (*c.shape[:2], lines)), 2)
                - begin[None, :, None], 0, across)
        for c in (left, right)
    )  # fmt: skip
    top, bottom = (
        np.clip(np.take_along_axis(c, np.broadcast_to(along, (*c.shape[:2], across)), 2)
                - first[:, None, None], 0, lines)
        for c in (top, bottom)
    )  # fmt: skip
    y = layout.rows.edges[:-1][rows][:, None, None] - layout.rows.margin + down
    x = layout.columns.edges[:-1][columns][None, :, None] - layout.columns.margin + along
    height, width = layout.canvas.shape
    if not layout.rows.period:
        off = np.broadcast_to((y < 0) | (y >= height), left.shape)
        left, right = np.where(off, across, left), np.where(off, 0, right)
    if not layout.columns.period:
        off = np.broadcast_to((x < 0) | (x >= width), top.shape)
        top, bottom = np.where(off, lines, top), np.where(off, 0, bottom)
    return np.concatenate([left, right, top, bottom], axis=2).astype(np.uint16)


def blend_linearly(settings: Settings, layout: Layout) -> Joints:
    """Feather blocks over the blending area (section 4.2.3); one of no width pastes them."""
    zones = np.zeros(_shown_shape(layout), np.int64)
    known: dict[tuple[Any, ...], int] = {}
    weights = []
    rows, columns = (_profiles(settings, layout, a) for a in (layout.rows, layout.columns))
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            kind = row.kind, column.kind
            if kind not in known:
                known[kind] = len(known)
                weights.append(_weights(row, column))
            zones[i, j] = known[kind]
    return Joints(np.zeros((0, 0), np.uint16), zones, np.stack(weights))


class _Profile(NamedTuple):
    """The share that a block has of each line of its window, along one axis.

    Two profiles of the same `kind` have the same shares. An odd block is of the second kind of its
    row or column.
    """

    kind: tuple[int, ...]
    share: NDArray[np.float64]
    odd: bool


def _profiles(settings: Settings, layout: Layout, axis: Axis) -> list[_Profile]:
    """Alpha of eqs. (4.9) and (4.10) from both sides of each block that can show."""
    width, side, margin = settings.blend_width, settings.side, settings.margin
    width = min(width, 2 * layout.reach)
    lines, firsts = axis.laid(layout.reach)
    found = []
    shown = range(axis.shown.start, axis.shown.stop)
    for block, first in zip(shown, firsts.tolist(), strict=True):
        size, start = int(axis.sizes[block]), int(axis.edges[block]) - margin
        # x of eq. (4.9), 1 at the first line that is blended
        at = np.arange(side) - margin + width // 2 + 1
        share = np.clip(at, 0, width + 1) / (width + 1)
        share -= np.clip(at - size, 0, width + 1) / (width + 1)
        low, high = 0, side
        if not axis.period:
            low, high = max(0, -start), min(side, axis.length - start)
            share[:low] = share[max(high, 0) :] = 0
        odd = bool(axis.numbers[block] % 2)
        found.append(_Profile((size, low, high, odd), share[first : first + lines], odd))
    return found


def _weights(row: _Profile, column: _Profile) -> NDArray[np.uint16]:
    """Weights in 1/256 that lay four kinds of blocks, one after the other, as eqs. 4.6 to 4.8 say.

    Every corner of a block meets one block of each kind. A block's weight is its share over the sum
    of its own share and the shares of the blocks laid before it.
    """
    shares = {}
    for odd_y in (False, True):
        for odd_x in (False, True):
            y = row.share if odd_y == row.odd else 1 - row.share
            x = column.share if odd_x == column.odd else 1 - column.share
            # Drawn ones of even rows, drawn ones of odd rows, gaps of even rows, of odd rows.
            shares[2 * (odd_y != odd_x) + odd_y] = np.outer(y, x)
    kind = 2 * (row.odd != column.odd) + row.odd
    own = shares[kind]
    before = sum(shares[k] for k in range(kind + 1))
    result = np.rint(256 * own / np.where(own > 0, before, 1))
    return result.astype(np.uint16)


def keep_known(layout: Layout, hole: Hole, joints: Joints) -> Joints:
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


def lay_blocks(
    sample: BlockSample,
    layout: Layout,
    place: NDArray[np.int32],
    joints: Joints,
    provenance: dict[str, Any],
    laid: NDArray[np.bool_],
) -> PatchSynthesis:
    """Lay blocks by kind: drawn ones of even rows, of odd rows, then the gaps."""
    rows, columns = layout.rows.shown, layout.columns.shown
    margin = layout.rows.margin
    place = place[rows, columns]
    place = sample.windows.to_sample(place.ravel()).reshape(place.shape)
    i, j = np.indices(place.shape)
    height, width = sample.exemplar.shape
    y, x = np.divmod(place, width)
    v = layout.rows.laid(layout.reach)[1][i]
    u = layout.columns.laid(layout.reach)[1][j]
    placements = np.stack(
        [
            (layout.rows.edges[:-1][rows][i] - margin + v) % layout.canvas.height,
            (layout.columns.edges[:-1][columns][j] - margin + u) % layout.canvas.width,
            (y + v) % height,
            (x + u) % width,
            joints.zones,
        ],
        axis=-1,
    )
    kind = 2 * layout.gap[rows, columns] + layout.rows.numbers[rows][:, None] % 2
    order = np.argsort(kind.ravel(), kind="stable")
    order = order[laid[rows, columns].ravel()[order]]
    placements = placements.reshape(-1, 5)[order].astype(np.int32)
    cuts = joints.cuts
    if cuts.ndim == 3:
        cuts = np.ascontiguousarray(cuts.reshape(kind.size, -1)[order])
    about: dict[str, Any] = {"seed": layout.seed}
    if any(layout.origin):
        about["origin"] = list(layout.origin)
    if any(layout.canvas.wrap):
        about["strain"] = round(layout.lattice.strain, 6)
    if layout.reach < margin:  # blocks of a small canvas that goes around
        about["border_narrowed_to"] = 2 * layout.reach
    told: dict[str, Any] = {
        "sample_shape": sample.exemplar.shape,
        "exemplar": sample.exemplar,
        "known_from": layout.canvas.known_from,
        "provenance": provenance | about,
    }
    plan = layout.canvas, np.ascontiguousarray(placements), joints.weights, cuts
    lookup = sample.lookup
    if lookup is None:
        return PatchSynthesis(*plan, **told)
    return RectifiedSynthesis(*plan, lookup=lookup, **told)


def _shown_shape(layout: Layout) -> tuple[int, int]:
    rows, columns = layout.rows.shown, layout.columns.shown
    return rows.stop - rows.start, columns.stop - columns.start
