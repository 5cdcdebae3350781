"""The studio under load, and how quick it is: requests at once, large uploads, lines that are cut.

    python benchmarks/speed/studio.py               all of it, in about a minute and a half
    python benchmarks/speed/studio.py --only start  what is named so

It starts `weftex studio` as a process, asks it over the loopback as a page does, and prints a
table.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import socket
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests" / "studio"))
import numpy as np
from pages import Page, Process

from weftex.io.pictures import write_image
from weftex.studio.app import static_files

Row = tuple[str, str]
BRICKS = {"sample": "bricks"}
LONG = {"materials": [BRICKS], "size": [1500, 1500], "seed": 1, "method": "efros-leung"}


def resident(run: Process) -> float:
    """MiB of memory that the server had at most."""
    text = Path(f"/proc/{run.run.pid}/status").read_text()
    return int(text.split("VmHWM:")[1].split()[0]) / 1024


def took(work: Callable[[], Any], times: int = 5) -> str:
    """The median and the longest of some calls, in milliseconds."""
    seconds = []
    for _ in range(times):
        start = time.perf_counter()
        work()
        seconds.append(1000 * (time.perf_counter() - start))
    return f"{statistics.median(seconds):.0f} ms (at most {max(seconds):.0f})"


def start(folder: Path, times: int = 5) -> Iterator[Row]:
    """From the command to the first picture, as the page asks for it."""
    seconds = []
    for _ in range(times):
        begun = time.perf_counter()
        run = Process(folder / os.urandom(4).hex(), "sample:bricks", "--port", "0")
        for path in ("/", *(f"/static/{name}" for name in static_files())):
            run.client.get(path)
        page = Page(run.client, run.token)
        material = page.post("materials", page.start["opened"])
        page.get(f"materials/{material['id']}/picture")
        seconds.append(time.perf_counter() - begun)
        run.end(signal.SIGTERM)
    yield (
        "`weftex studio sample:bricks` to the sample's picture, without the browser's own start",
        f"{statistics.median(seconds):.2f} s (at most {max(seconds):.2f})",
    )


def quick(folder: Path) -> Iterator[Row]:
    """What a hand waits for."""
    run = Process(folder / "quick", "--port", "0")
    page = Page(run.client, run.token)
    material = page.post("materials", BRICKS)["id"]
    yield (
        "what a sample of 256x256 is like, the first time",
        took(lambda: page.look(material), 1),
    )
    angles = iter(range(1000))

    def drag() -> None:
        k = next(angles)
        page.get(
            f"materials/{material}/lattice?vectors={62 + k / 7:.2f},41.8,63.4,{-41 - k / 9:.2f}"
        )

    drag()
    yield "a drag of its lattice", took(drag, 20)
    for slug in ("patch-sampling", "quilting", "graphcut"):
        seeds = iter(range(1000))

        def preview(slug: str = slug, seeds: Any = seeds) -> None:
            recipe = {"materials": [BRICKS], "size": [512, 512], "method": slug}
            asked = {"recipe": {**recipe, "seed": next(seeds)}, "lane": "preview"}
            job = page.post("jobs?within=1000", asked)
            while not job["results"]:
                job = page.get(f"jobs/{job['id']}?seen={job['version']}&wait=20")
            page.get(f"results/{job['results'][0]['id']}/picture?raw=1")

        yield f"512x512 by {slug}, asked for, made and there as a picture", took(preview)
    for slug in ("best-tile", "near-regular"):
        plane = page.post("planes", {"materials": [BRICKS], "method": slug, "seed": 1})["id"]
        places = iter(range(-(10**6), 10**6))

        def window(plane: str = plane, places: Any = places) -> None:
            page.get(f"planes/{plane}/window?top=0&left={256 * next(places)}")

        yield f"a window of 256x256 of the endless plane by {slug}", took(window, 20)
    run.end(signal.SIGTERM)


def crowd(folder: Path) -> Iterator[Row]:
    """Fifty at once, ten times, from five tabs, while two jobs run."""
    run = Process(folder / "crowd", "--port", "0")
    tabs = [Page(run.client, run.token) for _ in range(5)]
    for tab in tabs[:2]:
        tab.post("jobs", {"recipe": LONG, "keep": True})
    seconds, codes = [], []

    def ask(k: int) -> None:
        paths = ["about", "jobs", "samples/stone_wall/picture", "samples/bricks/picture"]
        begin = time.perf_counter()
        codes.append(tabs[k % 5].ask("GET", paths[k // 5 % 4]).status_code)
        seconds.append(time.perf_counter() - begin)

    for _ in range(10):
        threads = [threading.Thread(target=ask, args=(k,)) for k in range(50)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    told = f"median {1000 * statistics.median(seconds):.0f} ms, the slowest {max(seconds):.2f} s"
    yield (
        "50 requests at once, ten times, beside two jobs",
        f"{codes.count(200)} of {len(codes)} answered, {told}",
    )
    full = []
    for _ in range(60):
        answer = tabs[0].ask("POST", "jobs", content=f'{{"recipe": {json.dumps(LONG)}}}')
        full.append(answer.status_code)
    yield "60 long jobs at once", f"{full.count(200)} taken, {full.count(429)} refused"
    for tab in tabs:
        tab.post("leave")
    run.end(signal.SIGTERM)


def large(folder: Path) -> Iterator[Row]:
    """A picture of 100 megapixels, and the largest that is taken."""
    run = Process(folder / "large", "--port", "0")
    page = Page(run.client, run.token)
    before = resident(run)
    for side, height in ((10_000, 10_000), (8192, 8192)):
        rows = np.arange(height, dtype=np.uint32)[:, None] * 7
        pixels = ((rows + np.arange(side, dtype=np.uint32)) % 251).astype(np.uint8)
        write_image(folder / "large.png", np.dstack([pixels] * 3))
        content = (folder / "large.png").read_bytes()
        begin = time.perf_counter()
        answer = page.ask("POST", "uploads", content=content, headers={"x-weftex-name": "l.png"})
        spent = time.perf_counter() - begin
        said = "taken" if answer.status_code == 200 else f"refused ({answer.status_code})"
        yield (
            f"an upload of {side}x{height}, {len(content) >> 20} MiB",
            f"{said} in {spent:.2f} s; {resident(run):.0f} MiB at most, {before:.0f} before",
        )
    run.end(signal.SIGTERM)


def cut(folder: Path) -> Iterator[Row]:
    """Twenty lines that are cut in the middle of a job, and five servers that are killed."""
    run = Process(folder / "cut", "--port", "0")
    page = Page(run.client, run.token)
    head = "".join(f"{name}: {value}\r\n" for name, value in page.headers.items())
    host = f"host: {run.client.host}\r\n"
    names = []
    for k in range(20):
        job = page.post("jobs", {"recipe": {**LONG, "seed": k}})
        names.append(job["id"])
        line = socket.create_connection(("127.0.0.1", run.client.port))
        path = f"/api/jobs/{job['id']}?seen={job['version']}&wait=20"
        line.sendall(f"GET {path} HTTP/1.1\r\n{host}{head}\r\n".encode())
        line.close()
    begin = time.perf_counter()
    while any(one["state"] in ("waiting", "running") for one in page.get("jobs")):
        time.sleep(0.2)
        if time.perf_counter() - begin > 60:
            break
    states = [page.get(f"jobs/{name}")["state"] for name in names]
    spent = time.perf_counter() - begin
    yield (
        "20 jobs whose pages' lines were cut",
        f"{states.count('cancelled')} cancelled within {spent:.0f} s",
    )
    run.end(signal.SIGTERM)
    data, kept, session = folder / "killed", 0, None
    for k in range(5):
        run = Process(data, "--port", "0")
        page = Page(run.client, run.token, session)
        session = page.start["session"]
        assert len(page.start["steps"]) == kept
        recipe = {"materials": [BRICKS], "size": [96, 96], "seed": k, "method": "quilting"}
        made = page.made(recipe)["id"]
        page.post("steps", {"id": f"{k:012}", "recipe": recipe, "result": made})
        kept += 1
        page.post("jobs", {"recipe": LONG})
        run.end(signal.SIGKILL)
        with socket.socket() as probe:
            gone = probe.connect_ex(("127.0.0.1", run.client.port)) != 0
        assert gone
    run = Process(data, "--port", "0")
    page = Page(run.client, run.token, session)
    yield (
        "5 servers killed in the middle of a job and started again",
        f"{len(page.start['steps'])} of {kept} steps there, {len(page.get('jobs'))} jobs",
    )
    run.end(signal.SIGTERM)


PARTS = {one.__name__: one for one in (start, quick, crowd, large, cut)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=PARTS)
    wanted = parser.parse_args().only
    print("| what | figure |\n|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, part in PARTS.items():
            for what, figure in part(Path(folder)) if wanted in (None, name) else ():
                print(f"| {what} | {figure} |", flush=True)


if __name__ == "__main__":
    main()
