"""Map sets as the files of a preset: channels packed, inverted and converted; and back."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weftex.errors import InvalidInputError
from weftex.io.formats import FORMATS, show, suffix_of, written_as
from weftex.io.pictures import Picture, atomic, check_output, read_image, write_bytes, write_image
from weftex.io.presets import UNUSED, Preset, PresetFile, read_preset, width_of
from weftex.raster.levels import to_stored
from weftex.raster.mixing import Kind, middle_of, mixing_of, opposite
from weftex.roles import ROLES, Role, as_role
from weftex.threads import in_turn, thread_count

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.io.formats import StrPath

    Pixels = NDArray[Any]
    #: Pixels by the names of maps.
    PixelsOf = Callable[[str], Pixels]

__all__ = ["PackedFile", "PackedSet", "pack_set", "unpack_set", "write_preset"]

#: Roles that others can be turned into: by themselves, or with values or the y axis reversed.
_TURNED = {
    "gloss": {"roughness": True},
    "roughness": {"gloss": True},
    "normal_gl": {"normal_dx": True, "normal": False},
    "normal_dx": {"normal_gl": True, "normal": True},
}
#: What unpacked maps are turned into, so that a set comes back as it was.
_BACK = {"gloss": "roughness", "normal_dx": "normal_gl"}
_SLACK = 1e-3  # that floats may lie outside 0 to 1


class _Part(NamedTuple):
    """What the channels of a role are taken from."""

    role: str
    source: str = ""  # the name of a map; a constant without
    channel: int | None = None  # of a packed map
    reverse: bool = False
    value: float = 0.0


@dataclass(frozen=True)
class PackedFile:
    """A file to write: where its channels come from, and what it is like."""

    name: str
    parts: tuple[_Part, ...]
    dtype: np.dtype[Any]
    alpha: bool = False
    icc: bytes | None = None
    half: bool = False
    alpha_of: frozenset[str] = frozenset()  # maps whose last channel is alpha

    def pixels(self, pixels_of: PixelsOf) -> Pixels:
        """Return the pixels of the file, from those of the maps."""
        if len(self.parts) == 1:
            return self._converted(self.parts[0], self._taken(self.parts[0], pixels_of))
        taken = {
            one: self._converted(one, self._channels(one, pixels_of))
            for one in self.parts
            if one.source
        }
        shape = next(iter(taken.values())).shape[:2]
        top = 1.0 if self.dtype.kind == "f" else np.iinfo(self.dtype).max
        flat = {one: np.full((*shape, 1), round(one.value * top), self.dtype) for one in self.parts}
        return np.concatenate([taken.get(one, flat[one]) for one in self.parts], axis=2)

    def _taken(self, part: _Part, pixels_of: PixelsOf) -> Pixels:
        """Return the pixels of one map, with its alpha if the file keeps that."""
        pixels = pixels_of(part.source)
        if part.channel is not None:
            pixels = pixels[..., part.channel]
        elif part.source in self.alpha_of and (len(self.parts) > 1 or not self.alpha):
            pixels = pixels[..., 0] if pixels.shape[2] == 2 else pixels[..., :-1]
        if not part.reverse:
            return pixels
        if ROLES[part.role].kind != "normal":
            return opposite(pixels, 0.5)
        pixels = pixels.copy()
        pixels[..., 1] = opposite(pixels[..., 1], middle_of(pixels))
        return pixels

    def _channels(self, part: _Part, pixels_of: PixelsOf) -> Pixels:
        pixels = np.atleast_3d(self._taken(part, pixels_of))
        width = width_of(part.role)
        return pixels.repeat(width, 2) if pixels.shape[2] < width else pixels[..., :width]

    def _converted(self, part: _Part, pixels: Pixels) -> Pixels:
        """Return pixels in the type of the file; integers are scaled to its range and rounded."""
        if pixels.dtype == self.dtype or self.dtype.kind == "f":
            return np.asarray(pixels, self.dtype)
        top = np.iinfo(self.dtype).max
        if pixels.dtype.kind == "f":
            values = np.clip(pixels.astype(np.float64), 0, 1)
            if ROLES[part.role].srgb:
                colors = slice(0, -1) if self.alpha and pixels.ndim == 3 else slice(None)
                values[..., colors] = to_stored(values[..., colors])
            return np.rint(values * top).astype(self.dtype)
        from_top = np.iinfo(pixels.dtype).max
        return ((pixels.astype(np.uint32) * top + from_top // 2) // from_top).astype(self.dtype)


@dataclass(frozen=True)
class PackedSet:
    """The files of a set, what is worth saying about them, and a file of the material."""

    files: tuple[PackedFile, ...]
    notes: tuple[str, ...] = ()
    name: str = ""
    material: str = ""

    def told(self) -> list[str]:
        """Return a line for each file, and the notes."""
        lines = [
            f"{one.name} holds {', '.join(role for role in _roles_of(one) if role != UNUSED)}"
            for one in self.files
        ]
        return [*lines, *self.notes]

    def document(self, read: Callable[[str], bytes]) -> tuple[str, bytes] | None:
        """Return name and content of the material's file; `read` gives the bytes of a picture."""
        if not self.material:
            return None
        from weftex.io.materials import Place, glb, usda

        where = {}
        for one in self.files:
            start = 0
            for part in one.parts:
                width = width_of(part.role) if len(one.parts) > 1 else 0
                where[part.role] = Place(one.name, start, width)
                start += width
        alphas = {one.name for one in self.files if one.alpha or "opacity" in _roles_of(one)}
        if self.material == "gltf":
            return f"{self.name}.glb", glb(self.name, where, alphas, read)
        if self.material == "usd":
            return f"{self.name}.usda", usda(self.name, where, alphas).encode()
        from weftex.io.materialx import materialx_document

        hextiled = self.material == "materialx-hextiled"
        text = materialx_document(self.name, where, hextiled=hextiled)
        return f"{self.name}.mtlx", text.encode()


