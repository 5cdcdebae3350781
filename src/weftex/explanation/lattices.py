"""The methods that follow a lattice at work."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.autocorrelations import autocorrelations
from weftex.analysis.canvas_lattice import MeanTile, given_lattice
from weftex.analysis.overlay import draw_correlation, draw_lattice
from weftex.explanation.drawing import colors, enlarged, framed, heat, made
from weftex.explanation.stages import Recorder, Stage

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar


def lattice_stages(exemplar: Exemplar, vectors: tuple[float, ...]) -> list[Stage]:
    """Return the stages of the correlation, the lattice, and the mean tile."""
    seen = autocorrelations(exemplar)
    stages = [
        Stage(
            "correlation",
            "How much the sample is like itself when it is shifted: its peaks are the translation "
            "vectors (chapter 3).",
            seen.field.correlation,
            enlarged(colors(draw_correlation(seen.field.correlation))),
        )
    ]
    if not len(vectors):
        return stages
    tile = MeanTile(exemplar.matching(), vectors)
    plane = tile.at(*np.indices(exemplar.shape))
    return [
        *stages,
        Stage(
            "lattice",
            "The translation vectors, drawn as tiles over the sample; x1, y1, x2, y2.",
            np.array(vectors),
            enlarged(draw_lattice(exemplar, given_lattice(vectors))),
        ),
        Stage(
            "mean tile",
            "The mean of all that lies at the same place of the tile: what is regular.",
            plane,
            enlarged(colors(plane)),
        ),
    ]


class NearRegularRecorder(Recorder):
    """Records the drawn blocks, and the blocks that fill the gaps."""

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """See `Recorder`."""
        sample, layout, sources = facts["sample"], facts["layout"], facts["sources"]
        self.found = self.found or lattice_stages(self.exemplar, facts["vectors"])
        picture = layout.preview(sample, sources)
        words = {
            "drawn": "Every second block shows a piece of the sample that lies a multiple of the "
            "vectors away, drawn at random (section 4.2.1, Fig. 4.7).",
            "filled": "Each gap shows the piece that fits its four neighbors best, near a multiple "
            "of the vectors (section 4.2.2, Figs. 4.8 and 4.9, eq. 4.4); edges are still straight.",
        }
        there = picture.reshape(*picture.shape[:2], -1).any(axis=2)
        self.found.append(
            Stage(f"blocks {step}", words[step], sources.copy(), made(picture, there))
        )


class BestTileRecorder(Recorder):
    """Records the errors of all tiles."""

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """See `Recorder`."""
        errors, (y, x) = facts["errors"], facts["anchor"]
        tile: NDArray[np.bool_] = np.zeros(self.exemplar.shape, bool)
        for v, u, last in facts["rows"].tolist():
            tile[y + v, max(x + u, 0) : x + last + 1] = True
        sample = colors(self.exemplar.matching())
        self.found = [
            *lattice_stages(self.exemplar, facts["vectors"]),
            Stage(
                "error of tiles",
                "How much the opposite borders of each tile differ, by its first corner (eq. 4.2, "
                "Figs. 4.4 and 4.5): bright is alike.",
                errors,
                enlarged(framed(heat(errors, errors >= 0), (y, x, 1, 1))),
            ),
            Stage(
                "best tile",
                "The tile with the lowest error, with half of its borders; it is repeated (Fig. "
                "4.6, eq. 4.1).",
                tile,
                enlarged(np.where(tile[..., None], sample, sample // 3)),
            ),
        ]
