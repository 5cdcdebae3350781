"""Progress is a plain callable; terminal bars, notebooks and servers only subscribe to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from weftex.errors import CancelledError, InvalidInputError, shown

#: Called as ``callback(done, total, stage, preview)``; ``preview()`` renders the picture so far.
#: Returning False cancels, anything else goes on.
ProgressCallback = Callable[[int, int, str, Callable[[], Any]], object]


class Progress:
    """Report steps of one stage to a callback.

    Parameters
    ----------
    callback : callable or None
        See `ProgressCallback`; None reports to nobody.
    total : int
        The number of steps.
    stage : str
        What is being done, in a word.
    preview : callable
        Renders the picture as it stands.

    Examples
    --------
    >>> seen = []
    >>> progress = Progress(lambda done, *_: seen.append(done), 2, "patches", lambda: None)
    >>> progress.advance(1); progress.advance(1); seen
    [1, 2]
    """

    def __init__(
        self,
        callback: ProgressCallback | None,
        total: int,
        stage: str,
        preview: Callable[[], Any],
    ) -> None:
        if callback is not None and not callable(callback):
            raise InvalidInputError(f"progress is {shown(callback)}; it must be callable")
        self.callback, self.total, self.stage, self.preview = callback, total, stage, preview
        self.done = 0

    def advance(self, steps: int) -> None:
        """Count `steps` as done; raises `CancelledError` if the callback returns False."""
        self.done += steps
        if self.callback is None:
            return
        if self.callback(self.done, self.total, self.stage, self.preview) is False:
            raise CancelledError(f"cancelled after {self.done} of {self.total} {self.stage}")

    def within(self) -> ProgressCallback | None:
        """A callback for the work of one step: it only says how many steps are done, and cancels.

        Examples
        --------
        >>> seen = []
        >>> steps = Progress(lambda *now: seen.append(now[:3]), 2, "outputs", lambda: None)
        >>> Progress(steps.within(), 99, "pixels", lambda: None).advance(40); seen
        [(0, 2, 'outputs')]
        """
        callback = self.callback
        if callback is None:
            return None

        def ask(done: int, total: int, stage: str, preview: Callable[[], Any]) -> bool:
            return callback(self.done, self.total, self.stage, preview) is not False

        return ask
