"""The studio's page in a real browser: a whole way, a shared state, contrast, keys, a phone."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import weftex

SCREENS = ("sample", "make", "see", "paint", "compare", "take")


def picture(data: bytes) -> np.ndarray[Any, Any]:
    return np.array(Image.open(io.BytesIO(data)))


BROWSERS = pytest.mark.parametrize("browser", ["chromium", "firefox"], indirect=True)


@BROWSERS
def test_a_persons_whole_way(tab: Any, address: str, photo: Path) -> None:
    """Drop a photo, look, tile it, paint a hole, fuse, light, plane, export: without a fault."""
    one = tab()
    page = one.begin(address, photo)
    assert "wall" in page.inner_text(".panel h2")

    page.click("[data-screen=make]")
    one.size(160, 128)
    page.check("input[value=xy]")
    page.check("input[value=best]")
    one.press_make()
    assert len(page.query_selector_all(".strip button")) == 2
    for mode in ("split", "light", "picture"):
        page.click(f"[data-key={mode}]")
        page.wait_for_selector(f"[data-key={mode}][aria-pressed=true]")
    page.click("[data-key=repeat2]")

    page.click("[data-screen=paint]")
    one.stroke((0.45, 0.5), (0.55, 0.5))
    one.stroke((0.5, 0.3), (0.5, 0.4))
    page.keyboard.press("Control+z")
    page.click("text=Fill the hole")
    page.wait_for_selector(".strip >> text=Hole filled")
    mask = picture(bytes(one.probe("painted")))[..., :3]
    assert set(np.unique(mask)) == {0, 255}  # no half-masked pixels
    assert mask[64, 80].all() and not mask[:40].any()  # the second stroke was taken back

    page.click("[data-screen=paint]")
    page.check("input[value=fuse]")
    page.select_option("[aria-label^='Add a sample']", "pebbles")
    page.wait_for_selector(".shelf >> text=pebbles")
    one.size(96, 96)
    page.wait_for_selector(".stage-bar >> text=96 × 96")
    one.stroke((0.4, 0.4), (0.6, 0.6), (0.4, 0.6))
    page.click("text=Fuse them")
    page.wait_for_selector(".strip >> text=Fused")

    page.click("[data-screen=take]")
    page.click("[data-group=more] > summary")
    page.check("text=Recipe (.json)")
    with page.expect_download() as saved:
        page.click("text=Save >> nth=0")
    with zipfile.ZipFile(saved.value.path()) as made:
        names = made.namelist()
        [recipe] = [json.loads(made.read(name)) for name in names if name.endswith(".json")]
        [data] = [made.read(name) for name in names if name.endswith(".png")]
    assert picture(data).shape == (96, 96, 3)
    assert recipe["task"] == "fuse"

    page.click(".strip button:has-text('Made')")  # back to the tile, and its endless plane
    page.click("[data-screen=make]")
    page.select_option("select", "near-regular")
    with page.expect_response(lambda r: "/window?" in r.url) as window:
        page.click("[data-key=plane]")
    assert window.value.ok


def test_a_shared_state_makes_the_same_bytes(tab: Any, address: str) -> None:
    one = tab()
    page = one.begin(address, "weave", "make")
    for side in ("Width", "Height"):
        page.fill(f"[aria-label={side}]", "100")
    page.select_option("select", "quilting")
    page.fill("input[type=number][step='1'][min='0']", "11")
    page.click("text=Make it")
    # A preview with the seed before may have been made by quilting, too, and is in the address.
    page.wait_for_function("""() => {
        const state = location.hash.split("state=")[1].replaceAll("-", "+").replaceAll("_", "/");
        return JSON.parse(atob(state)).seed === 11;
    }""")
    one.settle()
    state = page.url.split("#")[1]

    other = tab()
    page = other.open(f"{address}&{state}")
    page.wait_for_selector(".strip >> text=quilting")
    page.click("[data-screen=take]")
    with page.expect_download() as saved:
        page.click("text=Save >> nth=0")
    made = picture(Path(saved.value.path()).read_bytes())
    asked = weftex.synthesize("sample:weave", 100, method="quilting", seed=11).image
    np.testing.assert_array_equal(made, asked)


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_every_screen_has_contrast_and_names(tab: Any, address: str, scheme: str) -> None:
    """WCAG AA on every screen, in dark and light; every control says what it is."""
    one = tab(color_scheme=scheme)
    page = one.open(address)
    assert one.probe("contrasts") == [] and one.probe("unnamed") == []
    page.click(".samples button:has-text('grass')")
    page.wait_for_selector(".facts")
    for screen in SCREENS:
        page.click(f"[data-screen={screen}]")
        assert one.probe("contrasts") == [], screen
        assert one.probe("unnamed") == [], screen


@BROWSERS
def test_keys_alone(tab: Any, address: str) -> None:
    """Choose, make, paint and undo without a pointer; the focus is always seen."""
    one = tab()
    page = one.open(address)
    for _ in range(16):
        page.keyboard.press("Tab")
        assert one.probe("outline") != "none", one.probe("focused")
        if one.probe("focused").startswith("grass"):
            break
    page.keyboard.press("Enter")
    page.wait_for_selector(".facts")
    page.keyboard.press("Alt+4")
    page.keyboard.press("]")  # wherever the focus is
    page.wait_for_selector(".panel >> text=18 px")
    page.keyboard.press("Control+Enter")
    page.wait_for_selector("[role=alert] >> text=There is no hole yet")
    page.locator(".viewer").focus()
    for key in ("Enter", "ArrowRight", "Shift+ArrowRight", "Enter", "Escape"):
        page.keyboard.press(key)
    assert "0 % painted" not in page.inner_text(".panel")
    page.keyboard.press("Control+z")
    page.wait_for_selector("text=0 % painted")
    page.keyboard.press("Alt+2")
    page.check("input[value=best]")
    page.keyboard.press("Control+Enter")
    page.wait_for_selector(".panel >> text=Made by")
    page.keyboard.press("r")
    page.wait_for_selector("[data-key=repeat2][aria-pressed=true]")


def test_a_wrong_value_is_told_beside_its_control(tab: Any, address: str) -> None:
    one = tab(expected="422")
    page = one.begin(address, "grass", "make")
    page.select_option("select", "quilting")
    page.click("summary")
    page.fill(".parameter:has(label:text('Feature size')) input[type=number]", "0")
    page.click("text=Make it")
    told = page.inner_text(".parameter:has(label:text('Feature size')) [role=alert]")
    assert "patch_size is 0" in told and "\n" not in told


def test_what_is_written_while_a_preview_comes_stays(tab: Any, address: str) -> None:
    one = tab()
    page = one.begin(address, "grass", "make")
    held: list[Any] = []
    page.route("**/api/results/*/picture*", lambda route: held.append(route), times=1)
    with page.expect_request("**/api/results/*/picture*"):
        page.select_option("select", "quilting")
    page.fill("input[type=number][step='1'][min='0']", "23")
    page.keyboard.press("Tab")
    held[0].continue_()
    page.wait_for_selector(".strip >> text=quilting · 23")
    assert page.input_value("input[type=number][step='1'][min='0']") == "23"


def test_seeds_that_nobody_waits_for_end(tab: Any, address: str) -> None:
    """A kept seed, or another screen, ends the sheet; focus stays while panels change."""
    one = tab()
    page = one.begin(address, "grass", "make")
    page.select_option("select", "efros-leung")
    page.click("summary")
    page.uncheck("text=Preview while I change things")
    page.click("text=Nine seeds")
    page.wait_for_selector(".progress >> text=of 9")
    page.click("[data-screen=see]")
    one.settle()
    page.click("[data-screen=make]")
    page.locator("input[value=x]").focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_timeout(100)
    assert one.probe("focused_value") == "y"
