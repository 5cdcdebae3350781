"""How an endless plane is divided into blocks.

Corners lie at the nodes of a square grid, edges between two corners, an interior between four
corners and four edges::

    +--+--------+--+        c  corner    a copied piece of the sample, or a start of its own
    |c |   a    |c |        a  across    depends on the corners at its ends
    +--+--------+--+        d  down      likewise
    |  |        |  |        i  inside    depends on the four corners and four edges around it
    |d |   i    |d |
    |  |        |  |
    +--+--------+--+
    |c |   a    |c |
    +--+--------+--+

So a pixel depends on nine blocks at most, whatever was asked for before. Where a method may replace
pixels that are there, blocks reach a few pixels (`loose`) into those that they depend on.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

from weftex.endless.boxes import Box, Span

#: Kinds of blocks in the order in which they are made: corners, edges across and down, interiors.
CORNER, ACROSS, DOWN, INSIDE = range(4)


class Sizes(NamedTuple):
    """Block sizes in pixels: `pitch` between nodes, even `belt` width of corners and edges.

    `loose` is how far a block may change earlier ones, see `loose_in`; `around` is how much of the
    start is visible beside corners and edges.
    """

    pitch: int
    belt: int
    loose: int = 0
    around: int = 0


def loose_in(belt: int) -> int:
    """How far a block may change a belt: up to 8 pixels from its middle, or an eighth of it."""
    return belt // 2 - min(8, belt // 8)


class Block(NamedTuple):
    """A block by its kind and the node at its upper left end."""

    kind: int
    row: int
    column: int

    @property
    def at_nodes(self) -> tuple[bool, bool]:
        """Whether it lies at nodes along y and along x, or between them."""
        return self.kind in (CORNER, ACROSS), self.kind in (CORNER, DOWN)


@dataclass(frozen=True)
class Axis:
    """The nodes along an axis: `count` of them, evenly spaced, in each `period` pixels."""

    period: int
    count: int
    wraps: bool = False

    def node(self, number: int) -> int:
        """Where a node lies."""
        cycle, k = divmod(number, self.count)
        return cycle * self.period + k * self.period // self.count

    def name(self, number: int) -> int:
        """The number that stands for all nodes that are the same one."""
        return number % self.count if self.wraps else number

    def last_before(self, pixel: int) -> int:
        """The last node at or before a pixel."""
        number = pixel * self.count // self.period
        return number + 1 if self.node(number + 1) <= pixel else number


class Grid(NamedTuple):
    """The blocks of a plane."""

    sizes: Sizes
    down: Axis
    across: Axis

    def own(self, block: Block) -> Box:
        """The pixels of a block itself."""
        down, across = block.at_nodes
        rows = self._span(self.down, block.row, down)
        return Box(rows, self._span(self.across, block.column, across))

    def reached(self, block: Block) -> Box:
        """The same and what it may replace."""
        rows, columns = (0 if at_node else self.sizes.loose for at_node in block.at_nodes)
        return self.own(block).grown(rows, columns)

    def seen(self, block: Block) -> Box:
        """The same box with all that it depends on; beside that what a start shows."""
        belt, around = self.sizes.belt, self.sizes.around
        along = belt - self.sizes.loose if block.kind == INSIDE else belt
        rows, columns = (around if at_node else along for at_node in block.at_nodes)
        return self.own(block).grown(rows, columns)

    def dependencies(self, block: Block) -> list[Block]:
        """The blocks that must be there before, in their order."""
        kind, i, j = block
        if kind == CORNER:
            return []
        if kind == ACROSS:
            return [Block(CORNER, i, j), Block(CORNER, i, j + 1)]
        if kind == DOWN:
            return [Block(CORNER, i, j), Block(CORNER, i + 1, j)]
        return [
            *(Block(CORNER, i + v, j + u) for v in (0, 1) for u in (0, 1)),
            *(Block(ACROSS, i + v, j) for v in (0, 1)),
            *(Block(DOWN, i, j + u) for u in (0, 1)),
        ]

    def of_window(self, box: Box) -> list[Block]:
        """The blocks that a window depends on, in an order in which they can be made and pasted.

        Row by row of the grid, so that few are in use at a time; corners and edges of a row come
        before the interiors above it.
        """
        half, found = self.sizes.belt // 2, set[Block]()
        rows, columns = (
            range(axis.last_before(first - half) - 1, axis.last_before(last + half) + 2)
            for axis, (first, last) in zip((self.down, self.across), box, strict=True)
        )
        for kind, i, j in product((CORNER, ACROSS, DOWN, INSIDE), rows, columns):
            block = Block(kind, i, j)
            if all(part.start < part.stop for part in self.shown(block).within(box)):
                found |= {block, *self.dependencies(block)}
        return sorted(found, key=lambda b: (b.row + (not b.at_nodes[0]), b.kind, b.column))

    def shown(self, block: Block) -> Box:
        """A box around what others leave of a block and of what it replaces."""
        kind, loose = block.kind, self.sizes.loose
        if kind in (CORNER, INSIDE):
            return self.reached(block)
        rows, columns = (loose, -loose) if kind == DOWN else (-loose, loose)
        return self.own(block).grown(rows, columns)

    def _span(self, axis: Axis, number: int, at_node: bool) -> Span:
        half = self.sizes.belt // 2
        if at_node:
            return Span(axis.node(number) - half, axis.node(number) + half)
        return Span(axis.node(number) + half, axis.node(number + 1) - half)
