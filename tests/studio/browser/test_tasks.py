"""Tasks by their names, sizes that fit, and a picture that says what it is."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import weftex


def test_a_task_is_chosen_before_the_photo(tab: Any, address: str, photo: Path) -> None:
    """Each task leads to its screen; focus is never lost to the body of the page."""
    one = tab()
    page = one.open(address)
    screens = {"tile": "Make", "remove": "Paint", "blend": "Paint", "maps": "Make"}
    for task, heading in screens.items():
        page.click(f"[data-task={task}]")
        assert page.get_attribute(f"[data-task={task}]", "aria-pressed") == "true"
        page.set_input_files("input[type=file]", photo)
        page.wait_for_selector(f".panel h2 >> text={heading}")
        assert one.probe("focus_is_lost") is False
        if task == "blend":
            page.wait_for_selector("input[value=fuse]:checked")
        if task == "tile":
            one.press_make()
            assert "160 × 128" in page.inner_text(".stage-bar")
        page.click("[aria-label='Open another image']")


THUMBNAILS = "all => all.map((one) => one.toDataURL())"
DROP = """([name, bytes]) => {
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([Uint8Array.from(bytes)], name));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true }));
}"""


def test_a_dropped_image_is_one_more_material(tab: Any, address: str, photo: Path) -> None:
    """Painting and materials stay; the stage and the thumbnails show the steps that they name."""
    other = photo.with_name("gray.png")
    weftex.write_image(other, np.full((64, 64, 3), 128, np.uint8))
    one = tab()
    page = one.begin(address, photo)
    page.click("[aria-label='Open another image']")
    page.click(".samples button:has-text('pebbles')")
    page.wait_for_selector(".panel h2 >> text=pebbles")
    page.click("[data-screen=make]")
    shown = one.shot(), page.eval_on_selector_all(".strip canvas", THUMBNAILS)
    page.click("[data-task=blend]")
    page.wait_for_selector(".panel .shelf button:nth-child(2)")
    one.stroke((0.4, 0.5), (0.6, 0.5))
    painted = page.inner_text(".panel p[role=status]")
    page.evaluate(DROP, [other.name, list(other.read_bytes())])
    page.wait_for_selector(".panel .shelf button:nth-child(3) >> text=gray.png")
    assert page.inner_text(".panel p[role=status]") == painted != "0 % painted"
    for name in ("wall.png", "pebbles"):
        page.click(f".strip button:has-text('{name}')")
        page.wait_for_selector(f".panel .shelf button:first-child >> text={name}")
        found = page.locator(".panel .shelf button").all_inner_texts()
        assert sorted(found) == ["gray.png", "pebbles", "wall.png"]
    assert page.inner_text(".panel p[role=status]") == painted
    page.click("[data-screen=make]")
    assert shown == (one.shot(), page.eval_on_selector_all(".strip canvas", THUMBNAILS))


def test_maps_are_added_and_estimated(tab: Any, address: str, photo: Path) -> None:
    height = photo.with_name("wall_height.png")
    weftex.write_image(height, weftex.read_image(photo).pixels[..., 0])
    one = tab()
    page = one.open(address)
    page.click("[data-task=maps]")
    page.set_input_files("input[type=file]", photo)
    page.wait_for_selector("text=Add maps")
    page.set_input_files(".panel input[type=file]", height)
    page.wait_for_selector(".panel >> text=maps: color, height")
    page.click("text=Estimate maps")
    page.wait_for_selector(".panel >> text=color, ao, normal_gl, roughness")
    page.select_option("select", "quilting")
    page.click("text=Make it")
    page.click("[data-key=maps]")
    page.wait_for_selector(".cell >> text=Height")


def test_the_picture_says_what_it_is(tab: Any, address: str, photo: Path) -> None:
    """Previews are marked on the picture; what was said of another picture goes."""
    one = tab(expected="422")  # a size that is refused
    page = one.open(address)
    page.click("[data-task=bigger]")
    page.set_input_files("input[type=file]", photo)
    page.wait_for_selector(".panel h2 >> text=Make")
    assert page.input_value("[aria-label=Width]") == "512"
    page.click("[aria-label='Open another image']")
    wide = photo.with_name("wide.png")
    weftex.write_image(wide, np.tile(weftex.read_image(photo).pixels[:64], (1, 8, 1)))
    page.click("[data-task=bigger]")
    page.set_input_files("input[type=file]", wide)
    page.wait_for_selector(".strip >> text=wide.png")
    assert page.input_value("[aria-label=Width]") == "1280"  # never less than the sample's
    page.click(".strip >> text=wall.png")
    page.wait_for_selector(".stage-bar >> text=160 × 128")
    page.select_option("select", "quilting")
    page.wait_for_selector(".panel >> text=Made by quilting")
    assert page.is_hidden(".badge")
    page.select_option("select", "wei-levoy")
    page.wait_for_selector(".badge >> text=Preview, 192 × 192")
    assert "Made by quilting" not in page.inner_text(".panel")
    one.settle()
    page.select_option("select", "near-regular")  # a part of the picture, at full size
    one.size(4000, 4000)  # too large for the picture itself to be made at once
    page.wait_for_selector(".stage-bar >> text=4000 × 4000")
    page.wait_for_selector(".badge >> text=a part of the final image")
    one.write("Height", "512")
    one.settle()
    page.check("input[value=xy]")
    page.click("text=the lattice fits")
    assert int(page.input_value("[aria-label=Height]")) % 41 in (0, 1)
    one.write("Width", "0")
    page.wait_for_selector("[role=alert] >> text=size is")
    one.write("Width", "640")  # and Height, while the error goes
    page.keyboard.type("410")
    page.wait_for_selector(".stage-bar >> text=/(640|512) ×/")  # 512 if the machine is slow
    page.keyboard.press("Tab")
    page.wait_for_selector(".panel [role=alert]", state="detached")
    assert page.input_value("[aria-label=Height]") == "410"

    page.select_option("select", "quilting")
    one.write("Width", "200")
    one.press_make()
    page.click("[data-screen=take]")
    assert page.input_value(".field input[type=text]") == "wall_tileable"
    with page.expect_download():
        page.click("text=Save >> nth=0")
    page.click(".strip >> text=wide.png")
    page.wait_for_selector("[data-ticket]", state="detached")  # the file was of another step


def test_three_sliders_change_the_recipe_and_the_picture(tab: Any, address: str) -> None:
    """In an artist's words; each shows in the picture and in the command."""
    one = tab()
    page = one.begin(address, "pebbles")
    one.make("graphcut", 160, 160)
    last, values = one.shot(), []
    for words, key in (("Feature size", "End"), ("Variety", "End"), ("Seam softness", "End")):
        page.focus(f"input[type=range][aria-label='{words}']")
        page.keyboard.press(key)
        box = f".parameter:has(label:text('{words}')) input[type=number]"
        values.append(page.input_value(box))
        one.press_make()
        last = one.shot(last)
    page.click("[data-screen=take]")
    command = page.inner_text(".copyable pre >> nth=0")
    options = ("--patch-size", "--variety", "--tone-reach")
    for option, value in zip(options, values, strict=True):
        assert f"{option}={value}" in command