def _roles_of(file: PackedFile) -> list[str]:
    return [part.role for part in file.parts]


def pack_set(
    preset: Preset, name: str, pictures: Mapping[str, Picture], roles: Mapping[str, Role]
) -> PackedSet:
    """Plan the files of a preset for a set of maps; `pictures` and `roles` are by map name.

    Sizes, channels and values are checked on the pictures. Raises `InvalidInputError`.
    """
    return _Packer(preset, name, pictures, roles).packed()


class _Packer:
    def __init__(
        self,
        preset: Preset,
        name: str,
        pictures: Mapping[str, Picture],
        roles: Mapping[str, Role],
    ) -> None:
        self.preset, self.name, self.pictures, self.roles = preset, name, pictures, roles
        self.notes: list[str] = []
        self.used: set[str] = set()
        self.listed = {role for one in preset.files for role in one.roles}

    def packed(self) -> PackedSet:
        if self.preset.others:
            return PackedSet(tuple(map(self._renamed, self.pictures)), (), self.name)
        files = [packed for one in self.preset.files if (packed := self._file(one)) is not None]
        have = ", ".join(role.name for role in self.roles.values())
        if not files:
            raise InvalidInputError(
                f"preset {self.preset.name} needs one of {', '.join(sorted(self.listed))}, and "
                f"{self.name} has only {have}"
            )
        for key in self.pictures:
            if key not in self.used:
                self.notes.append(
                    f"{key} is left out: preset {self.preset.name} has no place for it"
                )
        return PackedSet(tuple(files), tuple(self.notes), self.name, self.preset.material)

    def _renamed(self, key: str) -> PackedFile:
        like = self.pictures[key]
        name = self.preset.stem(self.name, self.roles[key])
        return kept_file(name, key, like, self.roles[key].name)

    def _file(self, wanted: PresetFile) -> PackedFile | None:
        stem = wanted.name.replace("{name}", self.name)
        found = {role: self._find(role) for role in wanted.roles if role != UNUSED}
        if not any(found.values()):
            if len(found) > 1:
                self.notes.append(f"{stem} is not written: there is no {_or(found)}")
            return None
        parts = []
        for role in wanted.roles:
            part = _Part(UNUSED) if role == UNUSED else found[role]
            if part is None and wanted.optional and role == wanted.roles[-1]:
                continue
            if part is None:
                part = self._constant(role, stem)
            parts.append(part)
        return self._checked(wanted, stem, parts)

    def _constant(self, role: str, stem: str) -> _Part:
        if role not in self.preset.missing:
            have = ", ".join(one.name for one in self.roles.values())
            raise InvalidInputError(
                f"preset {self.preset.name} packs {role} into {stem}, and {self.name} has none "
                f"(it has {have}); add a map of it"
            )
        value = self.preset.missing[role]
        self.notes.append(f"{role} is missing, so it is {value:g} everywhere in {stem}")
        return _Part(role, value=value)

    def _find(self, role: str) -> _Part | None:
        """Return where a role comes from: its map, a channel, or a map that can be turned."""
        for other, reverse in ({role: False} | _TURNED.get(role, {})).items():
            if other != role and other in self.listed:
                continue
            for key, one in self.roles.items():
                if one.name == other or other in one.channels:
                    self.used.add(key)
                    channel = one.channels.index(other) if one.name != other else None
                    if other == "normal":
                        self.notes.append(
                            f"{key} is taken for normals whose y points up; if it points down, "
                            "name the map normal_dx"
                        )
                    return _Part(role, key, channel, reverse)
        return None

    def _checked(self, wanted: PresetFile, stem: str, parts: list[_Part]) -> PackedFile:
        given = {part.source: self.pictures[part.source] for part in parts if part.source}
        for part in parts:
            if part.source:
                self._check_map(part, self.pictures[part.source], alone=len(parts) == 1)
        sizes = {key: one.pixels.shape[:2] for key, one in given.items()}
        if len(set(sizes.values())) > 1:
            said = ", ".join(f"{key} {w}x{h}" for key, (h, w) in sizes.items())
            raise InvalidInputError(
                f"{stem} packs maps of unequal size ({said}); scale them to one size first"
            )
        first = next(iter(given.values()))
        single = len(parts) == 1 and parts[0].channel is None
        suffix = wanted.format
        if not suffix:
            floats = any(one.pixels.dtype.kind == "f" for one in given.values())
            suffix = ".exr" if floats else ".png"
            if single and not parts[0].reverse:
                suffix = written_as(first.path, floats)
        dtype = self._dtype(wanted, suffix, parts, stem)
        kept = single and parts[0].role == "color" and first.alpha
        icc = first.icc if parts[0].role == "color" else None
        alpha_of = frozenset(
            part.source
            for part in parts
            if part.source
            and self.pictures[part.source].alpha
            and not self.roles[part.source].channels
        )
        if alpha_of and not kept:
            self.notes.append(f"the alpha of {', '.join(sorted(alpha_of))} is left out of {stem}")
        width = sum(width_of(part.role) for part in parts)
        alpha = kept or (len(parts) > 1 and width in (2, 4))
        half = first.half and dtype.kind == "f"
        return PackedFile(stem + suffix, tuple(parts), dtype, alpha, icc, half, alpha_of)

    def _dtype(
        self, wanted: PresetFile, suffix: str, parts: list[_Part], stem: str
    ) -> np.dtype[Any]:
        """Return the type of a file's pixels, and note what it loses."""
        types = {p.source: self.pictures[p.source].pixels.dtype for p in parts if p.source}
        able = FORMATS[suffix.lower()].types
        if "uint8" not in able or (
            "float32" in able and not wanted.format and any(t.kind == "f" for t in types.values())
        ):
            return np.dtype(np.float32)
        deep = any(t != np.uint8 for t in types.values())
        most = wanted.bits if "uint16" in able else 8
        dtype = np.dtype(np.uint16 if deep and most == 16 else np.uint8)
        for part in parts:
            if part.source and types[part.source].kind == "f":
                pixels = self.pictures[part.source].pixels
                low, high = float(pixels.min()), float(pixels.max())
                if not ROLES[part.role].srgb and not -_SLACK <= low <= high <= 1 + _SLACK:
                    raise InvalidInputError(
                        f"{part.source} has values from {low:g} to {high:g}, and {stem}{suffix} "
                        "holds 0 to 1; scale them first"
                    )
        for key, one in types.items():
            if one.kind == "f" or (one == np.uint16 and dtype == np.uint8):
                what = "floats" if one.kind == "f" else "16 bits"
                self.notes.append(f"{key} is rounded from {what} to {8 * dtype.itemsize} bits")
        return dtype

    def _check_map(self, part: _Part, like: Picture, *, alone: bool) -> None:
        """Refuse normals that are none, and data whose channels differ."""
        pixels, role = like.pixels, ROLES[part.role]
        path = show(os.path.basename(like.path) or part.source)
        colors = (1 if pixels.ndim == 2 else pixels.shape[2]) - like.alpha
        if role.kind == "normal":
            if colors != 3:
                raise InvalidInputError(f"{path} has {colors} channels; a map of normals has three")
            if mixing_of(pixels, "normal", like.alpha).kind != Kind.VECTORS:
                raise InvalidInputError(
                    f"{path} is no map of normals: its pixels are not of length 1"
                )
        elif role.kind != "color" and part.channel is None and not alone and colors > 1:
            first = pixels[..., :1]
            if (pixels[..., 1:colors] != first).any():
                raise InvalidInputError(
                    f"{path} is {part.role} and has {colors} channels that differ; save it as gray"
                )


