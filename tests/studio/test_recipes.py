"""A recipe makes the same bytes again: by the page, the command and the Python that it shows."""

import shlex
import zipfile
from pathlib import Path

import numpy as np
import pytest

from weftex.cli import main
from weftex.io.pictures import read_image, write_image

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
        ids[name.partition(".")[0]] = page.upload(Path(name).read_bytes(), name)["id"]
    return ids


def recipes(photo):
    """One for each way in which uploads are in a recipe; tests/recipe has all options."""
    own = {"maps": {"color": photo["my photo"]}}
    quilting = {"method": "quilting", "parameters": {"patch_size": 24}}
    return {
        "mended": {"materials": [own | {"even_light": 2, "turn": "flip", "mask": photo["part"]}],
                   "size": [64, 64], **quilting},
        "set": {"materials": [WALL | {"map_weights": {"height": 2}}], "size": [64, 64], **quilting},
        "guide": {"materials": [own], "guide": photo["guide"], "method": "ashikhmin"},
        "fill": {"task": "fill", "materials": [own, BRICKS], "mask": photo["hole"],
                 "match_tone": True, "method": "patch-sampling",
                 "parameters": {"patch_size": 24}},
        "fuse": {"task": "fuse", "materials": [own, BRICKS], "map": photo["map"],
                 "colors": [[0, 0, 0], [200, 10, 0]], "belt_width": 12,
                 "method": "ashikhmin"},
    }  # fmt: skip


@pytest.mark.parametrize("name", ["mended", "set", "guide", "fill", "fuse"])
def test_page_command_and_python_make_the_same(page, photo, name):
    result = page.made({"seed": 7, **recipes(photo)[name]})
    content, file = page.taken(f"results/{result['id']}", name="mine")
    Path(file).write_bytes(content)
    if len(result["maps"]) > 1:
        zipfile.ZipFile(file).extractall()
    for line in result["command"].split(" && "):
        assert main([*shlex.split(line)[1:], "--quiet"]) == 0, line
    names = {"albedo": "color"}  # of the file that a set has instead
    folder = sorted(Path("out").glob("*")) if Path("out").is_dir() else []
    made = {names.get(one.stem, one.stem): one for one in folder} or {"color": Path("out.png")}
    for map_, path in made.items():
        mine = Path("mine.png" if len(made) == 1 else f"mine_{map_}.png")
        assert mine.read_bytes() == path.read_bytes(), (map_, result["command"])
    exec(compile(result["python"], "shown", "exec"), {})
    for map_, path in made.items():
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
    ({"materials": [{}]}, "materials"),
    ({"materials": ["/etc/passwd"]}, "materials"),
    ({"materials": [{"sample": "nothing"}]}, "sample"),
    ({"materials": [{"sample": "bricks", "path": "/etc"}]}, "materials"),
    ({"materials": [{"maps": {"color": 7}}]}, "maps"),
    ({"materials": [BRICKS | {"straighten": 4}]}, "straighten"),
    ({"materials": [BRICKS | {"even_light": 99}]}, "even_light"),
    ({"materials": [BRICKS], "task": "eval"}, "task"),
    ({"materials": [BRICKS], "threads": 4}, None),
    ({"materials": [BRICKS], "method": "nothing"}, "method"),
    ({"materials": [BRICKS], "method": "quilting", "parameters": {"patch_size": 0}}, "patch_size"),
    ({"materials": [BRICKS], "method": "quilting", "parameters": {"cls": 1}}, None),
    ({"materials": [BRICKS], "method": "quilting", "parameters": [1]}, "parameters"),
    ({"materials": [BRICKS], "size": [0, 9]}, "size"),
    ({"materials": [BRICKS], "seed": True}, "seed"),
    ({"materials": [BRICKS], "guide": ["x"]}, "guide"),
    ({"materials": [BRICKS], "best_of": 1000}, "best_of"),
    ({"materials": [BRICKS], "task": "tile", "axes": "/"}, "axes"),
    ({"materials": [BRICKS], "task": "fill", "parameters": {"effort": "best"}}, "effort"),
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
