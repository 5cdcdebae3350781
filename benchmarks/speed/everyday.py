"""What people wait for: materials of each kind from a shell, and what showing progress takes.

    python benchmarks/speed/everyday.py [FOLDER]        # the pictures of docs/index.md, to docs/img

The tables are run.py's. Needs weftex[test].
"""

from __future__ import annotations

import io
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter, process_time, thread_time
from unittest.mock import patch

from PIL import Image
from shared import ROOT, Table, busy, environment, ms, sample_of, sized, some

import weftex
from weftex.cli import terminal

#: The rows of docs/index.md: the name of a picture, the material, the words of the command.
MATERIALS = {
    "grain": ("gravel, grass, plaster", "synth pebbles.png --size {}"),
    "things": ("stones, rubble, leaves", "synth stone_wall.png --size {}"),
    "bricks": ("bricks, tiles", "synth bricks.png --size {}"),
    "cloth": ("cloth, mesh", "synth gingham.png --size {}"),
    "rows": ("boards, ribs", "synth boards.png --size {}"),
    "guided": (
        "a painted map, a guide",
        "synth pebbles.png --method ashikhmin --guide leaves.png",
    ),
    "tile": ("a photo that is to repeat", "tile wood.png"),
    "hole": ("a hole in a photo", "fill bricks.png --mask hole.png"),
    "meeting": ("two materials that meet", "fuse leaves.png pebbles.png --map hole.png"),
}
#: Those that the page of no task shows.
ROWS = ("grain", "things", "bricks", "cloth", "rows", "tile")
_HEIGHT = 76  # pixels of a picture in a row


def inputs(name: str, folder: str) -> list[str]:
    """Write the pictures that a row's command reads; their names."""
    files = [word for word in MATERIALS[name][1].split() if word.endswith(".png")]
    for file in files:
        step = 256 // sized(256)
        hole = weftex.read_image("sample:hole").pixels[::step, ::step]
        pixels = hole if file == "hole.png" else sample_of(256, Path(file).stem)
        weftex.write_image(f"{folder}/{file}", pixels)
    return files


def make(name: str, folder: str) -> None:
    """Run the command of a row."""
    words = MATERIALS[name][1].format(sized(1024)).split()
    command = [sys.executable, "-m", "weftex", *words, "-o", "out.png", "--seed", "7", "--quiet"]
    command += ["--save-source", "out.npz"]
    subprocess.run(command, cwd=folder, check=True, env=environment())


def materials() -> Table:
    """Whole processes, a material of each kind: what the landing page says."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, (kind, _) in some([*MATERIALS.items()], least=2):
            inputs(name, folder)
            took = []
            for _ in some(range(3)):
                start, clock = busy(), perf_counter()
                make(name, folder)
                took.append((busy() - start, perf_counter() - clock))
            result = weftex.Synthesis.load(f"{folder}/out.npz")
            size = f"{result.shape[1]}x{result.shape[0]}"
            times = (ms(statistics.median(part)) for part in zip(*took, strict=True))
            rows.append([kind, result.provenance.get("method", ""), size, *times])
    notes = "Samples of 256x256, medians of 3 processes; the method is the one chosen by weftex."
    return notes, ["material", "method", "output", "processor time", "elapsed"], rows


def draw(target: Path) -> None:
    """Write the inputs and output of rows that no other page has, side by side, small."""
    for name in ROWS:
        shown = []
        with tempfile.TemporaryDirectory() as folder:
            files = inputs(name, folder)
            make(name, folder)
            for file in [*files, "out.png"]:
                picture = Image.open(f"{folder}/{file}").convert("RGB")
                if picture.width >= 512:  # more of the material, at the scale of its sample
                    picture = picture.crop((0, 0, 512, 256))
                width = _HEIGHT * picture.width // picture.height
                shown.append(picture.resize((width, _HEIGHT), Image.Resampling.LANCZOS))
        row = Image.new("RGB", (sum(one.width + 4 for one in shown) - 4, _HEIGHT), "white")
        left = 0
        for one in shown:
            row.paste(one, (left, 0))
            left += one.width + 4
        row.save(target / f"row_{name}.webp", quality=52, method=6)


#: What a bar is measured beside: an output that takes a quarter of a second or more.
JOBS = {
    "patch-sampling": 3600,
    "quilting": 3000,
    "graphcut": 300,
    "efros-leung": 100,
    "wei-levoy": 180,
    "ashikhmin": 560,
    "exact-matching": 360,
    "refinement": 560,
    "near-regular": 3600,
    "best-tile": 7000,
}


def progress() -> Table:
    """What a bar on a terminal takes from the work that it shows."""
    rows = []
    screen = io.StringIO()
    idle = terminal.Bar(quiet=True)
    call = seconds_of_a_call(lambda: idle(1, 2, "preparing", lambda: None))
    with (
        patch.object(weftex.progress.Bar.__init__, "__defaults__", (0,)),
        patch.object(sys, "stderr", screen),
        patch.object(screen, "isatty", lambda: True),
    ):
        for method, size in JOBS.items():
            model = weftex.METHODS[method]().fit(sample_of(96 if size < 1000 else 256, "bricks"))
            sample = partial(model.sample, sized(size), seed=7, threads=1)
            calls: list[int] = []
            sample(progress=lambda done, *_, calls=calls: calls.append(done))
            found = []
            for _ in some(range(9)):
                start = process_time()
                sample()
                alone, start, drawn = process_time() - start, process_time(), thread_time()
                terminal.run(lambda bar, _, sample=sample: sample(progress=bar), quiet=False)
                drawn, beside = thread_time() - drawn, process_time() - start
                shares = len(calls) * call / alone, drawn / alone
                found.append((alone, *shares, sum(shares), beside / alone))
            took, *shares, ratio = map(statistics.median, zip(*found, strict=True))
            cells = [f"{100 * share:.2f} %" for share in shares]
            rows.append([method, str(size), ms(took), str(len(calls)), *cells, f"{ratio:.3f} x"])
    notes = (
        "Processor time, one thread, medians of 9 without the bar and with it, in turn. Counting "
        "is what the calls take from the work; the main thread draws meanwhile, here from the "
        "first moment on. The ratio has all noise of the machine. Loading tqdm comes to it, 31 ms, "
        "so a bar appears after half a second of work."
    )
    head = ["method", "output", "time", "calls", "counting", "drawing", "together", "ratio"]
    return notes, head, rows


def seconds_of_a_call(call: Callable[[], object], times: int = 100_000) -> float:
    """Seconds of processor time that a call takes, of many in a row."""
    start = thread_time()
    for _ in range(times):
        call()
    return (thread_time() - start) / times


TABLES = (materials, progress)

if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "img")
