"""What speaks for a lattice, and how often one is right that as much speaks for: its confidence.

A few figures say it. Of a pair of vectors the first is its contrast: how far the correlation at
multiples is above that between them; colors and light make some of it by chance. The second is what
is clear: the same of the whitened sample (see `weftex.analysis.whitening`), less what chance makes
there and in units of it; chance falls with the root of the number of multiples. Of a bond under
rows they are its contrast, and that in standard errors; of rows these two, and how far sums along
them differ from sums along other lines. A logistic regression puts them together. Its weights are
those that `python benchmarks/lattices.py --fit` prints; docs/lattice.md has how often each
confidence is right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: What 1 and the figures weigh, of each kind of evidence.
WEIGHTS = {
    "pairs": (-5.56, 4.47, 1.06, 0.31, 0.97),
    "rows": (-8.42, 2.39, 1.11, 1.57),
    "bonds": (-6.67, 8.00, 1.11),
}

#: Of the surest: some tiles pass for lattices that are part of one, whatever is seen.
SUREST = 0.98

_HALF = {"pairs": 0.05, "bonds": 0.25}  # contrast that counts half as much as any contrast could
_MOST = 40.0  # exponents beyond this are no numbers


@dataclass(frozen=True, eq=False)
class Evidence:
    """Vectors, and what speaks for them.

    Attributes
    ----------
    vectors : float64 array (2, 2) or (1, 2)
        As (x, y), in pixels of the relief: of a lattice, or from one row to the next.
    contrast : float
        Of the correlation at multiples; of pairs less its standard error.
    clear : float
        Of pairs the contrast of the whitened sample, in units of chance; of rows and bonds in
        standard errors.
    number : int
        Of multiples, that `clear` is a mean over.
    kind : str
        "pairs", "rows" or "bonds".
    apart : float
        Of rows: how many times the variance of sums along other lines that along them is.
    lines : (float, float)
        Of pairs: standard errors by which joints tell two families of their lines.
    """

    vectors: NDArray[np.float64]
    contrast: float
    clear: float
    number: int = 1
    kind: str = "pairs"
    apart: float = 1.0
    lines: tuple[float, float] = (0.0, 0.0)

    @property
    def figures(self) -> tuple[float, ...]:
        """What is weighed; each grows more slowly the larger it is."""
        contrast, clear = max(self.contrast, 0.0), max(self.clear, 0.0)
        sure = math.asinh(clear * self.number**0.5)
        if self.kind == "rows":
            return 1.0, contrast, sure, math.log(max(self.apart, 1.0))
        first = contrast / (_HALF[self.kind] + contrast)
        if self.kind == "bonds":
            return 1.0, first, sure
        return 1.0, first, sure, *(math.asinh(max(one, 0.0)) for one in self.lines)

    @property
    def confidence(self) -> float:
        """The share of lattices with such figures that are right, from 0 to `SUREST`.

        >>> import numpy as np
        >>> Evidence(np.eye(2), 0.4, 20.0, 60).confidence > 0.9
        True
        """
        weights = WEIGHTS[self.kind]
        total = sum(part * weight for part, weight in zip(self.figures, weights, strict=True))
        return SUREST / (1 + math.exp(-min(max(total, -_MOST), _MOST)))
