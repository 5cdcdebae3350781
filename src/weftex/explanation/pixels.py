"""The methods that choose one pixel after the other at work, and refinement."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.explanation.drawing import (
    MAGENTA,
    UNKNOWN,
    choice_stages,
    colors,
    enlarged,
    made,
    window_around,
)
from weftex.explanation.stages import Recorder, Stage

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar

_DRAWS = 256  # that show which windows may be drawn
_CURVE = 64  # pixels a side of the drawing of the curve


class EfrosLeungRecorder(Recorder):
    """Records the layers, and how the pixel is drawn."""

    def __init__(self, exemplar: Exemplar, pixel: tuple[int, int]) -> None:
        super().__init__(exemplar, pixel)
        self._order: NDArray[np.int32] | None = None
        self._layer = 0

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """See `Recorder`."""
        growth = facts["growth"]
        if step == "layer":  # before it grows
            if self._order is None:
                self._order = np.full(growth.done.shape, -1, np.int32)
            self._order[(self._order < 0) & (growth.done > 0)] = self._layer
            self._layer += 1
            return
        windows, weights = growth.windows, facts["search"].weights
        window, known = window_around(
            growth.pixels, growth.done, self.pixel, len(weights) // 2, growth.canvas.wrap
        )
        place = np.full(_DRAWS, self.pixel[0] * growth.canvas.width + self.pixel[1], np.int32)
        bits = (np.arange(_DRAWS, dtype=np.uint64) << np.uint64(64 - 8)) + np.uint64(1)
        drawn = np.unique(facts["draw"](place, bits)[0])
        columns = windows.pixels.shape[1]
        y, x = divmod(int(facts["chosen"]), columns)
        picture = made(growth.pixels, growth.done)
        self.found = [
            Stage(
                "canvas",
                "The picture when the pixel's turn comes: it grows in layers (section III.A).",
                growth.pixels.copy(),
                enlarged(picture),
            ),
            *choice_stages(
                windows.pixels,
                window,
                known,
                np.stack(np.divmod(drawn, columns), axis=1),
                (y, x),
                words=(
                    "What is known in the window around the pixel, which is framed.",
                    (
                        "How much that differs from each window of the sample, the middle counting "
                        "most (a Gaussian): bright is alike, the pixel drawn is framed."
                    ),
                    (
                        "The pixels that may be drawn: those whose windows are within the "
                        "tolerance of the best. The one drawn is framed."
                    ),
                ),
                weights=weights,
            ),
        ]

    def stages(self) -> list[Stage]:
        """See `Recorder`."""
        if self._order is None:
            return self.found
        self._order[self._order < 0] = self._layer
        share = self._order / max(1, self._layer)
        picture = np.stack([255 * share, 90 + 0 * share, 255 * (1 - share)], axis=-1)
        order = Stage(
            "order of growth",
            "The layer that made each pixel, blue first: from a piece of the sample, or the border "
            "of a hole, and a pixel without a good match waits (section III.A).",
            self._order,
            enlarged(picture.astype(np.uint8)),
        )
        return [order, *self.found]


class WeiLevoyRecorder(Recorder):
    """Records at each level of the pyramid how the pixel or its parent is chosen."""

    def __init__(self, exemplar: Exemplar, pixel: tuple[int, int]) -> None:
        super().__init__(exemplar, pixel)
        self._levels: dict[int, list[Stage]] = {}

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """See `Recorder`."""
        level = facts["level"]
        number, at = level.number, f" of level {level.number}"
        y, x = (n >> number for n in self.pixel)
        if step == "window":
            self._tree, self._before = facts["tree"], level.pixels.copy()
            reach = int(np.abs(facts["own"]).max(initial=0))
            window, known = window_around(
                level.pixels, level.done, (y, x), reach, (facts["wrap"][0], facts["wrap"][1])
            )
            seen = np.zeros_like(known)
            seen[tuple((facts["own"] + reach).T)] = True
            self._window, self._known = window, known & seen
            return
        tree, chosen = self._tree, int(level.source[y, x])
        row = int(np.flatnonzero(tree.places == chosen)[0])
        path = path_to(tree.nodes, row)
        columns = level.sample.shape[1]
        own = level.sample.pixels.reshape(*level.sample.shape, -1)
        first, last = path[-1][1:]
        picture = colors(own)
        shade = np.zeros(level.sample.shape)
        for _, start, stop in path:
            shade.ravel()[tree.places[start:stop]] += 1
        picture = (picture * (0.25 + 0.75 * shade[..., None] / len(path))).astype(np.uint8)
        neighborhood, surface, candidates = choice_stages(
            own,
            self._window,
            self._known,
            np.stack(np.divmod(tree.places[first:last], columns), axis=1),
            divmod(chosen, columns),
            words=(
                "The causal neighborhood: above and to the left in scan order (section III.B.1).",
                (
                    "How much it differs from each of the level's sample: bright is alike. The "
                    "neighborhood of the parent counts too."
                ),
                "The windows in the leaf of the tree where the nearest was found.",
            ),
            at=at,
        )
        self._levels[number] = [
            Stage(
                "output" + at,
                "The level of the output's pyramid before the pixel is chosen: noise with the "
                "sample's histogram, or a copy of what its parents show (section III.B.2).",
                self._before,
                enlarged(colors(self._before)),
            ),
            neighborhood,
            surface,
            Stage(
                "tree" + at,
                f"The way down the tree of vectors: {len(path)} nodes from all windows of the "
                "sample to a leaf, each brighter than the one before (tree-structured vector "
                "quantization).",
                np.array(path),
                enlarged(picture),
            ),
            candidates,
        ]

    def stages(self) -> list[Stage]:
        """See `Recorder`; the coarsest level first."""
        return [stage for number in sorted(self._levels)[::-1] for stage in self._levels[number]]


def path_to(nodes: NDArray[np.int32], row: int) -> list[tuple[int, int, int]]:
    """Return the nodes that hold a row of a tree, from the root: number, first and last row + 1."""
    first, last = int(nodes[:, 1].min()), int(nodes[:, 2].max())
    path, node = [(0, first, last)], 0
    while (child := int(nodes[node, 0])) >= 0:
        for node in (child, child + 1):
            first, last = spans_of(nodes, node)
            if first <= row < last:
                break
        path.append((node, first, last))
    return path


def spans_of(nodes: NDArray[np.int32], node: int) -> tuple[int, int]:
    """Return first and last row + 1 below a node."""
    child = int(nodes[node, 0])
    if child < 0:
        return int(nodes[node, 1]), int(nodes[node, 2])
    first, last = spans_of(nodes, child), spans_of(nodes, child + 1)
    return min(first[0], last[0]), max(first[1], last[1])


class CandidateRecorder(Recorder):
    """Records the candidates of the pixel: coherent ones, or listed windows."""

    words: tuple[str, str, str]
    canvas = ""

    def __init__(self, exemplar: Exemplar, pixel: tuple[int, int]) -> None:
        super().__init__(exemplar, pixel)
        self._passes: dict[str, list[Stage]] = {}

    def stages(self) -> list[Stage]:
        """See `Recorder`."""
        return [stage for stages in self._passes.values() for stage in stages]

    def take(
        self,
        pixels: NDArray[np.uint8],
        done: NDArray[np.uint8],
        pixel: tuple[int, int],
        half: int,
        wrap: tuple[bool, bool],
    ) -> None:
        """Keep the canvas as it is before the pixel is made."""
        self._before = pixels.copy(), done.copy()
        self._window = window_around(pixels, done, pixel, half, wrap)

    def choose(
        self, sample: NDArray[np.uint8], places: NDArray[Any], chosen: int, at: str, top: int = 0
    ) -> None:
        """Make the stages of one choice; `top` rows of the canvas lie above the output."""
        columns = sample.shape[1]
        pixels, done = self._before
        self._passes[at] = [
            Stage("canvas" + at, self.canvas, pixels[top:], enlarged(made(pixels, done)[top:])),
            *choice_stages(
                sample,
                *self._window,
                np.stack(np.divmod(places, columns), axis=1),
                divmod(chosen, columns),
                words=self.words,
                at=at,
            ),
        ]


class AshikhminRecorder(CandidateRecorder):
    """Records the coherent candidates of the first pass and of the last."""

    canvas = "The picture when the pixel's turn comes, in scan order."
    words = (
        "What its window shows: L-shaped in the first pass, whole in later ones (section 3).",
        (
            "How much that differs from each window of the sample; the method compares only the "
            "candidates."
        ),
        "The coherent candidates: where the neighbors' sources go on. The best is framed.",
    )

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """See `Recorder`."""
        growth = facts["growth"]
        if step == "window":
            self._pass = "" if facts["number"] == 0 else " of a later pass"
            self.take(growth.pixels, growth.done, self.pixel, facts["half"], growth.canvas.wrap)
            return
        places = facts["places"]
        chosen = int(growth.source[self.pixel])
        self.choose(growth.windows.pixels, np.unique(places[places >= 0]), chosen, self._pass)


class ExactMatchingRecorder(CandidateRecorder):
    """Records the windows listed under the neighbors' colors, at each level."""

    canvas = "The picture when the pixel's turn comes, in scanline order."
    words = (
        "The causal neighborhood (section 4.2).",
        (
            "How much it differs from each window of the sample; the method compares only those of "
            "its lists."
        ),
        (
            "The reduced search space: windows that have exactly a direct neighbor's color at "
            "that neighbor's place (sections 4.1 and 4.2, Fig. 3), or a drawn share of them. The "
            "best is framed."
        ),
    )

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """See `Recorder`."""
        sheet = facts["sheet"]
        y, x = (n >> sheet.level for n in self.pixel)
        if step == "window":
            reach = sheet.lists.reach
            self.take(sheet.pixels, sheet.done, (y + sheet.top, x), reach, sheet.wrap)
            return
        chosen, at = int(sheet.source[y + sheet.top, x]), f" of level {sheet.level}"
        self.choose(sheet.lists.windows.pixels, facts["places"], chosen, at, sheet.top)


