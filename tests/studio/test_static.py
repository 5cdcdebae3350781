"""The files of the page: their weight, how they are asked for, and their colors."""

import re

import pytest

from weftex.studio.page_files import static_files

FILES = {name: place.read_text("utf-8") for name, (place, _) in static_files().items()}
GROUNDS = ("bg", "surface", "raised", "wash")


def test_the_page_weighs_little():
    """At most 300 kB with one language; its modules are asked for at once."""
    own = {name for name in FILES if not name.startswith("strings/")} | {"strings/en.json"}
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
    import json

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
