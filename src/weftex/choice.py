"""A choice among the methods, and the reason for it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

__all__ = ["Choice"]


@dataclass(frozen=True)
class Choice:
    """A method for a sample, and why.

    Attributes
    ----------
    method : str
        A name in `weftex.METHODS`.
    parameters : dict
        Parameters that differ from the method's defaults.
    because : str
        The reason, as a clause.
    warnings : tuple of str
        Faults of the sample that no method can repair, with their size and a remedy.
    """

    method: str
    parameters: dict[str, Any] = field(default_factory=dict)
    because: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def reason(self) -> str:
        """One line: the method, and why."""
        return f"{self.method}, because {self.because}"

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers, texts, lists and dicts, ready for JSON."""
        return {
            "method": self.method,
            "parameters": self.parameters,
            "reason": self.reason,
            "warnings": list(self.warnings),
        }

    def __str__(self) -> str:
        return "; ".join((self.reason, *(f"but {text}" for text in self.warnings)))
