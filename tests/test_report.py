"""What `weftex report` writes, and what it refuses."""

import base64
import json

import numpy as np
import pytest

import weftex
from html_page import Page
from weftex import cli
from weftex.io.pictures import write_image
from weftex.pages.reports import report


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A sample, a result and its source, under names that a page must not take for markup."""
    folder = tmp_path_factory.mktemp("report")
    pixels = weftex.load_exemplar("sample:weave").pixels[:96, :96]
    sample = folder / 'we<b>"a&v e.png'
    write_image(sample, pixels)
    made = weftex.synthesize(pixels, (106, 128), method="quilting", seed=1, tileable="x")
    write_image(folder / "made.png", made.image)
    made.save(folder / "made.npz")
    return sample, folder / "made.png", folder / "made.npz"


def run(*words):
    return cli.main(["report", *map(str, words)])


def test_the_page_is_whole_and_needs_nothing_else(files, tmp_path, capsys):
    sample, made, source = files
    assert run(sample, made, "--source", source, "-o", tmp_path / "r.html") == 0
    said = capsys.readouterr()
    assert said.err == "" and said.out.count("\n") == 1 and said.out[0].isupper()
    text = (tmp_path / "r.html").read_text("utf-8")
    page = Page(text)
    assert len(page.pictures) == 5  # sample, result, broken, source, use
    for picture in page.pictures:
        assert picture["alt"] and picture["src"].startswith("data:image/png;base64,")
        base64.b64decode(picture["src"].partition(",")[2], validate=True)
    assert not set(page.tags) & {"script", "link", "iframe", "b"}
    assert "http" not in text and "url(" not in text
    assert "prefers-color-scheme: dark" in text
    words = page.text
    assert sample.name in words and any(sample.name in p["alt"] for p in page.pictures)
    assert said.out.strip() in words
    assert "quilting" in words and "patch_size" in words  # the parameters
    assert "seam at the wrap" in words


def test_without_a_page_each_measure_has_a_line(files, capsys):
    assert run(*files[:2]) == 0
    verdict, *lines = capsys.readouterr().out.splitlines()
    assert verdict[0].isupper() and len(lines) >= 4
    for line in lines:
        assert line.endswith(".") and any(c.isdigit() for c in line.partition(": ")[2]), line


def test_json_has_all_figures(files, capsys):
    sample, made, source = files
    assert run(sample, made, "--source", source, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    direct = report(sample, made, source).as_dict()
    assert found == json.loads(json.dumps(direct, allow_nan=False))
    assert found["provenance"]["method"] == "quilting"
    assert 0.5 < found["real"]["patches"] < 2 and found["real"]["wrap"] is None
    assert found["wrap"] < 0.1  # the source says that it tiles


def test_tileable_may_be_said(files, capsys):
    sample, made, source = files
    assert run(sample, made, "--json") == 0
    assert json.loads(capsys.readouterr().out)["wrap"] is None
    assert run(sample, made, "--json", "--source", source, "--tileable") == 0
    assert json.loads(capsys.readouterr().out)["wrap"] > 0.2  # to the right it does


def test_a_picture_of_another_source_is_noted(files):
    sample, made, source = files
    turned = weftex.read_image(made).pixels[::-1].copy()
    assert "differs from the image of its sources" in report(sample, turned, source).notes[0]
    assert report(sample, weftex.Synthesis.load(source)).notes == ()


def test_normals_are_measured_whichever_way_y_points():
    stones = weftex.load_exemplar("sample:stone_wall")
    made = weftex.synthesize(stones, 128, seed=1)
    normals = made.maps["normal"]
    down = np.stack([normals[..., 0], 255 - normals[..., 1], normals[..., 2]], axis=2)
    whole, turned = (
        report(stones, weftex.Exemplar(made.image, maps={"normal": one})) for one in (normals, down)
    )
    assert whole.of_maps["normal"].assessment == turned.of_maps["normal"].assessment


def test_large_pictures_are_shown_smaller(rng):
    sample = rng.integers(0, 256, (8, 8), np.uint8)
    text = report(sample, np.tile(sample, (2, 260))).html()
    assert "2080x16 pixels, shown at 1:3" in text
