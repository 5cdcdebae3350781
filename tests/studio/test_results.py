"""What a person sees of a material and of a result, and takes along."""

import json
import zipfile
from dataclasses import dataclass
from io import BytesIO
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

import weftex
from weftex.io.pictures import read_image
from weftex.io.png import SIGNATURE
from weftex.parameters import parameter
from weftex.roles import ROLES
from weftex.studio.pictures import on_screen, shown_smaller, smaller, times_smaller

BRICKS, WALL = {"sample": "bricks"}, {"sample": "stone_wall"}
QUICK = {"size": [72, 64], "seed": 1, "method": "quilting"}


@pytest.fixture(scope="module")
def wall(client, tmp_path_factory):
    """A result with maps of all depths, and its tab."""
    page, folder = client.page(), tmp_path_factory.mktemp("wall")
    maps = weftex.load_exemplar("sample:stone_wall").maps
    maps = maps | {"color": read_image("sample:stone_wall/albedo").pixels}
    small = {name: pixels[:80, :80] for name, pixels in maps.items()}
    small["height"] = small["height"].astype(np.uint16) * 257
    small["roughness"] = small["roughness"].astype(np.float32) / 255
    ids = {}
    for name, pixels in small.items():
        file = f"stone_{name}.{'tif' if name == 'roughness' else 'png'}"
        ids[name] = page.upload_pixels(pixels, folder, file)
    return page, page.made({**QUICK, "materials": [{"name": "stone", "maps": ids}]})


def test_a_new_method_is_there_by_itself(page, monkeypatch):
    @dataclass(frozen=True)
    class Knitting(weftex.Quilting):
        slug: ClassVar[str] = "knitting"
        yarn: int = parameter(3, "how thick", low=1, high=9)

    found = SimpleNamespace(load=lambda: Knitting)  # as an entry point is
    monkeypatch.setitem(weftex.METHODS._outside, "knitting", found)
    told = page.get("about")
    assert [one["slug"] for one in told["methods"]] == ["auto", *weftex.METHODS]
    (yarn,) = [one for one in told["methods"][-1]["parameters"] if one["name"] == "yarn"]
    assert (yarn["type"], yarn["default"], yarn["low"], yarn["high"]) == ("int", 3, 1, 9)
    assert {one["name"] for one in told["samples"]} >= {"bricks", "stone_wall"}
    made = page.made({"materials": [BRICKS], "size": [40, 40], "method": "knitting"})
    assert made["method"] == "knitting"
    line = page.refused("jobs", {"recipe": {"materials": [BRICKS], "method": "knitting",
                                            "parameters": {"yarn": 10}}})  # fmt: skip
    assert line == {"error": "yarn is 10; it must be from 1 to 9", "parameter": "yarn"}


def test_what_a_material_is(page):
    material = page.post("materials", BRICKS)["id"]
    seen = page.look(material)
    assert seen["lattice"]["words"] == "126.2 x 41.8 px, every other row shifted by half"
    assert len(seen["runners_up"]) == 4 and len(seen["lattice"]["lines"]) == 2
    assert "the sample has a lattice of 126.2 x 41.8 px" in seen["auto"]["reason"]
    other = seen["runners_up"][0]
    rated = page.get(f"materials/{material}/lattice?vectors={other['numbers']}")
    assert rated["goodness"] == pytest.approx(other["goodness"], rel=0.05)
    for wrong in ("", "1,2", "nan,0,0,1", "9999,0,0,9999"):
        answer = page.ask("GET", f"materials/{material}/lattice?vectors={wrong}")
        assert (answer.status_code, answer.json()["parameter"]) == (422, "lattice")


def test_what_can_be_mended_has_a_button(page, tmp_path):
    pixels = read_image("sample:pebbles").pixels.astype(float)
    lit = (pixels * np.linspace(0.25, 1, pixels.shape[1])[:, None]).astype(np.uint8)
    spec = {"maps": {"color": page.upload_pixels(lit, tmp_path)}}
    seen = page.look(page.post("materials", spec)["id"])
    (mending,) = [one for one in seen["mending"] if one["what"] == "even_light"]
    better = page.post("materials", spec | mending["spec"])
    seen = page.look(better["id"])
    assert [one for one in seen["mending"] if one["what"] == "even_light"] == []


