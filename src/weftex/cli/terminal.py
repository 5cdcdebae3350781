"""Run a command from a shell: progress bar, all outputs or none, a quick end on Ctrl-C."""

from __future__ import annotations

import os
import select
import signal
import stat
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack, suppress
from time import perf_counter
from typing import Any, TypeVar

from weftex import progress
from weftex.errors import InvalidInputError, printable

Result = TypeVar("Result")

_PATIENCE = 0.6  # seconds that work in hand has to end by itself
#: Signals that stop a command; SIGHUP is that its terminal is closed.
_SIGNALS = [getattr(signal, one) for one in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, one)]
_heard: list[int] = []
#: Whether a program runs the command: messages are JSON, and closing standard input stops it.
for_program = False
#: Files and folders that the command reads, which it never writes.
inputs: list[str] = []


class Stopped(BaseException):
    """A signal stopped the command; `code` is the exit code, `left` says what was written."""

    def __init__(self, code: int, left: str = "nothing was written") -> None:
        super().__init__(code)
        self.code, self.left = code, left


def hear_signals(left: str = "nothing was written") -> None:
    """Raise `Stopped` on the next signal, unless the process ignored it when it began."""

    def stop(number: int, frame: object) -> None:
        ignore_signals()
        raise Stopped(128 + number, left)

    _heard[:] = _heard or [one for one in _SIGNALS if signal.getsignal(one) is not signal.SIG_IGN]
    for number in _heard:
        signal.signal(number, stop)


def ignore_signals() -> None:
    """Ignore the signals that are heard: the command is about to end."""
    for number in _heard:
        signal.signal(number, signal.SIG_IGN)


def remove_temporary_files() -> None:
    """Remove those of this process, which ends at once."""
    temporary = sys.modules.get("weftex.io.temporary")
    if temporary is not None:
        temporary.release_all()


def open_closed_streams() -> None:
    """Open the null device for closed standard streams, so that no other file gets their numbers.

    Reading standard input and writing standard output still fail.
    """
    how = {"stdin": ("r", os.O_WRONLY), "stdout": ("w", os.O_RDONLY), "stderr": ("w", os.O_WRONLY)}
    for number, (name, (mode, flags)) in enumerate(how.items()):
        if getattr(sys, name) is None:
            opened = os.open(os.devnull, flags)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


class Bar(progress.Bar):
    """Progress on a terminal, drawn by the main thread, which has nothing else to do."""

    left = "nothing was written"  # what is there if the work is stopped now

    def __init__(self, quiet: bool) -> None:
        super().__init__()
        self._at_stop: list[Callable[[], None]] = []
        self.at_stop = self._at_stop.append  # has something done when the work is stopped
        self._shows = not quiet and (for_program or sys.stderr.isatty())
        self.stopped = False

    def __call__(self, done: int, total: int, stage: str, preview: Callable[[], Any]) -> bool:
        """Count; False once `stop` was called. This is all that the work waits for."""
        if stage != self._now[2]:
            self._end_stage(perf_counter())
        self._now = (done, total, stage)
        return not self.stopped

    @property
    def took(self) -> float:
        """Seconds since the work began."""
        return perf_counter() - self._start

    def show(self) -> None:
        """Draw, if it is time; a program gets every change."""
        if self._shows and for_program and self._now != self._drawn:
            self._drawn = self._now
            _print_fields(dict(zip(("done", "of", "stage"), self._now, strict=True)))
        elif self._shows and not for_program and self._is_time(perf_counter()):
            self.draw()

    def stop(self) -> None:
        """Cancel the work at its next step."""
        self.stopped = True
        for act in self._at_stop:
            act()


def refuse_input(path: str) -> None:
    """Raise `InvalidInputError` if a path to write is an input, or is in an input folder."""
    for one in inputs if os.path.exists(path) else ():
        folder = os.path.isdir(one) and os.path.isfile(path)
        inside = [os.path.join(one, name) for name in os.listdir(one)] if folder else []
        if any(os.path.exists(read) and os.path.samefile(read, path) for read in (one, *inside)):
            raise InvalidInputError(f"{path} is an input; name another file")


