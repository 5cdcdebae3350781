"""Planes on disk: speed, growth, kills, workers that die, disks that fill, what limits a cluster.

    python benchmarks/speed/planes_on_disk.py speed --side 16384 --methods near-regular
    python benchmarks/speed/planes_on_disk.py growth | kills | cluster | disk | null

Each prints its lines; docs/how-to/huge-images.md has those of one run.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
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
    """Megapixels a second to TIFF and Zarr, by one process, one worker and two."""
    for method in args.methods:
        alone = plain(method, args.side)
        for suffix in args.formats:
            for workers in args.workers:
                target = folder / f"p{suffix}"
                words = ["--method", method, *(("--workers", workers) if workers else ())]
                words += ["--block", 2048, *(["--threads", 1] * (not workers))]
                code, took, busy, memory = measured(command(target, args.side, *words))
                assert code == 0
                size = used(target) / 1e6
                print(
                    f"{method} {args.side} {suffix} workers {workers}: "
                    f"{args.side**2 / took / 1e6:.3g} MP/s, {args.side**2 / busy / 1e6:.3g} MP a "
                    f"processor second, {busy / alone:.2f} times the method, {memory:.0f} MB, "
                    f"{size:.0f} MB on disk",
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
    for suffix in args.formats:
        side = args.side
        words = ["--method", "near-regular", "--block", 64, "--threads", 1]
        subprocess.run(command(folder / f"whole{suffix}", side, *words), check=True)
        killed, blocks = 0, []
        for _ in range(args.times):
            run = subprocess.Popen(command(folder / f"p{suffix}", side, *words), **QUIET)
            record = folder / f"p{suffix}.run"
            before = lines(record)
            while lines(record) == before and run.poll() is None:
                time.sleep(0.002)
            time.sleep(moments.uniform(0, 0.4))
            run.send_signal(moments.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM]))
            run.wait()
            killed += run.returncode != 0
            blocks.append(lines(record) - before)
        subprocess.run(command(folder / f"p{suffix}", side, *words), check=True)
        equal = contents(folder, "p") == contents(folder, "whole")
        print(f"{suffix}: killed {killed} times, after {blocks} blocks; equal bytes: {equal}")
        clean(folder)


def scheduler(stack: contextlib.ExitStack) -> tuple[Callable[..., Process], str]:
    """Start a scheduler; return a function that starts Dask processes, and the address."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{one.getsockname()[1]}"

    def dask(*more: object) -> Process:
        made = [sys.executable, "-m", "dask", *map(str, more), "--no-dashboard"]
        process = subprocess.Popen(made, **QUIET)
        stack.callback(process.kill)
        return process

    dask("scheduler", "--host", "127.0.0.1", "--port", address.rpartition(":")[2])
    return dask, address


def cluster(args: argparse.Namespace, folder: Path) -> None:
    """A scheduler and workers: one killed in the middle, one added, one of another version."""
    words = ["--method", "near-regular", "--block", 128]
    subprocess.run(command(folder / "whole.zarr", args.side, *words), check=True)
    (folder / "old.py").write_text("import weftex; weftex.__version__ = '0.0.1'\n")
    with contextlib.ExitStack() as stack:
        dask, address = scheduler(stack)
        worker = ["worker", address, "--nthreads", 1, "--no-nanny"]
        workers = [dask(*worker), dask(*worker)]
        run = subprocess.Popen(command(folder / "p.zarr", args.side, *words, "--cluster", address))
        turns = 0
        while run.poll() is None:
            record, before = folder / "p.zarr.run", lines(folder / "p.zarr.run")
            while lines(record) < before + 15 and run.poll() is None:
                time.sleep(0.01)
            if run.poll() is None and turns < args.times:
                workers.pop(0).kill()
                workers.append(dask(*worker))
                turns += 1
        equal = contents(folder, "p") == contents(folder, "whole")
        print(
            f"workers killed and added: {turns}, exit code {run.returncode}, equal bytes: {equal}"
        )
        for one in workers:
            one.kill()
        dask(*worker, "--preload", folder / "old.py")
        done = subprocess.run(
            command(folder / "q.zarr", args.side, *words, "--cluster", address),
            capture_output=True,
            text=True,
            check=False,
        )
        print(f"another version: exit code {done.returncode}: {done.stderr.strip()}")


