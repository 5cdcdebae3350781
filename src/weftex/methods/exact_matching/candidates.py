"""Where exact neighborhood matching looks: windows that have the colour of a direct neighbour."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.exact_matching import match_kernels as _exact_kernels
from weftex.random import draw
from weftex.raster.masks import grown
from weftex.search.color_index import ColorIndex
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.exact_matching import ExactMatching

    Guide = tuple[NDArray[np.uint8], NDArray[np.int32]]

#: The direct neighbours of figure 2, and the next pixel, which is there where a row wraps around.
CAUSAL = [(0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1)]
#: All eight, for what is made between known pixels.
AROUND = [*CAUSAL, (1, 1), (1, 0), (1, -1)]

#: How far windows between known pixels reach at most: a layer is decided by what is near to it.
AROUND_REACH = 7

#: How far the window over the next coarser level reaches, in pixels of the finer one.
GUIDE_REACH = 4

_KEPT = 8  # looked-up colours


class Candidates:
    """The reduced search space of section 3, made ready by the analysis of section 4.1.

    Parameters
    ----------
    method : ExactMatching
        With its window width settled.
    sample : Exemplar
        The sample, or a coarser version of it.
    causal : bool
        Windows are L-shaped, as in figure 2; otherwise they look to all sides, not as far.
    guide : uint8 array (H, W, K), optional
        The next coarser level at the sample's own size; its windows are compared too.

    Attributes
    ----------
    windows : Windows
        The whole windows. A neighbour's source may go on up to the last of them.
    starts : int32 array (len(offsets), C + 1)
        The groups of colour c beside the centre at offset d are starts[d, c] to starts[d, c + 1].
    groups : int32 array (n + 1,)
        The places of group g are places[groups[g] : groups[g + 1]]; the first stands for all.
    places : int32 array
        Flat indices into the pixels of the windows.
    """

    def __init__(
        self,
        method: ExactMatching,
        sample: Exemplar,
        causal: bool,
        guide: NDArray[np.uint8] | None = None,
    ) -> None:
        assert method.window_width is not None
        # The coarser levels of a pyramid have room for smaller windows only.
        r = (min(method.window_width, *sample.shape) - 1) // 2
        if not causal:
            r = min(r, AROUND_REACH)
        self.causal, self.reach = causal, r
        self.guide_reach = min(r, GUIDE_REACH) if guide is not None else 0
        self.windows = windows_of(sample, (r, self.guide_reach if causal else r, r, r))
        self.index = ColorIndex(self.windows.pixels, self._with_room())
        self.radius = method.radius(self.index)
        self.offsets = np.array(CAUSAL if causal else AROUND, np.int32)
        starts, places = self.index.centres(self.offsets)
        self.starts, self.groups, self.places = self._group(starts, places, method.grouping)
        empty = np.empty((0, 0, self.windows.pixels.shape[2]), np.uint8)
        self.guide = empty if guide is None else self._padded(guide)

    def _with_room(self) -> NDArray[np.uint8]:
        """Centres that can be gone on with downwards for half a window.

        A jump to the last rows of a sample ends there at once, and the next jump lands in the same
        rows: they would be repeated over and over.
        """
        usable = self.windows.usable
        if not self.causal or self.windows.period[2] or not self.reach:
            return usable
        room = np.zeros_like(usable)
        room[: -self.reach] = usable[: -self.reach] & usable[self.reach :]
        return room if room.any() else usable

    def _padded(self, guide: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The guide's pixels for those of the windows."""
        top, left, height, width = self.windows.period
        if not height:
            return guide
        rows, columns = self.windows.usable.shape
        y, x = (np.arange(rows) - top) % height, (np.arange(columns) - left) % width
        return np.ascontiguousarray(guide[np.ix_(y, x)])

    def _group(
        self, starts: NDArray[np.int32], places: NDArray[np.int32], grouping: float
    ) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
        """Make one entry of places whose windows are alike (section 4.4)."""
        runs = self.runs()
        pixels = self.windows.pixels
        if not len(runs):
            return starts, np.arange(len(places) + 1, dtype=np.int32), places
        size = int(runs[:, 2].sum()) * pixels.shape[2]
        sums = self._sums(runs)[places]
        for row in starts:
            lists = np.repeat(np.arange(len(row) - 1), np.diff(row))
            part = slice(row[0], row[-1])
            order = np.lexsort((sums[part], lists))
            places[part], sums[part] = places[part][order], sums[part][order]
        limit = int(grouping * grouping * 255 * 255 * size)
        leader = np.empty(len(places), np.int32)
        query, heads = np.empty(size, np.uint8), np.empty(len(places), np.int32)
        for row in starts:
            _exact_kernels.group_places(
                pixels, row, places, sums, runs, size, limit, query, heads, leader
            )
        order = np.argsort(leader, kind="stable")
        new = np.flatnonzero(np.diff(leader[order], prepend=-1))
        groups = np.append(new, len(places)).astype(np.int32)
        # A list's groups lie where its places were, so that its first group is the first leader
        # that is not before it.
        return np.searchsorted(leader[order][new], starts).astype(np.int32), groups, places[order]

    def _sums(self, runs: NDArray[np.int32]) -> NDArray[np.int64]:
        """The sum of the bytes of each whole window."""
        pixels = self.windows.pixels
        along = np.zeros((pixels.shape[0], pixels.shape[1] + 1), np.int64)
        along[:, 1:] = pixels.sum(axis=2, dtype=np.int64).cumsum(axis=1)
        y, x = np.divmod(self.windows.centres, pixels.shape[1])
        total = np.zeros(self.windows.usable.size, np.int64)
        for dy, dx, length in runs.tolist():
            total[self.windows.centres] += along[y + dy, x + dx + length] - along[y + dy, x + dx]
        return total

    def runs(self) -> NDArray[np.int32]:
        """The whole window: rows (dy, dx, length)."""
        r = self.reach
        rows = [(dy, -r, 2 * r + 1) for dy in range(-r, 0)]
        rows += [(0, -r, r)]
        if not self.causal:
            rows += [(0, 1, r)] + [(dy, -r, 2 * r + 1) for dy in range(1, r + 1)]
        return np.array([row for row in rows if row[2]], np.int32).reshape(-1, 3)

    def put(self, sheet: Sheet, where: Any, places: NDArray[np.int32]) -> None:
        """Put pixels of the sample on a sheet; `places` are flat indices into the sample."""
        source = self.windows.from_sample(places)
        sheet.levels[where] = self.windows.pixels.reshape(-1, sheet.levels.shape[2])[source]
        sheet.source[where] = source
        sheet.done[where] = 1
        self.name_colors(sheet)

    def name_colors(self, sheet: Sheet) -> None:
        """Find the colour numbers of what is known, where need be that of the nearest colour.

        Of a large picture only those are looked for that touch something unknown.
        """
        wanted = (sheet.color < 0) & (sheet.done > 0) & grown(sheet.done == 0, 1, sheet.wrap)
        source = sheet.source[wanted]
        number = self.index.number.ravel()[source]
        strange = source < 0
        number[strange] = self.index.nearest(sheet.levels[wanted][strange])
        sheet.color[wanted] = number

    def whole(self, places: NDArray[np.int32]) -> NDArray[np.int32]:
        """Turn flat indices into the sample into those of the windows; -1 where none is centred."""
        found = self.windows.from_sample(places)
        usable = self.windows.usable.ravel()[found] > 0
        return np.where((places >= 0) & usable, found, np.int32(-1))


