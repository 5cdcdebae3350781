"""An endless plane of a material, made block by block by any method that fills holes.

A block is the method's answer to a hole: the pixels around it are known, with their positions in
the sample. Its random numbers depend only on the plane's seed and on the block, so the order in
which blocks are made does not matter; `weftex.endless.grid` says which blocks there are.
"""

from __future__ import annotations

import sys
from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from threading import Lock
from typing import Any, Protocol
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.endless.boxes import Box, PlaneRequest, Span, around, canvas_of, check_period
from weftex.endless.corners import SamplePieces
from weftex.endless.grid import ACROSS, CORNER, DOWN, Axis, Block, Grid, Sizes
from weftex.exemplar import Exemplar
from weftex.progress import Progress, ProgressCallback
from weftex.random import draw
from weftex.raster.arrays import Bytes, Ints, Mask
from weftex.raster.boxes import whole_windows
from weftex.results.pixels import PixelSynthesis, frame_of
from weftex.results.synthesis import Synthesis
from weftex.threads import thread_map

#: Bytes of blocks that are kept for each model.
MOST_BYTES = 2**27
_MOST_AT_ONCE = 2**24  # pixels of a start
_FEWEST = 2  # blocks around a plane that repeats


class BlockCache:
    """A thread-safe cache of arrays with at most `most` bytes; the least recently used go first.

    Of two threads that want one block, one computes it and the other waits.
    """

    def __init__(self, most: int) -> None:
        self.most, self.size = most, 0
        self._lock = Lock()
        self._kept: OrderedDict[Hashable, Future[NDArray[Any]]] = OrderedDict()

    def __contains__(self, key: Hashable) -> bool:
        return key in self._kept

    def get(self, key: Hashable, make: Callable[[], NDArray[Any]]) -> NDArray[Any]:
        """Return what is kept under a key, or make it."""
        with self._lock:
            found = self._kept.get(key)
            making = self._kept.setdefault(key, Future())
            self._kept.move_to_end(key)
        if found is not None:
            return found.result()
        try:
            made = make()
        except BaseException as error:
            with self._lock:
                del self._kept[key]
            making.set_exception(error)
            raise
        made.setflags(write=False)
        making.set_result(made)
        with self._lock:
            self.size += made.nbytes
            for old in [*self._kept] if self.size > self.most else ():
                if self.size > self.most and old != key and self._kept[old].done():
                    self.size -= self._kept.pop(old).result().nbytes
        return made


class Filler(Protocol):
    """What a model must have so that a plane can be made of it."""

    method: Any
    exemplar: Exemplar

    def block_sizes(self) -> Sizes:
        """Return the sizes of its blocks."""

    def start_of(self, box: Box, asked: PlaneRequest) -> NDArray[np.int32] | None:
        """Return what blocks are made from, as flat indices (H, W) of the sample, if anything."""

    def sample(self, size: Canvas, *, seed: int, threads: int) -> Synthesis:
        """Fill a canvas."""


_KEPT: WeakKeyDictionary[Any, tuple[BlockCache, SamplePieces | None]] = WeakKeyDictionary()


def kept_of(model: Filler) -> tuple[BlockCache, SamplePieces | None]:
    """The cache of a model, and where its corners are cut from, if the sample is large enough."""
    found = _KEPT.get(model)
    if found is None:
        usable = usable_corners(model.exemplar, model.block_sizes().belt)
        vectors = getattr(model.method, "lattice", None) or ()
        pieces = SamplePieces(model.exemplar, usable, vectors) if usable.any() else None
        found = _KEPT.setdefault(model, (BlockCache(MOST_BYTES), pieces))
    return found


def usable_corners(exemplar: Exemplar, belt: int) -> Bytes:
    """1 at the top left corners of the squares of `belt` pixels that may be copied."""
    last = belt - 1
    mask = exemplar.usable
    if exemplar.tileable:
        mask = np.pad(mask, (0, last), mode="wrap")
    height, width = exemplar.shape
    return whole_windows(mask, (0, last, 0, last))[:height, :width]


