"""Who listens to a method at work: one class for each family of methods."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.explanation.stages import Stage


class Watcher(Protocol):
    """Hears the notes of one run, and makes stages of them.

    A note's arrays go on changing, so what is needed later is copied when it is heard.
    """

    def __init__(self, exemplar: Exemplar, pixel: tuple[int, int]) -> None: ...

    def hear(self, step: str, facts: dict[str, Any]) -> None:
        """Take in what a step has in hand, see `weftex.notes.Listener`."""

    def stages(self) -> list[Stage]:
        """The steps that made the pixel, in their order; none if it was not made."""
