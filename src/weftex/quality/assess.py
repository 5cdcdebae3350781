"""All figures of a result, the verdict on it, and the check of what is compared."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.relief import means
from weftex.errors import wrong_value
from weftex.exemplar import Exemplar, Sample, load_exemplar
from weftex.exemplar.turns import as_it_was
from weftex.progress import counted
from weftex.quality.appearance import color_distance, patch_distance, sharpness
from weftex.quality.figures import FIGURES
from weftex.quality.score import Scorer, weigh
from weftex.quality.seams import wrap_seam
from weftex.raster.arrays import check_pixels
from weftex.raster.mixing import opposite
from weftex.results.synthesis import Synthesis

LARGEST_MEASURED = 2048
"""Pixels a side: of a larger result the middle is measured, except for the wrap."""

_DIGITS = 3
_SURE = 0.01  # of the product of two `_bent`, from which y of normals points the other way
#: Terms of the score that are shown by themselves.
_SCORED = ("uneven", "broken", "autocorrelation", "lattice", "seams")


@dataclass(frozen=True)
class Assessment:
    """All measures of a result, rounded to three digits; None for what cannot be measured.

    The page "Quality measures" has unit, limit and meaning of each.

    Attributes
    ----------
    uneven : float or None
        How unevenly the parts of the sample are used: 0 is evenly, above 1 a few parts only. It
        matches windows with the sample, so it needs no source map.
    patches : float or None
        Whether small windows look as in the sample; 1 is as similar as two halves of the sample.
    broken : float or None
        Whether features are whole, in the same unit.
    color : float or None
        Whether colors occur as often as in the sample, in the same unit.
    autocorrelation : float or None
        Whether it resembles itself at short shifts as the sample does, in the same unit.
    lattice : float or None
        Share of the sample's repetition that is left, 0 to 1.
    seams : float or None
        Strength of unexplained steps; 1 is as in the sample.
    sharpness : float or None
        Strength of the finest detail, relative to the sample's.
    wrap : float or None
        Share of the border that shows a seam; only of a tileable result.
    flags : tuple of str
        Names of the measures beyond their limits, worst first.
    score : float or None
        Predicted preference of a judge (AI models that see pictures): 0 is the sample itself, lower
        is better. If two scores differ by d, a share of 1 / (1 + exp(-d)) of judges prefers the
        lower one. 4 to 5 is typical of good results.
    """

    uneven: float | None = None
    patches: float | None = None
    broken: float | None = None
    color: float | None = None
    autocorrelation: float | None = None
    lattice: float | None = None
    seams: float | None = None
    sharpness: float | None = None
    wrap: float | None = None
    flags: tuple[str, ...] = ()
    score: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers, texts, lists and None, ready for JSON."""
        plain = dataclasses.asdict(self)
        return {k: list(v) if isinstance(v, tuple) else v for k, v in plain.items()}

    def badness(self, name: str) -> float | None:
        """Return how far a measure is from perfect: 0 is perfect, 1 is at its limit."""
        value = getattr(self, name)
        return None if value is None else FIGURES[name].badness(value)

    def verdict(self) -> str:
        """Return a sentence that says how good the result is, and its faults."""
        if self.score is None:
            return "Too small to be judged."
        if not self.flags:
            near = max(FIGURES, key=lambda name: self.badness(name) or 0.0)
            title = FIGURES[near].title
            return f"Good: all measures are within their limits; {title} is closest to its limit."
        faults = [FIGURES[name].fault(getattr(self, name)) for name in self.flags]
        listed = faults[0] if len(faults) == 1 else f"{', '.join(faults[:-1])} and {faults[-1]}"
        worst = max(self.badness(name) or 0.0 for name in self.flags)
        word = "Nearly good" if worst < 1.25 else "Flawed" if worst < 2.5 else "Bad"
        return f"{word}: it {listed}."


