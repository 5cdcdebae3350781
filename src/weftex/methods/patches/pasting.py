"""The output of a patch method in the making."""

from __future__ import annotations

from collections.abc import Callable
from threading import get_ident
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.methods.patches import patch_kernels as _kernels
from weftex.methods.patches import sight_kernels
from weftex.methods.patches.analysis import PatchAnalysis, Zones
from weftex.methods.patches.scan_order import Order, Run, scan_patches, scan_pixels
from weftex.methods.patches.settings import Frame, frame_of
from weftex.methods.patches.spiral_order import spiral_patches
from weftex.notes import is_asked, note, pixel_asked
from weftex.progress import Progress, ProgressCallback
from weftex.results import paste_kernels
from weftex.search.zone_search import ZoneSearch
from weftex.search.zone_search_kernels import Sample

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Output:
    """A canvas as far as it is covered with patches.

    Parameters
    ----------
    analysis : PatchAnalysis
        Of the sample.
    canvas : Canvas
        What to make.
    seed : int
        For `weftex.random.draw`.
    threads : int
        At most so many.
    callback : callable or None
        See `weftex.progress.ProgressCallback`.
    plane : callable, optional
        The order of patches, where that is not by the canvas alone.

    Attributes
    ----------
    placements : int32 array (n, 5)
        y and x of each patch, y and x of its source, and the number of its zone.
    cuts : uint16 array (n, 2 * (rows + columns)) or (0, 0)
        Minimum-error paths, see `PatchSynthesis`.
    pixels : uint8 array (H, W, K)
        The frame as it is matched; 0 where nothing was laid.
    """

    def __init__(
        self,
        analysis: PatchAnalysis,
        canvas: Canvas,
        seed: int,
        threads: int,
        callback: ProgressCallback | None,
        plane: Callable[[Zones], Order] | None = None,
    ) -> None:
        self.analysis, self.settings = analysis, analysis.settings
        self.frame = frame_of(self.settings, canvas)
        self._threads, self._callback = threads, callback
        self._zones = Zones(analysis, self.frame.boundary_width)
        self.pixels = np.zeros((*self.frame.shape, analysis.pixels.shape[2]), np.uint8)
        known = self.frame.known
        if plane is not None:
            self.order = plane(self._zones)
        elif known is None and self.settings.pixelwise:
            self.order = scan_pixels(self.frame, self._zones, seed)
        elif known is None:
            self.order = scan_patches(self.frame, self._zones, seed, threads)
        else:
            shown = canvas.shown
            if analysis.exemplar.maps and shown is None:
                raise InvalidInputError(
                    "a hole's surroundings lack the sample's maps; use weftex.fill"
                )
            exemplar = analysis.exemplar
            if shown is None:
                matching = exemplar.as_matching(known, self.settings.edge_weight)
            else:  # a block of a plane
                matching = analysis.pixels[np.divmod(shown, exemplar.shape[1])]
            self.pixels[self.frame.inside] = matching
            self.order = spiral_patches(self.frame, self._zones, seed)
        self.placements = np.zeros((len(self.order.corners), 5), np.int32)
        self.placements[:, :2] = self.order.corners
        self.cuts = np.zeros((0, 0), np.uint16)
        if self.settings.blend == "cut" and not self.settings.pixelwise:
            size = len(self.placements), 2 * sum(self.frame.window)
            self.cuts = np.zeros(size, np.uint16)
        self._sample = Sample(analysis.pixels, analysis.turned)
        self._scratch: dict[int, Any] = {}  # each thread has its own

    def in_order(self, lay: Callable[[Run], None]) -> None:
        """Call `lay` with every run of the order, in threads where runs do not need each other."""
        order = self.order
        progress = Progress(self._callback, order.total, order.stage, self._preview)

        def lay_piece(piece: list[Run]) -> None:
            for run in piece:
                lay(run)

        if not order.parallel:
            for step in order.steps:
                for piece in step.pieces:
                    lay_piece(piece)
                progress.advance(step.done)
            return
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(self._threads) as pool:
            for step in order.steps:
                list(pool.map(lay_piece, step.pieces))
                progress.advance(step.done)

    def structure(self, run: Run) -> ZoneSearch:
        """The sample's windows, arranged by the boundary zone of a run."""
        return self._zones.searches[run.zone]

    def choose_and_paste(self, run: Run, structure: ZoneSearch, rule: Any) -> None:
        """Choose the patches of a run by a `patch_kernels.Rule`, and paste each."""
        self.placements[run.first : run.last, 4] = run.zone
        weight = self._zones.laid_with[run.zone]
        scratch = self._scratch.get(get_ident())
        if scratch is None:
            scratch = self._scratch[get_ident()] = _kernels.Scratch(
                wanted=self.settings.candidates, **room_for(self.analysis, self.frame)
            )
        # A kd-tree is searched from Python, for one patch at a time; kernels do a whole run, unless
        # somebody wants to see how a patch is chosen.
        one_by_one = structure.tree is not None or pixel_asked() is not None
        step = 1 if one_by_one else run.last - run.first
        for first in range(run.first, run.last, step):
            y, x = self.placements[first, :2].tolist()
            here = slice(first, first + step)
            placements, cuts = self.placements[here], self.cuts[here]
            patches = _kernels.Patches(
                placements=placements,
                cuts=cuts,
                layout=paste_kernels.Layout(placements, weight, cuts, *self.frame.shape),
                bits=self.order.bits[here],
                all_placements=self.placements,
                around=self.order.around[here],
                given=structure.ask_tree(self.pixels, y, x),
                sight=self._sight(here),
            )
            zone, search = structure.kernel_zone, structure.kernel_search
            top, left = (at - over for at, over in zip((y, x), self.frame.margin, strict=True))
            own, asked = scratch, is_asked((top, left, *self.frame.window), self.frame.canvas.shape)
            if asked:
                before, room = self.pixels.copy(), room_for(self.analysis, self.frame)
                room["keys"].fill(-1)
                own = _kernels.Scratch(wanted=self.settings.candidates, **room)
            _kernels.lay_patches(self.pixels, self._sample, zone, search, rule, patches, own)
            if asked:
                note(
                    "patch", output=self, number=first, before=before, zone=structure.zone,
                    errors=room["keys"], places=room["places"], columns=structure.usable.shape[1],
                )  # fmt: skip

    def _sight(self, here: slice) -> Any:
        """What the patches of a run see of those laid before them."""
        frame, exemplar = self.frame, self.analysis.exemplar
        around = (exemplar.tileable,) * 2
        turning = [
            np.where(wraps, shape, 0).astype(np.int32)
            for wraps, shape in ((frame.canvas.wrap, frame.shape), (around, exemplar.shape))
        ]
        window = np.array(frame.window, np.int32)
        return sight_kernels.Sight(
            self.settings.variety, self.placements, self.order.seen[here], window, *turning
        )

    def weights(self) -> NDArray[np.uint16]:
        """Weight of every zone's new pixels in 1/256: (zones, rows, columns)."""
        found = [search.zone.weight for search in self._zones.searches]
        return np.stack(found) if found else np.zeros((0, *self.frame.window), np.uint16)

    def picture(self) -> NDArray[np.uint8] | None:
        """The matched pixels where they are the picture itself, so that it need not be rendered."""
        exemplar = self.analysis.exemplar
        if self.pixels.dtype != exemplar.pixels.dtype or exemplar.mixing.kind:
            return None
        if self.pixels.shape[2] != exemplar.channels:
            return None
        if self.settings.blend == "feather-at-end" and not self.settings.pixelwise:
            return None
        shape = *self.frame.canvas.shape, *exemplar.pixels.shape[2:]
        return self.pixels[self.frame.inside].reshape(shape)

    def _preview(self) -> NDArray[np.uint8]:
        return self.pixels[self.frame.inside][..., : self.analysis.exemplar.channels].copy()


def room_for(analysis: PatchAnalysis, frame: Frame) -> dict[str, NDArray[Any]]:
    """Make the arrays of `patch_kernels.Scratch`, large enough for any patch of an output."""
    settings, window = frame.settings, frame.window
    numbers = window[0] * window[1] * analysis.pixels.shape[2]
    columns = analysis.exemplar.shape[1]
    room = len(analysis.windows(*window)[1])
    if settings.search != "exhaustive":
        room = settings.candidates + 54 * analysis.block_side  # as many are climbed to at most
    depth = max(frame.boundary_width, min(window) // 2)  # of a band that a path is found in
    return {
        "keys": np.empty(room, np.int64),
        "places": np.empty(room, np.int32),
        "partial": np.empty(columns, np.int32),
        "total": np.empty(columns, np.int64),
        "query": np.empty(numbers, np.uint8),
        "means": np.empty(numbers, np.int32),
        "coordinates": np.empty(numbers, np.int16),
        "costs": np.empty(room, np.float64),
        "barred": np.empty(room, np.uint8),
        "cost": np.empty((max(window), depth), np.int64),
    }
