"""The trees of the sample's windows (TSVQ), and the replacement of pixels by their nearest."""

from __future__ import annotations

import numpy as np

from weftex.exemplar import Exemplar
from weftex.methods.wei_levoy import scan_kernels as kernels
from weftex.methods.wei_levoy.levels import Level
from weftex.methods.wei_levoy.passes import Pass
from weftex.methods.wei_levoy.tsvq import TSVQ, build_tsvq
from weftex.progress import Progress
from weftex.search.picture_kernels import Picture
from weftex.search.pyramid_windows import parent_offsets, window_offsets, window_vectors

_LEAST_PIXELS = 64  # in one call of the kernel, where lines are shorter


class Trees:
    """The trees of a sample's levels; those of windows to all sides are built at first use."""

    def __init__(
        self,
        samples: list[Exemplar],
        window_width: int,
        parent_width: int,
        tree_size: int,
        most_windows: int,
    ) -> None:
        self._samples, self._tree_size, self._most = samples, tree_size, most_windows
        self.window_width = window_width
        #: N of each level; at the coarsest 0, as pixels have no parents there.
        self.parent_widths = [parent_width] * (len(samples) - 1) + [0]
        self._built: dict[tuple[int, bool], TSVQ] = {}
        if window_width > 1:
            for level in range(len(samples)):
                self.of(level, causal=True)

    def of(self, level: int, *, causal: bool) -> TSVQ:
        """Return the tree of a level, 0 the finest."""
        if (level, causal) not in self._built:
            parent_width = self.parent_widths[level]
            parent = self._samples[level + 1] if parent_width else None
            widths = self.window_width, parent_width
            vectors, places = window_vectors(
                self._samples[level], parent, *widths, causal=causal, most=self._most
            )
            self._built[level, causal] = build_tsvq(vectors, places, self._tree_size)
        return self._built[level, causal]


def replace_by_nearest(
    level: Level, step: Pass, trees: Trees, wrap: tuple[bool, bool], progress: Progress
) -> None:
    """Replace the pixels of a pass in turn, each by the sample's pixel with the nearest window."""
    if trees.window_width == 1:  # such a window sees nothing, and the noise stays
        progress.advance(len(step.places))
        return
    tree = trees.of(level.number, causal=step.causal)
    own = window_offsets(trees.window_width, step.causal)
    parents = parent_offsets(trees.parent_widths[level.number])
    spans = np.empty((len(own) + len(parents), 2), np.int32)
    leaves = min(step.leaves, len(tree.places))
    here, above = (
        Picture(part.pixels, part.done, part.source, wrap)
        for part in (level, level.coarser or level)
    )
    sample, bundle = level.sample.pixels, tree.bundle(spans)
    line = max(level.pixels.shape[1], _LEAST_PIXELS)
    for start in range(0, len(step.places), line):
        places = step.places[start : start + line]
        kernels.replace_pixels(here, above, sample, own, parents, places, bundle, leaves)
        progress.advance(len(places))
