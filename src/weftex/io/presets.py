"""Presets: which files a program wants of a map set, and which roles their channels hold.

Each is a TOML file, in the package or of a user; `docs/how-to/presets.md` has a table of the keys.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from weftex.errors import FileError, InvalidInputError, did_you_mean, shown, wrong_value
from weftex.io.formats import FORMATS, StrPath, file_error, path_text
from weftex.roles import ROLES, UNUSED, Role, width_of

__all__ = ["Preset", "PresetFile", "presets", "read_preset"]

_FOLDER = Path(__file__).parent.parent / "presets"
_SUFFIX = ".toml"
#: Files of a whole material that a preset may ask for.
MATERIALS = ("gltf", "materialx", "materialx-hextiled", "usd")
_KEYS: dict[str, type] = {
    "about": str, "url": str, "format": str, "bits": int, "material": str, "others": str,
    "missing": dict, "file": list,
}  # fmt: skip
_FILE_KEYS: dict[str, type] = {"name": str, "channels": list, "format": str, "bits": int}
_MOST_CHANNELS = 4
#: Where glTF reads what it needs.
_GLTF = {"ao": 0, "roughness": 1, "metallic": 2}


class PresetFile(NamedTuple):
    """A file of a preset: its name with ``{name}``, and the roles of its channels in order."""

    name: str
    roles: tuple[str, ...]
    optional: bool = False  # whether the last role may be missing
    format: str = ""  # a suffix; as the map has it if empty
    bits: int = 16  # at most, for each channel


class Preset(NamedTuple):
    """What a program wants of a map set."""

    name: str
    files: tuple[PresetFile, ...] = ()
    about: str = ""
    material: str = ""  # one of `MATERIALS`
    others: str = ""  # the name of each map that no file lists; such a preset only renames
    missing: Mapping[str, float] = {}  # neutral values by role

    def stem(self, material: str, role: Role) -> str:
        """Return the file name without suffix of a map, for a preset that only renames."""
        for one in self.files:
            if one.roles == (role.name,):
                return one.name.replace("{name}", material)
        joined = "".join(map(str.capitalize, role.name.split("_")))
        stem = self.others.replace("{role}", role.name).replace("{Role}", joined)
        return stem.replace("{name}", material)


def presets() -> dict[str, str]:
    """Return what each preset that ships with weftex is for, by name.

    Examples
    --------
    >>> presets()["terrain3d"]
    'Terrain3D for Godot: albedo with height, normals with roughness'
    """
    return {name: read_preset(name).about for name in _names()}


def _names() -> list[str]:
    return sorted(file.stem for file in _FOLDER.glob(f"*{_SUFFIX}"))


def read_preset(preset: StrPath) -> Preset:
    """Read a preset by its name, or from a TOML file.

    Raises
    ------
    InvalidInputError
        If no preset has this name.
    FileError
        If the file cannot be read, or a key or value in it is wrong.
    """
    given = path_text(preset)
    path = Path(given)
    if path.suffix != _SUFFIX:
        if given not in _names():
            own = f"; a preset of your own is a {_SUFFIX} file" if path.suffix else ""
            raise InvalidInputError(f"preset is {shown(given)}{did_you_mean(given, _names())}{own}")
        path = _FOLDER / f"{given}{_SUFFIX}"
    try:
        text = path.read_text("utf-8")
    except OSError as error:
        raise file_error(given, "cannot read the preset", error) from None
    except UnicodeDecodeError:
        raise file_error(given, "is not UTF-8 text") from None
    try:
        return _preset(path.stem, tomllib.loads(text))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise file_error(given, "is not TOML", error) from None
    except InvalidInputError as error:
        raise FileError(f"{given}: {error}") from None


def _preset(name: str, found: dict[str, Any]) -> Preset:
    _check(found, _KEYS, "the preset")
    if not found.get("file") and not found.get("others"):
        raise InvalidInputError("has no [[file]]")
    files = [_file(one, found) for one in found.get("file", ())]
    material, others = found.get("material", ""), found.get("others", "")
    if material and material not in MATERIALS:
        raise InvalidInputError(f"material is {shown(material)}{did_you_mean(material, MATERIALS)}")
    missing = {}
    for role, value in found.get("missing", {}).items():
        _check_role(role)
        if type(value) not in (int, float) or not 0 <= value <= 1 or width_of(role) != 1:
            wanted = "a number from 0 to 1, for a role of one channel"
            raise wrong_value(f"missing.{role}", value, wanted)
        missing[role] = float(value)
    if others:
        _check_name(others, ("name", "role", "Role"), "others")
        packed = [one.name for one in files if len(one.roles) > 1]
        if packed or material:
            raise InvalidInputError(
                "others is for presets that only rename maps: without material, and with files of "
                "one role"
            )
    preset = Preset(name, tuple(files), found.get("about", ""), material, others, missing)
    _check_whole(preset)
    return preset


def _check_whole(preset: Preset) -> None:
    """Refuse files of one name, roles in two files, and what glTF has elsewhere."""
    names = [one.name for one in preset.files]
    roles = [role for one in preset.files for role in one.roles if role != UNUSED]
    for what, all_of in (("files are named", names), ("channels hold", roles)):
        twice = [one for one in all_of if all_of.count(one) > 1]
        if twice:
            raise InvalidInputError(f"two {what} {shown(twice[0])}")
    if preset.material == "gltf":
        for one in preset.files:
            if one.format != ".png":
                raise InvalidInputError(f'{one.name} must have format = "png", for glTF')
            if ("roughness" in one.roles) != ("metallic" in one.roles):
                raise InvalidInputError(f"{one.name} must hold roughness and metallic, for glTF")
            for place, role in enumerate(one.roles):
                if _GLTF.get(role, place) != place:
                    raise InvalidInputError(
                        f"{one.name} has {role} in channel {place + 1}; glTF reads ao, roughness "
                        "and metallic in channels 1, 2 and 3"
                    )


def _file(found: Any, above: dict[str, Any]) -> PresetFile:
    if not isinstance(found, dict):
        raise InvalidInputError("file must be tables: [[file]]")
    _check(found, _FILE_KEYS, "[[file]]")
    for key in ("name", "channels"):
        if not found.get(key):
            raise InvalidInputError(f"a [[file]] has no {key}")
    name, roles = found["name"], [str(one) for one in found["channels"]]
    _check_name(name, ("name",), "name")
    optional = roles[-1].endswith("?")
    roles[-1] = roles[-1].removesuffix("?")
    for role in roles:
        if role != UNUSED:
            _check_role(role, alone=len(roles) == 1)
    if len(roles) > 1 and sum(map(width_of, roles)) > _MOST_CHANNELS:
        raise InvalidInputError(
            f"channels of {name} are {', '.join(roles)}: a file has {_MOST_CHANNELS} at most, and "
            "colors and normals take three"
        )
    suffix = found.get("format", above.get("format", ""))
    if suffix and f".{suffix}" not in FORMATS:
        known = [one.removeprefix(".") for one in FORMATS]
        raise InvalidInputError(f"format is {shown(suffix)}{did_you_mean(suffix, known)}")
    bits = found.get("bits", above.get("bits", 16))
    if bits not in (8, 16):
        raise wrong_value("bits", bits, "8 or 16")
    return PresetFile(name, tuple(roles), optional, f".{suffix}" if suffix else "", bits)


def _check(found: dict[str, Any], keys: dict[str, type], where: str) -> None:
    for key, value in found.items():
        if key not in keys:
            raise InvalidInputError(f"{where} has the key {shown(key)}{did_you_mean(key, keys)}")
        if not isinstance(value, keys[key]):
            kind = {str: "a text", int: "a number", list: "a list", dict: "a table"}[keys[key]]
            raise wrong_value(key, value, kind)


def _check_role(role: str, *, alone: bool = False) -> None:
    known = [name for name, one in ROLES.items() if alone or not one.channels]
    if role not in known:
        raise InvalidInputError(f"no map has the role {shown(role)}{did_you_mean(role, known)}")


def _check_name(name: str, fields: tuple[str, ...], key: str) -> None:
    used = re.findall(r"\{(.*?)\}", name)
    plain = os.path.basename(name) == name and name.isprintable() and not name.startswith(".")
    if not plain or used.count("name") != 1 or not set(used) <= set(fields):
        raise wrong_value(key, name, "a file name without suffix that has {name} once")
