"""Texture analysis (section 4.1): from a color to the windows that have it beside their center."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError, size_words
from weftex.exemplar import Exemplar
from weftex.methods.exact_matching import list_kernels as kernels
from weftex.methods.exact_matching.color_index import ColorIndex
from weftex.methods.exact_matching.defaults import reach_of
from weftex.progress import counted
from weftex.search.picture_kernels import Query
from weftex.search.pyramid_windows import sample_pyramid
from weftex.search.windows import Windows, windows_of

#: The direct neighbors of figure 2, and the next pixel, which is there where a row wraps around.
CAUSAL_NEIGHBORS = [(0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1)]
#: All eight direct neighbors, for pixels that are made between known ones.
ALL_NEIGHBORS = [*CAUSAL_NEIGHBORS, (1, 1), (1, 0), (1, -1)]

_SMALLEST_SIDE = 5  # of the coarsest level, in pixels
_KEPT_LISTS = 8  # of colors looked up last: at least as many as there are direct neighbors


@dataclass(frozen=True, eq=False)
class ColorLists:
    """Lists of windows by color: the slices of the search space (section 3, figure 3)."""

    # L-shaped windows, as in figure 2; otherwise windows reach to all sides, not as far
    causal: bool
    reach: int  # pixels from the center of a window to its side
    coarse_reach: int  # the same on the next coarser level; 0 without one
    windows: Windows  # the whole windows; sources may continue up to the last of them
    index: ColorIndex  # the kd-tree of figure 4
    # (C,): for each color, the squared distance of colors that match it (section 5)
    radius: NDArray[np.int64]
    offsets: NDArray[np.int32]  # (d, 2): dy and dx of the direct neighbors
    # (d, C + 1): groups of color c at offset d are starts[d, c] to starts[d, c + 1]
    starts: NDArray[np.int32]
    # (n + 1,): group g is places[groups[g] : groups[g + 1]]; the first leads it
    groups: NDArray[np.int32]
    places: NDArray[np.int32]  # flat indices into the pixels of the windows
    # (H, W, K): the next coarser level at each pixel; (0, 0, K) without one
    coarse: NDArray[np.uint8]

    def for_kernels(self) -> kernels.Lists:
        """Return the lists for kernels, and space for the lists that are looked up (4.4)."""
        kept = np.full((_KEPT_LISTS, 3), -1, np.int32)
        intervals = np.empty((_KEPT_LISTS, len(self.index.colors) + 2), np.int32)
        return kernels.Lists(self, kept, intervals)


def color_lists(
    method: Any, sample: Exemplar, *, causal: bool, coarser: Exemplar | None = None
) -> ColorLists:
    """Return the windows of a level of the sample, listed by the colors of the direct neighbors.

    With `coarser`, the next coarser level, its windows are compared too.
    """
    width, guided = method.window_width, coarser is not None
    reaches, coarse_reach = reach_of(width, sample, causal=causal, guided=guided)
    windows, reach = windows_of(sample, reaches), reaches[0]
    index = ColorIndex(
        windows.pixels, _with_room_below(windows, reach) if causal else windows.usable
    )
    offsets = np.array(CAUSAL_NEIGHBORS if causal else ALL_NEIGHBORS, np.int32)
    starts, places = index.centers_beside(offsets)
    runs = _whole_window(reach, causal)
    if len(runs):
        starts, groups, places = _grouped(windows, runs, starts, places, method.grouping)
    else:
        groups = np.arange(len(places) + 1, dtype=np.int32)
    return ColorLists(
        causal=causal,
        reach=reach,
        coarse_reach=coarse_reach,
        windows=windows,
        index=index,
        radius=_radius(method, index),
        offsets=offsets,
        starts=starts,
        groups=groups,
        places=places,
        coarse=_expanded(coarser, sample, windows),
    )


def _with_room_below(windows: Windows, reach: int) -> NDArray[np.uint8]:
    """Return (H, W) centers, 1 where the sample continues downward for half a window.

    A jump to the last rows would end there at once, and the next would repeat the same rows.
    """
    usable = windows.usable
    if windows.period[2] or not reach:
        return usable
    room = np.zeros_like(usable)
    room[:-reach] = usable[:-reach] & usable[reach:]
    return room if room.any() else usable


def _radius(method: Any, index: ColorIndex) -> NDArray[np.int64]:
    """The squared distance up to which colors count as each color (section 5)."""
    if method.nearest_colors:
        return index.reach(method.nearest_colors)
    limit = int(method.tolerance * method.tolerance * index.span)
    return np.full(len(index.colors), limit, np.int64)


def _expanded(coarser: Exemplar | None, sample: Exemplar, windows: Windows) -> NDArray[np.uint8]:
    """The coarser level's pixels for those of the windows."""
    if coarser is None:
        return np.empty((0, 0, windows.pixels.shape[2]), np.uint8)
    top, left = windows.period[:2]
    y, x = (np.arange(n) for n in windows.usable.shape)
    y, x = (y - top) % sample.shape[0] // 2, (x - left) % sample.shape[1] // 2
    return np.ascontiguousarray(coarser.pixels[np.ix_(y, x)])


