"""What the server does not do, as one line and a status."""

from __future__ import annotations

from weftex.errors import WeftexError


class Refusal(WeftexError):
    """A request that is not answered as asked."""

    def __init__(self, status: int, message: str, parameter: str | None = None) -> None:
        super().__init__(message)
        self.status, self.parameter = status, parameter
