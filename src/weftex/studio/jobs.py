"""Work that takes a while: in a queue, with progress and previews, and it can be cancelled."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from weftex.errors import CancelledError
from weftex.progress import listening
from weftex.recipe import Recipe
from weftex.studio.limits import Limits
from weftex.studio.pictures import smaller
from weftex.studio.refusals import Refusal, answer_of
from weftex.studio.sessions import Session

Work = Callable[["Job"], None]

#: Threads that take any job, and further ones that take only those in lanes, such as previews.
WORKERS, QUICK = 2, 1
_PREVIEW = 512  # pixels a side
_PREVIEW_SHARE = 0.2  # of the time that may be spent on previews
_PREVIEW_EVERY = 0.15  # seconds
_NEWS_EVERY = 0.1  # seconds between two reports of progress alone
ENDED = ("done", "failed", "cancelled")


class Job:
    """One piece of work of a session; it ends the one before it in its `lane`.

    `work` takes the job, which is the progress callback; `keep` says that it goes on when its page
    goes. A lane is any value of JSON.
    """

    def __init__(
        self,
        session: Session,
        work: Work,
        lane: Any = None,
        recipe: Recipe | None = None,
        keep: bool = False,
    ) -> None:
        self.id, self.session = os.urandom(12).hex(), session
        self.work, self.lane, self.recipe, self.keep = work, lane, recipe, keep
        self.state, self.version = "waiting", 1
        self.done, self.total, self.stage = 0, 0, ""
        self.results: list[dict[str, Any]] = []
        self.failure: dict[str, str | None] = {"error": None, "parameter": None}
        self.picture: tuple[int, Any] = (0, None)  # of the preview: its number and pixels
        self.to_show: Callable[[Any], Any] = lambda pixels: pixels
        self.asked = time.monotonic()
        self.wanted = False  # whether somebody waits for news
        self._stop = False
        self._start = self._stage_start = self._shown = self._told = 0.0
        self._end: float | None = None

    def __call__(self, done: int, total: int, stage: str, preview: Callable[[], Any]) -> bool:
        """Take progress in; False once it is to stop."""
        now = time.perf_counter()
        if (stage, total) != (self.stage, self.total) or done < self.done:
            self._stage_start = now
        self.done, self.total, self.stage = done, total, stage
        if self.wanted and now - self._shown > _PREVIEW_EVERY and not self._stop:
            pixels = preview()
            if isinstance(pixels, np.ndarray) and pixels.size:
                times = -(-max(pixels.shape[:2]) // _PREVIEW)
                shown = smaller(self.to_show(pixels), times)
                self.picture = self.picture[0] + 1, (shown, pixels.shape[:2])
                self.version += 1
            self._shown = now + (time.perf_counter() - now) / _PREVIEW_SHARE
        if now - self._told > _NEWS_EVERY:
            self._told = now
            self.version += 1
        return not self._stop

    def cancel(self) -> None:
        """Stop it at its next step; one that waits never begins."""
        self._stop = True
        if self.state == "waiting":
            self._finish("cancelled")

    def run(self) -> None:
        """Do the work."""
        self._start = self._stage_start = time.perf_counter()
        self.version += 1
        try:
            self.check()
            with listening(self):
                self.work(self)
        except CancelledError:
            self._finish("cancelled")
        except Exception as error:  # one line for the page, whatever it is
            self.failure.update(answer_of(error)[1])
            self._finish("failed")
        else:
            self._finish("cancelled" if self._stop else "done")

    def _finish(self, state: str) -> None:
        self._end = time.perf_counter()
        self.state = state
        self.version += 1

    def check(self) -> None:
        """Raise `CancelledError` once it is to stop."""
        if self._stop:
            raise CancelledError("cancelled")

    def add(self, result: dict[str, Any]) -> None:
        """Add something that is done."""
        self.results.append(result)
        self.version += 1

    def as_json(self, ahead: int) -> dict[str, Any]:
        """Return the job as JSON for the page; `ahead` jobs come before it."""
        now, left = self._end or time.perf_counter(), None
        if self.state == "running" and self.done and now - self._stage_start > 0.2:
            left = round((now - self._stage_start) * (self.total - self.done) / self.done, 1)
        names = ("id", "version", "state", "keep", "done", "total", "stage")
        return {
            **{name: getattr(self, name) for name in names},
            "seconds": round(now - self._start, 3) if self._start else 0.0,
            "left": left,
            "ahead": ahead,
            "preview": self.picture[0],
            **self.failure,
            "results": list(self.results),
            "recipe": None if self.recipe is None else self.recipe.as_json(),
        }


class Jobs:
    """The queue of all sessions, and the threads that work on it."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self._jobs: dict[str, Job] = {}
        self._change = threading.Condition()
        self._open = True
        self._threads = [
            threading.Thread(target=self._work, args=(k >= WORKERS,), daemon=True)
            for k in range(WORKERS + QUICK)
        ]
        for thread in self._threads:
            thread.start()

    def add(self, job: Job) -> None:
        """Queue a job."""
        with self._change:
            for other in self.of(job.session):
                if job.lane is not None and other.lane == job.lane:
                    other.cancel()
            busy = [one for one in self._jobs.values() if one.state not in ENDED]
            own = sum(one.session is job.session for one in busy)
            if len(busy) >= self.limits.jobs or own >= self.limits.session_jobs:
                raise Refusal(429, f"{len(busy)} jobs are waiting; let some of them finish first")
            ended = [one for one in self._jobs.values() if one.state in ENDED]
            for old in ended[: max(0, len(ended) - 4 * self.limits.jobs)]:
                del self._jobs[old.id]
            self._jobs[job.id] = job
            self._change.notify_all()

    def get(self, name: str, session: Session) -> Job:
        """Return a job of a session, or raise `Refusal`."""
        job = self._jobs.get(name)
        if job is None or job.session is not session:
            raise Refusal(404, "there is no such job")
        return job

    def of(self, session: Session) -> list[Job]:
        """Return the jobs of a session."""
        return [job for job in list(self._jobs.values()) if job.session is session]

    def ahead(self, job: Job) -> int:
        """How many wait before it."""
        waiting = self._waiting()
        return waiting.index(job) if job in waiting else 0

    def _waiting(self) -> list[Job]:
        return [one for one in list(self._jobs.values()) if one.state == "waiting"]

    def end(self, session: Session, *, kept: bool = True) -> None:
        """Cancel the jobs of a session; if not `kept`, those alone that end with their page."""
        for job in self.of(session):
            if kept or not job.keep:
                job.cancel()

    def sweep(self) -> None:
        """Cancel jobs that nobody has asked about for a while."""
        now = time.monotonic()
        for job in list(self._jobs.values()):
            if now - job.asked > self.limits.away_seconds and not job.keep:
                job.cancel()

    def close(self) -> None:
        """Cancel everything; threads end with their job's next step."""
        with self._change:
            self._open = False
            for job in self._jobs.values():
                job.cancel()
            self._change.notify_all()
        for thread in self._threads:
            thread.join(2)

    def _next(self, quick: bool) -> Job | None:
        """The job that is to run: of the session that has fewest running, the first."""
        waiting = [job for job in self._waiting() if job.lane is not None or not quick]
        running = [job.session.key for job in self._jobs.values() if job.state == "running"]
        return min(waiting, key=lambda job: running.count(job.session.key), default=None)

    def _work(self, quick: bool) -> None:
        while True:
            with self._change:
                while self._open and (job := self._next(quick)) is None:
                    self._change.wait()
                if not self._open:
                    return
                assert job is not None
                job.state = "running"
            job.run()