class Plane:
    """One plane: a model, a seed and a period; a subclass may name its blocks by another rule."""

    half_line = 1  # pixels on both sides of a line between nodes, which is joined by itself

    def __init__(self, model: Filler, asked: PlaneRequest, grid: Grid | None = None) -> None:
        self.model, self.asked = model, asked
        if grid is None:
            sizes = model.block_sizes()
            self.grid = Grid(sizes, *axes_of(sizes, asked.period))
            self.cache, self.pieces = kept_of(model)
        else:
            self.grid, self.cache, self.pieces = grid, BlockCache(sys.maxsize), None
        self._start: tuple[Box, NDArray[np.int32]] | None = None
        self._pixels = model.exemplar.pixels.reshape(-1, *model.exemplar.pixels.shape[2:])

    def window(
        self, box: Box, canvas: Canvas, callback: ProgressCallback | None = None
    ) -> PixelSynthesis:
        """A window `box` as a result, with the rest of the cells in which its steps are spread."""
        exemplar, reach = self.model.exemplar, getattr(self.model.method, "tone_reach", 0.0)
        cells, frame = None, box
        if reach or any(r.kind == "height" for r in (exemplar.role, *exemplar.roles.values())):
            half = self.half_line
            found = [
                (k, axis.node(i) + side - first)
                for k, (axis, (first, last)) in enumerate(zip(self.grid[1:], box, strict=True))
                for i in range(
                    axis.last_before(first + half), axis.last_before(last - half - 1) + 2
                )
                for side in (-half, half)
            ]
            cells = np.array(found, np.int64)
            ends = zip(box, frame_of(cells, box.shape), strict=True)
            frame = Box(*(Span(at.first + a, at.first + b) for at, (a, b) in ends))
        return PixelSynthesis(
            canvas,
            self.show(frame, callback, box),
            cells,
            exemplar=exemplar,
            is_window=True,
            tone_reach=reach,
            provenance=self.model.method.describe() | self.asked.told,
        )

    def show(
        self, box: Box, callback: ProgressCallback | None = None, seen: Box | None = None
    ) -> NDArray[np.int32]:
        """Flat indices (H, W) of the sample's pixels in a window; progress shows what is `seen`."""
        shown = np.full(box.shape, -1, np.int32)
        preview = shown[(seen or box).within(box)]
        blocks = list(self.grid.of_window(box))
        threads = max(1, min(self.asked.threads, len(blocks)))
        within = max(1, self.asked.threads // threads)
        progress = Progress(callback, len(blocks), "blocks", lambda: self._pixels[preview])
        self._begin(blocks)
        with thread_map(threads) as each:
            for block, made in zip(
                blocks, each(lambda block: self.block(block, within), blocks), strict=True
            ):
                paste(shown, box, made, self.grid.reached(block))
                progress.advance(1)
        return shown

    def _begin(self, blocks: list[Block]) -> None:
        """Ask for what all blocks begin with at once, which is cheaper than one by one."""
        new = [self.grid.seen(block) for block in blocks if self._key(block) not in self.cache]
        if not self.grid.sizes.around or not new:
            return
        box = around(new)
        if box.shape[0] * box.shape[1] <= _MOST_AT_ONCE:
            start = self.model.start_of(box, self.asked)
            self._start = None if start is None else (box, start)

    def _start_of(self, box: Box, threads: int) -> NDArray[np.int32] | None:
        """What a block begins with."""
        if self._start is not None and self._start[0].has(box):
            return self._start[1][box.within(self._start[0])].copy()
        return self.model.start_of(box, self.asked._replace(threads=threads))

    def _key(self, block: Block) -> tuple[Any, ...]:
        """What a block is kept under, and its name."""
        return self.asked.seed, self.asked.period, self.name(block)

    def name(self, block: Block) -> Block:
        """The block that is shown in place of this one: the same one for every time around."""
        down, across = self.grid.down, self.grid.across
        return Block(block.kind, down.name(block.row), across.name(block.column))

    def block(self, block: Block, threads: int = 1) -> NDArray[np.int32]:
        """Flat indices of a block with what it replaces; -1 where it shows nothing."""
        key = self._key(block)
        return self.cache.get(key, lambda: self.make(key[-1], threads))

    def make(self, block: Block, threads: int = 1) -> NDArray[np.int32]:
        """Make a block, and the blocks that it depends on."""
        seed = int(draw(self.asked.seed, "block", *block)[()])
        start = None
        seen, own, reached = (f(block) for f in (self.grid.seen, self.grid.own, self.grid.reached))
        if self.grid.sizes.around:
            start = self._start_of(seen, threads)
        if start is None:
            piece = self.piece(block) if block.kind == CORNER else None
            if piece is not None:
                return self._cut(piece, own)
            # Nothing is there beside corners and edges.
            seen = seen.grown(*(-self.grid.sizes.around * at_node for at_node in block.at_nodes))
            shown = np.full(seen.shape, -1, np.int32)
        else:
            shown = start
        for other in self.grid.dependencies(block):
            paste(shown, seen, self.block(other, threads), self.grid.reached(other))
        hole = hole_of(own, seen)
        loose = hole[reached.within(seen)]
        free = self._may_replace(block, loose.shape)
        loose |= free
        made = self._filled(shown, hole, seed, threads, self.origin(block, seen))
        result: NDArray[np.int32] = made[reached.within(seen)].copy()
        result[~(free | hole_of(own, reached))] = -1
        return result

    def piece(self, block: Block) -> Ints | None:
        """Row and column in the sample of what a corner shows; None if it is too small."""
        if self.pieces is None:
            return None
        own = self.grid.own(block)
        at = own.rows.first, own.columns.first
        found: Ints = self.pieces.pick(self.asked.seed, np.array([block[1:]]), np.array([at]))[0]
        return found

    def origin(self, block: Block, seen: Box) -> tuple[int, int]:
        """Where a block's canvas is on the plane of the sample's lattice."""
        return canvas_of(seen).origin

    def _cut(self, corner: Ints, own: Box) -> NDArray[np.int32]:
        """A piece of the sample, as it is."""
        shape = self.model.exemplar.shape
        v, u = (
            (first + np.arange(length)) % n
            for first, length, n in zip(corner, own.shape, shape, strict=True)
        )
        piece: NDArray[np.int32] = (v[:, None] * shape[1] + u).astype(np.int32)
        return piece

    def _may_replace(self, block: Block, shape: tuple[int, int]) -> Mask:
        """Which pixels that are there a block may replace; edges leave each other their own."""
        free, loose = np.zeros(shape, bool), self.grid.sizes.loose
        if not loose or block.kind == CORNER:
            return free
        rows = slice(loose, -loose) if block.kind == ACROSS else slice(None)
        columns = slice(loose, -loose) if block.kind == DOWN else slice(None)
        free[rows, columns] = True
        return free

    def _filled(
        self, shown: NDArray[np.int32], hole: Mask, seed: int, threads: int, origin: tuple[int, int]
    ) -> NDArray[np.int32]:
        """Fill a hole by the method; `shown` has the pixels before, in the hole too."""
        height, width = shown.shape
        canvas = Canvas(height, width)
        if not hole.all() or (shown >= 0).any():
            known = self._pixels.take(shown, axis=0, mode="wrap")
            canvas = Canvas(height, width, known=known, hole=hole, shown=shown, origin=origin)
        made = self.model.sample(canvas, seed=seed, threads=threads)
        if isinstance(made, PixelSynthesis):
            flat = made.index
        else:
            y, x = np.moveaxis(made.pictured_source(), -1, 0)
            flat = y * np.int32(self.model.exemplar.shape[1]) + x
        return np.where(hole, flat, shown)


def hole_of(own: Box, within: Box) -> Mask:
    """Where a box lies in a larger one."""
    hole = np.zeros(within.shape, bool)
    hole[own.within(within)] = True
    return hole


def paste(shown: NDArray[np.int32], box: Box, block: NDArray[np.int32], place: Box) -> None:
    """Paste a block over the pixels of a box."""
    part = block[box.within(place)]
    here = shown[place.within(box)]
    np.copyto(here, part, where=part >= 0)


def axes_of(sizes: Sizes, period: tuple[int, int] | None) -> tuple[Axis, Axis]:
    """The nodes of a plane down and across; raises if the period is too short for blocks."""
    if period is None:
        return Axis(sizes.pitch, 1), Axis(sizes.pitch, 1)
    check_period(period, 2 * _FEWEST * sizes.belt)
    axes = [Axis(length, max(_FEWEST, length // sizes.pitch), wraps=True) for length in period]
    return axes[0], axes[1]
