"""Speed, memory, start-up, growth: run by hand or by CI, never a test.

    python benchmarks/run.py [all | speed | table1 | growth | recall | kernels | startup | memory |
                              copying | edges] [--json FILE] [--update docs/benchmarks.md]

Prints Markdown tables. Every time is a median of several runs, and what is compared is run in turn,
so that a busy machine disturbs all alike; look at the ratios first. --update puts the tables into a
page between its <!-- NAME --> and <!-- end NAME --> lines. Needs weft[test].
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import weft
from weft.patch_synthesis import PatchSynthesis

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "examples"))
import paper_patch_sampling as paper  # noqa: E402

METHODS = {"patch-sampling": weft.PatchSampling, "quilting": weft.Quilting}
Work = Callable[[], Any]
Table = paper.Table


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
        f"weft {weft.__version__}"
    )


def sample_of(side: int, name: str = "pebbles") -> np.ndarray:
    """A crop of a packaged sample, or more of it made by weft where it is too small."""
    pixels = paper.load(name)
    if side > min(pixels.shape[:2]):
        return weft.synthesize(pixels, side, seed=0).image
    return np.ascontiguousarray(pixels[:side, :side])


def medians(works: Mapping[Any, Work], repeats: int) -> dict[Any, float]:
    """Median seconds of each, all in turn; one round before is not counted."""
    times: dict[Any, list[float]] = {key: [] for key in works}
    for turn in range(repeats + 1):
        for key, work in works.items():
            start = perf_counter()
            work()
            if turn:
                times[key].append(perf_counter() - start)
    return {key: statistics.median(values) for key, values in times.items()}


def fitting(pixels: np.ndarray, method: str = "patch-sampling", **parameters: Any) -> Work:
    chosen = METHODS[method](**parameters)
    return lambda: chosen.fit(weft.Exemplar(pixels))  # a new one, as it caches


def sampling(pixels: np.ndarray, size: int, method: str = "patch-sampling", **given: Any) -> Work:
    threads = given.pop("threads", None)
    model = METHODS[method](**given).fit(weft.Exemplar(pixels))
    seeds = iter(range(10**9))
    return lambda: model.sample(size, seed=next(seeds), threads=threads).image


def child(environment: Mapping[str, str] | None = None, **job: Any) -> dict[str, float]:
    """Run `in_child` with these arguments in a process of its own."""
    done = subprocess.run(
        [sys.executable, __file__, "--child", json.dumps(job)],
        env={**os.environ, **(environment or {})},
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
) -> dict[str, float]:
    """Fit, sample and measure the process's largest resident size."""
    pixels = sample_of(side, name)
    before = peak_memory()
    fit, sample = [], []
    for seed in range(repeats):
        start = perf_counter()
        model = METHODS[method]().fit(weft.Exemplar(pixels))
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


# ------------------------------------------------------------------------------------ the tables