def test_stopped_work_leaves_a_page_that_works(tab: Any, address: str, photo: Path) -> None:
    """An analysis, an estimate and a picture in the making are stopped; nothing of them is left."""
    one = tab()
    page = one.open(address)
    page.route("**/look*", lambda route: None, times=1)  # it goes on until it is stopped
    page.set_input_files("input[type=file]", photo)
    page.click(".panel >> text=Cancel")
    page.wait_for_selector(".panel >> text=The analysis was stopped.")
    page.click("[data-screen=make]")
    page.click("[data-task=maps]")
    page.route("**/jobs/*?seen=*", lambda route: None, times=1)
    page.click("text=Estimate maps")
    page.click(".progress >> text=Cancel")
    one.settle()
    page.click("[data-task=bigger]")
    page.select_option("select", "efros-leung")
    page.click("text=Make it")
    page.wait_for_selector(".badge >> text=Not finished yet")
    page.click(".progress >> text=Cancel")
    one.settle()
    assert page.is_hidden(".badge") and len(page.query_selector_all(".strip button")) == 1
    one.make("quilting", 128, 128)
    page.click("[data-screen=sample]")
    page.click("text=Analyze the sample")
    page.wait_for_selector(".facts")


@pytest.mark.parametrize(
    ("width", "locale", "make"),
    [(390, "fr-CA", "Créer"), (1280, "ja", "作成"), (1280, "de-AT", "Erzeugen"),
     (390, "es", "Crear"), (1280, "zh-CN", "生成"), (2560, "pt", "Make")],
)  # fmt: skip
def test_the_language_is_the_browsers(
    tab: Any, address: str, width: int, locale: str, make: str
) -> None:
    """No label of a choice wraps and nothing leaves the page, also with longer words."""
    one = tab(viewport={"width": width, "height": 900}, locale=locale)
    page = one.begin(address, "bricks")
    assert ("because" in page.inner_text(".panel")) == (make == "Make")  # weftex says why
    for screen in ("sample", "make", "see", "paint", "compare", "take"):
        page.click(f"[data-screen={screen}]")
        assert one.probe("wrapped") == [] == one.probe("wide"), screen
    assert page.inner_text("[data-screen=make]") == make


