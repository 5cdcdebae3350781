"""What speaks for a lattice, and how often one is right that as much speaks for: its confidence.

Two figures say it. The contrast is how far the correlation at multiples is above that between
them; colors and light make some of it by chance. What is clear is the same of the whitened sample
(see `weftex.analysis.whitening`), less what chance makes there and in units of it; chance falls
with the root of the number of multiples. Rows of which joints alone tell (`weftex.analysis.joints`)
have two of their own: the contrast of edges in different strips, and how far these are alike; the
bond of rows (`weftex.analysis.bonds`) has one, how surely it is told. A logistic regression puts
figures together. `python benchmarks/lattices.py --fit` prints weights; docs/lattice.md says what
these were fitted on, and how often each confidence is right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: What 1, the contrast, and what is clear for the number of multiples weigh.
PAIRS = (-4.32, 6.32, 1.54)
#: The same of rows, whose contrast says nothing more.
ROWS = (-5.46, 0.0, 3.01)

#: What 1, and the geometric mean of the contrast and of how far strips are alike, weigh.
JOINTS = (-5.93, 13.96)
#: The same of a second family of joints, that crosses rows.
CROSSINGS = (-4.78, 15.82)
#: The same of stripes along both vectors of a lattice.
STRIPES = (-2.09, 12.34)
#: What 1, and how surely joints within rows tell their bond, weigh.
BONDS = (-9.02, 3.06)
#: The same where joints that cross rows are asked, too, whose figure of `CROSSINGS` weighs most.
BOTH = (-10.0, 3.06, 10.0)

#: Of the surest: some tiles pass for lattices that are part of one, whatever is seen.
SUREST = 0.95

_HALF = 0.05  # contrast that counts half as much as any contrast could
_MOST = 40.0  # exponents beyond this are no numbers


@dataclass(frozen=True, eq=False)
class Evidence:
    """Vectors, and what speaks for them.

    Attributes
    ----------
    vectors : float64 array (2, 2) or (1, 2)
        As (x, y), in pixels of the relief: of a lattice, or from one row to the next.
    contrast : float
        Of the correlation at multiples, less its standard error.
    clear : float
        Of the whitened sample, in units of chance.
    number : int
        Of multiples.
    kind : str
        "joints" of rows that joints tell: `clear` is how far edges of different strips are alike;
        "crossings" of what crosses them, and "stripes" of levels along both vectors of a lattice;
        "bonds" of the bond of rows: `clear` is how surely it is told; "both" of that and of what
        crosses rows: `contrast` is what weighs there.
    """

    vectors: NDArray[np.float64]
    contrast: float
    clear: float
    number: int
    kind: str = ""

    @property
    def figures(self) -> tuple[float, ...]:
        """What is weighed; each grows more slowly the larger it is."""
        contrast, clear = max(self.contrast, 0.0), max(self.clear, 0.0)
        if self.kind in ("joints", "crossings", "stripes"):
            return 1.0, math.sqrt(contrast * clear)
        if self.kind == "bonds":
            return 1.0, clear
        if self.kind == "both":
            return 1.0, clear, contrast
        return 1.0, contrast / (_HALF + contrast), math.asinh(clear * self.number**0.5)

    @property
    def confidence(self) -> float:
        """The share of lattices with such figures that are right, from 0 to `SUREST`.

        >>> import numpy as np
        >>> Evidence(np.eye(2), 0.4, 20.0, 60).confidence > 0.9
        True
        """
        plain = PAIRS if len(self.vectors) == 2 else ROWS
        weights: tuple[float, ...] = {
            "joints": JOINTS,
            "crossings": CROSSINGS,
            "stripes": STRIPES,
            "bonds": BONDS,
            "both": BOTH,
        }.get(self.kind, plain)
        total = sum(part * weight for part, weight in zip(self.figures, weights, strict=True))
        return SUREST / (1 + math.exp(-min(max(total, -_MOST), _MOST)))
