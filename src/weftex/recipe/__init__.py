"""Tasks, their options, and recipes of jobs.

A `Recipe` is all that a result depends on. It is read from JSON, where everything is checked, and
written as JSON, as a command, or as Python; all of them make the same bytes.

>>> from weftex.recipe import MATERIAL, TASKS, Recipe
>>> from weftex.recipe.command_line import command_of
>>> recipe = Recipe.from_json({"materials": [{"sample": "bricks", "turn": "flip"}],
...     "size": [60, 80], "method": "quilting", "parameters": {"patch_size": 24}, "seed": 7})
>>> command_of(recipe)
'weftex synth sample:bricks -o out.png --size 80x60 --turn flip --seed 7 --method quilting \
--patch-size=24'
>>> Recipe.from_json(recipe.as_json()) == recipe
True

`TASKS` has the options of each task, `MATERIAL` what is done to materials before; each `Option`
knows its help, default and range, and how its value is read, checked and written. Parameters of
methods are declared by the methods, and checked by them.

`open_recipe` reads the materials; then the size of the result is known, and it can be made:

>>> from weftex.recipe.opening import open_recipe
>>> job = open_recipe(recipe)
>>> job.shape, list(job.pictures)
((60, 80), ['color'])
>>> job.make().image.shape
(60, 80, 3)

Images have names: paths on the command line, ids of uploads in the studio. `open_recipe` takes
`open_picture` to read images that are no files, and `open_material` to reuse materials.

Who works on this machine may also name paths and windows: `Recipe.from_json(..., local=True)`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Self

from weftex.canvas import as_canvas
from weftex.errors import InvalidInputError, did_you_mean, shown, wrong_value
from weftex.io.pictures import sample_path
from weftex.method import Method
from weftex.naming import make_method
from weftex.recipe.declared import (
    ATLAS,
    CROP,
    GRADIENT,
    LANDMARKS,
    MATERIAL,
    PAD,
    PREPARATION,
    SEED,
    TASKS,
)
from weftex.recipe.options import PICTURE, plain
from weftex.registry import AUTO, method_class

__all__ = [
    "ATLAS",
    "CROP",
    "FIELDS",
    "GRADIENT",
    "LANDMARKS",
    "MATERIAL",
    "PAD",
    "PREPARATION",
    "SEED",
    "TASKS",
    "Recipe",
    "checked_material",
    "pictures_of",
]

_ALL = ("task", "materials", "seed", "method", "parameters")
#: Every field of a recipe, of a material and of a gradient.
FIELDS = frozenset({*_ALL, "sample", "path", "name", *MATERIAL, *GRADIENT}.union(
    *(task.options for task in TASKS.values())
))  # fmt: skip
#: Options that windows of an endless texture do not take.
_NOT_WITH_WINDOW = ("guide", "sample_guide", "tileable", "fit", "best_of", "landmarks")
#: The most materials of a recipe that is not local, and the most results it makes to keep one.
_MOST_MATERIALS, _MOST_OF_BEST = 8, 16


@dataclass(frozen=True)
class Recipe:
    """What to make: all that a result depends on."""

    task: str  # one of `TASKS`
    materials: tuple[dict[str, Any], ...]  # what it is made from, see `checked_material`
    seed: int
    method: Method  # or "auto", which chooses one
    parameters: dict[str, Any]  # those of the method that were given
    options: dict[str, Any]  # all other options of the task

    @classmethod
    def from_json(cls, given: Any, *, local: bool = False) -> Self:
        """Return a checked recipe; None is as if the field was left out, and a seed is drawn.

        If `local`, materials may be paths, and errors name options of the command line.
        """
        if not isinstance(given, Mapping):
            raise wrong_value("recipe", given, "an object")
        task = given.get("task", "synth")
        if not isinstance(task, str) or task not in TASKS:
            raise InvalidInputError(f"task is {shown(task)}{did_you_mean(str(task), TASKS)}")
        declared = TASKS[task].options
        known = [*_ALL, *(name for name, one in declared.items() if local or not one.local)]
        for name in given:
            if name not in known:
                near = did_you_mean(str(name), known)
                raise InvalidInputError(f"{task} has no {shown(name)}{near}")
        materials = _materials(task, given.get("materials"), local)
        seed = given.get("seed")
        if seed is None:
            seed = int.from_bytes(os.urandom(4), "little")  # short enough to be typed again
        seed = SEED.checked(seed, SEED.flag if local else "")
        options = {name: option.default for name, option in declared.items()}
        for name, option in declared.items():
            if given.get(name) is not None:
                options[name] = option.checked(given[name], option.flag if local else "")
        method, parameters = _method(task, given.get("method"), given.get("parameters"), options)
        recipe = cls(task, materials, seed, method, parameters, options)
        recipe._check(local)
        return recipe

    def as_json(self) -> dict[str, Any]:
        """Return the object that `from_json` reads, without fields that have their defaults."""
        declared = TASKS[self.task].options
        found: dict[str, Any] = {"task": self.task, "materials": self.materials}
        found |= {k: v for k, v in self.options.items() if v != declared[k].default}
        found |= {"method": self.method.slug, "parameters": self.parameters, "seed": self.seed}
        return {name: plain(value) for name, value in found.items()}

    def changed(self, **fields: Any) -> Self:
        """Return the same but for some fields, as JSON has them."""
        declared = TASKS[self.task].options
        given = [v is not None for k, v in self.options.items() if declared[k].local]
        local = any("path" in spec for spec in self.materials) or any(given)
        return type(self).from_json({**self.as_json(), **fields}, local=local)

    @property
    def pictures(self) -> list[str]:
        """The names of all pictures that it needs, but for paths of materials."""
        found = [name for spec in self.materials for name in pictures_of(spec)]
        declared = TASKS[self.task].options
        own = [v for k, v in self.options.items() if declared[k].kind is PICTURE or k == "map"]
        return found + [name for name in own if isinstance(name, str) and name != "alpha"]

    def _check(self, local: bool) -> None:
        """Refuse options that exclude each other, or have no effect."""
        options, declared = self.options, TASKS[self.task].options

        def named(name: str) -> str:
            option = declared.get(name) or MATERIAL[name]
            return option.flag if local else name

        if self.task == "synth":
            if options["window"] is not None:
                for name in (*_NOT_WITH_WINDOW, "size"):
                    if options[name] != declared[name].default:
                        raise InvalidInputError(f"give {named(name)} or --window, not both")
            elif options["period"] is not None:
                raise InvalidInputError("--period has no effect without --window; try --tileable")
            if options["fit"] and options["tileable"] is False:
                raise InvalidInputError(f"{named('fit')} has no effect without {named('tileable')}")
            if options["fit"] and options["guide"] is not None:
                raise InvalidInputError(f"give {named('fit')} or {named('guide')}, not both")
            if len(self.materials) > 1:
                self._check_several(named)
            if options["landmarks"] not in ("auto", "keep") and "turn" in self.materials[0]:
                raise InvalidInputError(f"give {named('landmarks')} or {named('turn')}, not both")
            if options["sample_guide"] is not None and options["guide"] is None:
                raise InvalidInputError(f"{named('sample_guide')} has no effect without a guide")
            count = options["best_of"]
            if not local and count > _MOST_OF_BEST:
                raise InvalidInputError(f"best_of is {count}; it must be from 1 to {_MOST_OF_BEST}")
        elif self.task == "fuse":
            self._check_map(named)
        elif any("turn" in spec for spec in self.materials[:1]):
            raise InvalidInputError(f"turn has no effect on the photo of {self.task}")

    def _check_several(self, named: Callable[[str], str]) -> None:
        """Refuse what can be said of one material only."""
        given = {name for spec in self.materials for name in spec}
        alone: list[str] = [n for n in ("map_weights", "mask", "repeats") if n in given]
        if {"path", "maps"} <= given:
            alone.append("maps")
        if self.options["landmarks"] not in ("auto", "keep"):
            alone.append("landmarks")
        if self.options["sample_guide"] is not None:
            alone.append("sample_guide")
        if alone:
            raise InvalidInputError(f"{named(alone[0])} needs one sample, not several")
        if len({spec.get("turn") for spec in self.materials}) > 1:
            raise InvalidInputError("turn must be the same for all materials of one sample")

    def _check_map(self, named: Callable[[str], str]) -> None:
        given, options = self.options["map"], self.options
        if given is None:
            raise InvalidInputError("the label map is missing; it must be an image or a gradient")
        if isinstance(given, str):
            if options["mixed"] and options["colors"] is None:
                raise InvalidInputError(f"{named('mixed')} needs {named('colors')} beside it")
            return
        gradient(given)
        if options["size"] is None:
            raise InvalidInputError(f"{named('size')} is missing; a gradient needs one")
        for name in ("colors", "mixed"):
            if options[name] is not None:
                raise InvalidInputError(f"{named(name)} has no effect: a gradient has no colors")


def gradient(given: Mapping[str, Any]) -> Any:
    """Return the `weftex.label_maps.Gradient` of a recipe's map."""
    from weftex.label_maps import Gradient

    for name in given:
        if name not in GRADIENT:
            raise InvalidInputError(f"map has {shown(name)}{did_you_mean(str(name), GRADIENT)}")
    return Gradient(**given)