class Sheet:
    """A picture in the making.

    Attributes
    ----------
    levels : uint8 array (H, W, K)
        What distances are taken on.
    done : uint8 array (H, W)
        1 where a pixel is known or made.
    source : int32 array (H, W)
        Flat index into the pixels of the candidates' windows, or -1.
    color : int32 array (H, W)
        Number of the colour, or -1.
    wrap : (bool, bool)
        Whether the vertical and the horizontal axis go around.
    """

    def __init__(self, shape: tuple[int, int], channels: int, wrap: tuple[bool, bool]) -> None:
        self.wrap = wrap
        self.levels = np.zeros((*shape, channels), np.uint8)
        self.done = np.zeros(shape, np.uint8)
        self.source = np.full(shape, -1, np.int32)
        self.color = np.full(shape, -1, np.int32)


class Matching:
    """Makes pixels of a sheet.

    Parameters
    ----------
    candidates : Candidates
        Where to look.
    sheet : Sheet
        What to fill.
    method : ExactMatching
        Settled.
    seed : int
        Breaks ties.
    stage : str
        What the random bits are for.
    guide : (uint8 array (H, W, K), int32 array (H, W)), optional
        The next coarser level at the sheet's size, and where in the sample it leads to.
    """

    def __init__(
        self,
        candidates: Candidates,
        sheet: Sheet,
        method: ExactMatching,
        seed: int,
        stage: str,
        guide: Guide | None = None,
    ) -> None:
        self.candidates, self.sheet = candidates, sheet
        self._method, self._seed, self._stage, self._guide = method, seed, stage, guide
        windows, channels = candidates.windows, sheet.levels.shape[2]
        self._coarse = candidates.guide[:0], np.empty((0, 0), np.int32)
        if guide is not None:
            self._coarse = guide[0], candidates.whole(guide[1])
        self._everywhere = np.ones(self._coarse[1].shape, np.uint8)
        self._coarse_room = _window_room(candidates.guide_reach, channels)
        self._room = _window_room(candidates.reach, channels)
        self._last = np.full(windows.usable.shape, -1, np.int32)
        made = np.flatnonzero(sheet.source >= 0)
        np.maximum.at(self._last.ravel(), sheet.source.ravel()[made], made)
        self._seen = np.zeros(windows.usable.shape, np.int32)
        self._stamp = 0
        self._kept = np.full((_KEPT, 3), -1, np.int32)
        self._intervals = np.empty((_KEPT, len(candidates.index.colors) + 2), np.int32)

    def again(self, stage: str) -> Matching:
        """For a further pass over the same sheet."""
        about = self._method, self._seed, stage, self._guide
        return Matching(self.candidates, self.sheet, *about)

    def make(self, order: NDArray[np.int32]) -> int:
        """Choose a source for the pixels of these flat indices, one after the other.

        Returns
        -------
        int
            How many windows were compared.
        """
        c, sheet, method = self.candidates, self.sheet, self._method
        stamps = 2 * len(order)  # a pixel takes one or two
        if self._stamp > 2**31 - 1 - stamps:
            self._seen[:], self._kept[:], self._stamp = 0, -1, 0
        tested: int = _exact_kernels.match_pixels(
            order, draw(self._seed, self._stage, order), c.causal, *sheet.wrap, c.reach,
            method.repeat_distance, c.causal and method.copying == "blocks",
            method.candidates,
            sheet.levels, sheet.done, sheet.source, sheet.color,
            c.windows.pixels, c.windows.usable, c.windows.period, c.windows.centres, c.index.number,
            c.offsets, c.starts, c.groups, c.places, c.radius,
            c.index.colors, c.index.low, c.index.high, c.index.depth,
            self._coarse[0], c.guide, self._everywhere, c.guide_reach, self._coarse[1],
            *self._coarse_room, self._last, self._seen, self._stamp, *self._room,
            self._kept, self._intervals,
        )  # fmt: skip
        self._stamp += stamps
        return tested


def _window_room(reach: int, channels: int) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
    """Space for the runs and the bytes of a window."""
    side = 2 * reach + 1
    return np.empty((side * (reach + 1) + 1, 3), np.int32), np.empty(
        side * side * channels, np.uint8
    )