def test_pictures_of_all_kinds(wall):
    page, result = wall
    assert {one["name"]: one["dtype"] for one in result["maps"]}["height"] == "uint16"
    for one in result["maps"]:
        picture = page.pixels(f"results/{result['id']}/picture?map={one['name']}")
        assert picture.shape[:2] == (72, 64) and picture.dtype == np.uint8
    assert page.ask("GET", f"results/{result['id']}/picture?map=x").status_code == 404
    for what in ("sources", "seams", "patches"):
        assert page.get(f"results/{result['id']}/picture?draw={what}").startswith(SIGNATURE)
    assert page.ask("GET", f"results/{result['id']}/picture?draw=/etc").status_code == 404
    answer = page.ask("GET", f"results/{result['id']}/picture?most=20")
    assert (answer.headers["x-weftex-width"], answer.headers["x-weftex-height"]) == ("64", "72")
    whole = page.pixels(f"results/{result['id']}/picture")
    assert (page.pixels(f"results/{result['id']}/picture?most=20") == smaller(whole, 4)).all()
    for wrong in ("most=-1", "most=x", "most=" + "9" * 4000):
        assert page.ask("GET", f"results/{result['id']}/picture?{wrong}").status_code == 400


def test_where_pixels_come_from(wall):
    page, result = wall
    one = page.get(f"results/{result['id']}/source?x=5&y=9")
    made = page.session.recall("result", result["id"]).result
    assert [one["y"], one["x"]] == made.source[9, 5].tolist()
    for wrong in ("x=64&y=0", "x=0&y=-1", "x=1"):
        status = page.ask("GET", f"results/{result['id']}/source?{wrong}").status_code
        assert status == (400 if "y" in wrong else 200)


def test_figures_and_faults(page):
    result = page.made({"materials": [{"sample": "weave"}], "size": 2 * [128], "seed": 1})
    found = page.found(f"results/{result['id']}/figures")
    assert found["score"] > 0 and found["verdict"].endswith(".")
    assert set(found["figures"]) == {one["name"] for one in page.get("about")["figures"]}
    assert page.get(f"results/{result['id']}/broken").startswith(SIGNATURE)


def test_a_screen_shows_any_kind_of_pixels(rng):
    linear = weftex.Exemplar(np.array([[[0.0, 0.5, 9.0]]], np.float32), name="photo")
    assert on_screen(linear, linear.pixels).tolist() == [[[0, 188, 255]]]
    deep = weftex.Exemplar(np.array([[0, 257, 65535]], np.uint16))
    assert on_screen(deep, deep.pixels)[..., 0].tolist() == [[0, 1, 255]]
    clear = weftex.Exemplar(np.array([[[9, 128], [7, 0]]], np.uint8), alpha=True)
    assert on_screen(clear, clear.pixels).tolist() == [[[9, 9, 9, 128], [7, 7, 7, 0]]]
    height = weftex.Exemplar(np.array([[-3.0, 0, 5]], np.float32), role=ROLES["height"])
    assert on_screen(height, height.pixels)[..., 0].tolist() == [[0, 96, 255]]
    assert times_smaller({"most": "100"}, (512, 300)) == 8


def test_a_large_sample_is_shown_in_bands(rng, monkeypatch):
    monkeypatch.setattr("weftex.studio.pictures._BAND", 300)
    large = weftex.Exemplar(rng.integers(0, 65535, (70, 90, 4)).astype(np.uint16), alpha=True)
    for times in (1, 2, 4):
        whole = smaller(on_screen(large, large.pixels), times)
        assert (shown_smaller(large, times) == whole).all()


