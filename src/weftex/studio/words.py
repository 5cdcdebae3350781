"""The command line and the Python that make the same bytes as a recipe."""

from __future__ import annotations

import dataclasses
import os
import shlex
from typing import TYPE_CHECKING, Any

from weftex.studio.materials import ways_to_straighten
from weftex.studio.recipes import GRADIENT, fields_of_gradient

if TYPE_CHECKING:
    from collections.abc import Mapping

    from weftex import Method
    from weftex.studio.making import Made
    from weftex.studio.recipes import Recipe

    Names = Mapping[str, str]

_PACKAGE = "weftex"


def path_of(spec: Mapping[str, Any], names: Names) -> str:
    """Return what a material is called where files have their names: a set is a folder."""
    if "sample" in spec:
        return f"sample:{spec['sample']}"
    if len(spec["maps"]) == 1:
        return names[next(iter(spec["maps"].values()))]
    return f"{spec.get('name') or 'material'}/"


def output_of(made: Made) -> str:
    """Return what is written: a folder for a set."""
    folder = any(material.folder for material in made.materials)
    like = next(iter(made.pictures.values()))
    return "out/" if folder else "out.exr" if like.pixels.dtype.kind == "f" else "out.png"


def command_of(made: Made, names: Names) -> str | None:
    """Return the commands that make the same; None if the command line cannot say it."""
    recipe = made.recipe
    lines: list[list[str]] = []
    paths = []
    for number, spec in enumerate(recipe.materials, 1):
        path = path_of(spec, names)
        mending = _mending(spec)
        if mending and recipe.task != "synth":  # which alone takes these options itself
            prepared = f"prepared{number}" + (
                "/" if path.endswith("/") else os.path.splitext(output_of(made))[1]
            )
            lines.append(["weftex", "prepare", path, "-o", prepared, *mending])
            path = prepared
        paths.append(path)
        if not _said(recipe, spec, number):
            return None
    words = ["weftex", recipe.task, *(paths if recipe.task != "fill" else paths[:1])]
    words += ["-o", output_of(made), *_options(recipe, paths, names), "--seed", str(recipe.seed)]
    lines.append(words + _parameters(recipe.method, recipe.task))
    return " && ".join(shlex.join(line) for line in lines)


def _said(recipe: Recipe, spec: Mapping[str, Any], number: int) -> bool:
    """Whether the command has options for what is done to a material."""
    own = {"synth": {"mask", "turn", "repeats", "map_weights"}, "tile": {"map_weights"}}
    able = own.get(recipe.task, {"map_weights"} if recipe.task == "fill" and number == 1 else set())
    able |= {"repeats"} if recipe.task == "fill" and number == 2 else set()
    return not {"mask", "turn", "repeats", "map_weights"} & set(spec) - able


def _mending(spec: Mapping[str, Any]) -> list[str]:
    words = []
    if "straighten" in spec:
        words.append("--straighten" + (f"={spec['straighten']}" if spec["straighten"] else ""))
    if "even_light" in spec:
        words += ["--even-light", str(spec["even_light"])]
    return words


def _options(recipe: Recipe, paths: list[str], names: Names) -> list[str]:
    options, spec, words = recipe.options, recipe.materials[0], list[str]()
    if options.get("size") is not None and not (
        recipe.task == "fuse" and isinstance(options["map"], str)
    ):
        height, width = options["size"]
        words += ["--size", f"{width}x{height}" if width != height else str(width)]
    axes = options.get("axes", options.get("tileable", False))
    if axes and (recipe.task != "tile" or axes is not True):
        words += ["--tileable"] + ([axes] if axes is not True else [])
    for name in ("guide", "sample_guide"):
        if options.get(name) is not None:
            words += [f"--{name.replace('_', '-')}", names[options[name]]]
    if options.get("mask", "alpha") != "alpha":
        words += ["--mask", names[options["mask"]]]
    if len(paths) > 1 and recipe.task == "fill":
        words += ["--sample", paths[1]]
        words += ["--tileable-sample"] if "repeats" in recipe.materials[1] else []
    if options.get("match_tone") is not None:
        words.append("--match-tone" if options["match_tone"] else "--no-match-tone")
    for name in ("border", "overlap", "best_of", "boundary", "belt_width"):
        usual = {"overlap": 0, "best_of": 1, "boundary": "cut"}.get(name)
        if options.get(name) not in (None, usual):
            words += [f"--{name.replace('_', '-')}", str(options[name])]
    if recipe.task == "fuse":
        words += _map_words(options, names)
    if recipe.task == "synth":
        words += _mending(spec)
        words += ["--tileable-sample"] if "repeats" in spec else []
        words += ["--turn", spec["turn"]] if "turn" in spec else []
    if "mask" in spec and recipe.task == "synth":
        words += ["--sample-mask", "alpha" if spec["mask"] == "alpha" else names[spec["mask"]]]
    if "map_weights" in spec:
        words += ["--map-weights", ",".join(f"{k}={v:g}" for k, v in spec["map_weights"].items())]
    return words


def _map_words(options: Mapping[str, Any], names: Names) -> list[str]:
    given = options["map"]
    if isinstance(given, str):
        words = ["--map", names[given]]
        if options["colors"] is not None:
            words += ["--colors", ",".join(_color(color) for color in options["colors"])]
    else:
        words = ["--map", "gradient"]
        for name in GRADIENT:
            if name in given:
                values = given[name] if isinstance(given[name], (list, tuple)) else [given[name]]
                values = values[::-1] if name == "center" else values
                words.append(f"--{name}={','.join(str(value) for value in values)}")
    if options["missing"]:
        words += ["--missing", ",".join(f"{k}={v}" for k, v in options["missing"].items())]
    return words