def assess(
    sample: Sample,
    result: Synthesis | NDArray[Any],
    *,
    tileable: bool | tuple[bool, bool] | None = None,
) -> Assessment:
    """Measure how well a result matches its sample.

    The measures compare: they do not say whether the sample is good. Of a result of more than 2048
    pixels a side, only the middle is measured, and the border if it is tileable.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The sample that the result was made from. Pixels outside its mask do not count.
    result : Synthesis or array (H, W) or (H, W, C)
        The result, of the sample's dtype and channels; y of normals may point the other way.
    tileable : bool or (bool, bool), optional
        Whether the vertical and the horizontal axis wrap around; by default as in the Synthesis,
        else not.

    Returns
    -------
    Assessment

    Raises
    ------
    InvalidInputError
        If the result does not fit the sample.

    Examples
    --------
    >>> import weftex
    >>> sample = weftex.load_exemplar("sample:pebbles")
    >>> good = assess(sample, weftex.synthesize(sample, 256, method="quilting", seed=1))
    >>> noise = np.random.default_rng(0).integers(0, 255, (256, 256, 3), np.uint8)
    >>> bad = assess(sample, noise)
    >>> good.score < bad.score, bad.patches > 5 * good.patches
    (True, True)
    """
    exemplar = load_exemplar(sample)
    with counted(5, "measures") as step:
        pixels, wrap = _checked(exemplar, result, tileable)
        scorer = Scorer(as_it_was(exemplar))
        own, whole = scorer.own, scorer.view(pixels)
        made = whole.center(LARGEST_MEASURED)
        patches, color = patch_distance(own, made), color_distance(own, made)
        step(1)
        scored = scorer.figures(made, step)
        figures: dict[str, Any] = {
            **{name: scored.get(name) for name in _SCORED},
            "patches": patches,
            "color": color,
            "sharpness": sharpness(own, made),
            "wrap": wrap_seam(scorer.steps, whole, wrap),
            "score": weigh(scored),
        }
    figures = {name: _rounded(value) for name, value in figures.items()}
    found = Assessment(**figures)
    off = {name: found.badness(name) or 0.0 for name in FIGURES}
    flags = sorted((name for name in FIGURES if off[name] > 1), key=lambda name: -off[name])
    return dataclasses.replace(found, flags=tuple(flags))


def _checked(
    exemplar: Exemplar, result: Synthesis | NDArray[Any], tileable: bool | tuple[bool, bool] | None
) -> tuple[NDArray[Any], tuple[bool, bool]]:
    """Return the pixels of a result, and whether each axis wraps around."""
    tiles = False if tileable is None else tileable
    wrap: Any = tiles if isinstance(tiles, tuple) else (tiles,) * 2
    if len(wrap) != 2 or not all(isinstance(axis, (bool, np.bool_)) for axis in wrap):
        raise wrong_value("tileable", tileable, "True, False or two of them")
    pixels: Any = result
    if isinstance(result, Synthesis):
        pixels = result.image if result.exemplar is not None else result.render(exemplar)
        wrap = result.canvas.wrap if tileable is None else wrap
    pixels = check_pixels(pixels, "result")
    normals = exemplar.role.kind == "normal" and pixels.ndim == exemplar.pixels.ndim == 3
    if normals and _bent(pixels) * _bent(exemplar.pixels) < -_SURE:
        y = opposite(pixels[..., 1:2], exemplar.mixing.middle)
        pixels = np.concatenate([pixels[..., :1], y, pixels[..., 2:]], axis=2)
    return pixels, wrap


def _bent(normals: NDArray[Any]) -> float:
    """Return -1 to 1: below 0 where y points up, above where it points down, about 0 if unsure.

    x and y are slopes of one surface, so x changes downwards as y does to the right.
    """
    x, y = means(np.moveaxis(normals[..., :2], 2, 0).astype(np.float64), 8)  # JPEG lacks details
    products = np.diff(x, axis=0)[:, 1:] * np.diff(y, axis=1)[1:]
    return float(products.sum()) / max(float(abs(products).sum()), 1e-12)


def real_crops(sample: Exemplar) -> dict[str, float | None]:
    """Return the mean figures of the sample's halves, each as if made from the other half.

    Halves that the mask does not leave whole are left out.
    """
    y, x = (side // 2 for side in sample.shape)
    boxes = (np.s_[:y], np.s_[-y:] if y else np.s_[:0]), (np.s_[:, :x], np.s_[:, -x:])
    found: list[Assessment] = []
    for pair in boxes:
        first, second = (_part(sample, box) for box in pair)
        if first is not None and second is not None:
            found += [assess(first, second.pixels), assess(second, first.pixels)]
    values = {name: [getattr(one, name) for one in found] for name in FIGURES}
    known = {name: [one for one in row if one is not None] for name, row in values.items()}
    return {name: _rounded(float(np.mean(row))) if row else None for name, row in known.items()}


def _part(sample: Exemplar, box: tuple[slice, ...] | slice) -> Exemplar | None:
    pixels: NDArray[np.generic] = sample.pixels[box]
    if pixels.size == 0 or (sample.mask is not None and not sample.mask[box].all()):
        return None
    return Exemplar(pixels, alpha=sample.alpha, name=sample.name)


def _rounded(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(float(value), _DIGITS)
