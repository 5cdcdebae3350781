"""Work outside Blender's main thread. Nothing here touches Blender's data."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from weftex.errors import CancelledError, WeftexError


class Job:
    """A call with progress that runs in a thread of its own.

    Attributes
    ----------
    done, total : int
        Steps of the current stage.
    stage : str
        What is being done.
    result : object
        What the call returned, once it has finished without an error.
    error : str
        Why it did not finish; empty if it did or was cancelled.
    cancelled : bool
    """

    def __init__(self, call: Callable[..., Any]) -> None:
        self.done, self.total, self.stage = 0, 1, "analyzing"
        self.result: Any = None
        self.error, self.cancelled = "", False
        self._call = call
        self._thread = threading.Thread(target=self._run, name="weftex", daemon=True)

    def start(self) -> None:
        """Begin the work and return at once."""
        self._thread.start()

    def cancel(self) -> None:
        """Ask the work to end; it does so after its current step."""
        self.cancelled = True

    @property
    def running(self) -> bool:
        """Whether the work goes on."""
        return self._thread.is_alive()

    def wait(self) -> None:
        """Return when the work has ended."""
        self._thread.join()

    def _progress(self, done: int, total: int, stage: str, preview: Any) -> bool:
        self.done, self.total, self.stage = done, total, stage
        return not self.cancelled

    def _run(self) -> None:
        try:
            self.result = self._call(progress=self._progress)
        except CancelledError:
            self.cancelled = True
        except (WeftexError, MemoryError) as error:
            self.error = str(error) or "not enough memory"
        except Exception as error:  # shown by Blender, as nobody waits for this thread
            self.error = f"{type(error).__name__}: {error}"
