"""Find the weftex command, run it with progress, and cancel it.

Plug-ins of GIMP and Krita share this file: `integrations/build.py` copies it into both. It uses the
standard library only and works with Python 3.8, as hosts bring their own Python.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

NEEDS = (0, 2, 0)
MAX_PIXELS = 2**28
_PREFIX = "weftex-plug-in-"


class Problem(Exception):
    """Why nothing was made, as one line for the user."""


class Canceled(Problem):
    """The user stopped the run."""


#: What a host shows to the user: problems, a full disk, not enough memory.
FAILURES = (Problem, OSError, MemoryError)


def message_of(failure: BaseException) -> str:
    """Return one of `FAILURES` as one line."""
    if isinstance(failure, OSError) and failure.strerror:
        return f"{failure.strerror}: {failure.filename or tempfile.gettempdir()}"
    return str(failure) or "There is not enough memory"


def find_command(setting: str = "") -> str:
    """Return the path of the command: $WEFTEX, the setting, the PATH, the usual folders."""
    for named, source in ((os.environ.get("WEFTEX", ""), "$WEFTEX"), (setting, "the setting")):
        if named:
            found = shutil.which(os.path.expanduser(named))
            if not found:
                raise Problem(f"{source} names {named}, which is not a program")
            return found
    found = shutil.which("weftex") or shutil.which("weftex", path=os.pathsep.join(usual_folders()))
    if not found:
        raise Problem(
            "The command weftex was not found. Install weftex, or name the command in the "
            "environment variable WEFTEX; see the README of this plug-in"
        )
    return found


def usual_folders() -> list[str]:
    """Return the folders in which pipx, uv and pip put commands."""
    home, data = Path.home(), os.environ.get("APPDATA", "")
    folders = [os.environ.get("PIPX_BIN_DIR", ""), os.environ.get("UV_TOOL_BIN_DIR", "")]
    folders += [str(home / ".local" / "bin"), "/usr/local/bin", "/opt/homebrew/bin"]
    folders += [str(one) for one in sorted(home.glob("Library/Python/3.*/bin"))]
    if data:
        folders += [str(one) for one in sorted(Path(data).glob("Python/Python3*/Scripts"))]
    return [one for one in folders if one]


def environment() -> dict[str, str]:
    """Return the environment for the command, without what points to the host's own Python."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    bundle = os.environ.get("APPDIR")  # of an AppImage, whose libraries are not for others
    if bundle and "LD_LIBRARY_PATH" in kept:
        own = [one for one in kept["LD_LIBRARY_PATH"].split(":") if not one.startswith(bundle)]
        kept["LD_LIBRARY_PATH"] = ":".join(own)
    return kept


