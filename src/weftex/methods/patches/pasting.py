"""The output of a patch method in the making."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import get_ident
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.methods.patches.analysis import PatchAnalysis, Zones
from weftex.methods.patches.patch_kernels import Patches, Tolerance, lay_patches
from weftex.methods.patches.scan_order import Order, Run, frame_of, scan_patches, scan_pixels
from weftex.methods.patches.spiral_order import spiral_patches
from weftex.notes import is_asked, note, pixel_asked
from weftex.progress import Progress, ProgressCallback
from weftex.results.paste_kernels import Layout
from weftex.search.zone_kernels import Shortlist
from weftex.search.zone_search import ZoneSearch

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Output:
    """A canvas while it is covered with patches.

    `plane` makes the order of the patches of a plane's window; by default the canvas determines it.
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
        self.analysis, self.method = analysis, analysis.method
        self.frame = frame_of(self.method, canvas)
        self._threads, self._callback = threads, callback
        self._zones = Zones(analysis, self.frame.boundary_width)
        # (H, W, K): the frame as it is matched; 0 where nothing was pasted
        self.pixels = np.zeros((*self.frame.shape, analysis.pixels.shape[2]), np.uint8)
        if self.frame.known is not None and plane is None:
            self.pixels[self.frame.inside] = self._known_pixels()
        self.order = plane(self._zones) if plane else self._order(seed)
        # (n, 5): y, x of each patch, y, x of its source, number of its zone
        self.placements = np.zeros((len(self.order.corners), 5), np.int32)
        self.placements[:, :2] = self.order.corners
        # (n, 2 * (rows + columns)) or (0, 0): minimum-error paths, see `PatchSynthesis`
        self.cuts = np.zeros((0, 0), np.uint16)
        if self.method.blend == "cut" and not self.method.pixelwise:
            self.cuts = np.zeros((len(self.placements), 2 * sum(self.frame.window)), np.uint16)
        self._patches = Patches(
            analysis.pixels,
            analysis.turned,
            self.placements,
            self.cuts,
            self.order.bits,
            self.order.around,
            self.method.keep_apart,
        )
        self._room: dict[int, dict[str, Any]] = {}  # of `Shortlist`; each thread has its own

    def _order(self, seed: int) -> Order:
        """The order of the patches by the canvas."""
        if self.frame.known is not None:
            return spiral_patches(self.frame, self._zones, seed)
        if self.method.pixelwise:
            return scan_pixels(self.frame, self._zones, seed)
        return scan_patches(self.frame, self._zones, seed, self._threads)

    def _known_pixels(self) -> NDArray[np.uint8]:
        """The known pixels of the canvas, as they are matched."""
        exemplar, canvas = self.analysis.exemplar, self.frame.canvas
        if canvas.shown is not None:  # a block of a plane
            return self.analysis.pixels[np.divmod(canvas.shown, exemplar.shape[1])]
        if exemplar.maps:
            raise InvalidInputError("a hole's surroundings lack the sample's maps; use weftex.fill")
        assert canvas.known is not None
        return exemplar.as_matching(canvas.known, self.method.edge_weight)

    def in_order(self, lay: Callable[[Run], None]) -> None:
        """Call `lay` with every run of the order, in threads where runs are independent."""
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

    def windows_for(self, run: Run) -> ZoneSearch:
        """Return the sample's windows, arranged to be searched by the boundary zone of a run."""
        return self._zones.searches[run.zone]

    def choose_and_paste(self, run: Run, windows: ZoneSearch, tolerance: Tolerance) -> None:
        """Choose the sources of a run's patches within a tolerance, and paste each patch."""
        self.placements[run.first : run.last, 4] = run.zone
        weights = self._zones.weights[run.zone]
        layout = Layout(self.placements, weights, self.cuts, *self.frame.shape)
        room = self._own_room()
        found = Shortlist(self.method.candidates or 0, **room)
        # A kd-tree is searched from Python, for one patch at a time; so are patches explained.
        one_by_one = windows.tree is not None or pixel_asked() is not None
        step = 1 if one_by_one else run.last - run.first
        for first in range(run.first, run.last, step):
            if windows.tree is not None:
                places = windows.nearest_in_tree(self.pixels, *self.placements[first, :2].tolist())
                room["places"][: len(places)] = places
            with self._explained(first, windows, room):
                lay_patches(
                    self.pixels, self._patches, first, first + step, layout, windows.kernel,
                    tolerance, found,
                )  # fmt: skip

    @contextmanager
    def _explained(self, number: int, windows: ZoneSearch, room: dict[str, Any]) -> Iterator[None]:
        """Tell whoever explains a pixel about the patch that is pasted over it."""
        (y, x), over = self.placements[number, :2].tolist(), self.frame.margin
        box = y - over[0], x - over[1], *self.frame.window
        if not is_asked(box, self.frame.canvas.shape):
            yield
            return
        before = self.pixels.copy()
        room["keys"].fill(-1)
        yield
        note(
            "patch", output=self, number=number, before=before, zone=windows.zone,
            errors=room["keys"].copy(), places=room["places"].copy(),
            columns=windows.usable.shape[1],
        )  # fmt: skip

    def _own_room(self) -> dict[str, Any]:
        """Return this thread's arrays of a `Shortlist`, large enough for any patch."""
        if get_ident() not in self._room:
            analysis, frame = self.analysis, self.frame
            numbers = frame.window[0] * frame.window[1] * analysis.pixels.shape[2]
            columns, count = analysis.exemplar.shape[1], self.method.candidates
            # 54 neighbors are climbed to at most from each stride.
            room = (
                count + 54 * analysis.block_side
                if count
                else len(analysis.windows(*frame.window)[1])
            )
            depth = max(frame.boundary_width, min(frame.window) // 2)  # of a band with a path
            self._room[get_ident()] = {
                "keys": np.empty(room, np.int64),
                "places": np.empty(room, np.int32),
                "query": np.empty(numbers, np.uint8),
                "means": np.empty(numbers, np.int32),
                "coordinates": np.empty(numbers, np.int16),
                "partial": np.empty(columns, np.int32),
                "total": np.empty(columns, np.int64),
                "barred": np.empty(room, np.uint8),
                "path": np.empty((max(frame.window), depth), np.int64),
            }
        return self._room[get_ident()]

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
        if self.method.blend == "feather-at-end" and not self.method.pixelwise:
            return None
        shape = *self.frame.canvas.shape, *exemplar.pixels.shape[2:]
        return self.pixels[self.frame.inside].reshape(shape)

    def _preview(self) -> NDArray[np.uint8]:
        return self.pixels[self.frame.inside][..., : self.analysis.exemplar.channels].copy()