class Outputs(ExitStack):
    """Files that appear together when all of them are written, or not at all."""

    def __init__(self) -> None:
        super().__init__()
        self._made: list[str] = []
        #: Held while files appear, which is not to be cut off.
        self.appearing = threading.Lock()

    def __exit__(self, *error: Any) -> None:
        try:
            with self.appearing:
                super().__exit__(*error)
        finally:
            if error[0] is not None:
                self.sweep()

    def make_folder(self, path: str) -> None:
        """Make a folder that goes again if anything fails."""
        from weftex.errors import FileError
        from weftex.io.formats import READABLE, suffix_of

        if os.path.isdir(path):
            return
        if suffix_of(path) in READABLE:
            raise FileError(f"{path}: the output has several files; name a folder")
        try:
            os.mkdir(path)
        except OSError as error:
            why = "it is a file" if os.path.exists(path) else error.strerror
            raise FileError(f"{path}: cannot make this folder: {why}") from None
        self._made.append(path)

    def staged_path(self, path: str) -> str:
        """Return a temporary path to write what appears at `path` when the work has ended well."""
        from weftex.io.pictures import atomic

        refuse_input(path)
        return self.enter_context(atomic(path))

    def sweep(self) -> None:
        """Remove the folders that were made."""
        for folder in reversed(self._made):
            with suppress(OSError):
                os.rmdir(folder)


def run(work: Callable[[Bar, Outputs], Result], quiet: bool) -> tuple[Result, Bar]:
    """Do `work` in a thread, so that a signal ends it within a second; return its result and bar.

    The main thread gets signals while compiled code runs. Outputs appear when the work ends well; a
    signal after that is ignored. Raises `Stopped`, or ends the process if the work does not stop.
    """
    from weftex.io.formats import image_library

    image_library()  # in a thread its 25 MiB would be mapped a page at a time: 8 ms
    # Once memory of this size is freed, glibc keeps what smaller arrays free: 20 ms of page faults.
    bytes(2**22)
    outputs = Outputs()
    bar, ended = Bar(quiet), threading.Event()
    outcome: list[tuple[Result | None, BaseException | None]] = []
    stopped: Stopped | None = None

    def begin() -> None:
        try:
            with outputs, progress.listening(bar):
                done = work(bar, outputs)
            outcome.append((done, None))
        except BaseException as error:
            outcome.append((None, error))
        finally:
            ended.set()

    try:
        threading.Thread(target=begin, daemon=True).start()
        while not ended.wait(progress.PAUSE):  # for ever, and Windows would not notice Ctrl-C
            bar.show()
            if for_program and _input_closed():
                raise Stopped(129, bar.left)
        ignore_signals()
    except (KeyboardInterrupt, Stopped) as error:
        ignore_signals()
        stopped = Stopped(error.code if isinstance(error, Stopped) else 130, bar.left)
        bar.stop()
        if not ended.wait(_PATIENCE) and outputs.appearing.acquire(blocking=False):
            remove_temporary_files()
            outputs.sweep()
            say(bar.left, "stopped")
            os._exit(stopped.code)
        ended.wait()
    finally:
        bar.close()
    result, failure = outcome[0]
    if failure is not None:
        raise (stopped or failure) from None
    return result, bar  # type: ignore[return-value]


def run_and_report(
    work: Callable[[Bar, Outputs], str], quiet: bool, *, verbose: bool = False
) -> None:
    """`run`, and what `work` returns is said unless `quiet`; what stages took, if `verbose`."""
    message, bar = run(work, quiet)
    if verbose:
        for stage, seconds in bar.seconds.items():
            say(f"stage: {stage} {seconds:.2f} s")
    if not quiet:
        for line in message.splitlines():
            say(line)


def print_json(found: object) -> None:
    """Print measures on standard output; what JSON does not have as text."""
    import json

    print(json.dumps(found, indent=1, default=str))


def say(text: str, kind: str = "message") -> None:
    """Print one line about this program on standard error, with escapes for what is not printable.

    Reasons, names of maps and paths may come from files of strangers.
    """
    streams = sys.modules.get("weftex.io.streams")
    text = " ".join((streams.unhidden(text) if streams is not None else text).split())
    if for_program:
        _print_fields({kind: text})
        return
    before = {"message": "", "error": "error: ", "stopped": "stopped; "}[kind]
    with suppress(OSError):
        print(f"weftex: {before}{printable(text)}", file=sys.stderr, flush=True)


def _print_fields(fields: dict[str, Any]) -> None:
    """Print a JSON object as one line on standard error."""
    import json

    with suppress(OSError):
        print(json.dumps(fields), file=sys.stderr, flush=True)


def _input_closed() -> bool:
    """Whether standard input is a pipe whose other end was closed; what it sent is discarded."""
    mode = os.fstat(0).st_mode
    if not stat.S_ISFIFO(mode) and not stat.S_ISSOCK(mode):
        return False
    if sys.platform == "win32":
        import _winapi
        import msvcrt

        try:
            _winapi.PeekNamedPipe(msvcrt.get_osfhandle(0), 0)
        except BrokenPipeError:
            return True
        return False
    return bool(select.select([0], [], [], 0)[0]) and not os.read(0, 4096)
