"""A studio of its own, and browsers that look at it; skipped where there is none."""

from __future__ import annotations

import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

playwright = pytest.importorskip(
    "playwright.sync_api", reason="no playwright: pip install 'weftex[browser]'"
)

NAMES = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM = next(filter(None, map(shutil.which, NAMES)), None)
FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")
BETWEEN = Path(__file__).with_name("firefox.py")
PROBES = Path(__file__).with_name("probes.js").read_text(encoding="utf-8")


@contextmanager
def running(folder: Path) -> Iterator[str]:
    """A studio that stores its work in a folder; the address where it is to be opened."""
    pytest.importorskip("starlette")
    pytest.importorskip("uvicorn")
    command = [sys.executable, "-m", "weftex", "studio", "--no-browser", "--port", "0"]
    with subprocess.Popen(
        [*command, "--data", str(folder)], stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        found = re.search(r"http://\S+", process.stderr.readline())
        assert found, "the studio printed no address"
        try:
            yield found[0]
        finally:
            process.send_signal(signal.SIGINT)
            process.stderr.read()


@pytest.fixture(name="running", scope="session")
def running_studio() -> Any:
    """`running`, for tests that start and end studios."""
    return running


@pytest.fixture(scope="session")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Where a studio that runs for the tests is to be opened."""
    with running(tmp_path_factory.mktemp("studio")) as found:
        yield found


@pytest.fixture(scope="session")
def tools() -> Iterator[Any]:
    """Playwright."""
    with playwright.sync_playwright() as found:
        yield found


@pytest.fixture(scope="session")
def chromium(tools: Any) -> Iterator[Any]:
    """Chromium without a window."""
    if CHROMIUM is None:
        pytest.skip("no chromium: apt-get install chromium")
    flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    opened = tools.chromium.launch(executable_path=CHROMIUM, args=flags)
    yield opened
    opened.close()


@pytest.fixture(scope="session")
def firefox(tools: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Firefox without a window, as `firefox.py` runs it."""
    if FIREFOX is None or sys.platform == "win32":
        pytest.skip("no firefox: apt-get install firefox-esr")
    pytest.importorskip("websockets", reason="no websockets: pip install 'weftex[browser]'")
    command = tmp_path_factory.mktemp("firefox") / "firefox"
    words = shlex.join([sys.executable, str(BETWEEN), FIREFOX])
    command.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
    command.chmod(0o755)
    try:
        opened = tools.firefox.launch(channel="moz-firefox", executable_path=command)
    except playwright.Error as error:
        pytest.skip(f"this playwright does not drive this firefox: {error}")
    yield opened
    opened.close()


@pytest.fixture
def browser(request: pytest.FixtureRequest) -> Any:
    """Chromium, or what a test is parametrized by."""
    return request.getfixturevalue(getattr(request, "param", "chromium"))


class Tab:
    """A page with nothing of an earlier one.

    `faults` is what its console complains of; the test fails unless all of it is `expected`.
    """

    def __init__(self, browser: Any, expected: str = "$^", **options: Any) -> None:
        self.expected = expected  # a pattern
        self.context = browser.new_context(accept_downloads=True, **options)
        self.page = self.context.new_page()
        self.page.set_default_timeout(120_000)
        self.faults: list[str] = []
        self.page.on("console", lambda one: self.faults.append(one.text))
        self.page.on("pageerror", lambda one: self.faults.append(str(one)))

    def open(self, address: str) -> Any:
        """Go there and wait until the page is ready."""
        self.page.goto(address)
        self.page.wait_for_selector("[data-ready]")
        return self.page

    def begin(self, address: str, photo: Path | str, screen: str = "sample") -> Any:
        """Open a photo, or a sample by its name, and go to a screen."""
        page = self.open(address)
        if isinstance(photo, Path):
            page.set_input_files("input[type=file]", photo)
        else:
            page.click(f".samples button:has-text('{photo}')")
        page.wait_for_selector(".facts")
        page.click(f"[data-screen={screen}]")
        return page

    def probe(self, name: str) -> Any:
        """What a probe finds; by the debugger, because the page's own policy forbids eval."""
        code = f"({PROBES}).{name}()"
        if self.context.browser.browser_type.name != "chromium":
            return self.page.evaluate(code)  # by the debugger there
        tools = self.context.new_cdp_session(self.page)
        wanted = {"expression": code, "returnByValue": True, "awaitPromise": True}
        found = tools.send("Runtime.evaluate", wanted)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def write(self, label: str, text: str) -> None:
        """Write into a field as a person does; `fill` adds to numbers in Firefox."""
        self.page.focus(f"[aria-label={label}]")
        self.page.keyboard.press("Control+a")
        self.page.keyboard.type(text)
        self.page.keyboard.press("Tab")

    def settle(self) -> None:
        """Wait until no work is under way."""
        self.page.wait_for_selector(".stage:not(.busy)")

    def size(self, width: int, height: int) -> None:
        """Write the size of what is to be made."""
        self.write("Width", str(width))
        self.write("Height", str(height))

    def make(self, method: str, width: int, height: int) -> None:
        """Make an image by a method, from the screen Make."""
        self.page.click("[data-screen=make]")
        self.page.select_option("select", method)
        self.size(width, height)
        self.press_make()

    def press_make(self) -> None:
        """Make what the screen Make says; a preview of the same picture would be "Changed"."""
        self.page.click("text=Make it")
        made = ".strip [aria-current] .what > span:text-is('Made')"
        self.page.wait_for_selector(f"body:has({made}):has(.panel .hint:has-text('Made by'))")

    def shot(self, before: bytes | None = None, at: str = ".viewer") -> bytes:
        """What is drawn left of the controls, once it is another picture than the one before."""
        box = self.page.locator(at).first.bounding_box()
        assert box
        end = time.monotonic() + 60
        while (found := self.page.screenshot(clip={**box, "width": box["width"] - 260})) == before:
            assert time.monotonic() < end, "nothing has changed"
        return bytes(found)

    def stroke(self, *places: tuple[float, float]) -> None:
        """Draw through places, in shares of the view."""
        box = self.page.locator(".viewer").first.bounding_box()
        assert box
        for k, (x, y) in enumerate(places):
            self.page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"], steps=4)
            if k == 0:
                self.page.mouse.down()
        self.page.mouse.up()


@pytest.fixture
def tab(browser: Any) -> Iterator[Any]:
    """A new tab of 1280 x 800 pixels."""
    tabs: list[Tab] = []

    def make(**options: Any) -> Tab:
        tabs.append(Tab(browser, **{"viewport": {"width": 1280, "height": 800}, **options}))
        return tabs[-1]

    yield make
    for one in tabs:
        one.context.close()
        assert [line for line in one.faults if not re.search(one.expected, line)] == []


@pytest.fixture(scope="session")
def photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small photo of bricks."""
    import weftex

    path = tmp_path_factory.mktemp("photo") / "wall.png"
    weftex.write_image(path, weftex.load_exemplar("sample:bricks").pixels[:128, :160])
    return path
