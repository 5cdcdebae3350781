"""The lattice of a near-regular sample: how it lies upon itself when it is shifted."""

from __future__ import annotations

import math
from dataclasses import dataclass

from weft.errors import InvalidInputError

Vector = tuple[float, float]


@dataclass(frozen=True)
class Lattice:
    """Translations under which a material looks the same.

    Attributes
    ----------
    vectors : tuple of (float, float)
        Two vectors (x, y) in pixels, x to the right and y downwards, with fractions; their
        parallelogram is the tile. Or one, where a material repeats along one direction only.
    confidence : float
        From 0 to 1.

    Raises
    ------
    InvalidInputError
        If the vectors are zero, not finite, or lie on one line.

    Examples
    --------
    >>> bond = Lattice(((64.0, 40.5), (128.0, 0.0)))
    >>> bond.area
    5184.0
    >>> bond.reduced().vectors
    ((64.0, 40.5), (64.0, -40.5))
    """

    vectors: tuple[Vector, ...]
    confidence: float = 1.0

    def __post_init__(self) -> None:
        plain = tuple((float(x), float(y)) for x, y in self.vectors)
        object.__setattr__(self, "vectors", plain)
        text = ", ".join(f"[{x:g}, {y:g}]" for x, y in plain)
        if len(plain) not in (1, 2):
            raise InvalidInputError(f"a lattice has one or two vectors, not {len(plain)}")
        if not all(math.isfinite(c) for v in plain for c in v):
            raise InvalidInputError(f"lattice vectors {text} are not finite")
        lengths = [math.hypot(*v) for v in plain]
        if min(lengths) < 1:
            raise InvalidInputError(f"lattice vectors {text}: each must be 1 pixel long or more")
        if len(plain) == 2 and abs(self.area) < 1e-6 * lengths[0] * lengths[1]:
            raise InvalidInputError(f"lattice vectors {text} lie on one line")

    @property
    def area(self) -> float:
        """Pixels of the tile (eq. 3.25); 0 for one vector."""
        if len(self.vectors) == 1:
            return 0.0
        (ax, ay), (bx, by) = self.vectors
        return abs(ax * by - bx * ay)

    def reduced(self) -> Lattice:
        """The same lattice by its shortest vectors, the shortest first; they point right or down."""
        first = self.vectors[0]
        if len(self.vectors) == 1:
            return Lattice((_rightward(first),), self.confidence)
        second = self.vectors[1]
        while True:  # Gauss: observation (iv) of the paper, until neither gets shorter
            if math.hypot(*second) < math.hypot(*first):
                first, second = second, first
            dot, square = first[0] * second[0] + first[1] * second[1], math.hypot(*first) ** 2
            times = math.ceil(dot / square - 0.5 - 1e-9)
            if times == 0:
                return Lattice((_rightward(first), _rightward(second)), self.confidence)
            second = second[0] - times * first[0], second[1] - times * first[1]

    def same_as(self, other: Lattice, tolerance: float = 0.015) -> bool:
        """Whether both are one lattice, by whatever vectors (observation iv of the paper).

        Parameters
        ----------
        other : Lattice
            The lattice to compare with.
        tolerance : float
            How far this lattice may miss each of the other's shortest vectors, to its length.
        """
        if len(self.vectors) != len(other.vectors):
            return False
        ours, theirs = self.reduced(), other.reduced()
        for x, y in theirs.vectors:
            near = ours.nearest((x, y))
            if math.hypot(near[0] - x, near[1] - y) > tolerance * math.hypot(x, y):
                return False
        return len(ours.vectors) == 1 or 0.5 < ours.area / theirs.area < 1.5

    def nearest(self, place: Vector) -> Vector:
        """The multiple that is nearest to a place (x, y); of one vector it or its opposite."""
        (ax, ay), (x, y) = self.vectors[0], place
        if len(self.vectors) == 1:
            corners = [(ax, ay), (-ax, -ay)]
        else:
            bx, by = self.vectors[1]
            det = ax * by - bx * ay
            a, b = math.floor((x * by - y * bx) / det), math.floor((ax * y - ay * x) / det)
            corners = [(i * ax + j * bx, i * ay + j * by) for i in (a, a + 1) for j in (b, b + 1)]
        return min(corners, key=lambda c: math.hypot(c[0] - x, c[1] - y))


def _rightward(vector: Vector) -> Vector:
    """It or its opposite (observation iii), so that neither axis is where the sign turns."""
    x, y = vector
    return (x, y) if x + y / 8 > 0 else (-x, -y)
