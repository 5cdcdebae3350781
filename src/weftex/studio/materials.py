"""Materials as the page names them, and what analysis says about them."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from functools import partial
from typing import Any

import weftex
from weftex import Exemplar
from weftex.analysis.overlay import Lattice, LatticeRating, Rated, draw, is_tilted
from weftex.errors import InvalidInputError
from weftex.recipe import checked_material, pictures_of
from weftex.recipe.opening import PreparedMaterial, prepare_material, read_described
from weftex.roles import COLOR, is_preview, role_of, words_of
from weftex.studio.pictures import formats_of
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import Session
from weftex.studio.uploads import label_of, picture_of


def id_of(spec: Mapping[str, Any]) -> str:
    """Return a short name for what JSON describes: the same for the same."""
    text = json.dumps(spec, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def load_material(given: Any, session: Session) -> PreparedMaterial:
    """Read a material, or remember it."""
    spec, open_picture = checked_material(given), partial(picture_of, session=session)

    def read() -> PreparedMaterial:
        return prepare_material(spec, read_described(spec, open_picture), open_picture)

    for upload in pictures_of(spec):
        session.upload(upload)
    return session.find(read, lambda found: 2 * size_of(found.exemplar), "material", id_of(spec))


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
    notes += [f"{one['name']} is ignored: it is a preview" for one in previews]
    specs = []
    for name, group in groups.items():
        maps = {role: one["id"] for role, one in group.items()}
        specs.append({"name": "_".join(name) or "material", "maps": maps})
    specs += [{"maps": {COLOR.name: one["id"]}} for one in singles if one not in previews]
    return specs, notes


def _stem(upload: Mapping[str, Any]) -> str:
    return os.path.splitext(str(upload["name"]))[0]


def described(loaded: PreparedMaterial) -> dict[str, Any]:
    """Return a material as JSON for the page."""
    exemplar, material = loaded.exemplar, loaded.stored
    return {
        "id": id_of(loaded.spec),
        "name": material.name,
        "main": material.main,
        "width": exemplar.shape[1],
        "height": exemplar.shape[0],
        "maps": maps_of(exemplar, material.main),
        "formats": {name: formats_of(picture) for name, picture in material.pictures.items()},
        "density": material.pictures[material.main].density,
        "file": os.path.splitext(label_of(material.name))[0],
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


_LARGEST = 2**21  # pixels of a sample that is analyzed as a whole; a drag must be quick
_RUNNERS_UP = 4
_DEGREE = 2  # of the light that the button takes off


def analysis_of(loaded: PreparedMaterial, session: Session) -> dict[str, Any]:
    """Return what a material is like; larger ones are analyzed by a smaller copy."""
    key = "analysis", id_of(loaded.spec)
    return session.find(lambda: _analysis(loaded), lambda _: 2**14, *key)


def _analysis(loaded: PreparedMaterial) -> dict[str, Any]:
    exemplar = loaded.exemplar
    if exemplar.shape[0] * exemplar.shape[1] > _LARGEST:
        return _quick_analysis(loaded)
    found = weftex.analyze(exemplar, runners_up=_RUNNERS_UP)
    return {
        "scale": found.scale,
        "confidence": found.confidence,
        "scale_source": found.scale_source,
        "spectrum": [vars(band) for band in found.spectrum],
        "regularity": found.regularity,
        "lattice": _own(exemplar, found.lattice, found.ratings.found),
        "runners_up": [
            vars(draw(exemplar, one.vectors, one.goodness)) for one in found.ratings.runners_up
        ],
        "colors": found.colors,
        "tiles": list(found.tiles),
        "auto": found.choice.as_dict(),
        "mending": _mending(loaded.spec, found.evenness.lit_unevenly, found.lattice),
        "text": str(found),
    }


def _quick_analysis(loaded: PreparedMaterial) -> dict[str, Any]:
    """Describe a large sample from a smaller copy and a part of it, which `auto` analyzes."""
    exemplar = loaded.exemplar
    model = weftex.Auto().fit_exemplar(exemplar)
    seen = model.findings
    choice = model.choose((2 * exemplar.shape[0], 2 * exemplar.shape[1]))
    return {
        "scale": seen.scale,
        "confidence": None,
        "scale_source": "smaller copy",
        "spectrum": [],
        "regularity": None,
        "lattice": _own(exemplar, seen.lattice, None),
        "runners_up": [],
        "colors": seen.colors,
        "tiles": None,
        "auto": choice.as_dict(),
        "mending": _mending(loaded.spec, seen.evenness.lit_unevenly, seen.lattice),
        "text": f"{exemplar.shape[1]}x{exemplar.shape[0]}, analyzed on a smaller copy\n{choice}",
    }


def rate_lattice(loaded: PreparedMaterial, vectors: str, session: Session) -> dict[str, Any]:
    """Return how good a lattice is that somebody drew, or raise `InvalidInputError`."""
    if not vectors:
        raise InvalidInputError("lattice is missing; give x1,y1,x2,y2")
    exemplar = loaded.exemplar
    if exemplar.shape[0] * exemplar.shape[1] > _LARGEST:
        raise Refusal(413, "lattice: this sample is too large to rate lattices while you wait")
    size = 64 * exemplar.shape[0] * exemplar.shape[1]
    key = "rating", id_of(loaded.spec)
    rating = session.find(lambda: LatticeRating(exemplar), lambda _: size, *key)
    return vars(rating.rate(vectors))


def _own(exemplar: Exemplar, lattice: Lattice | None, rated: Rated | None) -> Any:
    """The sample's own lattice, the only one with a confidence; None if there is none."""
    if lattice is None:
        return None
    drawn = draw(exemplar, lattice.vectors, None if rated is None else rated.goodness)
    return {**vars(drawn), "confidence": lattice.confidence}


def _mending(
    spec: Mapping[str, Any], lit_unevenly: bool, lattice: Lattice | None
) -> list[dict[str, Any]]:
    """What would help, each with what is to be added to the material's description."""
    tilted = lattice is not None and is_tilted(lattice)
    needed: dict[str, Any] = {"even_light": _DEGREE} if lit_unevenly else {}
    needed |= {"straighten": ""} if tilted else {}
    return [{"what": one, "spec": {one: needed[one]}} for one in needed if one not in spec]
