"""Faults that tests of parts do not show: kills, full disks.

    python tests/faults.py              # at most five minutes
    python tests/faults.py --long       # each fault many times, for nights
    python tests/faults.py kills disk   # only some

Every fault must end with one line or none, and the bytes of an undisturbed run.
"""

from __future__ import annotations

import argparse
import os
import random
import subprocess
import tempfile
import time
from pathlib import Path

from processes import weftex_process

PLANE = ["synth", "sample:bricks", "--method", "best-tile", "--lattice", "64,0,0,32", "--quiet"]
PLANE += ["--size", 1000, "--block", 64]
PICTURE = ["synth", "sample:bricks", "--method", "quilting", "--size", 600, "--quiet"]
WAIT = 120  # seconds for one command on a busy machine


class Skipped(Exception):
    """A fault that this machine cannot have, and why."""


def ended(run):
    """Exit code and standard error of a process, of which there is at most one line."""
    err = run.communicate(timeout=WAIT)[1]
    assert err.count("\n") <= 1, err
    return run.returncode, err


def done(*words):
    """Run a command that must succeed."""
    code, err = ended(weftex_process(*words, stdout=subprocess.DEVNULL))
    assert code == 0, err


def whole_plane(folder, seed):
    """The bytes of an undisturbed run."""
    target = folder / f"whole{seed}.tif"
    if not target.exists():
        done(*PLANE, "--seed", seed, "-o", target)
    return target.read_bytes()


def check(target, folder, seed):
    """The plane has the bytes of an undisturbed run, and `check` agrees."""
    done("check", target, "--read")
    assert target.read_bytes() == whole_plane(folder, seed)


def hidden(folder):
    return [path.name for path in folder.rglob(".weftex-*")]


def kills(folder, long):
    """`kill -9` between the start and the first blocks, and while a picture is written."""
    moments, killed = random.Random(os.getpid()), 0
    start = time.perf_counter()
    picture = folder / "picture.png"
    done(*PICTURE, "--seed", 1, "-o", picture)
    took, content = time.perf_counter() - start, picture.read_bytes()
    for turn in range(200 if long else 12):
        target = folder / f"kills{turn}.tif"
        words = [*PLANE, "--seed", 1, "-o", target]
        for command in (words, [*PICTURE, "--seed", 1, "-o", picture]):
            run = weftex_process(*command)
            time.sleep(moments.uniform(0.2, 1.1) * took)
            run.kill()
            run.communicate()
            killed += run.returncode != 0
            assert picture.read_bytes() == content
        done(*words)
        check(target, folder, 1)
        target.unlink()
    done(*PICTURE, "--seed", 1, "-o", picture)
    assert killed and picture.read_bytes() == content and not hidden(folder), hidden(folder)


def disk(folder, long):
    """A disk without room: one line that names the file, nothing hidden, and then it works."""
    small = folder / "small"
    small.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", str(small)]
    if not hasattr(os, "getuid") or os.getuid() or subprocess.run(mount, check=False).returncode:
        raise Skipped("a small disk can be mounted by root only")
    try:
        for suffix in (".png", ".tif", ".exr", ".jpg") * (10 if long else 1):
            given = folder / "float.exr" if suffix == ".exr" else "sample:bricks"
            if suffix == ".exr":
                from weftex.io.pictures import read_image, write_image

                write_image(given, read_image("sample:bricks").pixels.astype("float32"))
            words = ["synth", given, "--method", "quilting", "--size", 1600, "--quiet", "-o"]
            target = small / f"a{suffix}"
            (small / "other").write_bytes(os.urandom(4_000_000))
            code, err = ended(weftex_process(*words, target))
            assert code == 2 and str(target) in err and "weftex-" not in err, err
            assert not target.exists() and not hidden(small)
            (small / "other").unlink()
            done(*words, target, "--size", 100)
            target.unlink()
        target = small / "p.tif"
        words = [*PLANE, "--seed", 1, "-o", target]
        run = weftex_process(*words, "--size", 2000, "--allow-huge")
        code, err = ended(run)
        assert code == 2 and "No space left" in err, err
        for path in small.glob("p.tif*"):
            subprocess.run(["rm", "-r", str(path)], check=True)
        done(*PLANE, "--seed", 1, "-o", target, "--size", 500)
    finally:
        subprocess.run(["umount", str(small)], check=True)


FAULTS = {act.__name__: act for act in (kills, disk)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("faults", nargs="*", metavar="FAULT", help=", ".join(FAULTS))
    parser.add_argument("--long", action="store_true", help="each fault many times")
    args = parser.parse_args()
    for name in args.faults or FAULTS:
        start = time.perf_counter()
        with tempfile.TemporaryDirectory(prefix="faults-") as folder:
            try:
                FAULTS[name](Path(folder), args.long)
                how = "passed"
            except Skipped as why:
                how = f"not run: {why}"
        print(f"{name}: {how} ({time.perf_counter() - start:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
