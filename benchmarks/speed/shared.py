"""What all tables need: samples, timing in turn, processes of their own, the machine."""

from __future__ import annotations

import json
import os
import platform
import re
import statistics
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

import weftex

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SURFACES = ROOT / "benchmarks" / "data" / "surfaces"
sys.path.append(str(ROOT / "examples" / "papers"))
import _common as papers  # noqa: E402
import patch_sampling as paper  # noqa: E402, F401
from _common import sized, some  # noqa: E402

PATCH_METHODS = ("patch-sampling", "quilting")
Work = Callable[[], Any]
Table = papers.Table


def machine() -> str:
    """Processor, cores, versions, in a line."""
    name = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        found = re.search(r"model name\s*:\s*(.+)", info.read_text())
        name = found[1] if found else name
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    blas = os.environ.get("OPENBLAS_NUM_THREADS", "default")
    return (
        f"{name}, {os.cpu_count()} cores{load}; {platform.system()}, Python "
        f"{platform.python_version()}, NumPy {np.__version__} (BLAS threads: {blas}), "
        f"weftex {weftex.__version__}"
    )


def sample_of(side: int, name: str = "pebbles") -> np.ndarray:
    """So much of a packaged sample; see `of_side`."""
    return of_side(side, papers.load(name))


def of_side(side: int, pixels: np.ndarray) -> np.ndarray:
    """A crop of a picture, or more of it made by weftex where it is too small.

    With --small, as much of it as ever, in fewer pixels.
    """
    if sized(side) < side:
        pixels = papers.shrunk(pixels, max(1, min(pixels.shape[:2]) // sized(side)))
        side = min(side, *pixels.shape[:2])
    if side > min(pixels.shape[:2]):
        return weftex.synthesize(pixels, side, seed=0).image
    return np.ascontiguousarray(pixels[:side, :side])


def busy() -> float:
    """Seconds of processor time so far, of this process and of its children that ended.

    Other work on the machine disturbs them little; what several threads do adds up.
    """
    import resource

    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return process_time() + children.ru_utime + children.ru_stime


def medians(works: Mapping[Any, Work], repeats: int) -> dict[Any, float]:
    """Median seconds of processor time of each, all in turn; one round before is not counted."""
    times: dict[Any, list[float]] = {key: [] for key in works}
    for turn in range(len(some(range(repeats + 1), least=2))):
        for key, work in works.items():
            start = busy()
            work()
            if turn:
                times[key].append(busy() - start)
    return {key: statistics.median(values) for key, values in times.items()}


def fitting(pixels: np.ndarray, method: str = "patch-sampling", **parameters: Any) -> Work:
    chosen = weftex.METHODS[method](**parameters)
    return lambda: chosen.fit(weftex.Exemplar(pixels))  # a new one, as it caches


def sampling(pixels: np.ndarray, size: int, method: str = "patch-sampling", **given: Any) -> Work:
    threads = given.pop("threads", None)
    model = weftex.METHODS[method](**given).fit(weftex.Exemplar(pixels))
    seeds = iter(range(10**9))
    return lambda: model.sample(sized(size), seed=next(seeds), threads=threads).image


def fuse_three(size: int, method: str) -> np.ndarray:
    """Three materials in bands that meet in waves."""
    size = sized(size)
    y, x = np.indices((size, size))
    labels = (y + size / 20 * np.sin(12 * x / size)) * 3 // size
    samples = [sample_of(192, name) for name in ("pebbles", "bricks", "leaves")]
    bands = labels.clip(0, 2).astype(int)
    return weftex.fuse(samples, bands, method=method, seed=1).image


def environment(**more: str) -> dict[str, str]:
    """That of a process to be timed: as people have it, which keeps compiled modules."""
    kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    return kept | more


def child(more: Mapping[str, str] | None = None, **job: Any) -> dict[str, float]:
    """Run `in_child` with these arguments in a process of its own."""
    small = {"small": True} if len(some(range(2))) < 2 else {}
    done = subprocess.run(
        [sys.executable, str(HERE / "run.py"), "--child", json.dumps(job | small)],
        env=environment(**(more or {})),
        stdout=subprocess.PIPE,
        check=True,
    )
    result: dict[str, float] = json.loads(done.stdout)
    return result


def in_child(
    method: str = "patch-sampling",
    side: int = 256,
    size: int = 0,
    threads: int | None = None,
    repeats: int = 1,
    name: str = "bricks",
    fuse: bool = False,
    small: bool = False,
) -> dict[str, float]:
    """Fit, sample (or fuse) and measure the process's largest resident size."""
    if small:
        papers.make_small()
    size = sized(size)
    if fuse:
        fuse_three(size, method)
        return {"peak": peak_memory() / 2**20}
    pixels = sample_of(side, name)
    before = peak_memory()
    fit, sample = [], []
    for seed in some(range(repeats)):
        start = perf_counter()
        model = weftex.METHODS[method]().fit(weftex.Exemplar(pixels))
        fit.append(perf_counter() - start)
        if size:
            start = perf_counter()
            _ = model.sample(size, seed=seed, threads=threads).image
            sample.append(perf_counter() - start)
    return {
        "fit": statistics.median(fit),
        "sample": statistics.median(sample) if sample else 0.0,
        "before": before / 2**20,
        "peak": peak_memory() / 2**20,
    }


def peak_memory() -> int:
    """Largest resident size of this process so far, in bytes."""
    status = Path("/proc/self/status")
    if status.exists():  # what getrusage says on Linux begins with the parent's
        return 1024 * int(re.search(r"VmHWM:\s*(\d+)", status.read_text())[1])  # type: ignore
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def ms(seconds: float) -> str:
    return f"{seconds * 1e3:.3g} ms" if seconds < 1 else f"{seconds:.2f} s"
