"""The reverse of packing: the files of a preset as a set of maps."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.io.formats import show
from weftex.io.packed import reversed_map
from weftex.io.pictures import Picture, read_image
from weftex.io.presets import UNUSED, Preset, PresetFile, width_of

#: What maps become, so that a set comes back as it was.
_BACK = {"gloss": "roughness", "normal_dx": "normal_gl"}


def unpack_set(
    preset: Preset, paths: Mapping[str, str], **limits: Any
) -> tuple[dict[str, Picture], list[str]]:
    """Read the files of a preset; return the maps by role, and notes.

    `paths` are by file name without suffix, `limits` those of `weftex.read_image`. Smoothness
    becomes roughness, and normals point up.
    """
    if preset.others:
        raise InvalidInputError(
            f"preset {preset.name} only renames maps; weftex reads such folders as they are"
        )
    found, notes = _recognized(preset, paths)
    maps = {}
    for file, path in found.items():
        for role, picture in _parts(file, path, read_image(path, **limits)).items():
            back = _BACK.get(role, role)
            if back != role:
                picture = replace(picture, pixels=reversed_map(picture.pixels, back))
            maps[back] = picture
    return maps, notes


def _parts(file: PresetFile, path: str, picture: Picture) -> dict[str, Picture]:
    """Return the map of each role in a file."""
    pixels = np.atleast_3d(picture.pixels)
    count, whole = pixels.shape[2], sum(map(width_of, file.roles))
    if len(file.roles) == 1 or (file.optional and len(file.roles) == 2 and count < whole):
        return {file.roles[0]: picture}
    if count not in (whole, whole - file.optional):
        raise InvalidInputError(
            f"{show(path)} has {count} channels, and {file.name} has {whole} "
            f"({', '.join(file.roles)})"
        )
    parts, start = {}, 0
    for role in file.roles:
        end = start + width_of(role)
        if role != UNUSED and end <= count:
            one = pixels[..., start] if end == start + 1 else pixels[..., start:end]
            icc = picture.icc if role == "color" else None
            parts[role] = replace(picture, pixels=np.ascontiguousarray(one), alpha=False, icc=icc)
        start = end
    return parts


def _recognized(
    preset: Preset, paths: Mapping[str, str]
) -> tuple[dict[PresetFile, str], list[str]]:
    """Return the path of each file of a preset that is there, and notes about other pictures."""
    found: dict[PresetFile, str] = {}
    names, notes = set(), []
    for stem, path in paths.items():
        fitting = []
        for file in preset.files:
            before, after = map(re.escape, file.name.split("{name}"))
            if fit := re.fullmatch(f"{before}(.+){after}", stem):
                fitting.append((len(file.name), fit[1], file))
        if not fitting:
            notes.append(f"{show(os.path.basename(path))} is ignored: no file of {preset.name}")
            continue
        _, name, file = max(fitting, key=lambda one: one[0])
        names.add(name)
        found[file] = path
    if not found:
        wanted = ", ".join(file.name for file in preset.files)
        raise InvalidInputError(f"preset {preset.name} has files named {wanted}; none is there")
    if len(names) > 1:
        raise InvalidInputError(
            f"the files are of several sets ({', '.join(sorted(names))}); name those of one"
        )
    return found, notes
