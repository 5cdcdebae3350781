"""What the page gets at the start: methods and their parameters, samples, formats."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import weftex
from weftex import Method
from weftex.io.pictures import sample_names
from weftex.io.presets import presets
from weftex.parameters import kind_of
from weftex.quality import FIGURES
from weftex.recipe import ATLAS, TASKS
from weftex.results.drawing import DRAWINGS

#: The options of tasks that the page asks for in a form.
_FORMS = {
    "synth": ("landmarks",),
    "tile": ("border",),
    "fill": ("overlap", "match_tone"),
    "fuse": ("boundary", "belt_width"),
}
_KINDS = {int: "int", float: "float", str: "text"}


def about() -> dict[str, Any]:
    """Return it; what methods say is read from the methods, so that a new one is there too."""
    return {
        "methods": [_method(weftex.Auto), *(_method(weftex.METHODS[k]) for k in weftex.METHODS)],
        "samples": _samples(),
        "presets": [{"name": name, "about": line} for name, line in presets().items()],
        "drawings": list(DRAWINGS),
        "figures": [
            {"name": name, "title": one.title, "limit": one.limit, "meaning": one.meaning}
            for name, one in FIGURES.items()
        ],
        "tasks": {k: [TASKS[k].options[n].as_json() for n in names] for k, names in _FORMS.items()}
        | {"atlas": [one.as_json() for one in ATLAS.values()]},
    }


def _method(method: type[Method]) -> dict[str, Any]:
    """Return what a method says of itself."""
    return {
        "slug": method.slug,
        "title": method.title,
        "paper": method.paper,
        "fast": "many" not in method.supports,  # that is what copying single pixels allows
        "parameters": [
            {"name": one.name, "type": _KINDS[kind_of(one)], "default": one.default, **one.metadata}
            for one in dataclasses.fields(method)
        ],
    }


@cache
def _samples() -> list[dict[str, Any]]:
    found = []
    for name in sample_names():
        sample = weftex.load_exemplar(f"sample:{name}")
        about = {"maps": 1 + len(sample.maps), "width": sample.shape[1], "height": sample.shape[0]}
        found.append({"name": name, "title": name.replace("_", " "), **about})
    return [one for one in found if one["name"] != "hole"]
