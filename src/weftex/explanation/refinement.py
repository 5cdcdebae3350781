"""Iterative refinement at work."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.explanation.drawing import MAGENTA, UNKNOWN, enlarged, made
from weftex.explanation.stages import Stage

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar

_CURVE = 64  # pixels a side of the drawing of the curve


class RefinementRecorder:
    """Records each level at its start, after its first sweep and after its last."""

    def __init__(self, exemplar: Exemplar, pixel: tuple[int, int]) -> None:
        self._found: dict[str, Stage] = {}
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
        self._found[title] = Stage(title, words, output.pixels.copy(), enlarged(picture))

    def stages(self) -> list[Stage]:
        """See `Recorder`."""
        if not self._changes:
            return list(self._found.values())
        changes = np.array(self._changes)
        words = (
            "How much each sweep changed, as a share of black to white, over all levels: sweeps "
            "end where it falls below the threshold (eq. 1, Fig. 7)."
        )
        return [*self._found.values(), Stage("convergence", words, changes, _curve(changes))]


def _curve(values: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return a drawing of bars, the highest as high as the drawing."""
    picture = np.full((_CURVE, len(values) * 4, 3), UNKNOWN, np.uint8)
    for k, value in enumerate(values / max(float(values.max()), 1e-12)):
        picture[_CURVE - round(float(value) * _CURVE) :, 4 * k : 4 * k + 3] = MAGENTA
    return enlarged(picture)