class RefinementRecorder(Recorder):
    """Records each level at its start, after its first sweep and after its last."""

    def __init__(self, exemplar: Exemplar, pixel: tuple[int, int]) -> None:
        super().__init__(exemplar, pixel)
        self._levels: dict[str, Stage] = {}
        self._changes: list[float] = []

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """See `Recorder`; the method of the start has notes of its own."""
        if step not in ("start", "sweep"):
            return
        output, at = facts["output"], f" of level {facts['output'].number}"
        if step == "start":
            title = "start" + at
            words = (
                "Seed points, or what another method made (PlantSeed, section 3, Fig. 5); on finer "
                "levels, what the coarser one shows."
            )
            self._latest = output.pixels.copy()
        else:
            first = facts["iteration"] == 0
            title = ("first sweep" if first else "last sweep") + at
            words = (
                "After each pixel took the place of the sample whose window is most like its own "
                "(RefineTexture, section 3)"
                + ("." if first else f", {facts['iteration'] + 1} times.")
            )
            apart = output.pixels.astype(np.float64) - self._latest
            self._changes.append(float(np.sqrt((apart**2).mean()) / 255))
            self._latest = output.pixels.copy()
        picture = made(output.pixels, output.done)
        self._levels[title] = Stage(title, words, output.pixels.copy(), enlarged(picture))

    def stages(self) -> list[Stage]:
        """See `Recorder`."""
        if not self._changes:
            return list(self._levels.values())
        changes = np.array(self._changes)
        words = (
            "How much each sweep changed, as a share of black to white, over all levels: sweeps "
            "end where it falls below the threshold (eq. 1, Fig. 7)."
        )
        return [*self._levels.values(), Stage("convergence", words, changes, _curve(changes))]


def _curve(values: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return a drawing of bars, the highest as high as the drawing."""
    picture = np.full((_CURVE, len(values) * 4, 3), UNKNOWN, np.uint8)
    for k, value in enumerate(values / max(float(values.max()), 1e-12)):
        picture[_CURVE - round(float(value) * _CURVE) :, 4 * k : 4 * k + 3] = MAGENTA
    return enlarged(picture)
