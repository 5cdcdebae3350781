"""The unit, limit and meaning of each figure."""

from __future__ import annotations

import math
from dataclasses import dataclass

_WORST = 16.0  # a figure that is further off counts as this


@dataclass(frozen=True)
class Figure:
    """One figure of an `Assessment`."""

    title: str
    unit: str
    good: str  # "low", "high", "one" (near 1) or "" where it only describes
    limit: float | None  # the last value that passes; a factor for "one"
    meaning: str  # one sentence for a reader who does not know the measure
    blind: str  # what it cannot detect
    #: What a result beyond the limit does, to follow "it"; below and above 1 with a "|".
    wrong: str = ""
    base: float = 0.0  # for "low", the value up to which nothing is wrong
    #: The share of judged pairs in which it is further off for the worse picture, ties as half;
    #: 0.5 is a coin. None where it needs more than the two pictures.
    agrees: float | None = None

    def off(self, value: float) -> float:
        """Return how far a value is from a perfect one; for "one" a logarithm."""
        if self.good == "high":
            return max(1 - value, 0.0)
        if self.good == "one":
            return abs(math.log(max(value, 1e-6)))
        return max(value - self.base, 0.0)

    def badness(self, value: float) -> float:
        """Return 0 for a perfect value, 1 at the limit, at most 16."""
        if self.limit is None:
            return 0.0
        return min(self.off(value) / self.off(self.limit), _WORST)

    def fault(self, value: float) -> str:
        """Return what is wrong with a result beyond the limit."""
        below, _, above = self.wrong.partition("|")
        return (above or below) if value > 1 else below

    def within(self) -> str:
        """Return the limit in words."""
        if self.limit is None:
            return ""
        if self.good == "one":
            return f"{1 / self.limit:.2f} to {self.limit:.2f}"
        return f"{'at most' if self.good == 'low' else 'at least'} {self.limit:g}"


SCORE = (
    "0 is the sample itself, and lower is better. Only results of one size from one sample "
    "compare: where two scores differ by 1, judges prefer the lower in three of four cases."
)
"""What the score means, in one sentence."""

_HALVES = "1 = as the sample's halves"

FIGURES: dict[str, Figure] = {
    "uneven": Figure(
        "uneven", "relative entropy", "", None,
        "How unevenly the parts of the sample are used.",
        "where they are used",
        agrees=0.67,
    ),
    "patches": Figure(
        "patches", _HALVES, "low", 1.6,
        "Whether small windows, at four scales, look as they do in the sample.",
        "where in the image they are; repetition; structure above 50 pixels",
        "has details that the sample lacks",
        agrees=0.67,
    ),
    "broken": Figure(
        "broken features", _HALVES, "low", 1.25,
        "Whether features are whole: how much large windows differ from the sample.",
        "faults below a twentieth of the sample's side; repetition",
        "has broken or merged features",
        agrees=0.75,
    ),
    "color": Figure(
        "color", _HALVES, "low", 3.0,
        "Whether colors occur as often as in the sample.",
        "where the colors are",
        "has other colors than the sample",
        agrees=0.60,
    ),
    "autocorrelation": Figure(
        "autocorrelation", _HALVES, "low", 1.6,
        "Whether the result is as similar to itself at short shifts as the sample.",
        "the content that is similar",
        "has another rhythm than the sample",
        agrees=0.67,
    ),
    "lattice": Figure(
        "lattice kept", "share", "high", 0.7,
        "How much of the sample's repetition is left in the result.",
        "order over more than three repetitions",
        "loses the sample's regular order",
        agrees=0.83,
    ),
    "seams": Figure(
        "seams", "1 = as the sample's own", "low", 1.75,
        "Steps between pixel rows or columns that are larger than the steps around them.",
        "feathered seams; mortar joints that break off",
        "has visible seams", 1.0,
        agrees=0.52,
    ),
    "sharpness": Figure(
        "sharpness", "ratio", "one", 1.15,
        "The strength of the finest detail, relative to the sample's.",
        "the form of the detail",
        "is blurred|is noisier than the sample",
        agrees=0.58,
    ),
    "wrap": Figure(
        "seam at the wrap", "share", "low", 0.1,
        "How much of the border shows as a seam where a tileable result repeats.",
        "salient features that reveal the tile",
        "shows a seam where it wraps around", 0.01,
    ),
}  # fmt: skip
"""Every figure by the name of its field in `Assessment`, in the order in which they are shown."""