def kept_file(stem: str, key: str, like: Picture, role: str = "color") -> PackedFile:
    """Return a file that holds one map as it is, in the format that it came in."""
    dtype = like.pixels.dtype
    suffix = written_as(like.path, dtype.kind == "f")
    return PackedFile(stem + suffix, (_Part(role, key),), dtype, like.alpha, like.icc, like.half)


def _or(roles: Mapping[str, object]) -> str:
    return " or ".join(roles)


def write_preset(
    maps: Mapping[str, Pixels | Picture],
    folder: StrPath,
    preset: str | os.PathLike[str] | Preset,
    *,
    roles: Mapping[str, Role | str] | None = None,
    name: str | None = None,
) -> tuple[list[str], list[str]]:
    """Write a set of maps as a preset wants it: all files, or none on an error.

    Parameters
    ----------
    maps : mapping of str to array (H, W) or (H, W, C), or Picture
        By role, such as ``{"color": ..., "normal_gl": ..., "roughness": ...}``; uint8, uint16 or
        float. An array with 2 or 4 channels whose role is a color has alpha.
    folder : path
        An existing folder.
    preset : str, path or Preset
        A name of `presets`, or a TOML file.
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
    ...     write_preset({"roughness": rough}, folder, "unreal", name="rock")
    (['T_rock_ORM.png'], ['ao is missing, so it is 1 everywhere in T_rock_ORM', ...])
    """
    shows = {key: as_role((roles or {}).get(key, key)) for key in maps}
    pictures = {key: _picture(key, one, shows[key]) for key, one in maps.items()}
    own = name or os.path.basename(os.path.abspath(os.fsdecode(folder)))
    planned = pack_set(read_preset(preset), own, pictures, shows)
    place = os.path.abspath(os.fsdecode(folder))
    check_set(planned, place, lambda key: pictures[key].pixels)
    with ExitStack() as stack:
        written = write_set(
            planned,
            place,
            lambda key: pictures[key].pixels,
            lambda path: stack.enter_context(atomic(path)),
        )
    return written, list(planned.notes)