def speed() -> Table:
    """Fit and sample beside the targets, with the exhaustive search in the same turns."""
    rows = []
    for side, size, fit_target, sample_target, repeats in (
        (128, 200, "60 ms", "3 ms", 21),
        (200, 800, "", "40 ms", 7),
        (512, 512, "1 s", "", 5),
    ):
        pixels = sample_of(side, "leaves")
        works: dict[Any, Work] = {}
        for method in METHODS:
            works[method, "fit"] = fitting(pixels, method)
            works[method, "sample"] = sampling(pixels, size, method)
        if side < 512:
            works["exhaustive"] = sampling(pixels, size, search="exhaustive")
        took = medians(works, repeats)
        for method in METHODS:
            fast = took[method, "sample"]
            ratio = f"{took['exhaustive'] / fast:.1f} x" if "exhaustive" in took else ""
            rows.append(
                [
                    f"{side} to {size}",
                    method,
                    f"{ms(took[method, 'fit'])}",
                    fit_target,
                    f"{ms(fast)}",
                    sample_target,
                    f"{size**2 / fast / 1e6:.3g}",
                    ratio if method == "patch-sampling" else "",
                    "",
                ]
            )
    for method in METHODS:
        for threads in (1, 2):
            runs = [child(method=method, size=8192, threads=threads) for _ in range(3)]
            took_once = statistics.median(run["sample"] for run in runs)
            rows.append(
                [
                    f"256 to 8192, {threads} thread{'s'[: threads - 1]}",
                    method,
                    ms(statistics.median(run["fit"] for run in runs)),
                    "",
                    ms(took_once),
                    "3.36 s",
                    f"{8192**2 / took_once / 1e6:.3g} (20)",
                    "",
                    f"{max(run['peak'] for run in runs):.0f} MiB (1024)",
                ]
            )
    for side in (128, 512):
        for threads in ("", "1"):
            blas = {"OPENBLAS_NUM_THREADS": threads} if threads else {}
            run = child(blas, side=side, repeats=9)
            what = f"fit {side}, {'one BLAS thread' if threads else 'BLAS as it comes'}"
            rows.append([what, "patch-sampling", ms(run["fit"]), *[""] * 6])
    notes = """
Side of the sample to side of the output, RGB, defaults. Targets are for patch sampling on two
cores. "x" is the time of the exhaustive search for the same over this one; the paper has 70.
"""
    head = ["", "method", "fit", "target", "sample", "target", "megapixels/s", "x", "peak memory"]
    return notes, head, rows


def table1() -> Table:
    """Table I of the paper; see examples/paper_patch_sampling.py."""
    return paper.table1(20)


def copying() -> Table:
    """Verbatim copying; see examples/paper_patch_sampling.py."""
    return paper.copying()


def edges() -> Table:
    """The edge metric; see examples/paper_patch_sampling.py."""
    return paper.edges()


