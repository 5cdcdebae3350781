"""Methods with a parameter `window_width`: the window around a pixel that is compared."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Self

from weftex.method import Method

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar


class WindowedMethod(Method):
    """Base of methods whose field `window_width` may be left open."""

    if TYPE_CHECKING:  # the subclasses declare it, each with its own help
        window_width: int | None

    def window_for(self, proposed: int) -> int:
        """See `Method.window_for`."""
        return self.window_width or proposed

    def for_belt(self, width: int) -> Self:
        """See `Method.for_belt`."""
        width = self.window_for(width)
        return dataclasses.replace(self, window_width=width)  # type: ignore[call-arg]

    def window_of(self, exemplar: Exemplar) -> int:
        """See `Method.window_of`."""
        settled = self.settle(exemplar)
        assert isinstance(settled, WindowedMethod)
        return settled.window_for(0)