def _picture(key: str, given: Pixels | Picture, role: Role) -> Picture:
    if isinstance(given, Picture):
        return given
    pixels = np.asarray(given)
    if pixels.ndim not in (2, 3) or 0 in pixels.shape:
        raise InvalidInputError(f"{key} has the shape {pixels.shape}; use (H, W) or (H, W, C)")
    if pixels.dtype == np.float64:
        pixels = pixels.astype(np.float32)
    if pixels.dtype.name not in ("uint8", "uint16", "float32"):
        raise InvalidInputError(f"{key} is {pixels.dtype}; use uint8, uint16 or float32")
    alpha = pixels.ndim == 3 and pixels.shape[2] in (2, 4) and role.srgb
    return Picture(pixels, alpha, None, f"{key}.exr" if pixels.dtype.kind == "f" else f"{key}.png")


def check_set(planned: PackedSet, folder: str, pixels_of: PixelsOf) -> None:
    """Refuse what cannot be written, before any work; `pixels_of` gives pixels of this kind."""
    names = [one.name for one in planned.files]
    for one in planned.files:
        if names.count(one.name) > 1:
            twins = [part.source for file in planned.files for part in file.parts
                     if file.name == one.name]  # fmt: skip
            raise InvalidInputError(
                f"{' and '.join(twins)} would both be written to {one.name}; rename one of them"
            )
        like = one.pixels(lambda key: pixels_of(key)[:1, :1])
        check_output(os.path.join(folder, one.name), like, alpha=one.alpha)
    document = planned.document(lambda name: b"")
    if document is not None:
        check_output(os.path.join(folder, document[0]), suffixes=(suffix_of(document[0]),))


