"""Map sets as the files of a preset and back: what goes into which channel, what is converted."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError
from weftex.io.formats import FORMATS, StrPath, show, written_as
from weftex.io.outputs import OutputFile, OutputSet, Part, kept_file, reversed_map
from weftex.io.pictures import Picture, atomic, read_image
from weftex.io.presets import Preset, PresetFile, read_preset
from weftex.raster.arrays import check_pixels
from weftex.raster.mixing import Kind, mixing_of
from weftex.roles import ROLES, UNUSED, Role, as_role, width_of

Pixels = NDArray[Any]

__all__ = ["write_preset"]

#: Maps that a role can be made from, and whether their values or y axis are reversed for it.
_MADE_FROM = {
    "gloss": {"roughness": True},
    "roughness": {"gloss": True},
    "normal_gl": {"normal_dx": True, "normal": False},
    "normal_dx": {"normal_gl": True, "normal": True},
}
#: What maps become, so that a set comes back as it was.
_BACK = {"gloss": "roughness", "normal_dx": "normal_gl"}
_SLACK = 1e-3  # that floats may lie outside 0 to 1


def pack_set(
    preset: Preset,
    folder: str,
    name: str,
    pictures: Mapping[str, Picture],
    roles: Mapping[str, Role],
) -> OutputSet:
    """Plan the files of a preset for a set of maps; `pictures` and `roles` are by map name.

    Raises `InvalidInputError` for maps whose sizes, channels or values do not fit.
    """
    if preset.others:
        kept = [
            kept_file(preset.stem(name, roles[key]), key, one, roles[key].name)
            for key, one in pictures.items()
        ]
        return OutputSet(folder, pictures, tuple(kept), (), name)
    packer = _Packer(preset, name, pictures, roles)
    files = [made for one in preset.files if (made := packer.file(one)) is not None]
    if not files:
        wanted = ", ".join(role for role in packer.listed if role != UNUSED)
        raise InvalidInputError(
            f"preset {preset.name} needs one of {wanted}, but {name} has only {packer.have}"
        )
    for key, role in roles.items():
        used = packer.used.get(key, set())
        left = [one for one in role.channels if one not in used and one != UNUSED]
        if not used or left:
            what = f"{', '.join(left)} of {key}" if used else key
            packer.notes.append(f"{what} is left out: preset {preset.name} has no file for it")
    return OutputSet(folder, pictures, tuple(files), tuple(packer.notes), name, preset.material)


class _Packer:
    """Plans the files of a set one by one; notes what is worth saying."""

    def __init__(
        self, preset: Preset, name: str, pictures: Mapping[str, Picture], roles: Mapping[str, Role]
    ) -> None:
        self.preset, self.name, self.pictures, self.roles = preset, name, pictures, roles
        self.notes: list[str] = []
        self.used: dict[str, set[str]] = {}  # roles by maps
        self.listed = dict.fromkeys(role for one in preset.files for role in one.roles)
        self.have = ", ".join(role.name for role in roles.values())

    def file(self, wanted: PresetFile) -> OutputFile | None:
        """Plan a file; None if the set has nothing for it."""
        stem = wanted.name.replace("{name}", self.name)
        found = {role: self._find(role) for role in wanted.roles if role != UNUSED}
        if not any(found.values()):
            if len(found) > 1 + wanted.optional:
                self.notes.append(f"{stem} is not written: there is no {' or '.join(found)}")
            return None
        parts = []
        for number, role in enumerate(wanted.roles, 1):
            part = Part(UNUSED) if role == UNUSED else found[role]
            if part is None and not (wanted.optional and number == len(wanted.roles)):
                part = self._neutral(role, stem)
            if part is not None:
                parts.append(part)
        return self._fitted(wanted, stem, parts)

    def _find(self, role: str) -> Part | None:
        """Return where a role comes from: its map, a channel, or a map that it is made from."""
        for other, reverse in ({role: False} | _MADE_FROM.get(role, {})).items():
            if other != role and other in self.listed:
                continue  # that map has a file of its own
            for key, one in self.roles.items():
                if one.name == other or other in one.channels:
                    self.used.setdefault(key, set()).add(other)
                    if other == "normal":
                        self.notes.append(
                            f"{key} is read as normals whose y points up; if it points down, name "
                            "the map normal_dx"
                        )
                    channel = None if one.name == other else one.channels.index(other)
                    part = Part(role, key, channel, reverse)
                    self._check_map(part)
                    return part
        return None

    def _neutral(self, role: str, stem: str) -> Part:
        if role not in self.preset.missing:
            wanted = " or ".join((role, *_MADE_FROM.get(role, ())))
            raise InvalidInputError(
                f"preset {self.preset.name} needs {wanted} for {stem}, but {self.name} has only "
                f"{self.have}; add a map of it"
            )
        value = self.preset.missing[role]
        self.notes.append(f"{role} is missing, so it is {value:g} everywhere in {stem}")
        return Part(role, value=value)

    def _check_map(self, part: Part) -> None:
        """Refuse normals that are none, and data whose channels differ."""
        like, shows = self.pictures[part.source], ROLES[part.role]
        pixels = like.pixels
        path = show(os.path.basename(like.path) or part.source)
        colors = (1 if pixels.ndim == 2 else pixels.shape[2]) - like.alpha
        packs = self.roles[part.source]
        if colors < len(packs.channels):
            raise InvalidInputError(
                f"{path} has {colors} channel{'s'[: colors > 1]}, and {packs.name} packs "
                f"{', '.join(packs.channels)}; rename it, or save it with all of them"
            )
        if shows.kind == "normal":
            if colors != 3:
                raise InvalidInputError(
                    f"{path} has {colors} channel{'s'[: colors > 1]}; a map of normals has three"
                )
            if mixing_of(pixels, "normal", like.alpha).kind != Kind.VECTORS:
                raise InvalidInputError(
                    f"{path} is not a normal map: the length of its vectors is not 1"
                )
        elif shows.kind != "color" and part.channel is None and not shows.channels and colors > 1:
            if (pixels[..., 1:colors] != pixels[..., :1]).any():
                raise InvalidInputError(
                    f"{path} is {part.role}, and its {colors} channels differ; save it as gray"
                )

    def _fitted(self, wanted: PresetFile, stem: str, parts: list[Part]) -> OutputFile:
        given = {part.source: self.pictures[part.source] for part in parts if part.source}
        sizes = {key: one.pixels.shape[:2] for key, one in given.items()}
        if len(set(sizes.values())) > 1:
            said = ", ".join(f"{key} {w}x{h}" for key, (h, w) in sizes.items())
            raise InvalidInputError(f"{stem} packs maps of unequal size ({said}); scale them first")
        first, single = next(iter(given.values())), len(parts) == 1 and parts[0].channel is None
        suffix = wanted.format
        if not suffix:
            floats = any(one.pixels.dtype.kind == "f" for one in given.values())
            plain = single and not parts[0].reverse
            suffix = written_as(first.path, floats) if plain else ".exr" if floats else ".png"
        kept = single and parts[0].role == "color" and first.alpha
        for number, part in enumerate(parts):
            if part.source and part.channel is None and given[part.source].alpha and not kept:
                parts[number] = part._replace(strip=True)
                self.notes.append(f"the alpha of {part.source} is left out of {stem}")
        dtype = self._dtype(wanted, suffix, given, parts)
        icc = first.icc if parts[0].role == "color" else None
        four = len(parts) > 1 and sum(width_of(part.role) for part in parts) in (2, 4)
        how = kept or four, icc, first.half and dtype.kind == "f", first.density
        return OutputFile(stem + suffix, tuple(parts), dtype, *how)

    def _dtype(
        self, wanted: PresetFile, suffix: str, given: Mapping[str, Picture], parts: list[Part]
    ) -> np.dtype[Any]:
        """Return the type of a file's pixels; note what is rounded."""
        types = {key: one.pixels.dtype for key, one in given.items()}
        able = FORMATS[suffix.lower()].types
        floats = any(one.kind == "f" for one in types.values())
        if "uint8" not in able or ("float32" in able and floats and not wanted.format):
            return np.dtype(np.float32)
        deep = any(one != np.uint8 for one in types.values())
        deep = deep and wanted.bits == 16 and "uint16" in able
        dtype = np.dtype(np.uint16 if deep else np.uint8)
        for part in parts:
            pixels = given[part.source].pixels if part.source else np.zeros(1)
            low, high = float(pixels.min()), float(pixels.max())
            outside = pixels.dtype.kind == "f" and not -_SLACK <= low <= high <= 1 + _SLACK
            said = f"{part.source} has values from {low:g} to {high:g}"
            if outside and ROLES[part.role].kind == "color":
                self.notes.append(f"{said}; values outside 0 to 1 are clipped")
            elif outside and ROLES[part.role].kind != "normal":
                raise InvalidInputError(f"{said}, but {suffix} stores 0 to 1; scale them")
        for key, one in types.items():
            if one.itemsize > dtype.itemsize:
                what = "floats" if one.kind == "f" else "16"
                self.notes.append(f"{key} is rounded from {what} to {8 * dtype.itemsize} bits")
        return dtype


