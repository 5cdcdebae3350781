"""The evidence for a lattice, and its calibrated confidence.

`contrast` is how far the correlation at multiples is above that between them; `clear` is the same
of the whitened sample, less chance and in units of it, which falls with the root of the number of
multiples. Rows by joints (`weftex.analysis.joints`) have the contrast of edges in different strips
and how alike these are; the bond of rows has one figure. A logistic regression combines them.
`python benchmarks/quality/lattices.py --fit` prints weights, and
docs/lab/lattice-detection.md has their reliability.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Weights of 1, the contrast, and `clear` by the number of multiples.
PAIRS = (-4.32, 6.32, 1.54)
#: The same of rows, whose contrast adds nothing.
ROWS = (-5.46, 0.0, 3.01)

#: Weights of 1, and of the geometric mean of the contrast and of how alike strips are.
JOINTS = (-5.93, 13.96)
#: The same of a second family of joints that crosses rows.
CROSSINGS = (-4.78, 15.82)
#: The same of stripes along both vectors of a lattice.
STRIPES = (-2.09, 12.34)
#: Weights of 1, and of the evidence of joints within rows.
BONDS = (-9.02, 3.06)
#: The same with joints that cross rows, whose figure of `CROSSINGS` is added.
BOTH = (-10.0, 3.06, 10.0)

#: Of the surest: some tiles pass for lattices that are part of one, whatever is fields.
SUREST = 0.95

_HALF = 0.05  # contrast that counts half as much as any contrast could
_MOST = 40.0  # exponents beyond this are no numbers


@dataclass(frozen=True, eq=False)
class Evidence:
    """The evidence for vectors (x, y) in pixels of the relief: two, or one from row to row.

    `kind` says what the figures measure: "" the correlations, "joints" of rows, "crossings" of
    joints across rows, "stripes" along both vectors, "bonds" within rows, or "both" of these.
    """

    vectors: NDArray[np.float64]
    contrast: float  # at multiples, less its standard error
    clear: float  # of the whitened sample, in units of chance; see `kind`
    number: int  # of multiples
    kind: str = ""

    @property
    def figures(self) -> tuple[float, ...]:
        """The figures that are weighted; each grows more slowly the larger it is."""
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
        """The share of lattices with such evidence that are right, from 0 to `SUREST`.

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
