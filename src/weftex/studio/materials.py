"""Materials as the page names them, and what analysis says about them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import partial
from typing import Any

import weftex
from weftex import Exemplar
from weftex.analysis.overlay import Lattice, LatticeRating, Rated, draw
from weftex.io.pictures import Picture
from weftex.prepare.straightening import is_tilted
from weftex.recipe import checked_material, pictures_of
from weftex.recipe.opening import PreparedMaterial, prepare_material, read_described
from weftex.roles import COLOR, is_preview, role_of, words_of
from weftex.studio.pictures import formats_of
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import Session
from weftex.studio.uploads import picture_of, stem_of


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
    for one in sorted(uploads, key=lambda one: one["name"]):
        stem = stem_of(one["name"])
        role = role_of(stem)
        if role is None or len(uploads) == 1:
            singles.append(one)
            continue
        about = {*" ".join(role.files).split(), *role.name.split("_")}
        group = groups.setdefault(tuple(w for w in words_of(stem) if w not in about), {})
        first = group.setdefault(role.name, one)
        if first is not one:
            notes.append(f"{one['name']} is ignored: {first['name']} is also {role.name}")
    for name, group in groups.items():
        own = [one for one in singles if tuple(words_of(stem_of(one["name"]))) == name]
        if COLOR.name not in group and len(own) == 1:  # the material under its bare name
            group[COLOR.name] = own[0]
            singles.remove(own[0])
    previews = [one for one in singles if groups and is_preview(stem_of(one["name"]))]
    notes += [f"{one['name']} is ignored: it is a preview" for one in previews]
    specs = []
    for name, group in groups.items():
        maps = {role: one["id"] for role, one in group.items()}
        specs.append({"name": "_".join(name) or "material", "maps": maps})
    specs += [{"maps": {COLOR.name: one["id"]}} for one in singles if one not in previews]
    return specs, notes


def described(loaded: PreparedMaterial) -> dict[str, Any]:
    """Return a material as JSON for the page."""
    exemplar, material = loaded.exemplar, loaded.stored
    return {
        "id": id_of(loaded.spec),
        "name": material.name,
        **pictures_as_json(exemplar, material.pictures, material.main),
        "width": exemplar.shape[1],
        "height": exemplar.shape[0],
        "file": stem_of(material.name),
        "notes": [line.removeprefix("map: ") for line in material.notes],
    }


def pictures_as_json(
    exemplar: Exemplar, pictures: Mapping[str, Picture], main: str
) -> dict[str, Any]:
    """Return what the page gets of the pictures of a material, and of a result alike."""
    return {
        "main": main,
        "maps": maps_of(exemplar, main),
        "formats": {name: formats_of(picture) for name, picture in pictures.items()},
        "density": pictures[main].density,
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
_DEGREE = 2  # of the light that the button takes off


def analysis_of(loaded: PreparedMaterial, session: Session) -> dict[str, Any]:
    """Return what a material is like; larger ones are analyzed by a smaller copy."""
    return session.find(lambda: _analysis(loaded), lambda _: 2**14, "analysis", id_of(loaded.spec))


def _analysis(loaded: PreparedMaterial) -> dict[str, Any]:
    exemplar = loaded.exemplar
    height, width = exemplar.shape
    found: Any
    more: dict[str, Any]
    if height * width > _LARGEST:  # what `auto` finds in a smaller copy, and in a part
        model = weftex.Auto().fit_exemplar(exemplar)
        found, choice, rated = model.findings, model.choose((2 * height, 2 * width)), None
        exact = model.lattice
        more = {
            "confidence": None,
            "scale_source": "smaller copy",
            "regularity": None,
            "runners_up": [],
            "tiles": None,
            "text": f"{width}x{height}, analyzed on a smaller copy\n{choice}",
        }
    else:
        found = weftex.analyze(exemplar)
        choice, rated, others = found.choice, found.ratings.found, found.ratings.runners_up
        exact = found.lattice
        more = {
            "confidence": found.confidence,
            "scale_source": found.scale_source,
            "regularity": found.regularity,
            "runners_up": [vars(draw(exemplar, one.vectors, one.goodness)) for one in others],
            "tiles": list(found.tiles),
            "text": str(found),
        }
    needed: dict[str, Any] = {"even_light": _DEGREE} if found.evenness.lit_unevenly else {}
    if exact is not None and is_tilted(exact):
        needed["straighten"] = ""
    return more | {
        "scale": found.scale,
        "lattice": _own(exemplar, found.lattice, rated),
        "auto": choice.as_dict(),
        # What would help, each with what is to be added to the material's description.
        "mending": [{"what": k, "spec": {k: v}} for k, v in needed.items() if k not in loaded.spec],
    }


def rate_lattice(loaded: PreparedMaterial, vectors: str, session: Session) -> dict[str, Any]:
    """Return how good a lattice is that somebody drew, or raise `InvalidInputError`."""
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
