"""What the page is told at the start: methods and their parameters, samples, formats."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import TYPE_CHECKING, Any

import weftex
from weftex.io.map_files import SCHEMES
from weftex.io.pictures import sample_names
from weftex.naming import kind_of
from weftex.quality.figures import FIGURES
from weftex.results.drawing import DRAWINGS

if TYPE_CHECKING:
    from weftex import Method

_KINDS = {int: "int", float: "float", str: "text"}


def about() -> dict[str, Any]:
    """Return it; what methods say is read from the methods, so that a new one is there too."""
    return {
        "methods": [_method(weftex.Auto), *(_method(weftex.METHODS[k]) for k in weftex.METHODS)],
        "samples": _samples(),
        "names": list(SCHEMES),
        "drawings": list(DRAWINGS),
        "figures": [
            {"name": name, "title": one.title, "limit": one.limit, "meaning": one.meaning}
            for name, one in FIGURES.items()
        ],
        "tasks": _TASKS,
    }


def _method(method: type[Method]) -> dict[str, Any]:
    """Return what a method says of itself."""
    return {
        "slug": method.slug,
        "title": method.title,
        "paper": method.paper,
        "fast": "many" not in method.supports,  # that is what copying single pixels allows
        "parameters": [_parameter(field) for field in dataclasses.fields(method)],
    }


def _parameter(field: dataclasses.Field[Any]) -> dict[str, Any]:
    found = {"name": field.name, "type": _KINDS[kind_of(field)], "default": field.default}
    return found | dict(field.metadata)


def _number(name: str, help: str, low: int, default_text: str = "", default: Any = None) -> Any:
    return _own(name, "int", help, default, low=low, unit="px", default_text=default_text)


def _own(name: str, kind: str, help: str, default: Any, **more: Any) -> dict[str, Any]:
    plain: dict[str, Any] = {
        "low": None, "high": None, "unit": "", "choices": [], "default_text": "", "needs": None,
        "needs_canvas": "", "idle_canvas": "", "count": 0, "parity": "",
    }  # fmt: skip
    return {"name": name, "type": kind, "default": default, "help": help, **plain, **more}


#: What tasks take beside a method; the words are those of the command line.
_TASKS = {
    "synth": [
        _own("best_of", "int", "make so many, with the seeds from this one on, and keep the best",
             1, low=1, high=16),
    ],
    "tile": [
        _number("border", "so many pixels at each side may change", 1,
                "an eighth of the shorter side"),
    ],
    "fill": [
        _number("overlap", "so many pixels around the holes may change, to hide the seam", 0,
                default=0),
        _own("match_tone", "bool", "shift tones inside the holes to those around", None,
             default_text="where no method is named"),
    ],
    "fuse": [
        _own("boundary", "text", "cut: where it shows least; merged: and belts there from merged "
             "samples", "cut", choices=["cut", "merged"]),
        _number("belt_width", "within how many pixels a boundary may wander", 2,
                "by the samples' scales"),
    ],
}  # fmt: skip


@cache
def _samples() -> list[dict[str, Any]]:
    found = []
    for name in sample_names():
        sample = weftex.load_exemplar(f"sample:{name}")
        about = {"maps": 1 + len(sample.maps), "width": sample.shape[1], "height": sample.shape[0]}
        found.append({"name": name, "title": name.replace("_", " "), **about})
    return [one for one in found if one["name"] != "hole"]
