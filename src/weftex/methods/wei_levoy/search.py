"""The search for the pixels of a level: trees of the sample's windows, and the kernel's run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.wei_levoy import growth_kernels as kernels
from weftex.notes import note, parts
from weftex.search.pyramid_windows import parent_offsets, window_offsets, window_vectors
from weftex.search.tsvq import TSVQ, build_tsvq
from weftex.search.tsvq_kernels import Query

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.methods.wei_levoy.levels import Level
    from weftex.methods.wei_levoy.passes import Pass
    from weftex.methods.wei_levoy.settings import Settings
    from weftex.progress import Progress

_LEAST_PIXELS = 64  # in one call of the kernel, where lines are shorter


class Trees:
    """The trees of a sample's levels.

    Those of causal windows are built at once, those of windows that look to all sides when a pass
    needs them.
    """

    def __init__(self, samples: list[Exemplar], settings: Settings) -> None:
        self._samples, self._settings = samples, settings
        self._built: dict[tuple[int, bool], TSVQ] = {}
        if settings.window_width > 1:
            for level in range(settings.levels):
                self.of(level, causal=True)

    def of(self, level: int, *, causal: bool) -> TSVQ:
        """Return the tree of a level, 0 the finest."""
        if (level, causal) not in self._built:
            settings = self._settings
            parent_width = settings.parent_width_at(level)
            parent = self._samples[level + 1] if parent_width else None
            vectors, places = window_vectors(
                self._samples[level],
                parent,
                settings.window_width,
                parent_width,
                causal=causal,
                most=settings.most_windows,
            )
            self._built[level, causal] = build_tsvq(vectors, places, settings.most_leaves)
        return self._built[level, causal]


def replace_by_nearest(
    level: Level,
    step: Pass,
    trees: Trees,
    settings: Settings,
    wrap: tuple[bool, bool],
    progress: Progress,
) -> None:
    """Replace the pixels of a pass, one after the other, by the sample's with the nearest windows.

    Parameters
    ----------
    level : Level
        Its pixels and sources change; parents are in its coarser level.
    step : Pass
        Pixels, and whether their windows are causal.
    trees : Trees
        Of the sample's windows.
    settings : Settings
        With S and N, the widths of the windows.
    wrap : (bool, bool)
        Axes that go around.
    progress : Progress
        Counts the pixels.
    """
    if settings.window_width == 1:  # such a window sees nothing, and the noise stays
        progress.advance(len(step.places))
        return
    tree = trees.of(level.number, causal=step.causal)
    own = window_offsets(settings.window_width, step.causal)
    parents = parent_offsets(settings.parent_width_at(level.number))
    spans = np.empty((len(own) + len(parents), 2), np.int32)
    query = Query(np.empty(tree.rows.shape[1], np.uint8), spans, 0)
    here, above = (kernels.Level(part, wrap) for part in (level, level.coarser or level))
    bundle, leaves = tree.bundle(), min(step.leaves, len(tree.places))
    line = max(level.pixels.shape[1], _LEAST_PIXELS)
    for start in range(0, len(step.places), line):
        places = step.places[start : start + line]
        for part, asked in parts(places, level.pixels.shape[1], level=level.number):
            if asked:
                note("window", level=level, own=own, tree=tree, wrap=wrap)
            kernels.replace_pixels(here, above, own, parents, places[part], bundle, leaves, query)
            if asked:
                note("chosen", level=level)
        progress.advance(len(places))
