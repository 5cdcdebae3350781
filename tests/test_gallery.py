"""The command that makes docs/lab/measured/quality.md, on a tiny part; surfaces and charts."""

import csv
import dataclasses
import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import weftex
from weftex.io.pictures import read_image
from weftex.naming import make_method

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "benchmarks" / name) for name in ("speed", "quality")]
import gallery  # noqa: E402
import gallery_page  # noqa: E402
import gallery_sheets  # noqa: E402
import judging  # noqa: E402
import sources  # noqa: E402

pytestmark = pytest.mark.pages
METHODS = ["auto", "quilting"]
WORDS = ["--surfaces", "grass_gray", "--methods", *METHODS, "--size", "64"]


def section(page, title):
    """What stands below a heading, up to the next of its kind."""
    text = page.read_text("utf-8")
    return text.split(f"\n## {title}\n")[1].split("\n## ")[0]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folders of pages and of what was kept."""
    folder = tmp_path_factory.mktemp("gallery")
    run(folder)
    return folder


def run(folder, *more):
    gallery.main([*WORDS, "--keep", f"{folder}/keep", "--docs", f"{folder}/docs", *more])


def test_pages_are_written_whole(made):
    """The pages of the repository have the same headings, and name the command."""
    for name in gallery_page.PAGES:
        old, new = ((where / name).read_text("utf-8") for where in (gallery.PAGES, made / "docs"))
        heads = [re.findall("^#+ .*", text, re.M) for text in (old, new)]
        assert set(heads[1]) <= set(heads[0]) and old != new
        assert "python benchmarks/quality/gallery.py" in new
    assert {p.name for p in (made / "docs").iterdir()} == set(gallery_page.PAGES)


def test_every_picture_and_figure_is_there(made):
    pictures = (made / "keep" / "index.html").read_text("utf-8")
    shown = re.findall(r'src="pictures/(\S+)"', pictures)
    assert sorted(shown) == sorted(p.name for p in (made / "keep/pictures").iterdir())
    assert len(shown) == 2
    with Image.open(made / "keep/pictures/grass_gray.webp") as sheet:
        assert sheet.size == (256 + 6 + 64, 256 + 6 + 32)
    scores = section(made / "docs" / "quality.md", "Scores")
    figures = section(made / "docs" / "quality-figures.md", "grass_gray")
    assert '<h2 id="grass_gray">' in pictures
    assert "[grass_gray](quality-figures.md#grass_gray)" in scores
    for method in METHODS:
        assert len(re.findall(rf"\| \[{method}\]\(\S+/{method}\.md\) \|", figures)) == 1


def test_pictures_and_figures_are_what_the_library_makes(made):
    exemplar = weftex.load_exemplar(ROOT / "benchmarks/data/surfaces/grass_gray.png")
    again = weftex.synthesize(exemplar, 64, method="quilting", seed=1)
    kept = read_image(made / "keep/quilting/grass_gray.png").pixels
    assert np.array_equal(kept, again.image)
    value = weftex.assess(exemplar, again).score
    row = next(r for r in section(made / "docs/quality.md", "Scores").split("\n") if "grass" in r)
    assert row.split(" | ")[-1].strip("*| ") == f"{value:.2f}"


def test_what_may_have_changed_is_made_again(made, monkeypatch):
    file = str(ROOT / "benchmarks/data/surfaces/grass_gray.png")
    job = gallery.Job("grass_gray", file, "quilting", 64, f"{made}/keep")
    assert job.done() == job.kept() == job.run()
    for change in ({"size": 65}, {"file": __file__}, {"surface": "bark"}):
        assert dataclasses.replace(job, **change).kept() is None

    def other(*modules):
        return changed if modules == ("weftex.quality.assess",) else sources.code_hash(*modules)

    changed = "measures"
    monkeypatch.setattr(gallery, "code_hash", other)
    assert job.kept() and job.done() is None
    monkeypatch.setattr(gallery.Job, "make", None)  # pictures are not made again for that
    assert job.run()["figures"]["score"] > 0 and job.done()
    monkeypatch.setattr(gallery, "code_hash", lambda *modules: "method")
    assert job.kept() is None


def test_a_part_is_no_page_of_the_repository(capsys):
    with pytest.raises(SystemExit):
        gallery.main(["--methods", "quilting"])
    assert "name another --docs" in capsys.readouterr().err


def test_the_gallery_shows_every_surface(made, monkeypatch):
    """The page in docs, whose commands test_readme runs, is what the command writes."""
    monkeypatch.setattr(gallery_sheets, "PAGE", "")
    run(made, "--sheets", f"{made}/sheets")
    page = (made / "sheets" / "gallery.md").read_text("utf-8")
    assert "-o grass_gray.png --size 64 --seed 1" in page
    with Image.open(made / "sheets" / "img" / "gallery_1.webp") as sheet:
        assert sheet.size == (128 + 6 + 32, 128)
    kept = (ROOT / "docs" / "gallery.md").read_text("utf-8")
    for about in gallery.surfaces().values():
        assert gallery_sheets.command(about, gallery.SIZE, gallery.SEED) in kept


def test_surfaces_are_listed_and_free():
    folder = gallery.SURFACES.parent
    listed = gallery.surfaces()
    assert len(listed) == 24 and list(listed) == sorted(listed)
    own = sorted(row["file"] for row in listed.values() if "/" not in row["file"])
    assert own == sorted(p.name for p in folder.iterdir() if p.suffix != ".csv")
    for row in listed.values():
        assert all(row.values()) and "CC0" in row["licence"]
        pixels = read_image((folder / row["file"]).resolve()).pixels
        assert pixels.shape[:2] == (int(row["height"]), int(row["width"])) == (256, 256)
    assert sum(p.stat().st_size for p in folder.iterdir()) < 3_000_000


def test_pictures_of_the_repository_are_small():
    kinds = {".png", ".jpg", ".webp", ".svg"}
    rooms = ("docs", "examples", "benchmarks", "src")
    pictures = [p for room in rooms for p in (ROOT / room).rglob("*") if p.suffix in kinds]
    assert len(pictures) > 60 and sum(p.stat().st_size for p in pictures) < 6_000_000


def test_every_picture_of_docs_is_shown():
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    shown = {
        (page.parent / name).resolve()
        for page in pages
        for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.read_text("utf-8"))
    }
    kept = {p for p in (ROOT / "docs").rglob("*") if p.suffix in (".webp", ".jpg", ".png", ".svg")}
    assert {p.resolve() for p in kept} == shown


def test_judged_scores_are_of_known_pictures():
    with open(gallery_page.JUDGED, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        assert row["surface"] in gallery.surfaces() and row["good"] in ("yes", "no")
        assert row["method"] in ("real", *gallery.METHODS) and float(row["score"]) >= 0
        assert re.fullmatch("[0-9a-f]{16}|", row["picture"])
        assert bool(row["picture"]) == (row["method"] != "real")


def test_quality_against_time(monkeypatch):
    monkeypatch.setattr(judging, "NAMES", ("bricks",))
    monkeypatch.setattr(judging, "_SEEDS", (1,))
    for setting in judging.SETTINGS:
        make_method(setting.method, setting.parameters)
    some = [judging.Setting("quilting"), judging.Setting("quilting", {"candidates": 5})]
    notes, head, rows = judging.quality_against_time(some, 48, 64)
    assert "48 to 64" in notes and [len(row) for row in rows] == [len(head)] * 2
    assert float(rows[0][1]) <= float(rows[1][1]) and rows[0][3] == "yes"
    chart = ET.fromstring(judging.quality_against_time_chart(rows))
    texts = [node.text for node in chart.iter("{http://www.w3.org/2000/svg}text")]
    assert {"quilting", "quilting, candidates 5", "seconds"} <= set(texts)
