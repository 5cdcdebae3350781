"""Recipes: all that a result hangs on, as JSON. The same recipe makes the same bytes."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import weftex
from weftex.canvas import as_canvas
from weftex.errors import InvalidInputError, did_you_mean, shown
from weftex.studio import materials
from weftex.studio.materials import id_of
from weftex.tasks.method_names import AUTO, make_method

if TYPE_CHECKING:
    from weftex import Method

#: What each task takes beside `_ALL`, and what stands for a field that is left out.
TASKS: dict[str, dict[str, Any]] = {
    "synth": {"size": None, "tileable": False, "guide": None, "sample_guide": None, "best_of": 1},
    "tile": {"axes": True, "border": None},
    "fill": {"mask": "alpha", "overlap": 0, "match_tone": None, "tileable": False},
    "fuse": {
        "map": None, "colors": None, "size": None, "boundary": "cut", "belt_width": None,
        "missing": None, "tileable": False,
    },
}  # fmt: skip
_ALL: dict[str, Any] = {
    "task": "synth",
    "materials": [],
    "seed": None,
    "method": None,
    "parameters": {},
}
#: Every field of a recipe.
FIELDS = frozenset(_ALL) | {name for fields in TASKS.values() for name in fields}
#: The methods where none is named.
_USUAL = {"synth": AUTO, "tile": AUTO, "fill": AUTO, "fuse": "refinement"}
#: How many materials there may be.
_COUNTS = {"synth": (1, 8), "tile": (1, 1), "fill": (1, 2), "fuse": (2, 8)}
#: What a gradient takes.
GRADIENT = ("direction", "center", "radii", "width", "circles")


@dataclass(frozen=True)
class Recipe:
    """What to make."""

    task: str  # one of `TASKS`
    materials: tuple[dict[str, Any], ...]  # descriptions, see `weftex.studio.materials`
    seed: int
    method: Method  # with its parameters
    options: dict[str, Any]  # the other fields of the task, with values for all of them

    @classmethod
    def of(cls, given: Any) -> Recipe:
        """Read what a page sent; a seed that is left out is drawn."""
        if not isinstance(given, Mapping):
            raise InvalidInputError(f"recipe is {shown(given)}; it must be an object")
        task = given.get("task", "synth")
        if not isinstance(task, str) or task not in TASKS:
            raise InvalidInputError(f"task is {shown(task)}{did_you_mean(str(task), TASKS)}")
        known = {**_ALL, **TASKS[task]}
        for name in given:
            if name not in known:
                raise InvalidInputError(
                    f"{task} has no {shown(name)}{did_you_mean(str(name), known)}"
                )
        options = {name: given.get(name, usual) for name, usual in TASKS[task].items()}
        for name, usual in TASKS[task].items():
            if options[name] is None:
                options[name] = usual
        recipe = cls(
            task=task,
            materials=_materials(task, given.get("materials")),
            seed=_seed(given.get("seed")),
            method=_method(task, given.get("method"), given.get("parameters")),
            options=options,
        )
        recipe._check()
        return recipe

    def _check(self) -> None:
        """Refuse what would be a path elsewhere, and what is no size."""
        options = self.options
        size = options.get("size")
        if size is not None:
            good = isinstance(size, (list, tuple)) and len(size) == 2
            if not good or not all(type(side) is int and side > 0 for side in size):
                raise InvalidInputError(f"size is {shown(size)}; it must be [height, width]")
            options["size"] = tuple(size)
        for name in ("guide", "sample_guide", "mask"):
            if not isinstance(options.get(name, ""), (str, type(None))):
                raise InvalidInputError(f"{name} is {shown(options[name])}; it must be an upload")
        as_canvas(1, options.get("tileable", False))
        if (
            self.task in ("tile", "fill")
            and self.method != weftex.Auto()
            and self.method.slug == AUTO
        ):
            raise InvalidInputError(f"effort has no effect on {self.task}")
        if self.task == "fuse":
            _check_map(options["map"])
        count = options.get("best_of", 1)
        if type(count) is not int or not 1 <= count <= 16:
            raise InvalidInputError(f"best_of is {shown(count)}; it must be from 1 to 16")
        if self.task == "tile" and options["axes"] not in (True, "x", "y"):
            raise InvalidInputError(
                f"axes is {shown(options['axes'])}; it must be true, 'x' or 'y'"
            )

    def as_json(self) -> dict[str, Any]:
        """Return what is shared: no field that has its usual value."""
        asked = self.method.describe()
        usual = {field.name: field.default for field in dataclasses.fields(self.method)}
        parameters = {k: _as_list(v) for k, v in asked.items() if k != "method" and v != usual[k]}
        found: dict[str, Any] = {"task": self.task, "materials": list(self.materials)}
        found |= {k: v for k, v in self.options.items() if v != TASKS[self.task][k]}
        found |= {"method": self.method.slug, "parameters": parameters, "seed": self.seed}
        return {name: _as_list(value) for name, value in found.items()}

    def changed(self, **fields: Any) -> Recipe:
        """Return the same but for some fields."""
        return Recipe.of({**self.as_json(), **fields})

    @property
    def id(self) -> str:
        """What its result is known by: the same for the same recipe."""
        return id_of(self.as_json())

    @property
    def uploads(self) -> list[str]:
        """The uploads that it needs."""
        found = [name for spec in self.materials for name in materials.uploads_of(spec)]
        own = [self.options.get(name) for name in ("guide", "sample_guide", "mask", "map")]
        return found + [name for name in own if isinstance(name, str) and name != "alpha"]


def _as_list(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _materials(task: str, given: Any) -> tuple[dict[str, Any], ...]:
    low, high = _COUNTS[task]
    if not isinstance(given, (list, tuple)) or not low <= len(given) <= high:
        many = str(low) if low == high else f"{low} to {high}"
        raise InvalidInputError(f"materials is {shown(given)}; {task} takes {many} of them")
    return tuple(materials.checked(one) for one in given)


def _seed(given: Any) -> int:
    if given is None:
        return int.from_bytes(os.urandom(4), "little")
    if type(given) is not int or not 0 <= given < 2**64:
        raise InvalidInputError(f"seed is {shown(given)}; it must be from 0 to 2**64 - 1")
    return given


def _method(task: str, name: Any, parameters: Any) -> Method:
    name = _USUAL[task] if name is None else name
    if not isinstance(name, str):
        raise InvalidInputError(f"method is {shown(name)}; it must be a name")
    if not isinstance(parameters or {}, Mapping):
        raise InvalidInputError(f"parameters is {shown(parameters)}; it must be an object")
    own = {key: value for key, value in (parameters or {}).items() if value is not None}
    if task == "fuse" and name == AUTO:
        name = _USUAL[task]
    return make_method(name, own)


def _check_map(given: Any) -> None:
    """The map of a fusion is an upload, or what a gradient takes."""
    if isinstance(given, str):
        return
    if not isinstance(given, Mapping):
        raise InvalidInputError(f"map is {shown(given)}; it must be an upload or a gradient")
    for name in given:
        if name not in GRADIENT:
            raise InvalidInputError(f"map has {shown(name)}{did_you_mean(str(name), GRADIENT)}")
    weftex.Gradient(**fields_of_gradient(given))


def fields_of_gradient(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return what `weftex.Gradient` takes: JSON has lists for tuples."""
    return {name: tuple(v) if isinstance(v, list) else v for name, v in given.items()}
