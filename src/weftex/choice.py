"""What a choice among the methods says."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Choice:
    """A method for a sample, and why.

    Attributes
    ----------
    method : str
        A name in `weftex.METHODS`.
    parameters : dict
        Those that differ from the method's defaults.
    reason : str
        One line.
    warnings : tuple of str
        What no method can do with this sample, the figure that says so, and what would help.
    """

    method: str
    parameters: dict[str, Any] = field(default_factory=dict)
    reason: str = ""
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        return "; ".join((self.reason, *(f"but {text}" for text in self.warnings)))
