"""Materials as a page names them: a bundled sample, or uploads by the maps that they are."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import weftex
from weftex.errors import InvalidInputError, shown
from weftex.io.pictures import mask_of, sample_names
from weftex.material import Material, read_material, role_of_picture
from weftex.roles import COLOR, Role, is_preview, role_of, words_of
from weftex.studio.refusals import Refusal
from weftex.studio.uploads import picture_of

if TYPE_CHECKING:
    from weftex import Exemplar
    from weftex.studio.sessions import Session

#: What is done to a material before anything is made from it.
CHANGES = ("mask", "straighten", "even_light", "turn", "repeats", "map_weights")
#: What a map may be called, in files too.
_MAP = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ -]{0,39}")
#: Every field of a description.
FIELDS = frozenset({"sample", "name", "maps", *CHANGES})


@dataclass(frozen=True)
class Loaded:
    """A material in memory."""

    spec: dict[str, Any]  # what it was asked for by
    material: Material  # as its files have it
    exemplar: Exemplar  # masked, straightened, evenly lit, but not turned

    @property
    def id(self) -> str:
        """What it is known by in addresses."""
        return id_of(self.spec)

    @property
    def sample(self) -> Exemplar:
        """What things are made from: with its turned copies, if they were asked for."""
        if "turn" not in self.spec:
            return self.exemplar
        return weftex.turned(self.exemplar, self.spec["turn"])


def id_of(spec: Mapping[str, Any]) -> str:
    """Return a short name for what JSON describes: the same for the same."""
    text = json.dumps(spec, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def checked(given: Any) -> dict[str, Any]:
    """Return the description of a material, or raise `InvalidInputError` where it is none.

    Nothing is read, so uploads need not be there.
    """
    if not isinstance(given, dict):
        raise InvalidInputError(f"materials has {shown(given)}; it must be a description")
    spec = {
        name: value for name, value in given.items() if value is not None and value is not False
    }
    for name in spec:
        if name not in FIELDS:
            raise InvalidInputError(f"materials has {shown(name)}, which is not known")
    if ("sample" in spec) == ("maps" in spec):
        raise InvalidInputError("materials must have a sample or maps, and not both")
    if "sample" in spec:
        spec["sample"] = str(spec["sample"]).removeprefix("sample:")
        if spec["sample"] not in sample_names() or "name" in spec:
            raise InvalidInputError(
                f"sample is {shown(given['sample'])}; there is none of this name"
            )
    else:
        maps = spec["maps"]
        good = isinstance(maps, dict) and 0 < len(maps) <= 40
        if not good or not all(_MAP.fullmatch(k) and isinstance(v, str) for k, v in maps.items()):
            raise InvalidInputError(f"maps is {shown(maps)}; it must be uploads by what they are")
        if not isinstance(spec.get("name", ""), str):
            raise InvalidInputError(f"name is {shown(spec['name'])}; it must be a text")
    for name in ("mask", "straighten", "turn"):
        if not isinstance(spec.get(name, ""), str):
            raise InvalidInputError(f"{name} is {shown(spec[name])}; it must be a text")
    if not isinstance(spec.get("repeats", True), bool):
        raise InvalidInputError(f"repeats is {shown(spec['repeats'])}; it must be true or false")
    return spec


def load(given: Any, session: Session) -> Loaded:
    """Read a material, or remember it."""
    spec = checked(given)

    def read() -> tuple[Loaded, int]:
        material = _read(spec, session)
        loaded = Loaded(spec, material, _changed(spec, material, session))
        return loaded, 2 * size_of(loaded.exemplar)

    for upload in uploads_of(spec):
        session.upload(upload)
    found: Loaded = session.find(read, "material", id_of(spec))
    return found


def uploads_of(spec: Mapping[str, Any]) -> list[str]:
    """Return the uploads that a material needs."""
    mask = spec.get("mask")
    return [*spec.get("maps", {}).values(), *([mask] if mask not in (None, "alpha") else [])]


def size_of(exemplar: Exemplar) -> int:
    """Return the bytes of a sample: its pixels, its maps, and what they are compared by."""
    whole = exemplar.pixels.nbytes + sum(one.nbytes for one in exemplar.maps.values())
    return whole + exemplar.shape[0] * exemplar.shape[1] * 4 * (1 + len(exemplar.maps))


def _read(spec: Mapping[str, Any], session: Session) -> Material:
    """The material as its files have it, its maps by their roles."""
    if "sample" in spec:
        found = read_material(f"sample:{spec['sample']}")
        if found.folder:
            return found
        (picture,), (role,) = found.pictures.values(), found.roles.values()
        return Material(str(spec["sample"]), {role.name: picture}, {role.name: role})
    pictures = {name: picture_of(id_, session) for name, id_ in spec["maps"].items()}
    if len(pictures) == 1:
        ((name, picture),) = pictures.items()
        role = role_of_picture(picture.path) if name == COLOR.name else _role(name)
        return Material(picture.path, {role.name: picture}, {role.name: role})
    order = sorted(pictures, key=lambda name: _stem(pictures[name].path))  # as a folder has them
    pictures = {name: pictures[name] for name in order}
    roles = {name: _role(name) for name in order}
    return Material(spec.get("name") or "material", pictures, roles, folder=True)


def _role(name: str) -> Role:
    return role_of(name) or Role(name)


def _stem(name: str) -> str:
    return os.path.splitext(name)[0]


def _changed(spec: Mapping[str, Any], material: Material, session: Session) -> Exemplar:
    """The sample as it is used, all that was asked for done to it, in the command's order."""
    exemplar = material.exemplar(tileable=spec.get("repeats", False))
    if "map_weights" in spec:
        exemplar = exemplar.changed(weights=spec["map_weights"])
    if "mask" in spec:
        if spec["mask"] == "alpha":
            from weftex.tasks.fill import hole_of

            usable = ~hole_of(None, exemplar)
        else:
            picture = picture_of(spec["mask"], session)
            usable = mask_of(picture.pixels, alpha=picture.alpha)
        exemplar = exemplar.changed(mask=usable)
    if "straighten" in spec:
        exemplar = weftex.straighten(exemplar, **ways_to_straighten(spec["straighten"]))
    if "even_light" in spec:
        exemplar = weftex.even_light(exemplar, spec["even_light"])
    return exemplar