def dragged(page: Any, what: str) -> list[str]:
    """The kind, name and address of the file that a drag out of the page carries."""
    page.evaluate("""() => document.addEventListener("dragstart", (event) => {
        document.body.dataset.carried = event.dataTransfer.getData("DownloadURL");
    }, {once: true})""")
    page.locator(what).scroll_into_view_if_needed()
    box = page.locator(what).bounding_box()
    page.mouse.move(box["x"] + 20, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(300, 300, steps=6)
    page.mouse.up()
    return str(page.get_attribute("body", "data-carried")).split(":", 2)


def test_a_material_on_solids_and_out_of_the_page(tab: Any, address: str) -> None:
    """Every slider of the 3D view changes what is drawn; maps go to presets and the clipboard."""
    one = tab(permissions=["clipboard-read", "clipboard-write"])
    page = one.begin(address, "stone wall")
    page.keyboard.press("d")
    page.wait_for_selector("canvas.solid")
    last = one.shot(at="canvas.solid")
    for shape in ("plane", "box", "cloth", "sphere"):
        page.check(f"input[value={shape}]")
        last = one.shot(last, "canvas.solid")
    for slider in page.query_selector_all(".solid-controls input[type=range]"):
        slider.focus()
        page.keyboard.press("End")
        last = one.shot(last, "canvas.solid")
    page.keyboard.press("p")

    one.make("quilting", 128, 128)
    page.click("[data-screen=take]")
    page.select_option("select", "unreal")
    with page.expect_download() as saved:
        page.click("text=Save >> nth=0")
    names = zipfile.ZipFile(saved.value.path()).namelist()
    assert saved.value.suggested_filename == "stone_wall_128x128.zip"
    assert "T_stone_wall_128x128_ORM.png" in names
    page.click("text=Copy the image")
    page.wait_for_selector("text=The image is in the clipboard")
    page.wait_for_function("() => document.querySelector('img.drag').naturalWidth === 128")
    kind, name, url = dragged(page, "img.drag")
    assert (kind, name) == ("image/png", "stone_wall_128x128.png") and url.startswith("blob:http")
    _, name, url = dragged(page, "[data-ticket]")
    assert name == "stone_wall_128x128.zip"
    with zipfile.ZipFile(io.BytesIO(page.request.get(url).body())) as file:
        assert file.namelist() == names  # what a folder gets
