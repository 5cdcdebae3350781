"""Files of results and of materials: their density, a border around them, checks and atlases."""

import json
import zipfile
from io import BytesIO

import numpy as np

import weftex
from weftex.io.pictures import read_image
from weftex.io.png import SIGNATURE

QUICK = {"size": [72, 96], "seed": 1, "method": "quilting"}
BRICKS, PEBBLES, WALL = ({"sample": name} for name in ("bricks", "pebbles", "stone_wall"))


def saved(page, folder, path, **wanted):
    """A picture that was exported."""
    content, name = page.taken(path, **wanted)
    (folder / name).write_bytes(content)
    return read_image(folder / name)


def test_density_is_stored_and_changed(page, tmp_path):
    plain = page.made({"materials": [BRICKS], **QUICK})
    wide = page.made({"materials": [BRICKS | {"sample_width": 0.512}], **QUICK})
    assert (plain["density"], wide["density"]) == (None, 500)
    path = f"results/{wide['id']}"
    one, other = saved(page, tmp_path, path), saved(page, tmp_path, f"results/{plain['id']}")
    assert (one.pixels == other.pixels).all() and (one.density, other.density) == (500, None)
    half = saved(page, tmp_path, path, density=250)
    assert half.pixels.shape == (36, 48, 3) and half.density == 250
    sample = weftex.Exemplar(one.pixels)
    assert (half.pixels == weftex.prepare.scaled(sample, 0.5).pixels).all()
    kept = page.post(f"results/{wide['id']}/sample")
    assert page.post("materials", kept)["density"] == 500
    for wrong in (0, -1, "x", 10**9):
        assert page.refused(f"{path}/exports", {"density": wrong})["parameter"] == "density"
    assert "8, as no detail" in page.refused(f"{path}/exports", {"density": 4001})["error"]
    line = page.refused(f"results/{plain['id']}/exports", {"density": 100})["error"]
    assert line.startswith("density is 100 pixels per meter, and bricks states none")


def test_a_border_is_added_and_removed(page, tmp_path):
    """The same bytes come back; maps of another size get as much of the surface."""
    pixels = weftex.load_exemplar("sample:pebbles").pixels[:60, :64]
    ids = {"color": page.upload_pixels(pixels, tmp_path, "s_color.png")}
    ids["height"] = page.upload_pixels(pixels[::2, ::2, 0], tmp_path, "s_height.png")
    path = f"materials/{page.post('materials', {'name': 's', 'maps': ids})['id']}"
    padded = saved(page, tmp_path, path, pad=6, maps=["color"]).pixels
    assert (padded == np.pad(pixels, ((6, 6), (6, 6), (0, 0)), "wrap")).all()
    height = saved(page, tmp_path, path, pad=6, maps=["height"]).pixels
    assert height.shape == (36, 38)
    again = {"maps": {"color": page.upload_pixels(padded, tmp_path)}}
    again = f"materials/{page.post('materials', again)['id']}"
    assert (saved(page, tmp_path, again, crop=6).pixels == pixels).all()
    for wrong, line in [
        ({"pad": 0}, "pad is 0; it must be 1 or more"),
        ({"pad": 66}, "so it can be at most 60"),
        ({"pad": 3}, "3 pixels of color are 1.5 of height"),
        ({"pad": 2, "crop": 2}, "give pad or crop, not both"),
        ({"preset": "terrain3d"}, "packs maps of unequal size"),
    ]:
        assert line in page.refused(f"{path}/exports", wrong)["error"], wrong
    bricks = page.post("materials", BRICKS)["id"]
    line = page.refused(f"materials/{bricks}/exports", {"preset": "terrain3d"})["error"]
    assert "needs height for bricks_alb_ht" in line
    line = page.refused(f"{path}/exports", {"report": True})["error"]
    assert line == "report needs a result, and this is a material"


def test_borders_are_checked(page, tmp_path):
    made = page.made({"materials": [PEBBLES], "task": "tile", "axes": "x", "seed": 1})
    pebbles = page.post("materials", PEBBLES)["id"]
    for path, good in [(f"results/{made['id']}", {1}), (f"materials/{pebbles}", set())]:
        job = page.wait(page.post(f"{path}/borders"))
        assert (job["done"], job["total"], job["stage"]) == (100, 100, "borders")
        (found,) = job["results"]
        (both,) = found["maps"].values()
        assert {axis for axis in (0, 1) if both[axis]["good"]} == good, both
        assert all(one["good"] == (one["steps"] <= found["most"][0] and
                                   one["seam"] <= found["most"][1]) for one in both)  # fmt: skip
        assert page.get(f"{path}/borders/picture").startswith(SIGNATURE)
    assert page.ask("GET", f"{path}/borders/picture?map=x").status_code == 404


def test_an_atlas_is_made_shown_and_saved(page, tmp_path):
    material = page.post("materials", WALL)["id"]
    ask = f"materials/{material}/atlases"
    job = page.wait(page.post(ask, {"tile_size": 64, "gutter": 2}))
    assert job["state"] == "done" and job["total"] > 1 and job["preview"] > 0
    (made,) = job["results"]
    assert (made["tiles"], made["tile"], made["width"]) == (16, [64, 64], 4 * 68)
    for what, side in (("", 272), ("&plane", 6 * 64)):
        answer = page.ask("GET", f"atlases/{made['id']}/picture?most=100{what}")
        assert answer.headers["x-weftex-width"] == str(side)
    content, _ = page.taken(f"atlases/{made['id']}", name="rock")
    with zipfile.ZipFile(BytesIO(content)) as file:
        names = set(file.namelist())
        assert {"rock.json", "rock.tsx", "rock.tres", "rock.gdshader", "rock_height.png"} <= names
        assert json.loads(file.read("rock.json"))["image"] == "rock_color.png"
    wrong_values = [({"colors": 4}, "colors"), ({"gutter": 40, "tile_size": 64}, "gutter")]
    wrong_values += [({"tile_size": one}, "tile_size") for one in (8, "x")]
    for wrong, parameter in wrong_values:
        answer = page.ask("POST", ask, content=json.dumps(wrong))
        told = answer.json() if answer.status_code == 422 else page.wait(answer.json())
        assert told["error"] and told["parameter"] == parameter, told
    assert page.ask("GET", "atlases/x/picture").status_code == 410
