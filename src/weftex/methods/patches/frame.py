"""How windows of the sample lie on a canvas."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from weftex.canvas import Canvas
from weftex.methods.patches.method import PatchMethod

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Frame:
    """How windows of the sample lie on a canvas; see `frame_of`."""

    canvas: Canvas
    method: PatchMethod  # resolved
    window: tuple[int, int]  # rows and columns that are compared; no more than the canvas has
    boundary_width: int  # width w_E of the boundary zone on this canvas
    margin: tuple[int, int]  # by which a single pixel's window hangs over a border without wrap

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the canvas with its margins."""
        (height, width), (top, left) = self.canvas.shape, self.margin
        return height + 2 * top, width + 2 * left

    @property
    def inside(self) -> tuple[slice, slice]:
        """The canvas inside its margins."""
        (height, width), (top, left) = self.canvas.shape, self.margin
        return slice(top, top + height), slice(left, left + width)

    @property
    def known(self) -> NDArray[Any] | None:
        """The known pixels around a hole (section 2.3); None where everything is to be made."""
        hole = self.canvas.hole
        return self.canvas.known if hole is not None and not hole.all() else None


def frame_of(method: PatchMethod, canvas: Canvas) -> Frame:
    """Return the frame that fits the windows of a resolved method to a canvas.

    The boundary may be narrower than the method's, as the last patch of a wrapped row has a zone at
    either end.
    """
    assert method.boundary_width
    (height, width), (wraps_y, wraps_x) = canvas.shape, canvas.wrap
    side, boundary = method.window_side, method.boundary_width
    if method.pixelwise:
        margin = 0 if wraps_y else boundary, 0 if wraps_x else boundary
        return Frame(canvas, method, (side, side), boundary, margin)
    window = min(side, height), min(side, width)
    wrapped = [n // 4 for n, wraps in zip(window, canvas.wrap, strict=True) if wraps]
    return Frame(canvas, method, window, max(1, min([boundary, *wrapped])), (0, 0))