def _color(color: Any) -> str:
    if isinstance(color, (list, tuple)):
        return "#" + bytes(color).hex() if len(color) == 3 else str(color[0])
    return str(color)


def _parameters(method: Method, task: str) -> list[str]:
    """The method's name, if it is not the usual one, and its parameters."""
    usual = "refinement" if task == "fuse" else "auto"
    words = [] if method.slug == usual else ["--method", method.slug]
    for field in dataclasses.fields(method):
        name, value = field.name, getattr(method, field.name)
        if value != field.default:
            text = ",".join(map(str, value)) if field.metadata["count"] else str(value)
            words.append(f"--{name.replace('_', '-')}={text}")
    return words


def python_of(made: Made, names: Names) -> str:
    """Return a script that makes the same."""
    recipe, options = made.recipe, made.recipe.options
    lines = ["import weftex", ""]
    inner: list[str] = []
    variables = []
    for number, spec in enumerate(recipe.materials, 1):
        variable = "sample" if len(recipe.materials) == 1 else f"sample{number}"
        variables.append(variable)
        lines += _load_lines(variable, spec, names, inner)
    how: dict[str, str] = {}
    for name in ("guide", "sample_guide"):
        if options.get(name) is not None:
            how[name] = repr(names[options[name]])
    for name in ("tileable", "axes", "border", "overlap", "match_tone", "best_of", "boundary",
                 "belt_width", "missing"):  # fmt: skip
        usual = {"overlap": 0, "best_of": 1, "boundary": "cut", "tileable": False, "axes": True}
        if name in options and options[name] != usual.get(name):
            how[name] = repr(options[name])
    asked = recipe.as_json()
    if asked["method"] != ("refinement" if recipe.task == "fuse" else "auto"):
        how["method"] = repr(asked["method"])
    how["seed"] = str(recipe.seed)
    if asked["method"] == "auto" and asked["parameters"]:
        arguments = ", ".join(f"{k}={v!r}" for k, v in asked["parameters"].items())
        how["method"] = f"{_PACKAGE}.Auto({arguments})"
    else:
        how |= {k: repr(v) for k, v in asked["parameters"].items()}
    first = variables[0]
    if recipe.task == "synth":
        if len(variables) > 1:
            first = f"{_PACKAGE}.together([{', '.join(variables)}])"
        call = [f"{_PACKAGE}.synthesize", first, repr(options["size"])]
    elif recipe.task == "tile":
        call = [f"{_PACKAGE}.tile", first]
    elif recipe.task == "fill":
        call = [f"{_PACKAGE}.fill", first]
        call += [repr(names[options["mask"]])] if options["mask"] != "alpha" else []
        how |= {"sample": variables[1]} if len(variables) > 1 else {}
    else:
        call = [f"{_PACKAGE}.fuse", f"[{', '.join(variables)}]", _map_python(options, names)]
        if not isinstance(options["map"], str):
            call.append(repr(options["size"]))
        if options["colors"] is not None:
            how["colors"] = repr(
                [tuple(c) if isinstance(c, list) else c for c in options["colors"]]
            )
    arguments = ", ".join([*call[1:], *(f"{name}={value}" for name, value in how.items())])
    lines += [f"made = {call[0]}({arguments})"]
    suffix = os.path.splitext(output_of(made))[1] or ".png"
    lines += [f'{_PACKAGE}.write_image("out{suffix}", made.image{_alpha(made)})']
    if len(made.pictures) > 1:
        lines += [
            "for name, pixels in made.maps.items():",
            '    suffix = "exr" if pixels.dtype.kind == "f" else "png"',
            '    weftex.write_image(f"out_{name}.{suffix}", pixels)',
        ]
    return "\n".join([*inner, *lines]) + "\n"


def _alpha(made: Made) -> str:
    return ", alpha=True" if made.pictures[made.main].alpha else ""


def _load_lines(
    variable: str, spec: Mapping[str, Any], names: Names, imports: list[str]
) -> list[str]:
    """Lines that load a material and mend it."""
    options = ", tileable=True" if "repeats" in spec else ""
    lines = [f"{variable} = weftex.load_exemplar({path_of(spec, names)!r}{options})"]
    if "map_weights" in spec:
        lines.append(f"{variable} = {variable}.changed(weights={spec['map_weights']!r})")
    if "mask" in spec:
        if spec["mask"] == "alpha":
            imports.append("from weftex.tasks.fill import hole_of")
            mask = f"~hole_of(None, {variable})"
        else:
            imports.append("from weftex.io.pictures import read_mask")
            mask = f"read_mask({names[spec['mask']]!r})"
        lines.append(f"{variable} = {variable}.changed(mask={mask})")
    if "straighten" in spec:
        ways = ways_to_straighten(spec["straighten"])
        how = "".join(f", {name}={text!r}" for name, text in ways.items())
        lines.append(f"{variable} = weftex.straighten({variable}{how})")
    if "even_light" in spec:
        lines.append(f"{variable} = weftex.even_light({variable}, {spec['even_light']})")
    if "turn" in spec:
        lines.append(f"{variable} = weftex.turned({variable}, {spec['turn']!r})")
    return lines


def _map_python(options: Mapping[str, Any], names: Names) -> str:
    given = options["map"]
    if isinstance(given, str):
        return repr(names[given])
    values = fields_of_gradient(given)
    return f"{_PACKAGE}.Gradient({', '.join(f'{k}={v!r}' for k, v in values.items())})"
