"""The command line of a recipe, in both directions."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from weftex.errors import InvalidInputError
from weftex.recipe import Recipe, checked_material
from weftex.recipe.declared import GRADIENT, MATERIAL, PREPARATION, SEED, TASKS
from weftex.recipe.options import PICTURE, Option, plain

__all__ = ["command_of"]

Words = Sequence[str]


def json_of(
    task: str,
    paths: Words,
    given: Mapping[str, str | bool | None],
    method: str | None,
    parameters: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the JSON of a command's recipe, which is local.

    `given` has texts by `Option.dest`; options without a value are true or false.
    """
    found: dict[str, Any] = {"task": task, "method": method, "parameters": parameters}
    found["seed"] = value_of(SEED, given)
    for name, option in TASKS[task].options.items():
        found[name] = value_of(option, given)
    if task == "fuse":
        fields = {name: value_of(option, given) for name, option in GRADIENT.items()}
        fields = {name: value for name, value in fields.items() if value is not None}
        if found["map"] == "gradient":
            found["map"] = fields
        elif fields:
            flag = GRADIENT[next(iter(fields))].flag
            raise InvalidInputError(f"{flag} has no effect unless --map is gradient")
    specs: list[dict[str, Any]] = [_spec(path, given.get("maps")) for path in paths]
    for name in TASKS[task].material:
        option = MATERIAL[name]
        value = value_of(option, given)
        if value in (None, False):
            continue
        places = specs[_meant(task, name)]
        if not places:
            raise InvalidInputError(
                f"{option.flag} has no effect without --sample; for the photo, use --tileable"
            )
        for spec in places:
            spec[name] = plain(value)
    return found | {"materials": specs}


def _meant(task: str, name: str) -> slice:
    """Return which materials an option is about: fill has a photo, and a sample to fill it from."""
    of_fill = {"maps": slice(0, 1), "repeats": slice(1, None), "mask": slice(-1, None)}
    return of_fill.get(name, slice(None)) if task == "fill" else slice(None)


def described_material(path: str, given: Mapping[str, Any], names: Words) -> dict[str, Any]:
    """Return the description of a material, with some options of `MATERIAL`."""
    spec = _spec(path, given.get("maps") if "maps" in names else None)
    spec |= {name: value_of(MATERIAL[name], given) for name in names}
    return checked_material(spec, local=True)


def value_of(option: Option, given: Mapping[str, Any]) -> Any:
    """Return the value of an option in JSON; None if it was not given."""
    value = given.get(option.dest)
    return plain(option.read(value)) if isinstance(value, str) else value


def _spec(path: str, maps: Any) -> dict[str, Any]:
    if path.startswith("sample:") and maps is None:
        return {"sample": path.removeprefix("sample:")}
    return {"path": path}


def path_of(spec: Mapping[str, Any], names: Mapping[str, str]) -> str:
    """Return the path of a material where pictures have these names; a set is a folder."""
    if "sample" in spec:
        return f"sample:{spec['sample']}"
    if "path" in spec:
        return str(spec["path"])
    if len(spec["maps"]) == 1:
        (picture,) = spec["maps"].values()
        return names.get(picture, picture)
    return f"{spec.get('name') or 'material'}/"


def renamed(option: Option, value: Any, names: Mapping[str, str]) -> Any:
    """Return the value of an option where pictures have these names."""
    return names.get(value, value) if option.kind is PICTURE else value


def command_of(
    recipe: Recipe, output: str = "out.png", names: Mapping[str, str] | None = None
) -> str:
    """Return the commands that make the same; empty if the command line cannot say it.

    An `output` that ends with a slash is a folder; `names` are other names of the pictures.
    """
    names = names or {}
    lines, paths, specs = list[list[str]](), list[str](), list[dict[str, Any]]()
    first = recipe.materials[0]
    together = recipe.task == "synth" and all(
        spec.get(name) == first.get(name) for spec in recipe.materials for name in PREPARATION
    )
    for number, spec in enumerate(recipe.materials, 1):
        path, left = path_of(spec, names), dict(spec)
        preparation = {k: left.pop(k) for k in PREPARATION if k in left and not together}
        if preparation:
            suffix = "/" if path.endswith("/") else os.path.splitext(output)[1]
            lines.append(["weftex", "prepare", path, "-o", path := f"prepared{number}{suffix}"])
            for name, value in preparation.items():
                lines[-1] += MATERIAL[name].words(value)
        paths.append(path)
        specs.append(left)
    said = _material_words(recipe.task, specs, names)
    if said is None:
        return ""
    own = paths[:1] if recipe.task == "fill" else paths
    words = ["weftex", recipe.task, *own, "-o", output]
    words += ["--sample", *paths[1:]] if len(paths) > len(own) else []
    for name, option in TASKS[recipe.task].options.items():
        value = recipe.options[name]
        if name == "map" and isinstance(value, str):
            words += ["--map", names.get(value, value)]
        elif name == "map":
            words += ["--map", "gradient"]
            for part, given in value.items():
                words += GRADIENT[part].words(given)
        elif value != option.default:
            words += option.words(renamed(option, value, names))
    words += [*said, *SEED.words(recipe.seed)]
    if recipe.method.slug != TASKS[recipe.task].default_method:
        words += ["--method", recipe.method.slug]
    for name, value in recipe.parameters.items():
        text = ",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
        words.append(f"--{name.replace('_', '-')}={text}")
    lines.append(words)
    return " && ".join(shlex.join(line) for line in lines)


def _material_words(
    task: str, specs: Sequence[Mapping[str, Any]], names: Mapping[str, str]
) -> list[str] | None:
    """Return the options about materials; None if the command has none for something."""
    words: list[str] = []
    for name, option in MATERIAL.items():
        values: list[Any] = [spec.get(name) for spec in specs]
        if name == "maps" and "path" not in specs[0]:
            continue  # they are uploads, which lie in one folder
        asked = values[_meant(task, name)]
        if all(value is None for value in values):
            continue
        if name not in TASKS[task].material or any(value != asked[0] for value in asked):
            return None
        if values.count(None) < len(values) - len(asked):
            return None
        value = asked[0]
        words += option.words(renamed(option, value, names))
    return words
