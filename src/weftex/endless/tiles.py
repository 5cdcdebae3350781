"""Corner tiles: a plane whose blocks depend on the colors of their nodes and on nothing else.

Each node of the grid has one of a few colors. A corner is made for each color, an edge for each
pair of colors, an inside for each four: so the square between any four nodes is one of a fixed set
of tiles, and tiles with the same colors at a side have the same pixels around it. After A. Lagae
and P. Dutré, An alternative for Wang tiles: colored edges versus colored corners (2006),
doi:10.1145/1183287.1183296. The set is made on a torus that has each tile once.
"""

from __future__ import annotations

import math

import numpy as np

from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.endless.boxes import Box, PlaneRequest
from weftex.endless.grid import Axis, Block, Grid, Sizes, loose_in
from weftex.endless.plane import Filler, Plane, usable_corners
from weftex.errors import InvalidInputError, size_words
from weftex.exemplar import Exemplar
from weftex.random import draw
from weftex.raster.arrays import Ints

_SHARE, _LEAST = 8, 8  # half of the belt is an eighth of the tile's shorter side; at least, pixels
_CANDIDATES = 256  # pieces of the sample from which corners are chosen
_CELLS = 8  # of a piece, a side, whose colors say whether it has a landmark
_OFF = 0.75  # pixels that a corner may lie off the lattice
#: Share of a side that whole periods may miss, up to which joints look unbroken.
_STRAIN = 0.01
_NEAR, _FAR = math.log(1.5), 4  # up to 1.5 times the size that is wished, or 4 times to name one
_PARTS = 1 << 16  # of a pixel, that steps of a lattice are in
_FIRST = "0001 0010 1011 0111"  # the torus of two colors
_UNIT = 16  # of a level


