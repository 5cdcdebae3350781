"""The Python that makes what a recipe makes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from weftex.recipe import Recipe
from weftex.recipe.command_line import path_of, renamed
from weftex.recipe.declared import TASKS
from weftex.recipe.opening import straighten_arguments
from weftex.registry import AUTO

__all__ = ["python_of"]

Names = Mapping[str, str]

_PACKAGE = "weftex"
#: Functions that are not at the top of weftex, and their modules.
_INNER = {"hole_of": "tasks.fill", "read_mask": "io.pictures", "read_material": "exemplar.material"}
#: Beside the picture, of a set of maps.
_MAPS = """\
for name, pixels in made.maps.items():
    suffix = "exr" if pixels.dtype.kind == "f" else "png"
    weftex.write_image(f"out_{name}.{suffix}", pixels)"""


def python_of(recipe: Recipe, output: str = "out.png", names: Names | None = None) -> str:
    """Return a script that makes the same; the arguments are those of `command_of`."""
    names = names or {}
    several = len(recipe.materials) > 1
    variables = [f"sample{k}" if several else "sample" for k, _ in enumerate(recipe.materials, 1)]
    lines: list[str] = []
    for variable, spec in zip(variables, recipe.materials, strict=True):
        lines += _load_lines(variable, spec, names)
        if recipe.task != "synth" and "turn" in spec:
            lines.append(f"{variable} = weftex.prepare.turned({variable}, {spec['turn']!r})")
    lines += _SCRIPTS[recipe.task](recipe, variables, names)
    suffix = os.path.splitext(output)[1] or ".png"
    stated = any({"sample_width", "density"} & one.keys() for one in recipe.materials)
    lines.append(f'{_PACKAGE}.write_image("out{suffix}", made.image, alpha=made.sample.alpha, '
                 f"icc=made.sample.icc{', density=density' * stated})")  # fmt: skip
    if output.endswith("/"):
        lines.append(_MAPS)
    imports = ["import weftex", ""]
    for name, module in _INNER.items():
        if any(f"{name}(" in line for line in lines):
            imports.insert(0, f"from weftex.{module} import {name}")
    return "\n".join([*imports, *lines]) + "\n"


def _load_lines(variable: str, spec: Mapping[str, Any], names: Names) -> list[str]:
    """Lines that load a material and do what its description says, but for turned copies."""
    how = f", files={spec['maps']!r}" if "path" in spec and "maps" in spec else ""
    how += ", tileable=True" if "repeats" in spec else ""
    lines = [f"{variable} = weftex.load_exemplar({path_of(spec, names)!r}{how})"]
    if "map_weights" in spec:
        lines.append(f"{variable} = {variable}.changed(weights={spec['map_weights']!r})")
    if "sample_width" in spec:
        lines.append(f"density = {variable}.shape[1] / {spec['sample_width']}")
    elif "density" in spec:
        lines.append(f"material = read_material({path_of(spec, names)!r}{how})")
        lines.append("density = material.pictures[material.main].density")
    if "mask" in spec:
        file = names.get(spec["mask"], spec["mask"])
        mask = f"~hole_of(None, {variable})" if file == "alpha" else f"read_mask({file!r})"
        lines.append(f"{variable} = {variable}.changed(mask={mask})")
    if "straighten" in spec:
        ways = straighten_arguments(spec["straighten"])
        own = "".join(f", {name}={text!r}" for name, text in ways.items())
        lines.append(f"{variable} = weftex.prepare.straighten({variable}{own})")
    if "even_light" in spec:
        lines.append(f"{variable} = weftex.prepare.even_light({variable}, {spec['even_light']})")
    if "density" in spec:
        times = f"{spec['density']} / density"
        lines.append(f"{variable} = weftex.prepare.scaled({variable}, {times})")
        lines.append(f"density = {spec['density']}")
    return lines


def _synth(recipe: Recipe, variables: list[str], names: Names) -> list[str]:
    options = dict(recipe.options)
    size, window = options.pop("size"), options.pop("window")
    lines = [f"size = {size!r}"]
    if size is None:
        lines = [f"size = [2 * side for side in {variables[0]}.shape]"]
    if options["guide"] is not None and size is None:
        guide = names.get(options["guide"], options["guide"])
        lines = [f"size = weftex.read_image({guide!r}).pixels.shape[:2]"]
    if len(variables) > 1:
        lines.append(f"sample = weftex.prepare.together([{', '.join(variables)}])")
    own = options.pop("sample_guide")
    if own is not None:
        own = names.get(own, own)
        lines.append(f"sample = sample.changed(guide=weftex.read_image({own!r}).pixels)")
    if "turn" in recipe.materials[0]:
        lines.append(f"sample = weftex.prepare.turned(sample, {recipe.materials[0]['turn']!r})")
    if window is None:
        return [*lines, _call(recipe, "synthesize", ["sample", "size"], options, names)]
    name = f"METHODS[{recipe.method.slug!r}]" if recipe.method.slug != AUTO else "Auto"
    method = f"{_PACKAGE}.{name}({_arguments(recipe.parameters)})"
    how = _arguments({"period": options["period"], "seed": recipe.seed})
    return [*lines[1:], f"made = {method}.fit(sample).window(*{window!r}, {how})"]


def _tile(recipe: Recipe, variables: list[str], names: Names) -> list[str]:
    return [_call(recipe, "tile", variables, recipe.options, names)]


def _fill(recipe: Recipe, variables: list[str], names: Names) -> list[str]:
    options = dict(recipe.options)
    mask = options.pop("mask")
    first = [variables[0]] + ([repr(names.get(mask, mask))] if mask != "alpha" else [])
    first += [f"sample={variables[1]}"] if len(variables) > 1 else []
    return [_call(recipe, "fill", first, options, names)]


def _fuse(recipe: Recipe, variables: list[str], names: Names) -> list[str]:
    options = dict(recipe.options)
    given, size = options.pop("map"), options.pop("size")
    if isinstance(given, str):
        label_map = repr(names.get(given, given))
    else:
        label_map = f"{_PACKAGE}.label_maps.Gradient({_arguments(given)})"
    first = [f"[{', '.join(variables)}]", label_map, repr(size)]
    return [_call(recipe, "fuse", first, options, names)]


_SCRIPTS = {"synth": _synth, "tile": _tile, "fill": _fill, "fuse": _fuse}


def _call(
    recipe: Recipe, task: str, first: list[str], options: Mapping[str, Any], names: Names
) -> str:
    """The call of a task, with all options that have not their defaults."""
    declared = TASKS[recipe.task].options
    how = {
        name: renamed(declared[name], value, names)
        for name, value in options.items()
        if value != declared[name].default
    }
    if recipe.method.slug != TASKS[recipe.task].default_method:
        how["method"] = recipe.method.slug
    how |= {"seed": recipe.seed, **recipe.parameters}
    return f"made = weftex.{task}({', '.join(first)}, {_arguments(how)})"


def _arguments(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in values.items() if value is not None)
