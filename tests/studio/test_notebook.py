"""The widget of notebooks, without a notebook: what it is told, and what it answers."""

import re
import subprocess
import sys

import numpy as np
import pytest

import weftex
from weftex.errors import InvalidInputError, UnsupportedError
from weftex.studio.page_files import module, styles, words

pytest.importorskip("anywidget", reason="no anywidget: pip install 'weftex[notebook]'")


@pytest.fixture(scope="module")
def made():
    return weftex.synthesize("sample:stone_wall", (40, 56), method="quilting", seed=1)


@pytest.fixture
def ask(made, monkeypatch):
    """A question of the page, and the answer that it gets."""
    view, said = weftex.studio.view(made, height=200), []
    monkeypatch.setattr(view, "send", lambda content, buffers=None: said.append((content, buffers)))

    def question(**wanted):
        view._answer(view, {"number": 7, **wanted}, [])
        assert said[-1][0].pop("number") == 7
        return said[-1]

    return question


def test_it_answers_with_the_pixels(ask, made):
    told, [pixels] = ask(of="results", map="color", most=2048)
    assert told == {"width": 56, "height": 40, "pixels": "56x40"}
    shown = np.frombuffer(pixels, np.uint8).reshape(40, 56, 4)
    np.testing.assert_array_equal(shown[..., :3], made.image)
    assert (shown[..., 3] == 255).all()
    _, [pixels] = ask(of="materials", map="height", most=64)
    assert len(pixels) == 4 * 64 * 64 or len(pixels) % 4 == 0
    told, [pixels] = ask(of="results", draw="patches", map=None, most=None)
    np.testing.assert_array_equal(
        np.frombuffer(pixels, np.uint8).reshape(40, 56, 4)[..., :3], made.draw("patches")
    )
    told, _ = ask(of="source", x=3, y=2)
    assert told["source"] == made.source[2, 3].tolist()[::-1]


@pytest.mark.parametrize(
    "wanted", [{"of": "results", "map": "../x"}, {"of": "results", "draw": "x"},
               {"of": "source", "x": 56, "y": 0}, {"of": "source"}],
)  # fmt: skip
def test_it_refuses_in_one_line(ask, wanted):
    told, pixels = ask(**wanted)
    assert "\n" not in told["error"] and pixels == []


def test_what_it_is_told(made):
    seen = weftex.studio.view(made)._seen
    names = [one["name"] for one in seen["result"]["maps"]]
    assert names[0] == seen["result"]["main"] == "color" and "height" in names
    assert seen["result"]["method"] == "quilting" and "sources" in seen["drawings"]
    alone = weftex.studio.view(made.sample)._seen
    assert alone["result"] is None and alone["drawings"] == []


def test_its_module_is_one_module_of_the_pages_own():
    """Nothing is left to be imported, and styles reach nothing outside of the widget."""
    text = module()
    assert not re.search(r"^(import|export (?!default))", text, re.M)
    assert text.count("class Viewer") == text.count("class LightView") == 1
    assert "http" not in re.sub(r"http://www.w3.org/\w+/svg", "", text)
    assert ":root" not in styles() and styles().count("{") == styles().count("}")
    used = set(re.findall(r"""\bt\("([a-z_.]+)"[,)]""", text))
    assert used - words().keys() <= {one for one in used if one.startswith(("job.", "time."))}


def test_what_it_does_not_take(made, monkeypatch):
    with pytest.raises(InvalidInputError, match="height is 9; it must be from 160 to 4000"):
        weftex.studio.view(made, height=9)
    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.delitem(sys.modules, "weftex.studio.widget", raising=False)
    with pytest.raises(UnsupportedError, match=r"pip install 'weftex\[notebook\]'"):
        weftex.studio.view(made)


def test_it_needs_no_server():
    """The extra `notebook` brings none."""
    code = "import sys; sys.modules.update(starlette=None, uvicorn=None); import weftex; "
    command = [sys.executable, "-c", code + "weftex.studio.view('sample:bricks')"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
