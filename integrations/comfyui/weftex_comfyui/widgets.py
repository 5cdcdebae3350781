"""What nodes ask for, made from the options that weftex declares."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

from weftex.parameters import kind_of
from weftex.recipe import SEED
from weftex.registry import METHODS

_AXES = {"no": False, "both": True, "x": "x", "y": "y"}
_ANSWERS = {"automatic": None, "yes": True, "no": False}
_DEFAULT = "default"
_OWN = "auto"  # what stands for options without a value on the command line


def inputs_of(options: Iterable[Any]) -> dict[str, tuple[Any, ...]]:
    """Return the inputs of ComfyUI for options of weftex; pictures are sockets, not inputs."""
    return {name: made for option in options for name, made in _inputs(option).items()}


def _inputs(option: Any) -> dict[str, tuple[Any, ...]]:
    about = option.help + (f", in {option.unit}" if option.unit else "")
    bare = option.kind.bare is not None  # such an option is off unless it is given
    about += f"; default: {option.default_text}" if option.default_text and not bare else ""
    unset = "off" if bare else "default"
    more: dict[str, Any] = {"tooltip": about[0].upper() + about[1:]}
    kind, default = option.kind.name, option.default
    if kind in ("picture", "map", "files"):
        return {}
    if kind == "size":
        number = more | {"default": 0, "min": 0, "max": 16384}
        number["tooltip"] += "; 0: default"
        return {"width": ("INT", number), "height": ("INT", number)}
    if option.choices:
        first = [] if default else [_DEFAULT]
        return {option.name: ([*first, *option.choices], more | {"default": default or _DEFAULT})}
    if kind == "axes":
        start = next(name for name, value in _AXES.items() if value == default)
        return {option.name: (list(_AXES), more | {"default": start})}
    if kind == "bool" and default is None:
        return {option.name: (list(_ANSWERS), more | {"default": "automatic"})}
    if kind == "bool":
        return {option.name: ("BOOLEAN", more | {"default": default})}
    if kind == "int":
        low = option.low if default is not None else 0
        more |= {"default": default or 0, "min": low, "max": min(option.high or 2**31, 2**31)}
        more["tooltip"] += f"; 0: {unset}" if default is None else ""
        return {option.name: ("INT", more)}
    more["tooltip"] += f"; {option.kind.wanted}; empty: {unset}"
    more["tooltip"] += f"; {_OWN}: by its own" if bare else ""
    return {option.name: ("STRING", more | {"default": ""})}


def fields_of(options: Iterable[Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return fields of a recipe from values of the inputs; None leaves the default."""
    return {option.name: _field(option, values) for option in options if _inputs(option)}


def _field(option: Any, values: Mapping[str, Any]) -> Any:
    kind = option.kind.name
    if kind == "size":
        width, height = values.get("width", 0), values.get("height", 0)
        return [height or width, width or height] if width or height else None
    value = values.get(option.name, option.default)
    if option.choices:
        return None if value == _DEFAULT else value
    if kind in ("axes", "bool"):
        return {"axes": _AXES, "bool": _ANSWERS}[kind].get(value, value)
    if kind == "int":
        return None if option.default is None and not value else value
    text = (value or "").strip()
    if text == _OWN and option.kind.bare is not None:
        return option.kind.bare
    return option._replace(given_flag=option.name).read(text) if text else None


def choice_of_method(holes: bool) -> dict[str, tuple[Any, ...]]:
    """Return the inputs for a method and its parameters."""
    able = [slug for slug in METHODS if not holes or "known" in METHODS[slug].supports]
    about = "How pixels are chosen; auto: weftex analyzes the sample and chooses"
    more = {"default": "", "multiline": True}
    more["tooltip"] = "Parameters of the method, one per line, such as patch_size=48; see "
    more["tooltip"] += "'weftex methods NAME'"
    return {
        "method": (["auto", *able], {"default": "auto", "tooltip": about}),
        "parameters": ("STRING", more),
    }


def parameters_of(method: str, text: str) -> dict[str, Any]:
    """Return the parameters in lines of a text; weftex refuses the unknown and the wrong."""
    declared = dataclasses.fields(METHODS[method]) if method in METHODS else ()
    fields = {one.name: one for one in declared}
    found: dict[str, Any] = {}
    for line in filter(None, map(str.strip, text.splitlines())):
        name, _, value = (part.strip() for part in line.partition("="))
        try:
            found[name] = kind_of(fields[name])(value) if name in fields else value
        except ValueError:
            found[name] = value
    return found


#: The seed, with ComfyUI's choice of what follows it.
SEED_INPUT = (
    "INT",
    {"default": 1, "min": SEED.low, "max": SEED.high, "control_after_generate": True,
     "tooltip": SEED.help.capitalize() + "; image k of a batch has seed + k"},
)  # fmt: skip
