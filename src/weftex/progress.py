"""Progress is a plain callable; terminal bars, notebooks and servers only subscribe to it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from time import perf_counter, process_time, thread_time
from typing import Any, Literal

from weftex.errors import CancelledError, wrong_value

__all__ = ["Bar", "Progress", "ProgressCallback", "listening"]

ProgressCallback = Callable[[int, int, str, Callable[[], Any]], object] | Literal[True]
"""A function ``progress(done, total, stage, render)``, or True for a progress bar.

It is called after each step, with the number of finished steps (`done`), their number (`total`),
and the name of the `stage`. ``render()`` returns the image so far, or None during an analysis or a
fit, which come first and count in percent. If the function returns False, the work stops with
`weftex.CancelledError`; any other value continues.
"""

PAUSE = 0.2  # seconds from one drawing to the next
_REST = 200  # times what a drawing took, which the process must have worked before the next
_LONGEST = 2.0  # seconds after which it need not, as others may work for it


class Bar:
    """A progress callback that draws a bar on a terminal or in a notebook, `after` some seconds.

    `seconds` has the time of each stage.
    """

    def __init__(self, after: float = 0.5) -> None:
        self._start = self._begun = perf_counter()
        self._next, self._rested = self._start + after, 0.0
        self._now, self._drawn = (0, 0, "preparing"), (0, 0, "")
        self._bar: Any = None
        self.seconds: dict[str, float] = {}

    def __call__(self, done: int, total: int, stage: str, preview: Callable[[], Any]) -> bool:
        """Count, and draw now and then."""
        clock = perf_counter()
        if stage != self._now[2]:
            self._end_stage(clock)
        self._now = (done, total, stage)
        if self._is_time(clock):
            self.draw()
        if done >= total:
            self.close()
        return True

    def _is_time(self, clock: float) -> bool:
        """Whether to draw: that must take less than a hundredth, also on a busy machine."""
        if clock < self._next:
            return False
        return process_time() >= self._rested or clock >= self._next + _LONGEST

    def draw(self) -> None:
        """Show how far it is."""
        done, total, stage = self._now
        if self._bar is not None and self._bar.total is None and total:
            self._bar.close()
            self._bar = None
        if self._bar is None:
            if "IPython" in sys.modules:
                from tqdm.auto import tqdm
            else:  # the same, in half the time
                from tqdm import tqdm

            how = {} if total else {"bar_format": f"{stage} {{elapsed}}"}  # nothing to count yet
            self._bar = tqdm(
                total=total or None, unit=f" {stage}", leave=False, miniters=1, mininterval=0, **how
            )
            self._drawn = (0, total, stage)
        start = thread_time()
        if (total, stage) != self._drawn[1:] or done < self._drawn[0]:  # another count begins
            self._bar.unit = f" {stage}"
            self._bar.reset(total)
        self._bar.update(done - self._bar.n)
        self._bar.refresh()  # the time goes on where no step ends
        self._drawn = self._now
        self._next = perf_counter() + PAUSE
        self._rested = process_time() + _REST * (thread_time() - start)

    def close(self) -> None:
        """Take the bar off the screen."""
        self._end_stage(perf_counter())
        if self._bar is not None:
            self._bar.close()
            self._bar, self._drawn = None, (0, 0, "")

    def _end_stage(self, clock: float) -> None:
        stage = self._now[2]
        self.seconds[stage] = self.seconds.get(stage, 0.0) + clock - self._begun
        self._begun = clock


def _called(callback: ProgressCallback | None) -> Callable[..., object] | None:
    """Return what to call, a bar for True; raises `InvalidInputError` if it cannot be called."""
    called = Bar() if callback is True else callback
    if called is not None and not callable(called):
        raise wrong_value("progress", called, "callable, or True")
    return called


class Progress:
    """Reports the steps of one stage to a callback, with a function that renders a preview."""

    def __init__(
        self, callback: ProgressCallback | None, total: int, stage: str, preview: Callable[[], Any]
    ) -> None:
        self.callback, self.done = _called(callback), 0
        self.total, self.stage, self.preview = total, stage, preview

    def advance(self, steps: int) -> None:
        """Count `steps` as done; raises `CancelledError` if the callback returns False."""
        self.done += steps
        if self.callback is None:
            return
        if self.callback(self.done, self.total, self.stage, self.preview) is False:
            raise CancelledError(f"cancelled after {self.done} of {self.total} {self.stage}")

    def within(self) -> ProgressCallback | None:
        """A callback for the work inside one step: it repeats this progress and can cancel."""
        callback = self.callback
        if callback is None:
            return None

        def ask(done: int, total: int, stage: str, preview: Callable[[], Any]) -> bool:
            return callback(self.done, self.total, self.stage, preview) is not False

        return ask


#: What hears of `counted` work.
_listener: ContextVar[Callable[..., object] | None] = ContextVar("listener", default=None)


@contextmanager
def listening(callback: ProgressCallback | None) -> Iterator[None]:
    """Report the analyses and fits of this thread to a function, within the block.

    For functions without `progress`, such as `weftex.analyze` and `Method.fit`. Fast fits report
    nothing, and a percentage may end below 100.

    Parameters
    ----------
    callback : callable or True, optional
        See `ProgressCallback`.

    Examples
    --------
    >>> import weftex
    >>> from weftex.progress import listening
    >>> with listening(lambda done, total, stage, render: None):
    ...     found = weftex.analyze("sample:weave")
    """
    called = _listener.get() if callback is None else _called(callback)
    token = _listener.set(called)
    try:
        yield
    finally:
        _listener.reset(token)
        if callback is True and isinstance(called, Bar):
            called.close()


@contextmanager
def counted(total: float, stage: str) -> Iterator[Callable[[float], None]]:
    """Count work to which no callback is passed, such as an analysis or a fit, in percent.

    Yields a function that advances by steps; work counted within a step is its share of that step.
    """
    callback, done = _listener.get(), 0.0

    def tell(share: float) -> bool:
        if callback is None:
            return True
        percent = int(100 * (done + min(share, 0.99)) / total)
        return callback(percent, 100, stage, lambda: None) is not False

    def advance(steps: float) -> None:
        nonlocal done
        done += steps
        if not tell(0.0):
            raise CancelledError(f"cancelled after {100 * done / total:.0f} % of {stage}")

    def within(part: int, of: int, inner: str, preview: Callable[[], Any]) -> bool:
        return tell(part / of if of else 0.0)

    with listening(None if callback is None else within):
        advance(0)
        yield advance
