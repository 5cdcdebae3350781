"""Pictures that come in: how much is taken, what is said of them, what is left where one fails."""

from contextlib import suppress
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from picture_files import bomb
from weftex.exemplar.material import read_material
from weftex.io.pictures import write_image
from weftex.studio.materials import sets_of


def left_over(client):
    """Files of uploads that did not end."""
    return [one for one in client.studio.store.folder.rglob("*") if ".new-" in one.name]


def test_a_picture(page, tmp_path, rng):
    pixels = rng.integers(0, 65535, (20, 30, 4)).astype(np.uint16)
    write_image(tmp_path / "a.png", pixels, alpha=True)
    content = (tmp_path / "a.png").read_bytes()
    found = page.upload(content, "../brick wall_normal_gl.png")
    name = "brick wall_normal_gl.png"
    assert found == {"id": sha256(content).hexdigest(), "name": name, "bytes": len(content)}
    assert page.get(f"uploads/{found['id']}") == content
    assert page.upload(content, "again.png") == {**found, "name": "again.png"}
    assert [*page.session.uploads] == [found["id"]]


def test_bytes_are_counted_while_they_come(client, page):
    """Whatever Content-Length says, or does not say."""
    before, most, sent = client.studio.store.bytes, client.studio.limits.upload_bytes, []

    def endless():
        for _ in range(10_000):
            sent.append(1)
            yield b"x" * 2**16

    with suppress(ConnectionError):  # the line is closed on whoever sends on
        assert page.ask("POST", "uploads", content=endless()).status_code == 413
    assert len(sent) < 10_000
    answer = page.ask("POST", "uploads", content=b"", headers={"content-length": str(most + 1)})
    assert answer.status_code in (400, 413)
    line = page.upload(b"\x89PNG" + b"x" * most, status=(413,))["error"]
    assert line == "photo.png is larger than 1 MiB, the limit for one file"
    assert client.studio.store.bytes == before
    assert left_over(client) == []


@pytest.mark.parametrize("shape", [(10_000, 10_000), (1_000_000, 1), (513, 512)])
def test_pixels_are_counted_before_they_are_decoded(client, page, shape):
    before = client.studio.store.bytes
    line = page.upload(bomb(*shape), "bomb.png", status=(413,))["error"]
    assert line == "bomb.png has more than 0.25 megapixels, the limit for one file"
    assert client.studio.store.bytes == before
    assert left_over(client) == []


@pytest.mark.parametrize("content", [b"", b"GIF89a", b"<svg/>", bomb(8, 8)[:-30], b"\x89PNG\r\n"])
def test_what_is_no_picture(client, page, content):
    answer = page.upload(content, "x/y\n.png", status=(422,))
    assert answer["error"].startswith("y.png: ")
    assert str(client.studio.store.folder) not in answer["error"]
    assert left_over(client) == []
    assert not page.session.uploads


@pytest.mark.parametrize(
    "body",
    [b"{", b"[1,", b"\xff", b"[" * 5000, b"NaN", b'"text"', b"[]", b"7", rb'{"lane": "\ud800"}'],
)
def test_what_is_no_request(page, body):
    for path in ("session", "jobs", "sets", "planes"):
        answer = page.ask("POST", path, content=body)
        assert answer.status_code in (400, 422), (path, answer.text)
        assert "\n" not in answer.json()["error"]


def test_long_requests_are_refused(page):
    answer = page.ask("POST", "jobs", content=b'{"recipe": "' + b"x" * 2**14 + b'"}')
    assert answer.status_code == 413


NAMES = {
    "Bricks_1K_Color.png": "color", "Bricks_1K_NormalGL.png": "normal_gl", "Bricks_1K.png": None,
    "Moss_albedo.png": "color", "Moss_height.png": "height", "leaves.png": None,
}  # fmt: skip


def test_what_is_dropped_together_is_sorted():
    uploads = [{"id": name, "name": name} for name in NAMES]
    specs, notes = sets_of([one for one in uploads if one["name"] != "Bricks_1K.png"])
    assert notes == []
    bricks = {"color": "Bricks_1K_Color.png", "normal_gl": "Bricks_1K_NormalGL.png"}
    moss = {"color": "Moss_albedo.png", "height": "Moss_height.png"}
    named = [{"name": "bricks", "maps": bricks}, {"name": "moss", "maps": moss}]
    assert specs == [*named, {"maps": {"color": "leaves.png"}}]
    both = [*uploads, {"id": "b", "name": "Moss_diffuse.png"}]
    specs, notes = sets_of(both)
    assert notes == ["Moss_diffuse.png is ignored: Moss_albedo.png is also color"]
    own = [{"id": k, "name": k} for k in ("Wall.png", "Wall_normal.png")]
    maps = {"color": "Wall.png", "normal": "Wall_normal.png"}
    assert sets_of(own)[0] == [{"name": "wall", "maps": maps}]
    assert sets_of(own[1:])[0] == [{"maps": {"color": "Wall_normal.png"}}]


def test_a_set(page):
    """Uploads as a set are what the command reads from a folder."""
    material = read_material("sample:stone_wall")
    ids = {}
    for name, picture in material.pictures.items():
        content = Path(picture.path).read_bytes()
        ids[name] = page.upload(content, f"stone_{name}.png")["id"]
    specs = page.post("sets", {"uploads": list(ids.values())})["materials"]
    assert specs == [{"name": "stone", "maps": ids}]
    found = page.post("materials", specs[0])
    names, roles = ([one[key] for one in found["maps"]] for key in ("name", "role"))
    assert names == roles == ["color", "ao", "height", "normal", "roughness"]
    recipe = {"size": [64, 64], "seed": 3, "method": "quilting"}
    mine = page.made({**recipe, "materials": specs})
    theirs = page.made({**recipe, "materials": [{"sample": "stone_wall"}]})
    for name in ("color", "height"):
        pictures = [page.get(f"results/{one['id']}/picture?map={name}") for one in (mine, theirs)]
        assert pictures[0] == pictures[1]
    assert mine["command"].startswith("weftex synth stone/ -o out/ --size 64 --seed 3")
