"""What each figure means: unit, direction, limit, and how to say it."""

from __future__ import annotations

import math
from dataclasses import dataclass

_WORST = 16.0  # a figure that is further off counts as this


@dataclass(frozen=True)
class Figure:
    """One figure of an `Assessment`.

    Attributes
    ----------
    title : str
        What to call it.
    unit : str
        Of the value.
    good : str
        "low", "high", "one" (near 1) or "" where it only describes.
    limit : float or None
        What still passes; a factor for "one", and None for what only describes.
    meaning : str
        One sentence for a reader who does not know the measure.
    blind : str
        What it cannot see.
    wrong : str
        What a result that passes the limit does, to go on after "it".
    base : float
        What is no fault yet, for "low".
    agrees : float or None
        In how many of the judged pairs it is further off for the picture that looks worse, ties as
        half; 0.5 is a coin. None for what needs more than the two pictures.
    """

    title: str
    unit: str
    good: str
    limit: float | None
    meaning: str
    blind: str
    wrong: str = ""
    base: float = 0.0
    agrees: float | None = None

    def off(self, value: float) -> float:
        """How far a value is from a perfect one; in its unit, and for "one" a logarithm."""
        if self.good == "high":
            return max(1 - value, 0.0)
        if self.good == "one":
            return abs(math.log(max(value, 1e-6)))
        return max(value - self.base, 0.0)

    def badness(self, value: float) -> float:
        """0 for a perfect value, 1 at the limit, 16 at most."""
        if self.limit is None:
            return 0.0
        return min(self.off(value) / self.off(self.limit), _WORST)

    def fault(self, value: float) -> str:
        """What is wrong with a result that passes the limit."""
        below, _, above = self.wrong.partition("|")
        return (above or below) if value > 1 else below

    def within(self) -> str:
        """The limit in words."""
        if self.limit is None:
            return ""
        if self.good == "one":
            return f"{1 / self.limit:.2f} to {self.limit:.2f}"
        return f"{'at most' if self.good == 'low' else 'at least'} {self.limit:g}"


SCORE = (
    "0 is the sample itself, and only pictures of one size from one sample compare: of two that "
    "are 1 apart an eye prefers the lower in three of four cases."
)
"""What the score means, in one sentence."""

_HALVES = "1 = as the sample's halves"

FIGURES: dict[str, Figure] = {
    "broken": Figure(
        "broken", _HALVES, "", None,
        "How far its worst windows, a third of the sample wide, are from all of the sample's.",
        "detail finer than a thirtieth of the sample",
        agrees=0.56,
    ),
    "uneven": Figure(
        "uneven", "relative entropy", "", None,
        "How unevenly the parts of the sample come up.",
        "where they come up",
        agrees=0.67,
    ),
    "alike": Figure(
        "alike", "logarithm", "", None,
        "How much nearer to each other its windows are than the sample's.",
        "how far apart, and how striking, they are",
        agrees=0.51,
    ),
    "patches": Figure(
        "patches", _HALVES, "low", 1.6,
        "Whether small patches, at four scales, look as they do in the sample.",
        "where in the picture they are; repetition; structure above 50 pixels",
        "has patches that the sample has not",
        agrees=0.67,
    ),
    "color": Figure(
        "color", _HALVES, "low", 3.0,
        "Whether colors occur as often as in the sample.",
        "where the colors are",
        "has other colors than the sample",
        agrees=0.60,
    ),
    "spectrum": Figure(
        "spectrum", _HALVES, "low", 1.3,
        "Whether each period and direction has as much power as in the sample.",
        "phase: edges and noise can have one spectrum",
        "varies more or less than the sample at some periods",
        agrees=0.60,
    ),
    "autocorrelation": Figure(
        "autocorrelation", _HALVES, "low", 1.6,
        "Whether it is as similar to itself at short shifts as the sample.",
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
        "Steps between neighboring lines that their surroundings do not explain.",
        "feathered seams; joints that end",
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
    "soft": Figure(
        "soft areas", "share", "low", 0.12,
        "How much of it is softer than the softest twentieth of the sample.",
        "the form of the detail",
        "is blurred in places", 0.05,
        agrees=0.52,
    ),
    "period": Figure(
        "period", "share", "low", 0.25,
        "The largest part that repeats at one shift.",
        "copies that are turned, scaled or blended",
        "repeats itself at one distance", 0.12,
        agrees=0.51,
    ),
    "repeats": Figure(
        "near repeats", "share", "low", 0.5,
        "How much repeats within half the sample's side, beyond the repetition of the lattice.",
        "copies that are turned, scaled or blended",
        "shows the same things side by side", 0.2,
        agrees=0.53,
    ),
    "copied": Figure(
        "copied", "share", "", None,
        "How much of it was copied in pieces of at least 64 pixels.",
        "whether copying is wanted",
    ),
    "piece": Figure(
        "piece", "pixels", "", None,
        "The median side of the piece around a pixel.",
        "whether copying is wanted",
    ),
    "largest": Figure(
        "largest piece", "of the sample", "", None,
        "The largest piece that was copied, as a share of the sample.",
        "whether copying is wanted: an eye likes large pieces",
    ),
    "evenness": Figure(
        "evenness of use", "share", "high", 0.33,
        "How much of the sample was used; seldom used parts count less.",
        "the order of the parts",
        "uses only a part of the sample",
    ),
    "distinct": Figure(
        "distinct", "share", "high", 0.7,
        "How many pixels within half the sample's side come from different places.",
        "repetition further apart",
        "uses the same parts over and over nearby",
    ),
    "joints": Figure(
        "joints", "steps of the sample", "low", 1.5,
        "The step of colors where two pieces meet.",
        "all else",
        "has pieces that do not fit each other",
    ),
    "wrap": Figure(
        "seam at the wrap", "share", "low", 0.1,
        "How much of the border shows as a seam when the result is repeated.",
        "striking parts that give a tile away",
        "shows a seam where it repeats", 0.01,
    ),
}  # fmt: skip
"""Every figure by the name of its field in `Assessment`, in the order in which they are shown."""
