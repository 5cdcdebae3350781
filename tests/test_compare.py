"""Every method on one sample: figures, times, and a page with everything in it."""

import base64
import json
import re

import numpy as np
import pytest

import weftex
from families import noise, refused
from html_page import Page
from weftex.cli import main
from weftex.errors import CancelledError, FileError
from weftex.io.pictures import read_image, write_image
from weftex.pages.comparisons import compare

NAMES = sorted(["auto", *weftex.METHODS])
WEAVE = weftex.load_exemplar("sample:weave").pixels[:64, :70]


@pytest.fixture(scope="module")
def found():
    sample = weftex.Exemplar(WEAVE, name="a <b> & 'c'.png")
    return compare(sample, (56, 60), seed=5, threads=2)


def test_every_method_is_there_best_first(found):
    assert sorted(e.method for e in found.entries) == NAMES
    ranks = [entry.rank for entry in found.entries]
    assert ranks == sorted(ranks) and found.shape == (56, 60) and found.seed == 5
    for entry in found.entries:
        assert entry.note == "" and entry.seconds > 0
        if entry.method not in ("quilting", "best-tile", "graphcut"):
            continue
        again = weftex.synthesize(WEAVE, (56, 60), method=entry.method, seed=5)
        assert np.array_equal(entry.result.image, again.image)
        assert entry.assessment == weftex.assess(weftex.Exemplar(WEAVE), again)


def test_the_page_needs_nothing_but_itself(found, tmp_path):
    found.save(tmp_path / "c.html")
    page = Page((tmp_path / "c.html").read_text("utf-8"))
    assert "a <b> & 'c'.png" in page.text and "<b>" not in found.html()
    assert sorted(page.ids) == NAMES
    assert sorted(page.links) == [f"#{name}" for name in NAMES]
    assert len(page.pictures) == 1 + 2 * len(NAMES)
    for number, picture in enumerate(page.pictures):
        assert picture["alt"] and picture["src"].startswith("data:image/png;base64,")
        (tmp_path / f"{number}.png").write_bytes(base64.b64decode(picture["src"][22:]))
    assert np.array_equal(read_image(tmp_path / "0.png").pixels, WEAVE)
    best = found.entries[0].result
    assert np.array_equal(read_image(tmp_path / "1.png").pixels, best.image)
    assert np.array_equal(read_image(tmp_path / "2.png").pixels, best.draw())
    assert found.choice.reason in page.text
    over = sum(len(entry.assessment.flags) for entry in found.entries)
    assert over > 0 and found.html().count('class="number over"') == over
    assert not re.search(r'(src|href)="(?!data:|#)', found.html())
    refused("c.png", found.save, tmp_path / "c.png", error=FileError)


def test_a_method_that_cannot_says_why():
    mask = np.ones((40, 40), bool)
    mask[::8] = False  # no whole patch of ten pixels
    sample = weftex.Exemplar(noise((40, 40)), mask=mask)
    found = compare(sample, 30, methods=["quilting", "ashikhmin"], seed=1)
    able, unable = found.entries
    assert able.method == "ashikhmin" and unable.result is None and unable.rank == float("inf")
    assert "patch" in unable.note and unable.as_dict()["figures"] is None
    page = Page(found.html())
    assert f"It cannot make this: {unable.note}." in page.text


@pytest.mark.parametrize(
    ("methods", "message"),
    [(["quiltin"], "did you mean 'quilting'"), ([], "at least one"), (["quilting"] * 2, "once")],
)
def test_wrong_methods_are_found_before_any_work(methods, message):
    refused(message, compare, "nowhere.png", 30, methods=methods)


def test_progress_counts_methods_and_cancels_within_one():
    seen = []

    def callback(done, total, stage, preview):
        seen.append((done, total, stage))
        assert (image := preview()) is None or done == 0 or image.shape == (90, 90, 3)
        return "ashikhmin" not in stage

    with pytest.raises(CancelledError):
        compare(WEAVE, 90, methods=["quilting", "ashikhmin"], seed=1, progress=callback)
    assert seen[-1][0] in (0, 1)
    assert {now.split()[-1] for *_, now in seen} == {"quilting", "ashikhmin"}


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_image("s.png", WEAVE)
    words = ["compare", "s.png", "--methods", "quilting, best-tile", "--size", "60x50"]
    assert main([*words, "-o", "c.html", "--json", "--tileable", "x"]) == 0
    out, err = capsys.readouterr()
    about = json.loads(out)
    assert {m["method"] for m in about["methods"]} == {"quilting", "best-tile"}
    assert (about["height"], about["width"], about["seed"]) == (50, 60, 1)
    assert "compared 2 methods" in err and (tmp_path / "c.html").exists()
    assert main(words) == 0
    assert capsys.readouterr().err.count("\n") >= 3  # a line for each method, and the best


def test_the_choice_can_be_among_them():
    found = compare("sample:weave", 64, methods=["auto", "quilting"], seed=1)
    auto = next(entry for entry in found.entries if entry.method == "auto")
    assert auto.result.provenance["method"] == found.choice.method
