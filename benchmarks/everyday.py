"""What people wait for: materials of each kind from a shell, and what showing progress takes."""

from __future__ import annotations

import io
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter, process_time, thread_time
from unittest.mock import patch

from shared import Table, busy, ms, sample_of, sized, some

import weftex
from weftex.cli import terminal

#: The rows of docs/index.md: a material, and the words of the command that makes it.
MATERIALS = {
    "gravel, grass, plaster": "synth pebbles.png --size {}",
    "stones, rubble, leaves": "synth stone_wall.png --size {}",
    "bricks, tiles": "synth bricks.png --size {}",
    "cloth, mesh": "synth weave.png --size {}",
    "boards, ribs": "synth boards.png --size {}",
    "a painted map, a guide": "synth pebbles.png --method ashikhmin --guide guide.png",
    "a photo that is to repeat": "tile bricks.png",
    "a hole in a photo": "fill bricks.png --mask hole.png",
    "two materials that meet": "fuse leaves.png pebbles.png --map hole.png",
}


def materials() -> Table:
    """Whole processes, a material of each kind: what the landing page says."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        names = {name for words in MATERIALS.values() for name in words.split() if ".png" in name}
        for name in names - {"hole.png", "guide.png"}:
            weftex.write_image(f"{folder}/{name}", sample_of(256, Path(name).stem))
        hole = weftex.read_image("sample:hole").pixels
        step = -(-256 // sized(256))
        weftex.write_image(f"{folder}/hole.png", hole[::step, ::step])
        weftex.write_image(f"{folder}/guide.png", sample_of(256, "leaves"))
        for kind, words in MATERIALS.items():
            command = [sys.executable, "-m", "weftex", *words.format(sized(1024)).split()]
            command += ["-o", "out.png", "--seed", "7", "--save-source", "out.npz", "--quiet"]
            took = []
            for _ in some(range(3)):
                start, clock = busy(), perf_counter()
                subprocess.run(command, cwd=folder, check=True)
                took.append((busy() - start, perf_counter() - clock))
            made = weftex.Synthesis.load(f"{folder}/out.npz")
            size = f"{made.shape[1]}x{made.shape[0]}"
            times = (ms(statistics.median(part)) for part in zip(*took, strict=True))
            rows.append([kind, made.provenance.get("method", ""), size, *times])
    notes = "Samples of 256x256, medians of 3 processes; the method is the one chosen by weftex."
    return notes, ["material", "method", "output", "processor time", "elapsed"], rows


def progress() -> Table:
    """What a bar on a terminal takes from the work that it shows."""
    rows = []
    start = thread_time()
    for _ in range(10_000):
        thread_time()
    pair = (thread_time() - start) / 10_000  # what is between two looks at the clock by themselves
    screen = io.StringIO()
    jobs = {"patch-sampling": 4096, "quilting": 4096, "graphcut": 1024, "wei-levoy": 128}
    jobs |= {"ashikhmin": 512, "exact-matching": 128, "refinement": 192, "best-tile": 2048}
    with (
        patch.object(terminal, "_BAR_AFTER", 0),
        patch.object(sys, "stderr", screen),
        patch.object(screen, "isatty", lambda: True),
    ):
        for method, size in jobs.items():
            model = weftex.METHODS[method]().fit(sample_of(96 if size < 1000 else 256, "bricks"))
            model.sample(sized(size) // 2, seed=1)
            shares = []
            for _ in some(range(3)):
                inside = [0, 0.0]

                def work(bar, outputs, model=model, size=size, inside=inside):
                    def counted(*given):
                        start = thread_time()
                        answer = bar(*given)
                        inside[0], inside[1] = inside[0] + 1, inside[1] + thread_time() - start
                        return answer

                    model.sample(sized(size), seed=7, progress=counted)

                start, drawn = process_time(), thread_time()
                terminal.run(work, quiet=False)
                drawn, all_of_it = thread_time() - drawn, process_time() - start
                called = max(0.0, inside[1] - inside[0] * pair)
                shares.append((called / all_of_it, drawn / all_of_it, inside[0], all_of_it))
            called, drawn, calls, took = (statistics.median(part) for part in zip(*shares, strict=True))
            share = [f"{100 * part:.2f} %" for part in (called, drawn)]
            rows.append([method, ms(took), str(int(calls)), *share])
    notes = "Medians of 3. Counting is taken from the work; the main thread draws meanwhile."
    return notes, ["method", "processor time", "calls", "counting", "drawing"], rows


TABLES = (materials, progress)
