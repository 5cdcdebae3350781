"""Tests that start processes of their own."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import weftex

SRC = str(Path(weftex.__file__).parents[1])
#: The package that is tested, for a process started from any folder.
ENVIRONMENT = os.environ | {"PYTHONPATH": SRC}
#: The same, and the helpers of the tests.
WITH_HELPERS = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), SRC])}


def hear_interrupts():
    """In a child: signals count, though runners in the background start with them ignored."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def wait_until_it_listens(process):
    """Until a command catches SIGTERM, however busy the machine is; seen on Linux only."""
    status, caught = Path(f"/proc/{process.pid}/status"), 0
    while status.exists() and process.poll() is None and not caught >> signal.SIGTERM - 1 & 1:
        time.sleep(0.05)
        caught = int(status.read_text().split("SigCgt:")[1].split()[0], 16)


def children_of(pid):
    """Process ids of all descendants."""
    try:
        tasks = list(Path(f"/proc/{pid}/task").iterdir())
        found = [int(one) for task in tasks for one in (task / "children").read_text().split()]
    except OSError:
        return []
    return found + [one for child in found for one in children_of(child)]


def have_ended(pids):
    """Whether processes end within a few seconds."""
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        states = []
        for pid in pids:
            try:
                states.append(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0])
            except OSError:
                continue
        if not set(states) - {"Z"}:
            return True
        time.sleep(0.05)
    return False


def run(code, *args, **options):
    """Run Python code with weftex importable, in a process of its own, which must not fail."""
    command = [sys.executable, "-c", textwrap.dedent(code), *map(str, args)]
    options = {"env": ENVIRONMENT, "timeout": 60} | options
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stderr
    return done


def weftex_process(*words, **options):
    """Start a command of weftex."""
    command = [sys.executable, "-m", "weftex", *map(str, words)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, **options)


#: Calls, by the names of their audit events, that change files or lock them.
FILE_CALLS = ("open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.truncate", "os.chmod")
FILE_CALLS += ("fcntl.lockf",)


def killed_at(number, work, folder):
    """Run `work` in a fork that is killed at a numbered call on a file below a folder.

    Returns whether it was: False once there are fewer calls. POSIX only.
    """
    child = os.fork()
    if child:
        return os.waitpid(child, 0)[1] != 0
    calls = 0

    def count(event, args):
        nonlocal calls
        if event in FILE_CALLS and (event == "fcntl.lockf" or str(args[0]).startswith(str(folder))):
            calls += 1
            if calls == number:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(count)
    try:
        work()
        os._exit(0)
    except BaseException as error:
        print(error, file=sys.stderr)
        os._exit(1)
