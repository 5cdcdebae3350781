"""Iterative refinement (the paper on texture refinement and fusion, sections 3 and 6)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weft.analysis.scale import dominant_scale
from weft.exemplar import Exemplar
from weft.method import METHODS, Method, Model, parameter
from weft.methods import _refinement_kernels
from weft.methods.pixel_growth import Growth, PixelModel, settle_window
from weft.methods.seed_points import plant_seeds
from weft.random import draw
from weft.search.pyramid import gaussian_pyramid, mask_pyramid
from weft.search.similar import nearest_centre, similar_places
from weft.search.windows import Windows, windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

_REACH = 3  # pixels from the centre of a window to its side, on every level
_TRIED = 2**23  # comparisons of the first iteration, about so many in all


@dataclass(frozen=True)
class Refinement(Method):
    """Iterative refinement.

    A grid of seed points, or the result of another method, is refined again and again: every
    pixel takes the place of the sample whose window is most like its own.

    Examples
    --------
    >>> import numpy as np, weft
    >>> sample = weft.Exemplar(np.random.default_rng(0).integers(0, 255, (48, 48), np.uint8))
    >>> weft.Refinement(iterations=2).fit(sample).sample((60, 80), seed=7).image.shape
    (60, 80)
    """

    slug: ClassVar[str] = "refinement"
    title: ClassVar[str] = "Iterative refinement"
    paper: ClassVar[str] = (
        "Iterative texture refinement and texture fusion: window size estimation, seed point "
        "planting, iterative refinement"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known"})

    window_width: int | None = parameter(
        None,
        "side of the square window, odd; a pyramid stands for what does not fit into 7 pixels",
        low=3,
        unit="px",
        default_text="twice the sample's dominant scale",
    )
    iterations: int = parameter(
        10, "at most so many; twice as many on the coarsest level", low=1, high=1000
    )
    threshold: float = parameter(
        0.01, "epsilon: stop when an iteration changes the picture by less (eq. 1)", low=0.0
    )
    init: str = parameter(
        "seeds",
        "start from a grid of seed points, or from another method's result",
        choices=("seeds", "quilting", "patch-sampling", "ashikhmin"),
    )
    seed_density: float = parameter(
        1.0,
        "seed points for each dominant scale along an axis",
        low=0.1,
        high=10.0,
        needs=("init", ("seeds",)),
    )
    matches: int = parameter(
        5, "k: a seed point is drawn from so many best tiles", low=1, needs=("init", ("seeds",))
    )
    similar: int = parameter(
        2, "places like its own that each candidate brings along", low=0, high=32
    )
    evenness: float = parameter(
        1.0, "how much what has been used too often counts as worse", low=0.0, high=100.0
    )

    def fit(self, exemplar: Exemplar) -> RefinementModel:
        """Analyse a sample: its dominant scale, and for each place the places like it."""
        return RefinementModel(self, exemplar)


@dataclass(frozen=True, eq=False)
class Level:
    """One level of the sample's pyramid.

    Attributes
    ----------
    windows : Windows
        The sample at this level.
    reach : int
        Windows have 2 * reach + 1 pixels a side.
    similar : int32 array (H' * W', k)
        See `similar_places`.
    centre : int32 array (H', W')
        See `nearest_centre`.
    cells : int32 array (H' * W')
        The sample is cut into squares as large as its structure, to see how evenly it is used.
    """

    windows: Windows
    reach: int
    similar: NDArray[np.int32]
    centre: NDArray[np.int32]
    cells: NDArray[np.int32]


class RefinementModel(PixelModel):
    """A sample prepared for iterative refinement.

    Attributes
    ----------
    scale : float
        Half of the window: the dominant scale in pixels.
    levels : list of Level
        From the finest to the coarsest.
    """

    def __init__(self, method: Refinement, exemplar: Exemplar) -> None:
        proposed = 3 if method.window_width else dominant_scale(exemplar).window_width
        settled: Refinement = settle_window(method, exemplar, proposed)
        super().__init__(settled, exemplar)
        width: int = settled.window_width  # type: ignore[assignment]
        self.scale = width / 2
        self.start: Model | None = None
        if settled.init != "seeds":
            self.start = METHODS[settled.init]().fit(exemplar)
        depth = 1
        while (2 * _REACH + 1) * 2 ** (depth - 1) < width and min(exemplar.shape) >> depth > 4 * _REACH:
            depth += 1
        tiles = (exemplar.tileable,) * 2
        pictures = gaussian_pyramid(exemplar.matching(), depth, tiles)
        mask = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
        masks = mask_pyramid(mask, depth, tiles)
        while not masks[-1].any():
            masks.pop()
        self.levels: list[Level] = []
        coarser = None
        for k in range(len(masks) - 1, -1, -1):
            level = self._level(pictures[k], masks[k], k, coarser, settled.similar)
            self.levels.insert(0, level)
            coarser = level.windows, level.similar
        self.windows = self.levels[0].windows

    def _level(
        self,
        pixels: NDArray[np.uint8],
        mask: NDArray[np.bool_],
        number: int,
        coarser: tuple[Windows, NDArray[np.int32]] | None,
        similar: int,
    ) -> Level:
        exemplar = Exemplar(pixels, mask=mask, tileable=self.exemplar.tileable, alpha=False)
        reach = min(_REACH, (min(pixels.shape[:2]) - 1) // 2)
        windows = windows_of(exemplar, (reach,) * 4, pixels)
        side = max(1, round(self.scale / 2**number))
        y, x = np.indices(windows.usable.shape)
        cells = y // side * (x.max() // side + 1) + x // side
        return Level(
            windows,
            reach,
            similar_places(windows, reach, similar if coarser is None else min(similar, 1), coarser),
            nearest_centre(windows),
            cells.astype(np.int32).ravel(),
        )

    def grow(self, growth: Growth) -> None:
        """Refine from the coarsest level to the finest."""
        Refining(self, growth).run()


class Refining:
    """One output in the making, level by level."""

    def __init__(self, model: RefinementModel, growth: Growth) -> None:
        self.model, self.growth, self.method = model, growth, model.method
        self.wrap = growth.canvas.wrap
        depth = len(model.levels)
        self.known = mask_pyramid(growth.done.astype(bool), depth, self.wrap)
        self.pictures = gaussian_pyramid(growth.levels, depth, self.wrap)
        self.curve: list[dict[str, float]] = []
        lines = [len(_lines(~known)) for known in self.known]
        rounds = [self._rounds(k) for k in range(depth)]
        total = sum(n * r for n, r in zip(lines, rounds, strict=True))
        self.progress = growth.progress(total, "lines")

    def run(self) -> None:
        """Refine the start until it stays as it is, on each level."""
        source = None
        for number in range(len(self.model.levels) - 1, -1, -1):
            source = self._refine_level(number, source)
        self.growth.source[:] = source
        self.growth.levels[:] = self.pictures[0]
        self.growth.about["convergence"] = self.curve

    def _rounds(self, number: int) -> int:
        """Structure is settled on the coarsest level, where iterations cost least."""
        if number == len(self.model.levels) - 1:
            return 2 * self.method.iterations
        return max(1, self.method.iterations // 2)

    def _refine_level(self, number: int, coarser: NDArray[np.int32] | None) -> NDArray[np.int32]:
        level = self.model.levels[number]
        picture, known = self.pictures[number], self.known[number]
        source = self._start(number, known) if coarser is None else self._children(number, coarser)
        flat = level.windows.pixels.reshape(-1, picture.shape[2])
        picture[~known] = flat[source[~known]]
        source[known] = self._own_places(number)[known]
        done = (known | (source >= 0)).astype(np.uint8)
        lines = _lines(~known)
        made = source[~known & (source >= 0)]
        usage = np.bincount(level.cells[made], minlength=level.cells.max() + 1).astype(np.int32)
        room = np.bincount(level.cells[level.windows.centres], minlength=len(usage))
        share = max(1.0, np.count_nonzero(~known) / len(level.windows.centres))
        capacity = np.maximum(room * share, 1).astype(np.int32)
        above = len(self.model.levels) - 1 - number
        weight = round(1024 * self.method.evenness / 4**above)
        width = 2 * level.reach + 1
        runs = np.zeros((max(width, 3) * (max(width, 3) + 1), 3), np.int32)
        query = np.zeros(runs.shape[0] * picture.shape[2], np.uint8)
        places = np.zeros(10 * (1 + level.similar.shape[1]), np.int32)
        given = np.zeros((1, 0), np.int32)
        for turn in range(self._rounds(number)):
            before = picture.copy()
            first = coarser is None and turn == 0
            changed = 0
            for order in _turned(lines, turn, picture.shape[:2], self.growth.hole is not None):
                if first:
                    given = self._tried(level, int(order[0]), known)
                changed += _refinement_kernels.refine_pixels(
                    picture,
                    done,
                    source,
                    order,
                    self.wrap,
                    level.windows.pixels,
                    level.windows.usable,
                    level.windows.period,
                    level.reach,
                    level.similar,
                    given,
                    level.cells,
                    usage,
                    capacity,
                    weight,
                    runs,
                    query,
                    places,
                )
                self.progress.advance(1)
            given = given[:, :0]
            if self._note(number, turn, changed, before, picture, known):
                self.progress.advance((self._rounds(number) - 1 - turn) * len(lines))
                break
        return source

    def _start(self, number: int, known: NDArray[np.bool_]) -> NDArray[np.int32]:
        """Seed points, or another method's result as far as this level shows it."""
        level, growth = self.model.levels[number], self.growth
        source = np.full(known.shape, -1, np.int32)
        if self.model.start is None:
            if growth.hole is None:  # a hole starts from its border
                density = 2**number * self.method.seed_density
                spacing = max(1, round(self.model.scale / density))
                grid = plant_seeds(
                    level.windows, known.shape, spacing, self.method.matches, growth.seed
                )
                source[::spacing, ::spacing] = grid
            return source
        made = self.model.start.sample(growth.canvas, seed=growth.seed, threads=growth.threads)
        step = 2**number
        y, x = np.moveaxis(made.source[::step, ::step] // step, -1, 0)
        return _nearest(level, y, x)

    def _children(self, number: int, coarser: NDArray[np.int32]) -> NDArray[np.int32]:
        """The source of each pixel goes on from its parent's."""
        windows, level = self.model.levels[number + 1].windows, self.model.levels[number]
        y, x = np.indices(self.known[number].shape)
        v, u = np.divmod(coarser[y // 2, x // 2], windows.pixels.shape[1])
        top, left = windows.period[:2]
        return _nearest(level, 2 * (v - top) + y % 2, 2 * (u - left) + x % 2)

    def _own_places(self, number: int) -> NDArray[np.int32]:
        """Where known pixels are in the sample, if they are; sources of their neighbours go on."""
        step = 2**number
        index = self.model.windows.to_sample(self.growth.source)[::step, ::step]
        y, x = np.divmod(index, self.model.exemplar.shape[1])
        place = _nearest(self.model.levels[number], y // step, x // step)
        return np.where(index < 0, np.int32(-1), place)

    def _tried(self, level: Level, line: int, known: NDArray[np.bool_]) -> NDArray[np.int32]:
        """Places that the first iteration tries at every pixel: all, if they are not too many."""
        centres = level.windows.centres
        count = max(_TRIED // np.count_nonzero(~known), 64)
        if count < len(centres):
            bits = draw(self.growth.seed, "tried place", line, np.arange(count))
            centres = centres[bits % np.uint64(len(centres))]
        return centres[None]

    def _note(
        self,
        number: int,
        turn: int,
        changed: int,
        before: NDArray[np.uint8],
        after: NDArray[np.uint8],
        known: NDArray[np.bool_],
    ) -> bool:
        """Add a point to the curve of Fig. 7; return whether to stop by eq. (1).

        As printed (1) grows with the picture and divides by 0 on black; this is its mean over
        the pixels that are made, and no pixel counts as darker than one level.
        """
        old, new = before[~known].astype(np.float64), after[~known].astype(np.float64)
        step = ((new - old) ** 2).sum(axis=1)
        ratio = np.sqrt(step / np.maximum((old**2).sum(axis=1), 1))
        count = len(step)
        # Summed as integers, so that every machine stops at the same iteration.
        difference = int(np.rint(ratio * 2**20).astype(np.int64).sum()) / 2**20 / count
        self.curve.append(
            {
                "level": number,
                "iteration": turn + 1,
                "changed": changed / count,
                "difference": difference,
                "mse": float(step.sum()) / (count * before.shape[2]),
            }
        )
        return turn > 0 and difference < self.method.threshold


def _lines(wanted: NDArray[np.bool_]) -> list[NDArray[np.int32]]:
    """Flat indices of the wanted pixels, row by row, without empty rows."""
    width = wanted.shape[1]
    rows = np.flatnonzero(wanted.any(axis=1))
    return [(y * width + np.flatnonzero(wanted[y])).astype(np.int32) for y in rows]


def _turned(
    lines: list[NDArray[np.int32]], turn: int, shape: tuple[int, int], cyclic: bool
) -> list[NDArray[np.int32]]:
    """The lines in the order of an iteration: to and fro, or from all four sides (Fig. 12)."""
    if not cyclic:
        return [line[::-1].copy() for line in lines[::-1]] if turn % 2 else lines
    if turn % 2:
        every = np.concatenate(lines)
        turned = np.zeros(shape[::-1], bool)
        turned[every % shape[1], every // shape[1]] = True
        lines = [(k % shape[0] * shape[1] + k // shape[0]) for k in _lines(turned)]
    if turn % 4 > 1:
        lines = [line[::-1] for line in lines[::-1]]
    return [np.ascontiguousarray(line, np.int32) for line in lines]


def _nearest(level: Level, y: NDArray[Any], x: NDArray[Any]) -> NDArray[np.int32]:
    """The window nearest to a place of the sample at this level."""
    top, left = level.windows.period[:2]
    height, width = level.centre.shape
    result: NDArray[np.int32] = level.centre[
        np.clip(y + top, 0, height - 1), np.clip(x + left, 0, width - 1)
    ]
    return result
