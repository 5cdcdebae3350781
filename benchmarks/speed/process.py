"""Whole processes: kernels of both kinds, loading, memory."""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from dataclasses import fields
from time import perf_counter, process_time

from shared import (
    PATCH_METHODS,
    SURFACES,
    Table,
    child,
    environment,
    medians,
    ms,
    of_side,
    sample_of,
    sized,
    some,
)

import weftex


def kernels() -> Table:
    """Kernels for AVX2 beside those for any processor, in processes of their own."""
    rows = []
    for method in PATCH_METHODS:
        for side, size in some(((200, 800), (256, 2048))):
            runs: dict[str, list[dict[str, float]]] = {"": [], "baseline": []}
            for _ in some(range(5)):
                for kind, found in runs.items():
                    only = {"WEFTEX_KERNELS": kind}
                    found.append(
                        child(only, method=method, side=side, size=size, threads=1, repeats=3)
                    )
            fast, plain = (statistics.median(r["sample"] for r in runs[k]) for k in runs)
            ratio = f"{plain / fast:.2f} x"
            rows.append([method, f"{side} to {size}", ms(fast), ms(plain), ratio])
    notes = "Sampling with one thread. The second kind is what WEFTEX_KERNELS=baseline chooses."
    return notes, ["method", "", "AVX2", "any x86-64", "ratio"], rows


def startup() -> Table:
    """Whole processes, beside `python -c "import numpy"`."""
    python = sys.executable
    with tempfile.TemporaryDirectory() as folder:
        commands: dict[str, list[str]] = {
            "python -c pass": [python, "-c", "pass"],
            "import numpy": [python, "-c", "import numpy"],
            "import weftex": [python, "-c", "import weftex"],
            "import weftex, numpy": [python, "-c", "import numpy, weftex"],
        }
        for side, size in some(((128, 200), (200, 800))):
            weftex.write_image(f"{folder}/{side}.png", sample_of(side, "bricks"))
            for method in PATCH_METHODS:
                label = f"weftex synth --method {method}, {side} to {size}"
                commands[label] = [
                    *(python, "-m", "weftex", "synth", f"{folder}/{side}.png"),
                    *("-o", f"{folder}/out.png", "--size", str(sized(size)), "--method", method),
                    *("--seed", "7", "--quiet"),
                ]
        works = {
            label: lambda command=command: subprocess.run(command, check=True, env=environment())
            for label, command in commands.items()
        }
        took = medians(works, 15)
    base = took["import numpy"]
    targets = {
        "import weftex, numpy": "50 ms more",
        "weftex synth --method patch-sampling, 128 to 200": "2.5 x",
        "weftex synth --method patch-sampling, 200 to 800": "4 x",
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
        ("efros-leung", 128, 128),
        ("wei-levoy", 192, 512),
        ("ashikhmin", 192, 1000),
        ("exact-matching", 192, 1000),
        ("refinement", 192, 512),
        ("graphcut", 192, 512),
    )
    for method, side, size in some(job for job in jobs if job[0] in weftex.METHODS):
        run = child(method=method, side=side, size=size)
        what = f"{side} to {size}" if size else f"fit {side}"
        picture = 3 * size * size / 2**20
        rows.append([method, what, *(f"{v:.0f}" for v in (picture, run["before"], run["peak"]))])
    notes = "MiB; before is the process with NumPy, Pillow and the sample loaded."
    return notes, ["method", "", "picture", "before", "peak"], rows


def rivals() -> Table:
    """Whole processes of `weftex synth` beside G'MIC's syntexturize_matchpatch."""
    rows, gmic = [], shutil.which("gmic")
    with tempfile.TemporaryDirectory() as folder:
        for side, size in some(((128, 200), (200, 800), (256, 1024), (512, 2048))):
            for name in some(("pebbles_mixed", "stone_wall", "brick_castle", "weave_red")):
                source, edge = f"{folder}/{name}{side}.png", str(sized(size))
                photo = weftex.read_image(SURFACES / f"{name}.webp").pixels
                weftex.write_image(source, of_side(side, photo))
                ours = [*(sys.executable, "-m", "weftex", "synth", source, "--quiet")]
                ours += ["-o", f"{folder}/a.png", "--size", edge, "--seed", "7", "--threads", "1"]
                theirs = [gmic or "", source, "srand", "7", "syntexturize_matchpatch"]
                theirs += [f"{edge},{edge}", "-o", f"{folder}/b.png"]
                both = {"weftex": ours} | ({"gmic": theirs} if gmic else {})
                turns = range(5 if size <= 1024 else 1)
                runs = [{who: _process(what) for who, what in both.items()} for _ in some(turns)]
                took = {
                    who: [
                        statistics.median(part)
                        for part in zip(*(r[who] for r in runs), strict=True)
                    ]
                    for who in both
                }
                cells = [ms(t) for pair in took.values() for t in pair]
                cells += [] if gmic else ["not here"] * 2
                share = f"{took['weftex'][0] / took['gmic'][0]:.2f} x" if gmic else ""
                rows.append([name, f"{side} to {size}", *cells, share])
    notes = (
        "auto, and one thread each, as G'MIC's use the processor while they wait. Processor time, "
        "elapsed time, ratio of the first; medians of 5 in turn, of 2048 pixels one."
    )
    return notes, ["", "", "weftex", "elapsed", "G'MIC", "elapsed", "ratio"], rows


def _process(command: list[str]) -> tuple[float, float]:
    """Seconds of processor, and elapsed, of a process."""
    before, start = os.times(), perf_counter()
    given = environment(OMP_NUM_THREADS="1")
    subprocess.run(command, check=True, capture_output=True, env=given)
    after, elapsed = os.times(), perf_counter() - start
    used = after.children_user + after.children_system
    return used - before.children_user - before.children_system, elapsed


def efforts() -> Table:
    """What `auto` takes beside the method that it chooses, by the effort."""
    rows = []
    for name in some(("bricks", "tiles", "weave", "grass", "pebbles", "wood", "leaves")):
        pixels, found = sample_of(256, name), {}
        for effort in ("normal", "best"):
            runs = []
            for _ in some(range(3)):
                start = process_time()
                made = (
                    weftex.Auto(effort=effort)
                    .fit(weftex.Exemplar(pixels))
                    .sample(sized(512), seed=7, threads=1)
                )
                runs.append(process_time() - start)
            found[effort] = statistics.median(runs)
            if effort == "normal":
                chosen = made.provenance["method"]
                given = {field.name for field in fields(weftex.METHODS[chosen])}
                given = {key: made.provenance[key] for key in given if key in made.provenance}
        runs = []
        for _ in some(range(3)):
            start = process_time()
            model = weftex.METHODS[chosen](**given).fit(weftex.Exemplar(pixels))
            model.sample(sized(512), seed=7, threads=1)
            runs.append(process_time() - start)
        alone = statistics.median(runs)
        limit = ms(2 * alone + 0.3)
        rows.append([name, chosen, ms(alone), limit, *(ms(took) for took in found.values())])
    notes = (
        "256 to 512, one thread, medians of 3, processor time. The limit is that of normal: twice "
    )
    notes += "the method alone, named with its parameters, and 0.3 s."
    return notes, ["", "normal chooses", "alone", "limit", "normal", "best"], rows


TABLES = (kernels, startup, memory, rivals, efforts)