def disk(args: argparse.Namespace, folder: Path) -> None:
    """A small disk that others fill while a plane is written; needs the right to mount one."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=40m", "tmpfs", folder], check=True)
    try:
        for suffix in (".tif", ".zarr", ".dzi"):
            words = [*command(folder / f"p{suffix}", 2048), "--method", "near-regular"]
            words += ["--block", "256"]
            run = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
            while lines(folder / f"p{suffix}.run") < 5:
                time.sleep(0.002)
            with contextlib.suppress(OSError), open(folder / "other", "wb", 0) as other:
                while True:
                    other.write(bytes(2**16))
            said = run.communicate()[1].strip()
            (folder / "other").unlink()
            again = subprocess.run(words, check=False)
            check = [sys.executable, "-m", "weftex", "check", str(folder / f"p{suffix}"), "--read"]
            whole = subprocess.run(check, check=False, capture_output=True).returncode == 0
            print(
                f"{suffix}: exit code {run.returncode}: {said}; again {again.returncode}: {whole}"
            )
            clean(folder)
    finally:
        subprocess.run(["umount", folder], check=True)


def null(args: argparse.Namespace, folder: Path) -> None:
    """Blocks of no work by two workers of Dask: what scheduler, client and journal cost each."""
    os.environ["PYTHONPATH"] = os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])
    import planes_on_disk as planes

    import weftex
    from weftex.planes import runners as module
    from weftex.planes.definition import define
    from weftex.planes.plane_file import PlaneFile
    from weftex.planes.record import Record
    from weftex.progress import Progress

    module.make_block = planes.no_block
    method = weftex.BestTile(lattice=(20, 0, 0, 20))
    plane = PlaneFile(
        define("sample:bricks", 64, method, {}, seed=1, block=64), str(folder / "p.tif")
    )
    steps = Progress(None, args.blocks, "blocks", lambda: None)
    with contextlib.ExitStack() as stack:
        dask, address = scheduler(stack)
        for _ in range(2):
            dask("worker", address, "--nthreads", 1, "--no-nanny")
        client = stack.enter_context(module.connected(address))
        client.wait_for_workers(2)
        run, record = module.in_cluster(client, plane), Record(plane.path)
        for count in (200, args.blocks):
            start = time.perf_counter()
            busy = time.process_time()
            for _ in run(record, ((0, 0, k) for k in range(count)), steps):
                pass
            took = (time.perf_counter() - start) / count * 1000
            busy = (time.process_time() - busy) / count * 1000
        print(f"{args.blocks} blocks of no work: {took:.2f} ms each, {busy:.2f} ms of this process")


def no_block(packed: bytes, run: str, place: tuple[int, int, int], version: str) -> None:
    """A task that does nothing."""


def lines(record: Path) -> int:
    """How many blocks are done."""
    with contextlib.suppress(OSError):
        return sum(path.read_bytes().count(b"\n") for path in record.glob("*.txt"))
    return 0


def used(target: Path) -> int:
    """Bytes on the disk."""
    found = [target] if target.is_file() else target.rglob("*")
    return sum(path.stat().st_size for path in found if path.is_file())


def contents(folder: Path, stem: str) -> dict[str, bytes]:
    """All files of a plane; the name in a Zarr is that of its file."""
    return {
        path.relative_to(folder).as_posix().removeprefix(stem): path.read_bytes().replace(
            f'"name": "{stem}"'.encode(), b""
        )
        for path in folder.rglob("*")
        if path.is_file()
        and path.relative_to(folder).parts[0].startswith((f"{stem}.", f"{stem}_"))
        and ".run" not in path.as_posix()
    }


def clean(folder: Path) -> None:
    """Remove what was made."""
    for path in folder.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()


WORKS = {f.__name__: f for f in (speed, growth, kills, cluster, disk, null)}


def main(words: list[str] | None = None) -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=WORKS)
    parser.add_argument("--side", type=int, default=1024)
    parser.add_argument("--methods", nargs="+", default=["near-regular"], choices=METHODS)
    parser.add_argument(
        "--workers", nargs="+", type=int, default=[0, 1, 2], help="0: this process alone"
    )
    parser.add_argument("--formats", nargs="+", default=[".tif", ".zarr"])
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
