"""Distributed's own scheduler state with workers that only tell it when a block is done.

Time is counted, not waited for: a block takes so many seconds, give or take a quarter, and the
scheduler is busy for as long as its state machine really was, and for messages.
"""

from __future__ import annotations

import heapq
import random
import time

from dask.task_spec import Task
from distributed.collections import HeapSet
from distributed.core import Status
from distributed.scheduler import ClientState, Scheduler, SchedulerState, WorkerState
from sortedcontainers import SortedDict

_SPREAD = 0.25
_WORKER = {"nthreads": 1, "memory_limit": 2**34, "local_directory": "", "nanny": None}
_ENDED = {"metadata": {}, "nbytes": 28, "type": b"", "typename": "", "startstops": []}


class Machinery(SchedulerState):
    """The scheduler without its network; `sent` are the tasks that it gave to workers."""

    def __init__(self, workers: int) -> None:
        queued = HeapSet(key=lambda task: task.priority)
        super().__init__({}, {}, SortedDict(), {}, {}, {}, {}, queued, False)
        self.sent: list[tuple[str, str, int]] = []
        self.client = self.clients["here"] = ClientState("here")
        for k in range(workers):
            name = f"tcp://10.0.{k // 250}.{k % 250}:1"
            about = {"address": name, "name": name, "server_id": name, "pid": k, **_WORKER}
            worker = WorkerState(status=Status.running, scheduler=self, **about)
            self.workers[name] = worker
            self.running.add(worker)
            self.total_nthreads += 1
            self.check_idle_saturated(worker)

    def log_event(self, topic: object, msg: object) -> None:
        """Nobody listens."""

    def transitions(self, recommendations: dict, stimulus_id: str) -> None:
        """As the scheduler does, but what workers are told is kept."""
        self.move(recommendations, {}, {}, stimulus_id)

    def move(self, recommendations: dict, client: dict, workers: dict, name: str) -> None:
        self._transitions(recommendations, client, workers, name)
        for address, messages in workers.items():
            compute = (one for one in messages if one["op"] == "compute-task")
            self.sent += [(address, one["key"], one["run_id"]) for one in compute]

    def submit(self, number: int) -> None:
        """A task that the client wants."""
        key = f"make_block-{number:08x}"
        task = self.new_task(key, Task(key, int), "released")
        task.priority, task.who_wants = (0, number), {self.client}
        self.client.wants_what.add(task)
        self.transitions({key: "waiting"}, "submit")

    def end(self, worker: str, key: str, run: int) -> None:
        """A worker is done with a task, and the client forgets it."""
        found = Scheduler.stimulus_task_finished(self, worker, "done", key, run, **_ENDED)
        self.move(*found, "done")
        Scheduler.stimulus_queue_slots_maybe_opened(self, stimulus_id="done")
        recommendations: dict = {}
        self._client_releases_keys([key], self.client, recommendations)
        self.transitions(recommendations, "released")


class Cluster:
    """Workers that make blocks, as `weftex.tasks.cluster` hands them out."""

    def __init__(self, workers: int, blocks: int, seconds: float, message: float) -> None:
        self.state = Machinery(workers)
        self.workers, self.blocks, self.seconds, self.message = workers, blocks, seconds, message
        self.ready = dict.fromkeys(self.state.workers, 0.0)
        self.events: list[tuple[float, str, str, int]] = []
        self.random, self.work = random.Random(1), 0.0

    def run(self) -> str:
        """Make all blocks; say what came of it."""
        clock, made = time.process_time(), min(self.blocks, max(16, 4 * self.workers))
        for number in range(made):
            self.state.submit(number)
        free = time.process_time() - clock + made * self.message
        busy, done = free, 0
        self.begin(free)
        while self.events:
            at, *ended = heapq.heappop(self.events)
            clock = time.process_time()
            self.state.end(*ended)
            if made < self.blocks:
                self.state.submit(made)
                made += 1
            cost = time.process_time() - clock + self.message
            free, busy, done = max(free, at) + cost, busy + cost, done + 1
            self.begin(free)
        end = max(free, *self.ready.values())
        share = 100 * self.work / end / self.workers
        return (
            f"{done} blocks of {self.seconds} s, {self.workers} workers: {end:.0f} s, workers "
            f"{share:.0f} % busy, scheduler {1000 * busy / done:.3f} ms a block, "
            f"{100 * busy / end:.1f} % busy"
        )

    def begin(self, at: float) -> None:
        """Workers start what they were sent, one after the other."""
        for address, key, run in self.state.sent:
            took = self.random.lognormvariate(-(_SPREAD**2) / 2, _SPREAD) * self.seconds
            self.work += took
            self.ready[address] = max(self.ready[address], at) + took
            heapq.heappush(self.events, (self.ready[address], address, key, run))
        self.state.sent.clear()
