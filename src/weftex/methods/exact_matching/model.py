"""A sample prepared for exact neighborhood matching."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.methods.exact_matching.lists import ColorLists, color_lists
from weftex.search.pyramid_windows import sample_pyramid
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from weftex.search.windows import Windows

_SMALLEST_SIDE = 5  # of the coarsest level, in pixels


@dataclass(frozen=True, eq=False)
class LevelSample:
    """A level of the sample's pyramid; its lists are built at first use."""

    method: Any
    sample: Exemplar
    coarser: Exemplar | None

    @cached_property
    def causal(self) -> ColorLists:
        """Lists of L-shaped windows."""
        return color_lists(self.method, self.sample, causal=True, coarser=self.coarser)

    @cached_property
    def around(self) -> ColorLists:
        """Lists of windows that look to all sides, for pixels between known ones."""
        return color_lists(self.method, self.sample, causal=False, coarser=self.coarser)

    @cached_property
    def turned(self) -> ColorLists:
        """Lists of L-shaped windows of the sample with its axes exchanged."""
        return color_lists(self.method, _turned(self.sample), causal=True)


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for exact neighborhood matching.

    `windows` are of one pixel, so indices are the sample's own. `levels` are finest first.
    """

    method: Any
    windows: Windows
    levels: tuple[LevelSample, ...]


def prepare(method: Any, exemplar: Exemplar) -> Prepared:
    """Return the analysis of a sample (section 4.1) at each of its levels."""
    windows = windows_of(exemplar, (0, 0, 0, 0))
    samples = sample_pyramid(exemplar, method.levels)
    enough = len(samples)
    while enough > 1 and min(samples[enough - 1].shape) < _SMALLEST_SIDE:
        enough -= 1
    if enough < method.levels:
        raise InvalidInputError(
            f"levels is {method.levels}; {exemplar.name} is {exemplar.shape[1]}x"
            f"{exemplar.shape[0]}, which is enough for {enough}"
        )
    coarser = [*samples[1:], None]
    levels = [LevelSample(method, *pair) for pair in zip(samples, coarser, strict=True)]
    for level in levels:
        _ = level.causal
    if method.init == "structured":
        _ = levels[-1].turned
    return Prepared(method, windows, tuple(levels))


def _turned(sample: Exemplar) -> Exemplar:
    """The sample with its axes exchanged."""
    mask = None if sample.mask is None else sample.mask.T
    turned = np.ascontiguousarray(sample.pixels.swapaxes(0, 1))
    return Exemplar(turned, mask=mask, tileable=sample.tileable, alpha=False, name=sample.name)