def checked_material(given: Any, *, local: bool = False) -> dict[str, Any]:
    """Return a checked description of a material: its source and options of `MATERIAL`.

    The source is "sample", the name of a bundled one; or "maps", images by role, and
    "name"; or, if `local`, "path" of a file, or of a folder with "maps", its files.
    """
    if not isinstance(given, Mapping):
        raise InvalidInputError(f"materials has {shown(given)}; it must be a description")
    spec = {k: v for k, v in given.items() if v is not None and v is not False}
    sources = ("sample", "maps", "path", "name") if local else ("sample", "maps", "name")
    for name in spec:
        if name not in sources and name not in MATERIAL:
            raise InvalidInputError(f"materials has {shown(name)}, which is not known")
    places = [name for name in ("sample", "path", "maps") if name in spec]
    if places not in (["sample"], ["path"], ["maps"], ["path", "maps"]):
        raise InvalidInputError("materials must have a sample or maps, and not both")
    if "name" in spec and "sample" in spec:
        raise InvalidInputError("name has no effect on a sample")
    for name in ("sample", "path", "name"):
        if name in spec and not isinstance(spec[name], str):
            raise wrong_value(name, spec[name], "a string")
    if "sample" in spec:
        spec["sample"] = spec["sample"].removeprefix("sample:")
        sample_path(spec["sample"])
    for name, option in MATERIAL.items():
        if name in spec:
            spec[name] = option.checked(spec[name], option.flag if local else "")
    return spec


