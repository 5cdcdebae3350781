"""Workflows: chains of steps in the data folder, whatever a page sends as one."""

import json

import pytest

MADE = {"task": "synth", "materials": [{"maps": {"color": "photo"}, "even_light": 2}]}
MADE |= {"size": [64, 64], "seed": 3, "method": "quilting", "parameters": {}}
STEPS = [
    {"label": "Maps", "estimate": {"maps": {"color": "photo"}}, "invert": True},
    {"label": "Made", "recipe": MADE | {"materials": [{"maps": {"color": "step 1"}}]}},
    {"label": "Tiled", "recipe": {"task": "tile", "materials": [{"maps": {"color": "step 2"}}]}},
]


def test_chains_are_saved_renamed_and_removed(page, client):
    saved = page.post("presets", {"name": " Wall ", "steps": STEPS})
    [(name, steps)] = saved.items()
    assert name == "Wall" and [one["label"] for one in steps] == ["Maps", "Made", "Tiled"]
    assert steps[0]["invert"] and steps[1]["recipe"]["method"] == "quilting"
    page.post("presets", {"name": "Other", "steps": steps[:2]})
    page.refused("presets", {"name": "Other", "to": "Wall"}, 409)
    page.refused("presets", {"name": "Wall", "steps": STEPS}, 409)  # nothing is replaced unasked
    assert list(page.post("presets", {"name": "Wall", "to": "Bricks"})) == ["Bricks", "Other"]
    assert list(page.post("presets", {"name": "Other"})) == ["Bricks"]
    page.refused("presets", {"name": "Other"}, 404)
    assert page.get("presets") == {"Bricks": steps}
    file = client.studio.store.folder / "presets.json"
    assert json.loads(file.read_text("utf-8")) == {"Bricks": steps}
    file.write_text("[", "utf-8")  # a damaged file is never replaced
    assert "presets.json" in page.refused("presets", {"name": "New", "steps": STEPS})["error"]
    assert file.read_text("utf-8") == "["
    file.unlink()


WRONG = [{"label": "neither"}, {"recipe": MADE, "estimate": {"maps": {"color": "photo"}}}]
WRONG += [{"recipe": MADE | {"materials": [{"sample": "bricks"}]}}]
WRONG += [{"recipe": MADE | {"materials": [{"maps": {"color": "step 1"}}]}}]  # of itself
WRONG += [{"recipe": MADE | {"method": "none"}}]


@pytest.mark.parametrize("steps", [[], "steps", [{"recipe": MADE}] * 33, *([one] for one in WRONG)])
def test_what_is_no_chain_is_refused(page, steps):
    page.refused("presets", {"name": "Wall", "steps": steps})
    assert page.get("presets") == {}


@pytest.mark.parametrize("name", ["", " ", "a\nb", "x" * 61, None, 7])
def test_what_is_no_name_is_refused(page, name):
    page.refused("presets", {"name": name, "steps": STEPS})