def write_set(
    planned: PackedSet,
    folder: str,
    pixels_of: PixelsOf,
    add: Callable[[str], str],
    threads: int | None = None,
) -> list[str]:
    """Write the files of a set under the names that `add` returns for their paths; their names."""
    files, at_once = planned.files, thread_count(threads)
    temporary = {one.name: add(os.path.join(folder, one.name)) for one in files}

    def write_one(number: int) -> None:
        one = files[number]
        how: dict[str, Any] = {"alpha": one.alpha, "icc": one.icc, "half": one.half}
        how["threads"] = max(1, at_once // len(files))
        write_image(temporary[one.name], one.pixels(pixels_of), **how)

    for _ in in_turn(write_one, range(len(files)), min(at_once, len(files))):
        pass  # the first that fails ends it
    document = planned.document(lambda name: Path(temporary[name]).read_bytes())
    if document is None:
        return list(temporary)
    write_bytes(add(os.path.join(folder, document[0])), document[1])
    return [*temporary, document[0]]


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
    maps: dict[str, Picture] = {}
    for one, path in found.items():
        picture = read_image(path, **limits)
        pixels = np.atleast_3d(picture.pixels)
        widths = one.widths()
        least = sum(widths.values()) - one.optional
        if len(widths) == 1:
            parts = {one.roles[0]: picture.pixels}
        elif pixels.shape[2] not in {least, sum(widths.values())}:
            raise InvalidInputError(
                f"{show(path)} has {pixels.shape[2]} channels; preset {preset.name} has "
                f"{', '.join(one.roles)} there, in {sum(widths.values())}"
            )
        else:
            parts = {
                role: pixels[..., start : start + widths[role]]
                for role, start in one.places().items()
                if start < pixels.shape[2]
            }
        for role, part in parts.items():
            if role != UNUSED:
                whole = len(widths) == 1 or part.shape[2] == pixels.shape[2]
                like = picture if whole else _alone(picture, role, part)
                back = _BACK.get(role, role)
                maps[back] = _turned_back(like, role, back)
    return maps, notes


def _alone(picture: Picture, role: str, part: Pixels) -> Picture:
    pixels = np.ascontiguousarray(part[..., 0] if part.shape[2] == 1 else part)
    icc = picture.icc if role == "color" else None
    return replace(picture, pixels=pixels, alpha=False, icc=icc)


def _turned_back(picture: Picture, role: str, back: str) -> Picture:
    if role == back:
        return picture
    file = PackedFile("", (_Part(back, role, None, True),), picture.pixels.dtype, picture.alpha)
    return replace(picture, pixels=file.pixels(lambda _: picture.pixels))


def _recognized(
    preset: Preset, paths: Mapping[str, str]
) -> tuple[dict[PresetFile, str], list[str]]:
    """Return the path of each file of a preset that is there, and notes about other pictures."""
    found: dict[PresetFile, str] = {}
    names: dict[str, str] = {}
    notes = []
    patterns = {
        one: re.compile(re.escape(one.name).replace(r"\{name\}", "(.+)")) for one in preset.files
    }
    for stem, path in paths.items():
        fitting = {one: fit[1] for one in patterns if (fit := patterns[one].fullmatch(stem))}
        if not fitting:
            notes.append(f"{show(os.path.basename(path))} is ignored: no file of {preset.name}")
            continue
        best = max(fitting, key=lambda one: len(one.name))
        names[fitting[best]] = found[best] = path
    if not found:
        wanted = ", ".join(one.name for one in preset.files)
        raise InvalidInputError(f"preset {preset.name} has files named {wanted}; none is there")
    if len(names) > 1:
        raise InvalidInputError(
            f"the files are of several sets ({', '.join(sorted(names))}); name those of one"
        )
    return found, notes