def pictures_of(spec: Mapping[str, Any]) -> list[str]:
    """Return the names of the pictures that a material needs, but for those of a path."""
    mask, maps = spec.get("mask"), {} if "path" in spec else spec.get("maps", {})
    return [*maps.values(), *([mask] if mask not in (None, "alpha") else [])]


def _materials(task: str, given: Any, local: bool) -> tuple[dict[str, Any], ...]:
    least = TASKS[task].least
    most = TASKS[task].most if local else min(TASKS[task].most, _MOST_MATERIALS)
    if not isinstance(given, (list, tuple)) or not least <= len(given) <= most:
        many = str(least) if least == most else f"{least} to {most}"
        got = len(given) if isinstance(given, (list, tuple)) else shown(given)
        raise InvalidInputError(f"{task} takes {many} materials, not {got}")
    return tuple(checked_material(one, local=local) for one in given)


def _method(
    task: str, name: Any, given: Any, options: Mapping[str, Any]
) -> tuple[Method, dict[str, Any]]:
    """Return the method of a task, and those of its parameters that were given."""
    task_declared = TASKS[task]
    name = task_declared.default_method if name is None else name
    if not isinstance(name, str):
        raise wrong_value("method", name, "a name")
    if not isinstance(given or {}, Mapping):
        raise wrong_value("parameters", given, "an object")
    own = {key: value for key, value in (given or {}).items() if value is not None}
    if name == AUTO and task != "synth" and (own or task_declared.default_method != AUTO):
        name = task_declared.parameter_method
        if "effort" in own:
            raise InvalidInputError(f"effort has no effect on {task}")
    belts: Iterable[str] = ()
    if task == "fuse" and options["boundary"] == "merged":
        from weftex.tasks.fuse import split_parameters

        belts = method_class(name).belt_parameters & own.keys()
        canvas = as_canvas(1, options["tileable"])
        method, alone = split_parameters(make_method(name, {}), own, canvas)
        method.for_belt(method.window_for(1), **alone)  # refuses what belts do not take
    else:
        method = make_method(name, own)
    return method, {k: own[k] if k in belts else getattr(method, k) for k in own}
