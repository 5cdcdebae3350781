"""The files of the page: their weight, how they are asked for, their colors and their languages."""

import ast
import json
import re
from pathlib import Path

import pytest

import weftex
from weftex.studio.about import about
from weftex.studio.app import static_files

FILES = {name: place.read_text("utf-8") for name, (place, _) in static_files().items()}
GROUNDS = ("bg", "surface", "raised", "wash")


def test_the_page_weighs_little():
    """At most 300 kB with one language; its modules are asked for at once."""
    words = ("strings/", "messages/")
    own = {name for name in FILES if not name.startswith(words)} | {"strings/en.json"}
    assert 100_000 < sum(len(FILES[name].encode()) for name in own) < 300_000
    named = set(re.findall(r'(?:href|src)="/static/([^"]+)"', FILES["index.html"]))
    assert named == own - {"index.html"}


def light(color):
    """Luminance by WCAG 2."""
    levels = [int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in levels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
def test_colors_have_contrast(scheme):
    """WCAG AA of text on whatever is plain behind it, and of what borders a control."""
    pairs = re.findall(r"--([\w-]+): light-dark\((#\w{6}), (#\w{6})\)", FILES["base.css"])
    colors = {name: light(both[scheme]) for name, *both in pairs}
    wanted = [(text, ground, 4.5) for text in ("text", "soft", "accent") for ground in GROUNDS]
    wanted += [("bad", "bad-wash", 4.5), ("on-accent", "accent", 4.5)]
    wanted += [("edge", ground, 3) for ground in GROUNDS[1:3]]
    for one, other, least in wanted:
        low, high = sorted((colors[one], colors[other]))
        assert (high + 0.05) / (low + 0.05) >= least, (one, other)


def test_strings_are_there_and_used():
    """Every word that is asked for by its name is there, in every language alike."""
    tables = {name: json.loads(text) for name, text in FILES.items() if name.startswith("strings/")}
    english = tables["strings/en.json"]
    code = "".join(text for name, text in FILES.items() if name.endswith(".js"))
    asked = set(re.findall(r"""\bt\("([a-z_.0-9]+)"[,)]""", code))
    assert asked <= english.keys()
    codes = english["languages"].split()
    assert tables.keys() == {f"strings/{code}.json" for code in codes} and len(codes) == 6
    for name, table in tables.items():
        assert {"languages", *table} == english.keys(), name
        for key, text in table.items():
            holes = [set(re.findall(r"\{(\w+)\}", one)) for one in (text, english[key])]
            assert holes[0] == holes[1], (name, key)


SOURCE = Path(weftex.__file__).parent
SHIFTED = ["every other {} shifted by half", "each {} shifted by a third"]
SHIFTED += ["each {} shifted by a quarter", "each {} shifted by {}"]


def template(node):
    """A text or an f-string with {} where values go; None for anything else."""
    if isinstance(node, ast.JoinedStr):
        return "".join(template(part) or "{}" for part in node.values)
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


def spoken(tree):
    """The sentences of a module: texts with words and spaces that are no docstrings."""
    inner = {part for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in
             ast.walk(node) if part is not node}  # fmt: skip
    inner |= {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    texts = [template(node) for node in ast.walk(tree) if node not in inner]
    return {text for text in texts if text and text.strip().count(" ") > 1}


def refusals(tree):
    """The messages of the refusals of a module."""
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    named = [node for node in calls if getattr(node.func, "id", "") == "Refusal"]
    return {text for node in named if (text := template(node.args[1])) is not None}


def test_what_weftex_says_is_translated():
    """Help, figures, reasons of auto and refusals are in every language, by their templates."""
    told = about()
    parameters = [one for method in told["methods"] for one in method["parameters"]]
    parameters += [one for task in told["tasks"].values() for one in task]
    wanted = {one["help"] for one in parameters}
    wanted |= {figure[key] for figure in told["figures"] for key in ("title", "meaning")}
    wanted |= spoken(ast.parse((SOURCE / "tasks/auto/rule.py").read_text("utf-8")))
    for file in (SOURCE / "studio").glob("*.py"):
        wanted |= refusals(ast.parse(file.read_text("utf-8")))
    assert {*SHIFTED} <= spoken(ast.parse((SOURCE / "analysis/overlay.py").read_text("utf-8")))
    for shift in SHIFTED:
        wanted |= {"{}, " + shift.replace("{}", line, 1) for line in ("row", "column")}
    trees = [ast.parse(file.read_text("utf-8")) for file in SOURCE.rglob("*.py")]
    said = "\n".join(text for tree in trees for node in ast.walk(tree) if (text := template(node)))
    tables = {name: json.loads(text) for name, text in FILES.items() if name.startswith("messages")}
    assert len(tables) == 5
    for name, table in tables.items():
        known = {re.sub(r"\{\d\}", "{}", key) for key in table}
        assert sorted(wanted - known) == [], name
        dead = [key for key in known - wanted if not all(part in said for part in key.split("{}"))]
        assert dead == [], name  # nothing says this any more
        assert table.keys() == tables["messages/de.json"].keys()
        for key, text in table.items():
            holes = [sorted(re.findall(r"\{\d\}", one)) for one in (key, text)]
            assert holes[0] == holes[1], (name, key)
