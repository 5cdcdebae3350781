"""Commands without end in one process: what stays behind of memory, files and threads.

    python benchmarks/guards/soak.py --seconds 300    as many as there is time for
    python benchmarks/guards/soak.py --commands 50    so many; the same for the same --seed

Tiny outputs of all commands that make pictures, with methods, options and maps drawn at random; a
quarter of them are told nonsense. Each ends with 0, or 2 and one line. The first tenth warms up;
growth is the slope of the line through what was measured from there on.
"""

from __future__ import annotations

import argparse
import io
import os
import random
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np

import weftex
from weftex import cli
from weftex.io.manifest import remove
from weftex.io.pictures import write_image

EVERY = 20  # commands between two looks at the process
NONSENSE = ("", "-1", "nan", "10**9", "no such thing", "a\nb", "\x1b[1m", "9" * 400, "é/../x")
#: Growth per 1000 commands that is none: allocators keep a little.
MOST = {"MiB": 20.0, "files": 0.5, "threads": 0.5, "left in /tmp": 0.5}


def resident() -> float:
    """MiB of memory that the process has now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def looked(folder: Path) -> dict[str, float]:
    """What the process holds."""
    return {
        "MiB": resident(),
        "files": len(os.listdir("/proc/self/fd")),
        "threads": threading.active_count(),
        "left in /tmp": sum(1 for _ in folder.iterdir()),
    }


def inputs(folder: Path) -> None:
    """Samples, maps, a folder of maps, and files that are damaged."""
    rng = np.random.default_rng(1)
    pixels = rng.integers(0, 256, (24, 28, 3), np.uint8)
    hole = np.zeros((24, 28), np.uint8)
    hole[8:14, 9:17] = 255
    labels = np.zeros((20, 22, 3), np.uint8)
    labels[:, 11:] = 255
    named = {"a.png": pixels, "b.png": pixels[::-1], "hole.png": hole, "labels.png": labels}
    named |= {"g.tif": pixels[..., 0].astype(np.float32), "one.png": pixels[:1, :1]}
    (folder / "set").mkdir()
    named |= {"set/s_albedo.png": pixels, "set/s_roughness.png": pixels[..., 0]}
    for name, picture in named.items():
        write_image(folder / name, picture)
    whole = (folder / "a.png").read_bytes()
    (folder / "cut.png").write_bytes(whole[: len(whole) // 2])
    (folder / "text.png").write_text("no picture")


def method_words(draw: random.Random) -> list[str]:
    """A method, and now and then a parameter of it."""
    slug = draw.choice([*weftex.METHODS])
    words = ["--method", slug]
    if draw.random() < 0.4:
        name, value = draw.choice(
            [("patch-size", 5), ("patch-size", 9), ("tolerance", 0.2), ("neighborhood", 5)]
        )
        words += [f"--{name}", str(value)]
    return words


def command(draw: random.Random) -> list[str]:
    """A command, relative to a folder with inputs, that writes into the folder `out`."""
    sample = draw.choice(["a.png", "a.png", "b.png", "g.tif", "set", "one.png", "cut.png"])
    size = f"{draw.randint(1, 40)}x{draw.randint(1, 40)}"
    seed = ["--seed", str(draw.randint(0, 99))]
    makes = {
        "synth": ["synth", sample, "-o", "out/o.png", "--size", size, *method_words(draw)],
        "tileable": ["synth", sample, "-o", "out/o.png", "--size", size, "--tileable"],
        "set": ["synth", "set", "-o", "out/set", "--size", size, *method_words(draw)],
        "tile": ["tile", sample, "-o", "out/o.png"],
        "fill": ["fill", sample, "--mask", "hole.png", "-o", "out/o.png", *method_words(draw)],
        "fuse": ["fuse", "a.png", "b.png", "--map", "labels.png", "-o", "out/o.png"],
        "source": [
            "synth",
            sample,
            "-o",
            "out/o.tif",
            "--size",
            size,
            "--save-source",
            "out/o.npz",
        ],
        "replay": ["replay", "kept.npz", "b.png", "-o", "out/o.png"],
        "analyze": ["analyze", sample],
        "methods": ["methods", draw.choice([*weftex.METHODS])],
    }
    words = makes[draw.choice([*makes])]
    if words[0] not in ("replay", "analyze", "methods"):
        words += seed
    if draw.random() < 0.25:
        words[draw.randrange(1, len(words))] = draw.choice((*NONSENSE, "text.png"))
    return words


@contextmanager
def at_work(folder: Path) -> Iterator[None]:
    """In a folder with inputs, whose temporary files are apart."""
    before, old = os.getcwd(), tempfile.tempdir
    inputs(folder)
    for name in ("out", "tmp"):
        (folder / name).mkdir()
    os.chdir(folder)
    tempfile.tempdir = str(folder / "tmp")
    try:
        run(["synth", "a.png", "-o", "out/k.png", "--size", "30", "--save-source", "kept.npz"])
        Path("out/k.png").unlink()
        yield
    finally:
        os.chdir(before)
        tempfile.tempdir = old


def run(words: list[str]) -> int:
    """Run a command, and see that it says one line at most where it fails."""
    out, said = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(said):
        code = cli.main(words)
    lines = said.getvalue().strip("\n").splitlines()
    if code not in (0, 2) or (code == 2 and (len(lines) != 1 or "error: " not in lines[0])):
        raise AssertionError(f"{words} ended with {code}: {said.getvalue()}")
    return code


def soak(commands: int, seconds: float, seed: int) -> tuple[Counter[str], list[tuple[int, dict]]]:
    """Run commands; return how they ended, and what was held after how many."""
    draw, counts = random.Random(seed), Counter[str]()
    seen: list[tuple[int, dict]] = []
    end = time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as name, at_work(Path(name)):
        there = {*os.listdir()}
        while sum(counts.values()) < commands and time.monotonic() < end:
            words = command(draw)
            code = run(words)
            counts["done" if code == 0 else "refused"] += 1
            for file in Path("out").iterdir():
                assert code == 0, f"{words} failed and left {file}"
                remove(str(file))
            for file in {*os.listdir()} - there:  # what nonsense as a name was good for
                assert code == 0, f"{words} failed and left {file}"
                remove(file)
            if sum(counts.values()) % EVERY == 0:
                seen.append((sum(counts.values()), looked(Path("tmp"))))
    return counts, seen


def growth(seen: list[tuple[int, dict]]) -> dict[str, float]:
    """Return by how much each thing grows in 1000 commands, after the first tenth."""
    late = [one for one in seen if one[0] >= seen[-1][0] / 10]
    at = [count for count, _ in late]
    return {
        name: 1000 * float(np.polyfit(at, [held[name] for _, held in late], 1)[0])
        for name in seen[0][1]
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--commands", type=int, default=10**9)
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    counts, seen = soak(args.commands, args.seconds, args.seed)
    print(f"{sum(counts.values())} commands: " + ", ".join(f"{v} {k}" for k, v in counts.items()))
    found = growth(seen)
    for name, first in seen[0][1].items():
        print(f"{name}: {first:.4g} to {seen[-1][1][name]:.4g}, {found[name]:+.3g} per 1000")
    return int(any(found[name] > most for name, most in MOST.items()))


if __name__ == "__main__":
    sys.exit(main())