def write_preset(
    maps: Mapping[str, Pixels | Picture],
    folder: StrPath,
    preset: str | os.PathLike[str],
    *,
    roles: Mapping[str, Role | str] | None = None,
    name: str | None = None,
) -> tuple[list[str], list[str]]:
    """Write a set of maps as a preset wants it: all files, or none on an error.

    Parameters
    ----------
    maps : mapping of str to array (H, W) or (H, W, C), or Picture
        By role, such as ``{"color": ..., "normal_gl": ..., "roughness": ...}``; uint8, uint16 or
        float. A color of 2 or 4 channels has alpha.
    folder : path
        An existing folder.
    preset : str or path
        A name of `weftex.io.presets.presets`, or a TOML file.
    roles : mapping of str to Role or str, optional
        Roles of maps whose names are no roles.
    name : str, optional
        Name of the material in file names; by default that of the folder.

    Returns
    -------
    files : list of str
        Names of the files in the folder.
    notes : list of str
        What was converted, filled in or left out, a line each.

    Raises
    ------
    InvalidInputError
        If a map is missing, or its size, channels or values do not fit.
    FileError
        If a file cannot be written.

    Examples
    --------
    >>> import numpy as np, tempfile
    >>> rough = np.full((4, 4), 200, np.uint8)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     files, notes = write_preset({"roughness": rough}, folder, "unreal", name="rock")
    >>> files, notes[0]
    (['T_rock_ORM.png'], 'ao is missing, so it is 1 everywhere in T_rock_ORM')
    """
    shows = {key: as_role((roles or {}).get(key, key)) for key in maps}
    pictures = {key: _picture(key, one, shows[key]) for key, one in maps.items()}
    place = os.path.abspath(os.fsdecode(folder))
    own = name or os.path.basename(place)
    planned = pack_set(read_preset(preset), place, own, pictures, shows)
    planned.check()
    with ExitStack() as stack:
        files = planned.write(lambda path: stack.enter_context(atomic(path)))
    return files, list(planned.notes)


def _picture(key: str, given: Pixels | Picture, role: Role) -> Picture:
    if isinstance(given, Picture):
        return given
    pixels = check_pixels(given, key)
    if pixels.dtype == np.float64:
        pixels = pixels.astype(np.float32)
    alpha = pixels.ndim == 3 and pixels.shape[2] in (2, 4) and role.srgb
    return Picture(pixels, alpha, None, key)


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