def ways_to_straighten(text: str) -> dict[str, str]:
    """Return what `straighten` is told: vectors, corners, or nothing."""
    names, count = {4: "lattice", 8: "corners"}, text.count(",") + 1
    if text and count not in names:
        raise InvalidInputError(
            f"straighten is {shown(text)}; it must be four numbers, a lattice, or eight, corners"
        )
    return {names[count]: text} if text else {}


def sets_of(uploads: list[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[str]]:
    """Sort what was dropped together into sets of maps and single pictures, by its names."""
    notes: list[str] = []
    groups: dict[tuple[str, ...], dict[str, dict[str, Any]]] = {}
    singles: list[dict[str, Any]] = []
    for one in sorted(uploads, key=lambda one: str(one["name"])):
        stem = _stem(one["name"])
        role = role_of(stem)
        if role is None or len(uploads) == 1:
            singles.append(one)
            continue
        about = {
            word for files in (role.files, (role.name,)) for name in files for word in name.split()
        }
        name = tuple(w for w in words_of(stem) if w not in {*about, *role.name.split("_")})
        group = groups.setdefault(name, {})
        if role.name in group:
            notes.append(
                f"{one['name']} is left out: {group[role.name]['name']} is {role.name} too"
            )
        else:
            group[role.name] = one
    for name, group in groups.items():
        own = [one for one in singles if tuple(words_of(_stem(one["name"]))) == name]
        if own and COLOR.name not in group and len(own) == 1:  # the material under its bare name
            group[COLOR.name] = own[0]
            singles.remove(own[0])
    previews = [one for one in singles if groups and is_preview(_stem(one["name"]))]
    notes += [f"{one['name']} is left out: a preview" for one in previews]
    specs = []
    for name, group in groups.items():
        maps = {role: one["id"] for role, one in group.items()}
        specs.append({"name": "_".join(name) or "material", "maps": maps})
    specs += [{"maps": {COLOR.name: one["id"]}} for one in singles if one not in previews]
    return specs, notes


def described(loaded: Loaded) -> dict[str, Any]:
    """Return what the page is told of a material."""
    exemplar, material = loaded.exemplar, loaded.material
    return {
        "id": loaded.id,
        "name": material.name,
        "main": material.main,
        "width": exemplar.shape[1],
        "height": exemplar.shape[0],
        "maps": maps_of(exemplar, material.main),
        "notes": [line.removeprefix("map: ") for line in material.notes],
    }


def map_of(exemplar: Exemplar, main: str, name: str | None) -> Exemplar:
    """Return a map of a sample whose own picture is called `main`, or raise `Refusal`."""
    if name in (None, "", main):
        return exemplar
    if name not in exemplar.maps:
        raise Refusal(404, "there is no such map", "map")
    return exemplar.map(name)


def maps_of(exemplar: Exemplar, main: str) -> list[dict[str, Any]]:
    """Return what the page is told of each map of a sample."""
    named = {name: map_of(exemplar, main, name) for name in (main, *exemplar.maps)}
    return [
        {"name": name, "role": one.role.name, "dtype": one.pixels.dtype.name, "alpha": one.alpha}
        for name, one in named.items()
    ]
