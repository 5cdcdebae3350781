"""The methods that paste patches at work."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.explanation.drawing import (
    MAGENTA,
    colors,
    enlarged,
    error_surface,
    framed,
    heat,
    made,
    marked,
)
from weftex.explanation.stages import Recorder, Stage
from weftex.results.drawing import draw_seams, gray_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.graphcut.placement import Patch
    from weftex.methods.patches.boundary_zone import BoundaryZone


class PatchRecorder(Recorder):
    """Records how the last patch that covers the pixel is chosen and pasted."""

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """See `Recorder`; there is a note for each patch that covers the pixel."""
        output = facts["output"]
        placement = output.placements[facts["number"]].tolist()
        self._facts = facts | {"after": output.pixels.copy(), "placement": placement}

    def stages(self) -> list[Stage]:
        """See `Recorder`."""
        facts = self._facts
        output, zone, before, after = (facts[k] for k in ("output", "zone", "before", "after"))
        y, x, v, u, _ = facts["placement"]
        inside = output.frame.inside
        height, width = zone.weight.shape
        rows, columns = (np.arange(y, y + height), np.arange(x, x + width))
        here = np.ix_(rows % before.shape[0], columns % before.shape[1])
        box = (y - inside[0].start, x - inside[1].start, height, width)
        there = _made_before(output, facts["number"])
        stages = [
            Stage(
                "canvas",
                "The canvas before the patch, and where it goes: patches are laid one after the "
                "other, and overlap those before.",
                before[inside],
                framed(made(before, there)[inside], box),
            )
        ]
        known = zone_mask(zone)
        sample, patch = (
            output.analysis.pixels,
            output.analysis.pixels[v : v + height, u : u + width],
        )
        if known.any():
            stages += _matching(sample, before[here], known, facts, (v, u))
        share = zone.weight / np.float32(256)
        if len(output.cuts):
            new = (after[here] == patch).all(axis=2)
            share = np.where(there[here] & ~new, np.float32(0), np.float32(1))
        shown = enlarged(np.where(share[..., None] > 0, colors(patch), colors(before[here]) // 3))
        stages += [
            Stage(
                "patch",
                "What of the patch is shown; dark, the pixels before it that stay. It is cut along "
                "the path of least error (Efros and Freeman, section 2.1), or fades in over the "
                "zone (Liang et al., section 2.2).",
                share,
                shown,
            ),
            Stage(
                "canvas after",
                "The canvas with the patch.",
                after[inside],
                framed(made(after, there | _box_mask(there.shape, here))[inside], box),
            ),
        ]
        return stages


def zone_mask(zone: BoundaryZone) -> NDArray[np.bool_]:
    """Return the pixels of a boundary zone, bool (rows, columns)."""
    known = np.zeros(zone.weight.shape, bool)
    for upright, v, u, length in zone.runs.tolist():
        part = np.s_[v : v + length, u] if upright else np.s_[v, u : u + length]
        known[part] = True
    return known


def _matching(
    sample: NDArray[np.uint8],
    window: NDArray[np.uint8],
    known: NDArray[np.bool_],
    facts: dict[str, Any],
    chosen: tuple[int, int],
) -> list[Stage]:
    """Return the stages of the boundary zone, the error of all windows, and the candidates."""
    height, width = known.shape
    middle = error_surface(sample, window, known)
    errors = np.full_like(middle, np.inf)  # by the corner and not by the middle
    errors[: sample.shape[0] - height + 1, : sample.shape[1] - width + 1] = middle[
        height // 2 : height // 2 + sample.shape[0] - height + 1,
        width // 2 : width // 2 + sample.shape[1] - width + 1,
    ]
    there = np.isfinite(errors)
    seen = facts["errors"] >= 0
    y, x = np.divmod(facts["places"][seen], facts["columns"])
    candidates = np.stack([y, x, facts["errors"][seen]], axis=1)
    best = candidates[np.argsort(candidates[:, 2], kind="stable")]
    return [
        Stage(
            "boundary zone",
            "The known pixels that the patch must match (Liang et al., section 2.2, Fig. 3).",
            np.where(known[..., None], window, 0),
            enlarged(made(window, known)),
        ),
        Stage(
            "error surface",
            "How much the zone differs from each window of the sample, by its corner (Liang et "
            "al., eq. 2): bright is alike.",
            errors,
            enlarged(framed(heat(errors, there), (*chosen, 1, 1), MAGENTA)),
        ),
        Stage(
            "candidates",
            "Windows that were compared at the full resolution, the best in green (row, column "
            "and sum of squares, or as much of it as ruled one out); one within the tolerance is "
            "drawn, in magenta.",
            best,
            marked(colors(sample), best[:12, :2], chosen, (height, width)),
        ),
    ]


def _made_before(output: Any, number: int) -> NDArray[np.bool_]:
    """Return the pixels of the frame that earlier patches cover, or that are known."""
    there = np.zeros(output.pixels.shape[:2], bool)
    height, width = output.frame.window
    for y, x in output.placements[:number, :2].tolist():
        rows, columns = np.arange(y, y + height), np.arange(x, x + width)
        there[np.ix_(rows % there.shape[0], columns % there.shape[1])] = True
    if output.method.pixelwise:
        there[...] = output.pixels.any(axis=2)
    return there


def _box_mask(shape: tuple[int, ...], here: Any) -> NDArray[np.bool_]:
    mask = np.zeros(shape, bool)
    mask[here] = True
    return mask


class GraphCutRecorder(Recorder):
    """Records how the last patch whose box holds the pixel is placed and cut."""

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
        self.found = [
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
            self.found.append(
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
        self.found += [
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
                marked(colors(self.exemplar.matching()), at, chosen, size),
            ),
        ]
