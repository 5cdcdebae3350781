"""Materials as a page names them: a bundled sample, or uploads by the maps that they are."""

from __future__ import annotations

import hashlib
import json
import os
from functools import partial
from typing import TYPE_CHECKING, Any

from weftex.recipe import checked_material, pictures_of
from weftex.recipe.making import Loaded, loaded, material_of
from weftex.roles import COLOR, is_preview, role_of, words_of
from weftex.studio.refusals import Refusal
from weftex.studio.uploads import picture_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from weftex import Exemplar
    from weftex.studio.sessions import Session


def id_of(spec: Mapping[str, Any]) -> str:
    """Return a short name for what JSON describes: the same for the same."""
    text = json.dumps(spec, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def load(given: Any, session: Session) -> Loaded:
    """Read a material, or remember it."""
    spec, open_picture = checked_material(given), partial(picture_of, session=session)

    def read() -> tuple[Loaded, int]:
        found = loaded(spec, material_of(spec, open_picture), open_picture)
        return found, 2 * size_of(found.exemplar)

    for upload in pictures_of(spec):
        session.upload(upload)
    found: Loaded = session.find(read, "material", id_of(spec))
    return found


def size_of(exemplar: Exemplar) -> int:
    """Return the bytes of a sample: its pixels, its maps, and what they are compared by."""
    whole = exemplar.pixels.nbytes + sum(one.nbytes for one in exemplar.maps.values())
    return whole + exemplar.shape[0] * exemplar.shape[1] * 4 * (1 + len(exemplar.maps))


def sets_of(uploads: list[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[str]]:
    """Sort what was dropped together into sets of maps and single pictures, by its names."""
    notes: list[str] = []
    groups: dict[tuple[str, ...], dict[str, dict[str, Any]]] = {}
    singles: list[dict[str, Any]] = []
    for one in sorted(uploads, key=lambda one: str(one["name"])):
        stem = _stem(one)
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
                f"{one['name']} is ignored: {group[role.name]['name']} is also {role.name}"
            )
        else:
            group[role.name] = one
    for name, group in groups.items():
        own = [one for one in singles if tuple(words_of(_stem(one))) == name]
        if own and COLOR.name not in group and len(own) == 1:  # the material under its bare name
            group[COLOR.name] = own[0]
            singles.remove(own[0])
    previews = [one for one in singles if groups and is_preview(_stem(one))]
    notes += [f"{one['name']} is a preview, and ignored" for one in previews]
    specs = []
    for name, group in groups.items():
        maps = {role: one["id"] for role, one in group.items()}
        specs.append({"name": "_".join(name) or "material", "maps": maps})
    specs += [{"maps": {COLOR.name: one["id"]}} for one in singles if one not in previews]
    return specs, notes


def _stem(upload: Mapping[str, Any]) -> str:
    return os.path.splitext(str(upload["name"]))[0]


def described(loaded: Loaded) -> dict[str, Any]:
    """Return a material as JSON for the page."""
    exemplar, material = loaded.exemplar, loaded.material
    return {
        "id": id_of(loaded.spec),
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
    """Return each map of a sample as JSON for the page."""
    named = {name: map_of(exemplar, main, name) for name in (main, *exemplar.maps)}
    return [
        {"name": name, "role": one.role.name, "dtype": one.pixels.dtype.name, "alpha": one.alpha}
        for name, one in named.items()
    ]
