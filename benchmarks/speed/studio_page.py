"""How fast the studio's page is in headless Chromium, without a graphics card.

    python benchmarks/speed/studio_page.py
    python benchmarks/speed/studio_page.py --shots    # only draw the pictures of the docs

Prints the time from the command to the sample on the screen, that from a change of a number to the
picture that follows, the frames a second while the endless plane is panned, and the weight of the
page. Needs `weftex[browser]` and Chromium. The server alone: `benchmarks/speed/studio.py`.
"""

from __future__ import annotations

import io
import itertools
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.resources import files
from typing import Any

from PIL import Image
from playwright.sync_api import sync_playwright
from shared import ROOT

_ACROSS, _QUALITY = 1000, 72  # pixels, and of WebP, of the pictures in the docs
_LIGHT = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]  # WebGL2 by the processor
FRAMES = """
  window.times = [];
  (function count(now) { times.push(now); requestAnimationFrame(count); })(performance.now());
"""


def weight() -> int:
    """Bytes of all files of the page."""
    found, waiting = 0, [files("weftex.studio") / "static"]
    while waiting:
        for one in waiting.pop().iterdir():
            if one.is_dir():
                waiting.append(one)
            else:
                found += len(one.read_bytes())
    return found


def slide(page: Any) -> float:
    """Median seconds from a change of a parameter to the 512x512 picture that follows."""
    page.click("[data-screen=make]")
    page.select_option("select", "quilting")
    page.click("summary")
    page.wait_for_timeout(1500)
    taken = []
    for k in range(7):
        begun = time.perf_counter()
        with page.expect_response(lambda answer: "/picture" in answer.url):
            page.fill(".parameter input[type=number] >> nth=0", str(40 + k))
            page.press(".parameter input[type=number] >> nth=0", "Tab")
        taken.append(time.perf_counter() - begun)
        page.wait_for_timeout(300)
    return statistics.median(taken)


def pan(page: Any) -> list[float]:
    """Seconds of each frame while the plane is dragged over fresh ground."""
    page.select_option("select", "near-regular")
    page.wait_for_timeout(2000)
    page.click("[data-key=plane]")
    page.wait_for_timeout(2500)
    tools = page.context.new_cdp_session(page)
    tools.send("Runtime.evaluate", {"expression": FRAMES})
    page.mouse.move(880, 500)
    page.mouse.down()
    for k in range(100):
        page.mouse.move(880 - 8 * k, 500 - 2 * k)
        time.sleep(0.016)
    page.mouse.up()
    told = tools.send("Runtime.evaluate", {"expression": "times.slice(1)", "returnByValue": True})
    times = told["result"]["value"]
    return [(after - before) / 1000 for before, after in itertools.pairwise(times)]


def draw(page: Any, name: str) -> None:
    """Write what is on the screen as a picture of the docs."""
    shown = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    shown.thumbnail((_ACROSS, _ACROSS), Image.Resampling.LANCZOS)
    path = ROOT / "docs" / "img" / f"studio_{name}.webp"
    shown.save(path, quality=_QUALITY, method=6)
    print(f"{path}: {path.stat().st_size} bytes")


def shots(page: Any) -> None:
    """The screens of a whole way, from the sample to a fused picture."""
    page.wait_for_selector(".facts")
    draw(page, "sample")
    page.click("[data-screen=paint]")
    page.check("input[value=fuse]")
    page.select_option("[aria-label^='Add a sample']", "pebbles")
    page.wait_for_selector(".shelf >> text=pebbles")
    page.mouse.move(300, 620)
    page.mouse.down()
    for x, y in ((430, 430), (560, 400), (640, 250), (660, 130)):
        page.mouse.move(x, y, steps=8)
    page.mouse.up()
    draw(page, "paint")
    page.click("[aria-label^='Open another']")
    page.click(".samples button:has-text('stone wall')")
    page.wait_for_selector(".facts")
    page.click("text=Make it")
    page.wait_for_selector(".panel >> text=Made by")
    page.click("[data-key=light]")
    page.mouse.move(330, 230)
    page.wait_for_timeout(2000)
    draw(page, "light")


def main() -> None:
    """Start a studio and look at it."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    flags = ["--no-sandbox", *(_LIGHT if "--shots" in sys.argv else [])]
    with sync_playwright() as play, tempfile.TemporaryDirectory() as folder:
        browser = play.chromium.launch(executable_path=chromium, args=flags)
        page = browser.new_page(viewport={"width": 1280, "height": 800}, color_scheme="dark")
        page.set_default_timeout(15_000)
        command = [sys.executable, "-m", "weftex", "studio", "sample:bricks", "--no-browser"]
        begun = time.perf_counter()
        studio = subprocess.Popen(
            [*command, "--port", "0", "--data", folder], stderr=subprocess.PIPE, text=True
        )
        try:
            assert studio.stderr is not None
            found = re.search(r"http://\S+", studio.stderr.readline())
            assert found
            page.goto(found[0])
            page.wait_for_selector(".stage-bar >> text=256 × 256")
            if "--shots" in sys.argv:
                shots(page)
                return
            print(f"first picture       {time.perf_counter() - begun:.2f} s")
            page.wait_for_selector(".facts")
            print(f"after a change      {slide(page):.2f} s")
            steps = pan(page)
            slow = statistics.quantiles(steps, n=20)[-1]
            print(f"panning             {1 / statistics.mean(steps):.0f} frames a second")
            print(f"its slowest 20th    {1 / slow:.0f} frames a second")
            print(f"weight of the page  {weight() / 1000:.0f} kB")
        finally:
            studio.terminate()
            browser.close()
            studio.communicate()


if __name__ == "__main__":
    main()
