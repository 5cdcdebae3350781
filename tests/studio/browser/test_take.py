"""What is saved: its size in meters, its borders, a border around it, and an atlas."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from weftex.io.pictures import read_image

BROWSERS = pytest.mark.parametrize("browser", ["chromium", "firefox"], indirect=True)


def group(page: Any, name: str) -> None:
    page.click(f"[data-group={name}] > summary")


def write(page: Any, label: str, text: str) -> None:
    """Write into a field as a person does."""
    page.get_by_label(label).and_(page.locator("input[type=number]")).focus()
    page.keyboard.press("Control+a")
    page.keyboard.type(text)
    page.keyboard.press("Tab")


def saved(page: Any, button: str = "text=Save >> nth=0", at: str = "[data-ticket]") -> bytes:
    """What is saved; the page's own click is left out, as Firefox here waits for its end."""
    page.evaluate("() => { HTMLAnchorElement.prototype.click = () => {}; }")
    old = page.locator(at).get_attribute("data-ticket") if page.locator(at).count() else ""
    page.click(button)
    page.wait_for_selector(f"{at}:not([data-ticket='{old}'])")
    address = page.locator(at).evaluate("one => one.href")
    return bytes(page.request.get(address).body())


def picture(content: bytes, folder: Path) -> Any:
    (folder / "saved.png").write_bytes(content)
    return read_image(folder / "saved.png")


@BROWSERS
def test_the_size_in_meters_is_saved(tab: Any, address: str, photo: Path, tmp_path: Path) -> None:
    one = tab(expected="422")
    page = one.begin(address, photo)
    one.make("quilting", 160, 128)
    page.click("[data-screen=take]")
    group(page, "size")
    page.wait_for_selector("text=The size in meters is not known")
    write(page, "Width of the sample, in meters", "-1")
    page.wait_for_selector("[data-group=size] [role=alert] >> text=sample_width is -1")
    write(page, "Width of the sample, in meters", "0.4")
    page.wait_for_selector("text=0.4 × 0.32 m, 400 pixels per meter")
    found = picture(saved(page), tmp_path)
    assert (found.pixels.shape, found.density) == ((128, 160, 3), 400)
    assert "--sample-width 0.4m" in page.inner_text(".copyable >> nth=0")
    write(page, "Pixels per meter to save", "0")
    page.click("text=Save >> nth=0")
    page.wait_for_selector("[role=alert] >> text=density is 0")
    write(page, "Pixels per meter to save", "200")
    page.wait_for_selector("text=0.4 × 0.32 m, 200 pixels per meter")
    found = picture(saved(page), tmp_path)
    assert (found.pixels.shape, found.density) == ((64, 80, 3), 200)
    write(page, "Width in meters", "0.5")
    page.click("text=Make this size")
    page.wait_for_selector(".stage-bar >> text=200 × 128")


@BROWSERS
def test_borders_are_checked_and_repaired(tab: Any, address: str) -> None:
    one = tab()
    page = one.begin(address, "pebbles", "take")
    group(page, "borders")
    page.click("text=Check the borders")
    page.wait_for_selector("[data-tileable=false]")
    told = page.inner_text("[data-tileable]")
    assert "Not tileable" in told and "Top to bottom: across the border, pixels change 5.9" in told
    assert page.locator("[data-group=borders] canvas.shown").evaluate("one => one.width") == 192
    page.click("[data-group=borders] >> text=Make it tileable")
    page.wait_for_selector(".panel >> text=Made by")
    page.click("[data-screen=take]")
    page.click("text=Check the borders")
    page.wait_for_selector("[data-tileable=true]")
    assert page.locator("[data-group=borders] canvas.shown").count() == 0
    for name in ("size", "wrap", "atlas", "more"):
        group(page, name)
    for probe in ("contrasts", "unnamed", "wide", "wrapped"):
        assert one.probe(probe) == [], probe


@BROWSERS
def test_a_border_is_added_and_taken_off(
    tab: Any, address: str, photo: Path, tmp_path: Path
) -> None:
    """Of photos as they are, to the same bytes."""
    page = tab(expected="422").begin(address, photo, "take")
    plain = saved(page)
    group(page, "wrap")
    write(page, "Add pixels at each side", "129")
    page.click("text=Save >> nth=0")
    page.wait_for_selector("[role=alert] >> text=so it can be at most 128")
    write(page, "Add pixels at each side", "24")
    padded = tmp_path / "padded.png"
    padded.write_bytes(saved(page))
    wide = np.pad(read_image(photo).pixels, ((24, 24), (24, 24), (0, 0)), "wrap")
    assert (read_image(padded).pixels == wide).all()
    page.click("[aria-label='Open another image']")
    page.set_input_files("input[type=file]", padded)
    page.wait_for_selector(".panel h2 >> text=padded")
    page.click("[data-screen=take]")
    write(page, "Remove pixels at each side", "24")
    assert saved(page) == plain


@BROWSERS
def test_an_atlas_has_a_preview_and_can_be_stopped(tab: Any, address: str) -> None:
    page = tab().begin(address, "pebbles", "take")
    group(page, "atlas")
    write(page, "Corner colors", "3")
    page.click("text=Make the atlas")
    page.wait_for_selector("[data-group=atlas] canvas.shown")
    assert "%" in page.inner_text("[data-group=atlas] [role=status]")
    page.click("[data-group=atlas] >> text=Cancel")
    page.wait_for_selector("[data-group=atlas] .meter", state="detached")
    assert page.locator("[data-group=atlas] [role=alert]").count() == 0
    write(page, "Corner colors", "2")
    write(page, "Tile size", "64")
    page.click("text=Make the atlas")
    page.wait_for_selector("text=16 tiles of 64 × 64 pixels")
    page.locator("[data-group=atlas] input[value=plane]").check()
    page.wait_for_function("() => document.querySelector('canvas.shown').width === 384")
    content = saved(page, "text=Save the atlas", "[data-group=atlas] [data-ticket]")
    with zipfile.ZipFile(io.BytesIO(content)) as file:
        ends = ("png", "json", "tsx", "tres", "gdshader")
        assert set(file.namelist()) == {f"pebbles_tiles.{one}" for one in ends}
        assert json.loads(file.read("pebbles_tiles.json"))["tile_width"] == 64