def test_any_format_that_holds_it(wall, tmp_path):
    page, result = wall
    path = f"results/{result['id']}"
    content, name = page.taken(path, preset="ambientcg", name="../My Wall", source=True,
                               report=True, recipe=True)  # fmt: skip
    assert name == "My Wall.zip"
    packed = zipfile.ZipFile(BytesIO(content))
    names = set(packed.namelist())
    assert names == {f"My Wall_{one}" for one in (
        "Color.png", "AmbientOcclusion.png", "Displacement.png", "Normal.png", "Roughness.tif",
    )} | {"My Wall.npz", "My Wall.html", "My Wall.weftex.json"}  # fmt: skip
    packed.extractall(tmp_path)
    assert json.loads((tmp_path / "My Wall.weftex.json").read_text()) == result["recipe"]
    assert read_image(tmp_path / "My Wall_Displacement.png").pixels.dtype == np.uint16
    assert read_image(tmp_path / "My Wall_Roughness.tif").pixels.dtype == np.float32
    sample = read_image("sample:stone_wall/albedo").pixels[:80, :80]
    again = weftex.Synthesis.load(tmp_path / "My Wall.npz", weftex.load_exemplar(sample))
    assert (again.image == read_image(tmp_path / "My Wall_Color.png").pixels).all()
    assert result["formats"]["height"] == [".png", ".tif"]
    assert result["formats"]["roughness"] == [".tif", ".exr"]
    for map_, suffixes in result["formats"].items():
        for suffix in suffixes:
            _, name = page.taken(path, maps=[map_], format=suffix)
            assert name == f"stone_64x72_{map_}{suffix}"
    ask = f"{path}/exports"
    assert page.refused(ask, {"maps": ["height"], "format": ".jpg"})["parameter"] == "format"
    assert page.refused(ask, {"maps": ["../x"]})["parameter"] == "maps"
    assert page.refused(ask, {"preset": "mine"})["parameter"] == "preset"
    assert page.refused(ask, {"preset": "unreal", "format": ".png"})["parameter"] == "format"
    content, name = page.taken(path, preset="unreal", name="rock")
    packed = set(zipfile.ZipFile(BytesIO(content)).namelist())
    assert {"T_rock_ORM.png", "T_rock_Normal.png"} <= packed and name == "rock.zip"
    assert page.refused(ask, {"path": "/tmp"}, 400)
    waiting = [one for one in page.client.studio.downloads.folder.rglob("*") if one.is_file()]
    assert len(waiting) <= 40


def test_the_endless_plane(page):
    recipe = {"materials": [{"sample": "weave"}], "method": "best-tile", "seed": 4}
    plane = page.post("planes", recipe)
    ask = f"planes/{plane['id']}/window?top=-{10**9}&left=7"
    one = page.pixels(f"{ask}&height=60&width=50")
    assert one.shape == (60, 50, 3)
    two = page.pixels(f"{ask.replace('=7', '=27')}&height=60&width=50")
    assert (one[:, 20:] == two[:, :30]).all()
    for wrong in ("width=2000", "top=x", f"left={2**41}"):
        assert page.ask("GET", f"planes/{plane['id']}/window?{wrong}").status_code == 400
    for name in ("auto", "quilting"):
        plane = page.post("planes", {**recipe, "method": name})
        assert page.get(f"planes/{plane['id']}/window?top=-{10**9}&left=7").startswith(SIGNATURE)


def test_previews_of_sets_are_pictures(page):
    recipe = {**QUICK, "materials": [WALL], "size": [512, 512], "method": "graphcut"}
    job = page.job(recipe)
    assert job["state"] == "done" and job["preview"] > 0
    assert page.get(f"jobs/{job['id']}/preview").startswith(SIGNATURE)


def test_alpha_and_masks_come_through(page, tmp_path, rng):
    pixels = rng.integers(0, 255, (48, 48, 4)).astype(np.uint8)
    pixels[..., 3] = 255
    pixels[10:20, 12:30, 3] = 0
    upload = page.upload_pixels(pixels, tmp_path, alpha=True)
    whole = page.made({"task": "fill", "materials": [{"maps": {"color": upload}}], "mask": "alpha"})
    picture = page.pixels(f"results/{whole['id']}/picture")
    assert picture.shape == (48, 48, 4) and (picture[..., 3] == 255).all()
    part = page.made({**QUICK, "materials": [{"maps": {"color": upload}, "mask": "alpha"}]})
    assert (page.pixels(f"results/{part['id']}/picture")[..., 3] == 255).all()
