"""A recipe makes the same bytes again: by the page, the command and the Python that it shows."""

import os
import shlex
import zipfile
from io import BytesIO

import numpy as np
import pytest

from weftex.cli import main
from weftex.io.pictures import read_image, write_image
from weftex.recipe import Recipe

BRICKS, WEAVE, WALL = {"sample": "bricks"}, {"sample": "weave"}, {"sample": "stone_wall"}


@pytest.fixture
def photo(page, tmp_path, monkeypatch):
    """A folder with a photo, a mask and a map, which are uploads too."""
    monkeypatch.chdir(tmp_path)
    pixels = read_image("sample:pebbles").pixels[:96, :90]
    hole = np.zeros((96, 90), np.uint8)
    hole[30:50, 40:70] = 255
    labels = np.zeros((32, 36, 3), np.uint8)
    labels[15:] = (200, 10, 0)
    part = np.full((96, 90), 255, np.uint8)
    part[:10] = 0
    canvas = np.dstack([pixels[:48, :40], np.full((48, 40), 255, np.uint8)])  # as browsers make it
    pictures = {"guide.png": canvas, "my photo.png": pixels, "hole.png": hole}
    pictures |= {"map.png": labels, "part.png": part}
    ids = {}
    for name, picture in pictures.items():
        write_image(name, picture, alpha=picture.shape[2:] == (4,))
        with open(name, "rb") as file:
            ids[name.partition(".")[0]] = page.upload(file.read(), name)["id"]
    return ids


def recipes(photo):
    own = {"maps": {"color": photo["my photo"]}}
    quilting = {"method": "quilting", "parameters": {"patch_size": 24}}
    return {
        "auto": {"materials": [own], "size": [64, 80], "parameters": {"effort": "quick"}},
        "method": {"materials": [BRICKS], "size": [60, 70], "tileable": "x", **quilting},
        "lattice": {"materials": [BRICKS], "size": [96, 100], "method": "near-regular",
                    "parameters": {"lattice": [62.73, 41.85, 63.42, -41.69]}},
        "mended": {"materials": [own | {"even_light": 2, "turn": "flip", "mask": photo["part"]}],
                   "size": [64, 64], **quilting},
        "straight": {"materials": [own | {"straighten": "0,0,80,4,80,90,2,88", "repeats": True}],
                     "size": [64, 64], **quilting},
        "set": {"materials": [WALL | {"map_weights": {"height": 2}}], "size": [64, 64], **quilting},
        "several": {"materials": [own, BRICKS], "size": [64, 64], **quilting},
        "best": {"materials": [own], "size": [64, 64], "best_of": 2, **quilting},
        "guide": {"materials": [own], "guide": photo["guide"], "method": "ashikhmin"},
        "tile": {"task": "tile", "materials": [own], "border": 8, "seed": 2},
        "tile x": {"task": "tile", "materials": [own | {"even_light": 1}], "axes": "x",
                   "method": "quilting", "parameters": {"patch_size": 12}},
        "fill": {"task": "fill", "materials": [own], "mask": photo["hole"], "overlap": 3},
        "fill from": {"task": "fill", "materials": [own, BRICKS], "mask": photo["hole"],
                      "match_tone": True, "method": "patch-sampling",
                      "parameters": {"patch_size": 24}},
        "fuse": {"task": "fuse", "materials": [own, BRICKS], "map": photo["map"],
                 "colors": [[0, 0, 0], [200, 10, 0]], "belt_width": 12,
                 "method": "ashikhmin"},
        "gradient": {"task": "fuse", "materials": [own, own | {"even_light": 1}], "size": [20, 24],
                     "map": {"center": [0.5, 0.25], "width": 0.5}, "method": "ashikhmin"},
    }  # fmt: skip


NAMES = ["auto", "method", "lattice", "mended", "straight", "set", "several", "best",
         "guide", "tile", "tile x", "fill", "fill from", "fuse", "gradient"]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_page_command_and_python_make_the_same(page, photo, name):
    recipe = {"seed": 7, **recipes(photo)[name]}
    result = page.made(recipe)
    assert Recipe.from_json(result["recipe"]).as_json() == result["recipe"]
    content, file = page.taken(result, name="mine")
    with open(file, "wb") as out:
        out.write(content)
    if len(result["maps"]) > 1:
        zipfile.ZipFile(BytesIO(content)).extractall()
    for line in result["command"].split(" && "):
        words = shlex.split(line)
        assert words[0] == "weftex"
        assert main([*words[1:], *([] if words[1] == "analyze" else ["--quiet"])]) == 0, line
    by_command = {}
    if os.path.isdir("out"):
        names = {"albedo": "color"}
        stems = {os.path.splitext(one)[0]: one for one in os.listdir("out")}
        by_command = {names.get(k, k): f"out/{one}" for k, one in stems.items()}
    else:
        by_command["color"] = "out.png"
    for map_, path in by_command.items():
        mine = "mine.png" if len(result["maps"]) == 1 else f"mine_{map_}.png"
        with open(mine, "rb") as one, open(path, "rb") as two:
            assert one.read() == two.read(), (map_, result["command"])
    exec(compile(result["python"], "shown", "exec"), {})
    for map_, path in by_command.items():
        other = "out.png" if map_ == "color" else f"out_{map_}.png"
        assert (read_image(other).pixels == read_image(path).pixels).all(), map_