def torus(colors: int) -> Ints:
    """Colors (n, n) of the nodes of a torus where each square of four nodes occurs once.

    >>> torus(3).shape
    (9, 9)
    """
    if colors == 2:
        return np.array([[int(color) for color in row] for row in _FIRST.split()])
    # Rows are shifts of a ring with each pair once; from row to row by each distance once.
    ring, n = np.array([0, 0, 1, 0, 2, 1, 1, 2, 2]), colors**2
    across, down = np.arange(n), np.arange(n)[:, None]
    found: Ints = ring[(across + down * (down - 1) // 2) % n]
    return found


def belt_of(size: tuple[int, int]) -> int:
    """Width of corners and edges of tiles of a size, an even number of pixels."""
    return 2 * max(_LEAST, min(size) // _SHARE)


class TilePlane(Plane):
    """A torus of all tiles, of `size` (height, width) each.

    `vectors` are the sample's lattice x1, y1, x2, y2, of which the size has whole periods, or ().
    """

    def __init__(
        self,
        model: Filler,
        asked: PlaneRequest,
        size: tuple[int, int],
        colors: int,
        vectors: tuple[float, ...],
    ) -> None:
        self.torus, n, belt = torus(colors), colors**2, belt_of(size)
        loose = loose_in(belt) if model.block_sizes().loose else 0
        self.half_line = belt // 2 - loose  # pixels on both sides of a border that all tiles share
        axes = (Axis(n * side, n, wraps=True) for side in size)
        super().__init__(model, asked, Grid(Sizes(min(size), belt, loose), *axes))
        self._corners = typical_pieces(model.exemplar, belt, colors, asked.seed, vectors)
        self._first: dict[tuple[int, ...], Block] = {}
        for kind, i, j in np.ndindex(4, n, n):
            block = Block(kind, i, j)
            self._first.setdefault(self._colors(block), block)

    def name(self, block: Block) -> Block:
        """See `Plane.name`: the first block with these colors at its ends."""
        return self._first[self._colors(block)]

    def piece(self, block: Block) -> Ints:
        """See `Plane.piece`: one for each color."""
        found: Ints = self._corners[self._colors(block)[1]]
        return found

    def origin(self, block: Block, seen: Box) -> tuple[int, int]:
        """See `Plane.origin`: each tile begins anew, as it has whole periods."""
        down, across = self.grid.down.node(block.row), self.grid.across.node(block.column)
        return seen.rows.first - down, seen.columns.first - across

    def _colors(self, block: Block) -> tuple[int, ...]:
        """The kind of a block and the colors of the nodes at its ends."""
        kind, i, j = block
        down, across = (range(1 if at_node else 2) for at_node in block.at_nodes)
        n = len(self.torus)
        return kind, *(int(self.torus[(i + v) % n, (j + u) % n]) for v in down for u in across)


def typical_pieces(
    exemplar: Exemplar, belt: int, count: int, seed: int, vectors: tuple[float, ...]
) -> Ints:
    """Rows and columns (count, 2) in the sample of squares of `belt` pixels that are typical.

    Corners repeat more often than anything else in a set, so they have no landmarks, and the mean
    color of most pieces. With a lattice their middles are in phase with (0, 0).
    """
    places = np.argwhere(usable_corners(exemplar, belt))
    if vectors and len(places):
        lattice = CanvasLattice(vectors)
        times = np.stack(lattice.multiples(*(places.T + belt // 2)), axis=1)
        off = (times - np.rint(times)) @ lattice.sample
        places = places[(abs(off) <= _OFF).all(axis=1)]
    if not len(places):
        height, width = exemplar.shape
        what = " in phase with its lattice" if vectors else ""
        raise InvalidInputError(
            f"{exemplar.name} is {width}x{height}, too small for the corners of tiles: they need "
            f"{belt}x{belt} usable pixels{what}; give a larger sample, or a smaller tile size"
        )
    some = draw(seed, "corner", np.arange(_CANDIDATES)) % np.uint64(len(places))
    places = places[np.unique(some)]
    far = _differences(exemplar, places, belt)
    order = np.argsort(far, kind="stable")
    found: list[Ints] = []
    for apart in (belt, belt // 2, belt // 4, 1, 0):
        for place in places[order]:
            if len(found) < count and all(abs(place - one).max() >= apart for one in found):
                found.append(place)
    return np.array(found)


def _differences(exemplar: Exemplar, places: Ints, belt: int) -> Ints:
    """How far squares are from the usual one, in their mean color and their oddest cell."""
    pixels = exemplar.matching().astype(np.int64)
    mean = _UNIT * pixels.sum(axis=(0, 1)) // (pixels.shape[0] * pixels.shape[1])
    side, features = belt // _CELLS, []
    for y, x in places.tolist():
        rows, columns = (np.arange(at, at + side * _CELLS) for at in (y, x))
        square = pixels.take(rows, 0, mode="wrap").take(columns, 1, mode="wrap")
        cells = square.reshape(_CELLS, side, _CELLS, side, -1).sum(axis=(1, 3))
        away = _UNIT * cells // side**2 - mean
        odd = math.isqrt(int(np.square(away).sum(axis=2).max()))
        features.append([*(away.sum(axis=(0, 1)) // _CELLS**2), odd])
    off = np.array(features, np.int64)
    off -= np.sort(off, axis=0)[len(off) // 2]
    usual = np.sort(abs(off), axis=0)[len(off) // 2] + 1
    result: Ints = np.square(_UNIT * off // usual).sum(axis=1)
    return result


def size_with_periods(
    vectors: tuple[float, ...], wish: tuple[int, int], name: str
) -> tuple[int, int]:
    """Return the height and width nearest to those wished that have whole periods of a lattice.

    Raises `InvalidInputError`, which names them, if they are far away.
    """
    found: list[int] = []
    asked = f"no tile of about {size_words(wish)} pixels contains whole periods of"
    for axis, length in enumerate(wish):
        reach = [int(_FAR * length), 1]
        ends = CanvasLattice(vectors).steps(*(reach if axis == 0 else reach[::-1])) / _PARTS
        along, off = ends[:, axis], ends[:, 1 - axis]
        whole = np.rint(along)
        fits = (along >= 1) & (np.hypot(along - whole, off) <= _STRAIN * along)
        if not fits.any():
            raise InvalidInputError(
                f"{asked} the lattice of {name}; straighten it first, such as with --straighten"
            )
        found.append(int(min(whole[fits], key=lambda n: (abs(math.log(n / length)), n))))
    height, width = found
    if any(abs(math.log(n / side)) > _NEAR for n, side in zip(found, wish, strict=True)):
        raise InvalidInputError(f"{asked} the lattice of {name}; the nearest is {width}x{height}")
    return height, width
