"""Planes on disk: speed, growth, kills, disks that fill.

    python benchmarks/speed/planes_on_disk.py speed --side 16384 --methods near-regular
    python benchmarks/speed/planes_on_disk.py growth | kills | disk

Each prints its lines; docs/how-to/huge-images.md has those of one run.
"""

from __future__ import annotations

import argparse
import contextlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
METHODS = ("patch-sampling", "quilting", "graphcut", "near-regular", "refinement")
Process = subprocess.Popen[bytes]
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def command(target: Path, side: int, *words: object) -> list[str]:
    """One run of weftex synth."""
    made = [sys.executable, "-m", "weftex", "synth", "sample:bricks", "-o", target, "--seed", 1]
    return [str(word) for word in [*made, "--size", side, "--quiet", *words]]


def measured(words: list[str]) -> tuple[int, float, float, float]:
    """Exit code, seconds, processor seconds with children, most megabytes of one process."""
    code = (
        "import resource, subprocess, sys; code = subprocess.call(sys.argv[1:]);"
        "used = resource.getrusage(resource.RUSAGE_CHILDREN);"
        "print(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024); sys.exit(code)"
    )
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, *words], stdout=subprocess.PIPE, text=True, check=False
    )
    took = time.perf_counter() - start
    busy, memory = map(float, done.stdout.split()[-2:])
    return done.returncode, took, busy, memory


def plain(method: str, side: int) -> float:
    """Processor seconds of the method itself for so many pixels, in pieces of 2048."""
    import weftex

    piece = min(side, 2048)
    model = weftex.METHODS[method]().fit("sample:bricks")
    start = time.process_time()
    model.sample(piece, seed=1, threads=1).image  # noqa: B018
    return (time.process_time() - start) * (side / piece) ** 2


def speed(args: argparse.Namespace, folder: Path) -> None:
    """Megapixels a second, by one process, one worker and two."""
    for method in args.methods:
        alone = plain(method, args.side)
        for workers in args.workers:
            target = folder / "p.tif"
            words = ["--method", method, *(("--workers", workers) if workers else ())]
            words += ["--block", 2048, *(["--threads", 1] * (not workers))]
            code, took, busy, memory = measured(command(target, args.side, *words))
            assert code == 0
            print(
                f"{method} {args.side} workers {workers}: "
                f"{args.side**2 / took / 1e6:.3g} MP/s, {args.side**2 / busy / 1e6:.3g} MP a "
                f"processor second, {busy / alone:.2f} times the method, {memory:.0f} MB, "
                f"{target.stat().st_size / 1e6:.0f} MB on disk",
                flush=True,
            )
            clean(folder)


def growth(args: argparse.Namespace, folder: Path) -> None:
    """One to four gigapixels: processor time a megapixel, and memory."""
    for side in (args.side, int(args.side * 1.5), 2 * args.side):
        words = command(folder / "p.tif", side, "--method", args.methods[0], "--threads", 1)
        busy, most, runs, code = 0.0, 0.0, 0, 1
        while code:  # stopped and gone on with, so that others have the machine, too
            code, _, now, memory = measured(["timeout", str(args.slice), *words])
            busy, most, runs = busy + now, max(most, memory), runs + 1
            time.sleep(args.rest)
        print(
            f"{args.methods[0]} {side}: {busy / side**2 * 1e9:.2f} processor seconds a gigapixel "
            f"in {runs} runs, {most:.0f} MB",
            flush=True,
        )
        clean(folder)


def kills(args: argparse.Namespace, folder: Path) -> None:
    """A run that is killed at random moments, again and again, beside one that is not."""
    moments = random.Random(1)
    words = ["--method", "near-regular", "--block", 64, "--threads", 1]
    target, whole, record = (folder / name for name in ("p.tif", "whole.tif", "p.tif.run"))
    subprocess.run(command(whole, args.side, *words), check=True)
    killed, blocks = 0, []
    for _ in range(args.times):
        run = subprocess.Popen(command(target, args.side, *words), **QUIET)
        before = lines(record)
        while lines(record) == before and run.poll() is None:
            time.sleep(0.002)
        time.sleep(moments.uniform(0, 0.4))
        run.send_signal(moments.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM]))
        run.wait()
        killed += run.returncode != 0
        blocks.append(lines(record) - before)
    subprocess.run(command(target, args.side, *words), check=True)
    equal = target.read_bytes() == whole.read_bytes()
    print(f"killed {killed} times, after {blocks} blocks; equal bytes: {equal}")
    clean(folder)


def disk(args: argparse.Namespace, folder: Path) -> None:
    """A small disk that others fill while a plane is written; needs the right to mount one."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=40m", "tmpfs", folder], check=True)
    try:
        target = folder / "p.tif"
        words = [*command(target, 2048), "--method", "near-regular", "--block", "256"]
        run = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
        while lines(folder / "p.tif.run") < 5:
            time.sleep(0.002)
        with contextlib.suppress(OSError), open(folder / "other", "wb", 0) as other:
            while True:
                other.write(bytes(2**16))
        said = run.communicate()[1].strip()
        (folder / "other").unlink()
        again = subprocess.run(words, check=False)
        check = [sys.executable, "-m", "weftex", "check", str(target), "--read"]
        whole = subprocess.run(check, check=False, capture_output=True).returncode == 0
        print(f"exit code {run.returncode}: {said}; again {again.returncode}: {whole}")
        clean(folder)
    finally:
        subprocess.run(["umount", folder], check=True)


def lines(record: Path) -> int:
    """How many blocks are done."""
    with contextlib.suppress(OSError):
        return sum(path.read_bytes().count(b"\n") for path in record.glob("*.txt"))
    return 0


def clean(folder: Path) -> None:
    """Remove what was made."""
    for path in folder.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()


WORKS = {f.__name__: f for f in (speed, growth, kills, disk)}


def main(words: list[str] | None = None) -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=WORKS)
    parser.add_argument("--side", type=int, default=1024)
    parser.add_argument("--methods", nargs="+", default=["near-regular"], choices=METHODS)
    parser.add_argument(
        "--workers", nargs="+", type=int, default=[0, 1, 2], help="0: this process alone"
    )
    parser.add_argument("--rest", type=float, default=0, help="seconds between runs of growth")
    parser.add_argument("--slice", type=float, default=3600, help="seconds of a run of growth")
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--blocks", type=int, default=1000)
    parser.add_argument("--folder", help="where to write; default: a temporary one")
    args = parser.parse_args(words)
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        WORKS[args.what](args, Path(folder))


if __name__ == "__main__":
    main()