def test_the_same_recipe_is_the_same_result(client, page, other):
    """In another tab, after it was forgotten, and whatever the order of its fields."""
    recipe = {"materials": [BRICKS], "size": [64, 64], "seed": 1, "method": "quilting"}
    first = page.made(recipe)
    again = other.made({**dict(reversed(recipe.items())), "parameters": {"blend": None}})
    assert again["id"] == first["id"]
    picture = page.get(f"results/{first['id']}/picture")
    assert picture == other.get(f"results/{first['id']}/picture")
    client.studio.memory.forget(page.session.key)
    assert page.ask("GET", f"results/{first['id']}/picture").status_code == 410
    page.made(first["recipe"])
    assert picture == page.get(f"results/{first['id']}/picture")
    drawn = page.made({**recipe, "seed": None})
    assert drawn["recipe"]["seed"] < 2**32
    assert drawn["id"] != first["id"]


WRONG = [
    ({}, "materials"),
    ([], "recipe"),
    ({"materials": []}, "materials"),
    ({"materials": [{}]}, "materials"),
    ({"materials": ["/etc/passwd"]}, "materials"),
    ({"materials": [{"sample": "nothing"}]}, "sample"),
    ({"materials": [{"sample": "bricks", "path": "/etc"}]}, "materials"),
    ({"materials": [{"maps": {"color": 7}}]}, "maps"),
    ({"materials": [BRICKS | {"straighten": 4}]}, "straighten"),
    ({"materials": [BRICKS | {"straighten": "1,2"}]}, "straighten"),
    ({"materials": [BRICKS | {"even_light": 99}]}, "even_light"),
    ({"materials": [BRICKS], "task": "eval"}, "task"),
    ({"materials": [BRICKS], "threads": 4}, None),
    ({"materials": [BRICKS], "method": "nothing"}, "method"),
    ({"materials": [BRICKS], "method": 7}, "method"),
    ({"materials": [BRICKS], "method": "quilting", "parameters": {"patch_size": 0}}, "patch_size"),
    ({"materials": [BRICKS], "method": "quilting", "parameters": {"cls": 1}}, None),
    ({"materials": [BRICKS], "method": "quilting", "parameters": {"self": 1}}, None),
    ({"materials": [BRICKS], "method": "quilting", "parameters": [1]}, "parameters"),
    ({"materials": [BRICKS], "size": [0, 9]}, "size"),
    ({"materials": [BRICKS], "size": "9x9"}, "size"),
    ({"materials": [BRICKS], "size": [9.5, 9]}, "size"),
    ({"materials": [BRICKS], "seed": -1}, "seed"),
    ({"materials": [BRICKS], "seed": True}, "seed"),
    ({"materials": [BRICKS], "tileable": "z"}, "tileable"),
    ({"materials": [BRICKS], "guide": ["x"]}, "guide"),
    ({"materials": [BRICKS], "best_of": 1000}, "best_of"),
    ({"materials": [BRICKS], "task": "tile", "axes": "/"}, "axes"),
    ({"materials": [BRICKS], "task": "fill", "parameters": {"effort": "best"}}, "effort"),
    ({"materials": [BRICKS], "task": "fuse"}, "materials"),
    ({"materials": [BRICKS, WEAVE], "task": "fuse", "map": None}, "map"),
    ({"materials": [BRICKS, WEAVE], "task": "fuse", "map": {"file": "/etc"}}, "map"),
    ({"materials": [BRICKS, WEAVE], "task": "fuse", "map": {"width": 7}, "size": [9, 9]}, "width"),
]


@pytest.mark.parametrize(("recipe", "parameter"), WRONG)
def test_what_is_wrong_is_one_line_with_its_field(page, recipe, parameter):
    answer = page.refused("jobs", {"recipe": recipe})
    assert answer["parameter"] == parameter, answer
    assert 10 < len(answer["error"]) < 400


def test_too_large_is_refused_before_it_waits(page):
    recipe = {"materials": [BRICKS], "size": [4096, 4096]}
    line = page.refused("jobs", {"recipe": recipe}, 413)
    assert line["parameter"] == "size"
    assert page.get("jobs") == []