def _whole_window(reach: int, causal: bool) -> NDArray[np.int32]:
    """The runs of a whole window: rows (dy, dx, length)."""
    rows = [(dy, -reach, 2 * reach + 1) for dy in range(-reach, 0)]
    rows += [(0, -reach, reach)]
    if not causal:
        rows += [(0, 1, reach)] + [(dy, -reach, 2 * reach + 1) for dy in range(1, reach + 1)]
    return np.array([row for row in rows if row[2]], np.int32).reshape(-1, 3)


def _grouped(
    windows: Windows,
    runs: NDArray[np.int32],
    starts: NDArray[np.int32],
    places: NDArray[np.int32],
    grouping: float,
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Return `starts`, `groups`, `places` with similar windows grouped (section 4.4)."""
    size = int(runs[:, 2].sum()) * windows.pixels.shape[2]
    sums = _window_sums(windows, runs)[places]
    for row in starts:
        lists = np.repeat(np.arange(len(row) - 1), np.diff(row))
        part = slice(row[0], row[-1])
        order = np.lexsort((sums[part], lists))
        places[part], sums[part] = places[part][order], sums[part][order]
    limit = int(grouping * grouping * 255 * 255 * size)
    leader = np.empty(len(places), np.int32)
    query, heads = Query(runs, np.empty(size, np.uint8)), np.empty(len(places), np.int32)
    for row in starts:
        kernels.group_places(windows.pixels, query, places, sums, row, limit, heads, leader)
    order = np.argsort(leader, kind="stable")
    new = np.flatnonzero(np.diff(leader[order], prepend=-1))
    groups = np.append(new, len(places)).astype(np.int32)
    # A list's groups lie where its places were, so that its first group is the first leader
    # that is not before it.
    return np.searchsorted(leader[order][new], starts).astype(np.int32), groups, places[order]


def _window_sums(windows: Windows, runs: NDArray[np.int32]) -> NDArray[np.int64]:
    """The sum of the bytes of each whole window."""
    pixels, centers = windows.pixels, windows.centers
    along = np.zeros((pixels.shape[0], pixels.shape[1] + 1), np.int64)
    along[:, 1:] = pixels.sum(axis=2, dtype=np.int64).cumsum(axis=1)
    y, x = np.divmod(centers, pixels.shape[1])
    total = np.zeros(windows.usable.size, np.int64)
    for dy, dx, length in runs.tolist():
        total[centers] += along[y + dy, x + dx + length] - along[y + dy, x + dx]
    return total


@dataclass(frozen=True, eq=False)
class LevelSample:
    """A level of the sample's pyramid; its lists are built at first use."""

    method: Any
    sample: Exemplar
    coarser: Exemplar | None

    @cached_property
    def causal(self) -> ColorLists:
        """Lists of L-shaped windows."""
        return color_lists(self.method, self.sample, causal=True, coarser=self.coarser)

    @cached_property
    def around(self) -> ColorLists:
        """Lists of windows that look to all sides, for pixels between known ones."""
        return color_lists(self.method, self.sample, causal=False, coarser=self.coarser)

    @cached_property
    def turned(self) -> ColorLists:
        """Lists of L-shaped windows of the sample with its axes exchanged."""
        return color_lists(self.method, _turned(self.sample), causal=True)


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for exact neighborhood matching.

    `windows` are of one pixel, so indices are the sample's own. `levels` are finest first.
    """

    method: Any
    windows: Windows
    levels: tuple[LevelSample, ...]


def prepare(method: Any, exemplar: Exemplar) -> Prepared:
    """Return the analysis of a sample (section 4.1) at each of its levels."""
    windows = windows_of(exemplar, (0, 0, 0, 0))
    samples = sample_pyramid(exemplar, method.levels)
    enough = len(samples)
    while enough > 1 and min(samples[enough - 1].shape) < _SMALLEST_SIDE:
        enough -= 1
    if enough < method.levels:
        raise InvalidInputError(
            f"levels is {method.levels}; {exemplar.name} is {size_words(exemplar.shape)}, "
            f"which is enough for {enough}"
        )
    coarser = [*samples[1:], None]
    levels = [LevelSample(method, *pair) for pair in zip(samples, coarser, strict=True)]
    with counted(len(levels), "colors") as step:
        for level in levels:
            _ = level.causal
            step(1)
    if method.init == "structured":
        _ = levels[-1].turned
    return Prepared(method, windows, tuple(levels))


def _turned(sample: Exemplar) -> Exemplar:
    """The sample with its axes exchanged."""
    mask = None if sample.mask is None else sample.mask.T
    turned = np.ascontiguousarray(sample.pixels.swapaxes(0, 1))
    return Exemplar(turned, mask=mask, tileable=sample.tileable, alpha=False, name=sample.name)
