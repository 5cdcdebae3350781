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
        The value of a perfect result, for "low".
    """

    title: str
    unit: str
    good: str
    limit: float | None
    meaning: str
    blind: str
    wrong: str = ""
    base: float = 0.0

    def badness(self, value: float) -> float:
        """0 for a perfect value, 1 at the limit, 16 at most."""
        if self.limit is None:
            return 0.0
        if self.good == "low":
            off = (value - self.base) / (self.limit - self.base)
        elif self.good == "high":
            off = (1 - value) / (1 - self.limit)
        else:
            off = abs(math.log(max(value, 1e-6))) / math.log(self.limit)
        return min(max(off, 0.0), _WORST)

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


_HALVES = "1 = as the sample's halves"

FIGURES: dict[str, Figure] = {
    "patches": Figure(
        "patches", _HALVES, "low", 1.6,
        "Whether small patches, at four scales, look as they do in the sample.",
        "where in the picture they are; repetition; structure above 50 pixels",
        "has patches that the sample has not",
    ),
    "color": Figure(
        "colour", _HALVES, "low", 3.0,
        "Whether colours occur as often as in the sample.",
        "where the colours are",
        "has other colours than the sample",
    ),
    "spectrum": Figure(
        "spectrum", _HALVES, "low", 1.3,
        "Whether as much varies at each period and in each direction.",
        "phase: edges and noise can have one spectrum",
        "varies more or less than the sample at some periods",
    ),
    "autocorrelation": Figure(
        "autocorrelation", _HALVES, "low", 1.6,
        "Whether it is as alike to itself at short shifts.",
        "what it is that is alike",
        "has another rhythm than the sample",
    ),
    "lattice": Figure(
        "lattice kept", "share", "high", 0.7,
        "How much of what repeats in the sample repeats in the result.",
        "order over more than three repetitions",
        "loses the sample's regular order",
    ),
    "seams": Figure(
        "seams", "1 = as the sample's own", "low", 1.75,
        "Steps between neighbouring lines that what is around them does not explain.",
        "feathered seams; joints that end",
        "has visible seams",
    ),
    "sharpness": Figure(
        "sharpness", "ratio", "one", 1.15,
        "How strong the finest detail is beside the sample's.",
        "what the detail is",
        "is blurred|is noisier than the sample",
    ),
    "soft": Figure(
        "soft areas", "share", "low", 0.12,
        "How much of it is softer than the softest twentieth of the sample.",
        "what the detail is",
        "is blurred in places", 0.05,
    ),
    "period": Figure(
        "period", "share", "low", 0.12,
        "The largest part that comes back at one and the same shift.",
        "copies that are turned, scaled or blended",
        "repeats itself at one distance",
    ),
    "repeats": Figure(
        "near repeats", "share", "low", 0.2,
        "How much comes back within half the sample's side, beyond what a lattice makes come back.",
        "copies that are turned, scaled or blended",
        "shows the same things side by side",
    ),
    "copied": Figure(
        "copied", "share", "", None,
        "How much of it was taken over in pieces of at least 64 pixels.",
        "how good that is",
    ),
    "piece": Figure(
        "piece", "pixels", "", None,
        "The side of the piece that a pixel usually lies in.",
        "how good that is",
    ),
    "largest": Figure(
        "largest piece", "of the sample", "low", 0.5,
        "The largest piece that was taken over, beside the sample.",
        "many pieces that are smaller",
        "copies a large part of the sample in one piece",
    ),
    "evenness": Figure(
        "evenness of use", "share", "high", 0.33,
        "How much of the sample was used, counting what was used seldom for less.",
        "in what order the parts were used",
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
        "How far colours jump where two pieces meet.",
        "what else is in the picture",
        "has pieces that do not fit each other",
    ),
    "wrap": Figure(
        "seam at the wrap", "share", "low", 0.1,
        "How much of the border shows as a seam when the result is laid side by side.",
        "striking parts that give a tile away",
        "shows a seam where it repeats", 0.01,
    ),
}  # fmt: skip
"""Every figure by the name of its field in `Assessment`, in the order in which they are shown."""