def check_version(command: str) -> None:
    """Raise `Problem` if the command is not weftex, or too old."""
    try:
        answer = subprocess.run(
            [command, "--version"], capture_output=True, text=True, timeout=60, **_started()
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Problem(f"{command} cannot be started: {error}") from None
    found = re.match(r"weftex (\d+)\.(\d+)\.(\d+)", answer.stdout)
    if answer.returncode or not found:
        lines = (answer.stderr or answer.stdout).strip().splitlines()
        raise Problem(f"{command} does not work: {lines[-1] if lines else 'it printed nothing'}")
    if tuple(int(one) for one in found.groups()) < NEEDS:
        wanted = ".".join(str(one) for one in NEEDS)
        raise Problem(f"{command} is {found.group()}; this plug-in needs {wanted} or later")


def check_size(width: int, height: int) -> None:
    """Raise `Problem` for images that the command refuses as too large."""
    if width * height > MAX_PIXELS:
        raise Problem(
            f"{width} x {height} pixels are too many; the limit is {MAX_PIXELS // 10**6} megapixels"
        )


def options_of(task: str) -> list[dict[str, Any]]:
    """Return the options of a task that dialogs show, as `integrations/build.py` wrote them."""
    text = Path(__file__).with_name("options.json").read_text("utf-8")
    return json.loads(text)[task]  # type: ignore[no-any-return]


def title_of(option: dict[str, Any]) -> str:
    """Return the label of an option in a dialog."""
    title: str = option["name"].replace("_", " ")
    return title[0].upper() + title[1:]


def about(option: dict[str, Any]) -> str:
    """Return the help of an option in a dialog."""
    text: str = option["help"][0].upper() + option["help"][1:]
    return text + (f"; default: {option['default_text']}" if option["default_text"] else "")


def choices_of(option: dict[str, Any]) -> tuple[list[tuple[str, str]], str]:
    """Return values with their labels, and the first choice, of an option that has choices."""
    if option["type"] == "axes":
        pairs = [("none", "No"), ("both", "Along both axes"), ("x", "Along x"), ("y", "Along y")]
        return (pairs[1:], "both") if option["default"] else (pairs, "none")
    if option["type"] == "bool":
        return [("auto", "Automatic"), ("yes", "Yes"), ("no", "No")], "auto"
    if option["name"] == "method":
        return [(value, label) for value, label in option["choices"]], "auto"
    return [(one, one.capitalize()) for one in option["choices"]], option["default"]


def words_of(task: str, values: dict[str, Any]) -> list[str]:
    """Return the words of the command line for values of options by their names.

    A size is a pair (width, height), in which 0 stands for the default, or for the other side.
    Values that are None, "" or "auto" leave the default.
    """
    words = []
    for option in options_of(task):
        name, flag, value = option["name"], option["flag"], values.get(option["name"])
        if value is None or value in ("", "auto"):
            continue
        if option["type"] == "size":
            width, height = value
            if width or height:
                words += [flag, f"{width or height}x{height or width}"]
        elif option["type"] == "axes":
            words += {"none": [], "both": [flag]}.get(value, [flag, value])
        elif option["type"] == "bool":
            words.append(flag if value in (True, "yes") else f"--no-{flag[2:]}")
        elif option["type"] == "int" and not value and name != "seed":
            continue  # 0 is the default
        elif value != option["default"] or name == "seed":
            words += [flag, str(value)]
    return words


class Folder:
    """A temporary folder, removed at the end of a `with` block.

    A host may end a plug-in at any time, so folders older than a day are removed too.
    """

    def __enter__(self) -> Path:
        for old in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
            if old.stat().st_mtime < time.time() - 86_400:
                shutil.rmtree(old, ignore_errors=True)
        self.path = Path(tempfile.mkdtemp(prefix=_PREFIX))
        return self.path

    def __exit__(self, *error: object) -> None:
        shutil.rmtree(self.path, ignore_errors=True)


class Run:
    """A run of the command in a process of its own; nothing here waits, but for `finish`.

    Attributes
    ----------
    share : float
        Part of the current stage that is done, from 0 to 1.
    stage : str
        What is being done.
    """

    def __init__(self, command: str, words: list[str]) -> None:
        self.share, self.stage = 0.0, "starting"
        self._error, self._canceled = "", False
        try:
            self._process = subprocess.Popen(
                [command, "--for-program", *words],
                stdin=subprocess.PIPE,  # closed to cancel, also if the host ends this process
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                **_started(),
            )
        except OSError as error:
            raise Problem(f"{command} cannot be started: {error}") from None
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def running(self) -> bool:
        """Whether the process is alive."""
        return self._process.poll() is None

    def cancel(self) -> None:
        """Ask the process to end, which takes it up to a second."""
        self._canceled = True
        self._process.stdin.close()  # type: ignore[union-attr]

    def finish(self) -> None:
        """Wait for the end; raise `Canceled`, or `Problem` with the command's own error."""
        try:
            code = self._process.wait(10 if self._canceled else None)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        self._reader.join()
        if self._canceled:
            raise Canceled("Canceled")
        if code:
            said = self._error or f"weftex ended with code {code}"
            raise Problem(said[:1].upper() + said[1:])

    def _read(self) -> None:
        with self._process.stderr as stream:  # type: ignore[union-attr]
            for line in stream:
                text = line.decode("utf-8", "replace").strip()
                if text.startswith("{"):
                    self._hear(json.loads(text))
                else:  # Python's own last words
                    self._error = text or self._error

    def _hear(self, event: dict[str, Any]) -> None:
        if "stage" in event:
            self.stage = event["stage"]
            self.share = event["done"] / event["of"] if event["of"] else 0.0
        self._error = event.get("error", self._error)


def run(command: str, words: list[str], report: Callable[[float, str], bool]) -> None:
    """Run the command; `report` is called with share and stage, and returns False to cancel."""
    job = Run(command, words)
    try:
        while job.running:
            if not report(job.share, job.stage):
                job.cancel()
            time.sleep(0.1)
    except BaseException:
        job.cancel()
        raise
    job.finish()


def _started() -> dict[str, Any]:
    """Return how processes are started: with a clean environment, and on Windows no console."""
    return {
        "env": environment(),
        "creationflags": getattr(subprocess, "CREATE_NO_WINDOW", 0),
    }
