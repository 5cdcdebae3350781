"""What operators ask for: properties of Blender, made from the options that weftex declares."""

from __future__ import annotations

from typing import Any

import bpy

from weftex.recipe import SEED, TASKS
from weftex.registry import METHODS

_AXES = [
    ("NONE", "No", "The result does not repeat"),
    ("XY", "Both", "The result repeats along both axes"),
    ("x", "X only", "The result repeats from left to right"),
    ("y", "Y only", "The result repeats from top to bottom"),
]


def _property(option: Any) -> Any:
    """Return the property of an option, or None if Blender has no field for its kind."""
    name = option.name.replace("_", " ").capitalize()
    about = option.help[0].upper() + option.help[1:]
    if option.default_text:
        about += f" (0: {option.default_text})"
    if option.kind.name == "size":
        return bpy.props.IntVectorProperty(
            name=name, description=about, size=2, min=0, soft_max=8192, subtype="NONE"
        )
    if option.kind.name == "axes":
        default = "XY" if option.default else "NONE"
        return bpy.props.EnumProperty(name=name, description=about, items=_AXES, default=default)
    if option.kind.name == "int" and type(option.default) in (int, type(None)):
        high = min(option.high or 2**31 - 1, 2**31 - 1)
        return bpy.props.IntProperty(
            name=name, description=about, default=option.default or 0, min=0, max=high
        )
    return None


def _of_task(task: str) -> dict[str, Any]:
    declared = {name: option for name, option in TASKS[task].options.items() if not option.local}
    found = {name: _property(option) for name, option in declared.items()}
    found = {name: made for name, made in found.items() if made is not None}
    names = [("auto", "Automatic", "weftex analyzes the image and chooses")]
    names += [(slug, METHODS[slug].title, METHODS[slug].paper) for slug in METHODS]
    found["method"] = bpy.props.EnumProperty(
        name="Method", description="How pixels are chosen", items=names
    )
    found["seed"] = _property(SEED._replace(default=1))
    return found


#: Properties by their names, for each task that the sidebar offers.
PROPERTIES = {task: _of_task(task) for task in ("synth", "tile", "fill")}


def fields_of(task: str, values: Any) -> dict[str, Any]:
    """Return the fields of a recipe from values of the properties; 0 leaves the default."""
    fields: dict[str, Any] = {"task": task, "method": values.method, "seed": values.seed}
    for name in set(PROPERTIES[task]) - set(fields):
        kind, value = TASKS[task].options[name].kind.name, getattr(values, name)
        if kind == "size":
            fields[name] = [value[1] or value[0], value[0] or value[1]] if any(value) else None
        elif kind == "axes":
            fields[name] = {"XY": True, "NONE": False}.get(value, value)
        elif value:
            fields[name] = value
    return fields
