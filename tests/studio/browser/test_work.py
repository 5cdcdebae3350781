"""Results that are painted on and used as samples, branches, and what is kept of them."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import pytest


def steps(page: Any) -> int:
    return len(page.query_selector_all(".strip button"))


@pytest.mark.parametrize("browser", ["chromium", "firefox"], indirect=True)
def test_results_are_retouched_and_nothing_is_lost(tab: Any, address: str, photo: Path) -> None:
    """A result is healed and becomes a sample; a branch and F5 lose no step."""
    one = tab()
    page = one.begin(address, photo)
    one.make("quilting", 200, 200)

    page.click("text=Paint on it")
    one.stroke((0.45, 0.5), (0.55, 0.5))
    page.dblclick("text=Fill the hole")  # and it is filled once
    page.wait_for_selector(".strip [aria-current] >> text=Hole filled")
    one.settle()
    assert "200 × 200" in page.inner_text(".stage-bar")  # the result was filled, not the photo
    page.click("text=Use as sample", delay=2000)  # the analysis ends meanwhile
    page.wait_for_selector(".panel h2 >> text=wall_filled")
    before = steps(page)

    page.click(".strip button:has-text('quilting · 1')")  # back, and on from there
    page.click("[data-screen=make]")
    page.wait_for_selector(".stage-bar strong >> text=quilting")
    page.focus("input[type=number][step='1'][min='0']")
    for key in ("Control+a", "7", "Tab"):
        page.keyboard.press(key)
    one.press_make()
    assert steps(page) > before and page.query_selector_all(".strip .aside")
    page.click("[aria-label^=Undo]")
    page.wait_for_selector(".strip [aria-current] >> text=quilting · 1")
    page.click("[aria-label^=Redo]")
    page.wait_for_selector(".strip [aria-current] >> text=quilting · 7")

    count = steps(page)
    page.reload()
    page.wait_for_selector("[data-ready]")
    one.settle()
    assert steps(page) == count
    assert page.query_selector(".strip [aria-current] >> text=quilting · 7")

    other = tab(expected="410")  # another day: results that the server makes again
    found = other.open(address)
    found.click(".work button:has-text('wall')")
    found.wait_for_selector(".strip [aria-current] >> text=quilting · 7")
    other.settle()
    assert steps(found) == count
    found.click(".strip button:has-text('Hole filled')")
    found.wait_for_selector(".panel >> text=Made by")


@pytest.mark.parametrize("browser", ["chromium", "firefox"], indirect=True)
def test_steps_are_repeated_on_another_photo(tab: Any, address: str, photo: Path) -> None:
    """Estimate, tile, enlarge: a workflow. A painted hole ends one, and what was made stays."""
    one = tab()
    page = one.begin(address, photo, "make")
    page.click("[data-task=maps]")
    page.click("text=Estimate maps")
    page.wait_for_selector(".strip [aria-current] >> text=Maps estimated")
    page.click("[data-task=tile]")
    one.press_make()
    page.click("text=Use as sample")
    page.wait_for_selector(".panel h2 >> text=wall_tileable")
    one.make("quilting", 200, 200)
    page.click("text=Save as workflow")
    page.wait_for_selector("dialog li:nth-child(3):last-child")
    page.fill("[aria-label='Name of the workflow']", "Larger set")
    page.click("dialog button.main")
    page.wait_for_selector("[aria-label='Name of Larger set']")
    page.click("dialog >> text=Close")

    page.click("text=Paint on it")
    one.stroke((0.45, 0.5), (0.55, 0.5))
    page.click("text=Fill the hole")
    page.wait_for_selector(".strip [aria-current] >> text=Hole filled")
    one.settle()
    page.click("text=Save as workflow")
    page.wait_for_selector("dialog li:nth-child(4) >> text=its hole was painted on another photo")
    page.fill("[aria-label='Name of the workflow']", "Healed")
    page.click("dialog button.main")
    page.wait_for_selector("[aria-label='Name of Healed']")
    page.click("dialog >> text=Close")

    page.click("[aria-label='Open another image']")
    page.click(".samples button:has-text('pebbles')")
    page.wait_for_selector(".panel h2 >> text=pebbles")
    page.click("text=Apply a workflow")
    page.click("[aria-label='Apply Healed to this photo']")
    page.wait_for_selector(".stage-message >> text=its hole was painted on another photo")
    assert "quilting · 1" in page.inner_text(".strip [aria-current]")
    page.click("[data-screen=take]")
    assert page.input_value(".field input[type=text]") == "pebbles_200x200"
    assert page.query_selector(".panel >> text=normal_gl")


@pytest.mark.parametrize("browser", ["chromium", "firefox"], indirect=True)
def test_a_whole_day(tab: Any, running: Any, photo: Path, tmp_path: Path) -> None:
    """From a photo to a tileable set for an engine, through F5, a new server, undo and a phone."""
    with running(tmp_path) as morning:
        one = tab(expected="ERR_|NetworkError|refused|Loading failed")  # the server goes
        page = one.begin(morning, photo, "make")
        page.click("[data-task=tile]")
        one.press_make()
        page.reload()
        page.wait_for_selector("[data-ready]")
        one.settle()
        page.click("[data-screen=make]")
        page.click("text=Use as sample")
        page.wait_for_selector(".panel h2 >> text=wall_tileable")
        page.click("[data-screen=make]")
        page.click("[data-task=maps]")
        page.click("text=Estimate maps")
        page.wait_for_selector(".panel >> text=maps: color, ao, height, normal_gl, roughness")
        count = steps(page)
    with running(tmp_path) as evening:
        page.keyboard.press("Control+Enter")  # asks the server that has gone
        page.fill("dialog input", evening)
        page.click("dialog >> text=Continue")
        page.wait_for_selector("dialog", state="detached")
        page.wait_for_selector("[data-ready]")
        page.wait_for_selector(".strip [aria-current] >> text=Maps estimated")
        one.settle()
        assert steps(page) == count
        page.set_viewport_size({"width": 390, "height": 800})
        page.click("[data-screen=make]")
        page.select_option("select", "quilting")
        page.check("input[value=xy]")
        page.wait_for_selector(".strip [aria-current]:has-text('Changed')")
        one.size(128, 128)
        page.click("text=Make it")
        for key, words in ((None, "Made"), ("Undo", "Maps estimated"), ("Redo", "Made")):
            if key:
                page.click(f"[aria-label^={key}]")
            page.wait_for_selector(f".strip [aria-current]:has-text('{words}')")
            one.settle()
        assert one.probe("wide") == []
        page.click("[data-screen=take]")
        page.select_option("select", "unreal")
        with page.expect_download() as saved:
            page.click("text=Save >> nth=0")
        names = {name.rsplit("_", 1)[1] for name in zipfile.ZipFile(saved.value.path()).namelist()}
        assert names >= {"BaseColor.png", "Normal.png", "ORM.png"}
