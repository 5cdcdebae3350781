"""Graph-cut textures at work."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.explanation.drawing import colors, enlarged, framed, heat, made, marked
from weftex.explanation.stages import Stage
from weftex.results.drawing import draw_seams, gray_of

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.methods.graphcut.placement import Patch


class GraphCutRecorder:
    """Records how the last patch whose box holds the pixel is placed and cut."""

    def __init__(self, exemplar: Exemplar, pixel: tuple[int, int]) -> None:
        self._exemplar, self._stages = exemplar, list[Stage]()
        self._matches: dict[str, Any] = {}

    def stages(self) -> list[Stage]:
        """See `Recorder`."""
        return self._stages

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """See `Recorder`."""
        if step == "matches":
            self._matches = facts
            return
        growth, place = facts["growth"], facts["place"]
        box = (place.top, place.left, place.height, place.width)
        if step == "patch":
            self._before = growth.pixels.copy(), growth.done.copy(), growth.source.copy()
            return
        pixels, done, source = self._before
        columns = growth.windows.pixels.shape[1]
        self._stages = [
            Stage(
                "canvas",
                "The canvas before the patch, and the box that it may change.",
                pixels,
                framed(made(pixels, done), box),
            ),
            *self._placement(place),
        ]
        if done.any():
            sources = np.stack(np.divmod(source, columns), axis=-1).astype(np.int32)
            seams = draw_seams(gray_of(pixels), sources, growth.windows.pixels.shape[:2])
            seams[done == 0] = made(pixels, done)[done == 0]
            self._stages.append(
                Stage(
                    "old seams",
                    "The seams that are there, in red: each is a node of the new graph, so that "
                    "the cut may go over it and what it costs counts (section 3, Fig. 3).",
                    sources,
                    framed(seams, box),
                )
            )
        new = (growth.source != source) | ((done == 0) & (growth.done > 0))
        picture = made(growth.pixels, growth.done)
        self._stages += [
            Stage(
                "cut",
                "What the minimum cut takes from the patch, bright, and what it leaves (sections "
                "2 and 3).",
                new,
                framed(np.where(new[..., None], picture, picture // 3), box),
            ),
            Stage("canvas after", "The canvas with the patch.", growth.pixels.copy(), picture),
        ]

    def _placement(self, place: Patch) -> list[Stage]:
        """Return the candidate offsets of the patch."""
        found = self._matches
        costs, allowed = found["costs"] * found["factors"], found["allowed"] != 0
        there = allowed & np.isfinite(costs)
        at = np.array(found["drawn"]).reshape(-1, 2) << found["halvings"]
        chosen, size = (place.source_top, place.source_left), (place.height, place.width)
        return [
            Stage(
                "cost of places",
                "C(t): the mean squared difference to the canvas for each place of the sample, on "
                f"a copy halved {found['halvings']} times; bright is alike (section 4). "
                "Places that would show again what is near cost more, which is not in the paper.",
                costs,
                enlarged(heat(np.where(there, costs, 0), there)),
            ),
            Stage(
                "candidates",
                "Places drawn by exp(-C(t) / (k sigma**2)) (section 4); each is cut, and "
                "the one with the cheapest seam is laid, in magenta.",
                at,
                marked(colors(self._exemplar.matching()), at, chosen, size),
            ),
        ]