def growth() -> Table:
    """How fit and sample grow with the sizes of the sample, the output and the patch."""
    rows = []
    series: tuple[tuple[str, tuple[int, ...]], ...] = (
        ("sample side", (64, 128, 256, 512, 1024)),
        ("output side", (128, 256, 512, 1024, 2048)),
        ("patch size", (8, 16, 32, 64, 96)),
        ("candidates", (10, 40, 160, 640)),
    )
    for what, values in series:
        works: dict[Any, Work] = {}
        for value in values:
            side, size, patch, candidates = 192, 512, 40, 40
            if what == "sample side":
                side, patch = value, min(patch, value // 2)
            elif what == "output side":
                size = value
            elif what == "patch size":
                patch = value
            else:
                candidates = value
            pixels = sample_of(side)
            given: dict[str, Any] = {"patch_size": patch, "candidates": candidates}
            works[value, "fit"] = fitting(pixels, **given)
            works[value, "sample"] = sampling(pixels, size, **given)
        took = medians(works, 5)
        for value in values:
            rows.append([what, str(value), ms(took[value, "fit"]), ms(took[value, "sample"])])
    notes = "Otherwise 192 to 512, patches of 40 px, 40 candidates, the default search."
    return notes, ["varied", "to", "fit", "sample"], rows


def recall() -> Table:
    """How near each search comes to the truly nearest windows, and what it costs."""
    searches: list[tuple[str, dict[str, Any]]] = [("exhaustive", {})]
    searches += [
        (search, {"candidates": candidates})
        for search in ("quadtree", "kdtree", "kdtree-pca", "pca")
        for candidates in (10, 40, 160)
    ]
    common = {"patch_size": 32, "boundary_width": 4, "repeat_distance": 0, "epsilon": 0}
    ratios: dict[int, list[float]] = {k: [] for k in range(len(searches))}
    times: dict[int, list[float]] = {k: [] for k in range(len(searches))}
    for name in paper.SAMPLES:
        exemplar = weft.Exemplar(paper.load(name, 128))
        truth = Truth(exemplar)
        works = {}
        for k, (search, given) in enumerate(searches):
            model = weft.PatchSampling(search=search, **given, **common).fit(exemplar)
            ratios[k] += truth.ratios(model.sample(200, seed=1))
            works[k] = lambda model=model: model.sample(200, seed=1).image
        for k, took in medians(works, 5).items():
            times[k].append(took)
    rows = []
    for k, (search, given) in enumerate(searches):
        ratio = np.array(ratios[k])
        rows.append(
            [
                search,
                str(given.get("candidates", "all")),
                f"{100 * (ratio < 1.0001).mean():.0f} %",
                f"{ratio.mean():.3f}",
                f"{np.quantile(ratio, 0.95):.2f}",
                ms(statistics.mean(times[k])),
            ]
        )
    notes = """
For every patch of a 200x200 output from a 128x128 crop of each packaged sample (epsilon 0, so the
best window found is taken; patches of 32 px, zones of 4): how often it is the truly nearest one,
and its distance over the nearest one's (eq. 2), on average and for the worst twentieth.
"""
    head = ["search", "candidates", "nearest found", "distance ratio", "95 %", "sample"]
    return notes, head, rows


class Truth:
    """Distances of eq. (2) to all windows of a sample, by a matrix product."""

    def __init__(self, exemplar: weft.Exemplar) -> None:
        self.exemplar = exemplar
        self.pixels = exemplar.pixels.reshape(*exemplar.shape, -1)
        self.windows: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def ratios(self, result: weft.Synthesis) -> list[float]:
        """Distance of each patch of a result over the least possible at its place."""
        found = []
        for k, (y, x, sy, sx, zone) in enumerate(result.placements.tolist()):
            weight = result.weights[zone]
            mask = (weight > 0) & (weight < 256)
            if not mask.any():
                continue
            before = PatchSynthesis(
                result.canvas,
                result.placements[:k],
                result.weights,
                result.cuts,
                sample_shape=result.sample_shape,
                exemplar=self.exemplar,
            )
            height, width = mask.shape
            part = before.image[y : y + height, x : x + width].reshape(height, width, -1)
            distances = self._distances(part[mask].ravel(), mask)
            chosen = distances[sy, sx]
            found.append(float(max(chosen, 1) / max(distances.min(), 1)) ** 0.5)
        return found

    def _distances(self, query: np.ndarray, mask: np.ndarray) -> np.ndarray:
        key = mask.tobytes()
        if key not in self.windows:
            views = np.lib.stride_tricks.sliding_window_view(self.pixels, mask.shape, (0, 1))
            zones = np.moveaxis(views, 2, -1)[:, :, mask]
            zones = zones.reshape(*zones.shape[:2], -1).astype(np.float64)  # exact sums
            self.windows[key] = zones, (zones**2).sum(axis=2)
        zones, squares = self.windows[key]
        asked = query.astype(np.float64)
        return squares - 2 * (zones @ asked) + asked @ asked


def kernels() -> Table:
    """Kernels for AVX2 beside those for any processor, in processes of their own."""
    rows = []
    for method in METHODS:
        for side, size in ((200, 800), (256, 2048)):
            runs: dict[str, list[dict[str, float]]] = {"": [], "baseline": []}
            for _ in range(5):
                for kind, found in runs.items():
                    environment = {"WEFT_KERNELS": kind}
                    found.append(
                        child(
                            environment, method=method, side=side, size=size, threads=1, repeats=3
                        )
                    )
            fast, plain = (statistics.median(r["sample"] for r in runs[k]) for k in runs)
            ratio = f"{plain / fast:.2f} x"
            rows.append([method, f"{side} to {size}", ms(fast), ms(plain), ratio])
    notes = "Sampling with one thread. The second kind is what WEFT_KERNELS=baseline chooses."
    return notes, ["method", "", "AVX2", "any x86-64", "ratio"], rows


def startup() -> Table:
    """Whole processes, beside `python -c "import numpy"`."""
    python = sys.executable
    with tempfile.TemporaryDirectory() as folder:
        commands: dict[str, list[str]] = {
            "python -c pass": [python, "-c", "pass"],
            "import numpy": [python, "-c", "import numpy"],
            "import weft": [python, "-c", "import weft"],
            "import weft, numpy": [python, "-c", "import numpy, weft"],
        }
        for side, size in ((128, 200), (200, 800)):
            weft.write_image(f"{folder}/{side}.png", sample_of(side, "bricks"))
            for method in METHODS:
                label = f"weft synth --method {method}, {side} to {size}"
                commands[label] = [
                    *(python, "-m", "weft.cli", "synth", f"{folder}/{side}.png"),
                    *("-o", f"{folder}/out.png", "--size", str(size), "--method", method),
                    *("--seed", "7", "--quiet"),
                ]
        works = {
            label: lambda command=command: subprocess.run(command, check=True)
            for label, command in commands.items()
        }
        took = medians(works, 15)
    base = took["import numpy"]
    targets = {
        "import weft, numpy": "50 ms more",
        "weft synth --method patch-sampling, 128 to 200": "2.5 x",
        "weft synth --method patch-sampling, 200 to 800": "4 x",
    }
    rows = [[k, ms(v), f"{v / base:.2f} x", targets.get(k, "")] for k, v in took.items()]
    return "Median of 15 processes each, in turn.", ["", "time", "over numpy's", "target"], rows


def memory() -> Table:
    """Largest resident size of a process that fits and samples."""
    rows = []
    jobs: tuple[tuple[str, int, int], ...] = (
        ("patch-sampling", 128, 200),
        ("patch-sampling", 512, 0),
        ("patch-sampling", 1024, 0),
        ("patch-sampling", 256, 4096),
        ("patch-sampling", 256, 8192),
        ("quilting", 256, 8192),
    )
    for method, side, size in jobs:
        run = child(method=method, side=side, size=size)
        what = f"{side} to {size}" if size else f"fit {side}"
        picture = 3 * size * size / 2**20
        rows.append([method, what, *(f"{v:.0f}" for v in (picture, run["before"], run["peak"]))])
    notes = "MiB; before is the process with NumPy, Pillow and the sample loaded."
    return notes, ["method", "", "picture", "before", "peak"], rows


TABLES: dict[str, Callable[[], Table]] = {
    f.__name__: f for f in (speed, table1, recall, growth, kernels, startup, memory, copying, edges)
}


def main() -> None:
    if len(sys.argv) == 3 and sys.argv[1] == "--child":
        print(json.dumps(in_child(**json.loads(sys.argv[2]))))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs="*", default=["all"], metavar="TABLE")
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--update", type=Path, metavar="PAGE")
    args = parser.parse_args()
    names = list(TABLES) if "all" in args.tables else args.tables
    if unknown := [name for name in names if name not in TABLES]:
        parser.error(f"unknown table '{unknown[0]}'; known: {', '.join(TABLES)}, all")
    about = machine()
    print(f"{about}\n")
    found: dict[str, Any] = {"machine": about}
    for name in names:
        table = TABLES[name]()
        text = paper.as_markdown(table)
        print(f"## {name}\n\n{text}", flush=True)
        found[name] = {"notes": table[0].strip(), "head": table[1], "rows": table[2]}
        if args.update:
            put(args.update, name, text)
    if args.update:
        put(args.update, "machine", f"Measured on: {about}.\n")
    if args.json:
        args.json.write_text(json.dumps(found, indent=1), encoding="utf-8")


def put(page: Path, name: str, text: str) -> None:
    """Replace what lies between a table's two marks."""
    first, last = f"<!-- {name} -->\n", f"<!-- end {name} -->"
    whole = page.read_text(encoding="utf-8")
    head, mark, rest = whole.partition(first)
    if mark:
        page.write_text(f"{head}{mark}{text}{last}{rest.partition(last)[2]}", encoding="utf-8")


if __name__ == "__main__":
    main()
