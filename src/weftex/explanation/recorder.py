"""The protocol of recorders, which turn the notes of a method into stages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.explanation.stages import Stage


class Recorder(Protocol):
    """Records the notes of one run and returns stages; arrays are copied, as they change later."""

    def __init__(self, exemplar: Exemplar, pixel: tuple[int, int]) -> None: ...

    def record(self, step: str, facts: dict[str, Any]) -> None:
        """Record a note, see `weftex.notes.Listener`."""

    def stages(self) -> list[Stage]:
        """Return the steps that made the pixel, in order; none if it was not made."""
