"""Results, materials and atlases as files, in any format; their routes, and those of checks."""

from __future__ import annotations

import json
import math
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import weftex
from weftex import Exemplar
from weftex.atlas import Atlas, atlas
from weftex.errors import InvalidInputError, did_you_mean, shown
from weftex.exemplar.material import Material, with_border
from weftex.io.formats import written_as
from weftex.io.packing import write_preset
from weftex.io.pictures import Picture, write_text
from weftex.io.presets import presets, read_preset
from weftex.prepare import estimate_maps, light_joints
from weftex.recipe import ATLAS, CROP, MATERIAL, PAD
from weftex.recipe.opening import PreparedMaterial, prepare_material
from weftex.studio.jobs import Job
from weftex.studio.materials import id_of
from weftex.studio.pictures import Bytes, formats_of, on_screen, preview_of
from weftex.studio.refusals import Refusal
from weftex.studio.requests import Call, route
from weftex.studio.results import Result, borders_of_maps, drawn_borders
from weftex.studio.routes import found, loaded_of, queued, reduced, result_of
from weftex.studio.sessions import Session
from weftex.studio.uploads import file_in, label_of, stem_of

#: What may stand beside the pictures of a result, and how its file ends.
BESIDE = {"source": ".npz", "report": ".html", "recipe": ".weftex.json"}
#: What changes the pictures that are saved.
CHANGES = {"density": MATERIAL["density"], "pad": PAD, "crop": CROP}
FIELDS = ("maps", "format", "preset", "name", *BESIDE, *CHANGES)
_NAME = 60  # characters
_PLANE = 6  # tiles a side, of a plane that shows what an atlas is for


class Source(NamedTuple):
    """What is checked and saved: a result, or a material as it is."""

    id: str
    material: Material
    stem: str
    sample: Exemplar  # what atlases are made of
    tileable: bool
    made: Result | None


async def source_of(call: Call) -> Source:
    """The result, or the material as it is, of an address."""
    if call.request.url.path.startswith("/api/materials/"):
        loaded = await loaded_of(call)
        sample, own = loaded.exemplar, loaded.stored
        return Source(id_of(loaded.spec), own, stem_of(own.name), sample, sample.tileable, None)
    made = result_of(call)
    material = await call.work(lambda: made.material)  # its maps are rendered
    return Source(made.id, material, made.stem, made.result.sample, made.tileable, made)


@route("POST", "/materials/{id}/exports")
@route("POST", "/results/{id}/exports")
async def add_export(call: Call) -> Any:
    """Write files of a result or a material, ready to be downloaded."""
    given = await call.object(*FIELDS)
    return await call.work(export, await source_of(call), given, call.session)


def export(source: Source, given: Mapping[str, Any], session: Session) -> dict[str, Any]:
    """Write what the page wants of a result or a material; return its description of it."""
    form, preset, known = given.get("format"), given.get("preset"), [*source.material.pictures]
    maps = given.get("maps") or known
    if not isinstance(maps, list) or not all(one in known for one in maps):
        raise InvalidInputError(f"maps is {shown(maps)}; it must list some of {', '.join(known)}")
    if preset is not None and preset not in [*presets()]:
        raise InvalidInputError(f"preset is {shown(preset)}{did_you_mean(str(preset), presets())}")
    renames = preset is None or bool(read_preset(preset).others)
    if form is not None and not renames:
        raise InvalidInputError(f"format has no effect beside the preset {preset}")
    made, beside = source.made, [one for one in BESIDE if given.get(one)]
    if made is None and beside:
        raise InvalidInputError(f"{beside[0]} needs a result, and this is a material")
    changed = _changed(source, given, session.limits.output_pixels)
    name, notes = _stem(given, source.stem), list[str]()
    pictures = {one: changed.pictures[one] for one in maps}
    if renames:
        for one, like in pictures.items():
            pictures[one] = replace(like, path=name + _suffix(like, form, one))
    with session.store.downloads.new_folder() as folder:
        if len(known) == 1 and preset is None:
            files = [folder / one.path for one in pictures.values()]
            _write_picture(pictures[known[0]], files[0])
        else:
            roles = {one: changed.roles[one] for one in maps}
            roles = {k: replace(one, name=label_of(one.name)) for k, one in roles.items()}
            how: dict[str, Any] = {"roles": roles, "name": name}
            written, notes = write_preset(pictures, folder, preset or "weftex", **how)
            files = [folder / one for one in written]
        if made is not None:
            files += [_write_beside(made, one, folder / f"{name}{BESIDE[one]}") for one in beside]
        return _ready(files, name, session) | {"notes": notes}


def _changed(source: Source, given: Mapping[str, Any], most: int) -> Material:
    """Return the pictures to save: at another density, with a border or without one."""
    wanted = {k: one.checked(given[k]) for k, one in CHANGES.items() if given.get(k) is not None}
    if {"pad", "crop"} <= wanted.keys():
        raise InvalidInputError("give pad or crop, not both")
    material = source.material
    if density := wanted.pop("density", None):
        main = material.pictures[material.main]
        times = density / (main.density or math.inf)  # without one it is refused below
        if math.prod(main.pixels.shape[:2]) * times**2 > most:
            raise Refusal(
                413, f"density: the studio saves at most {most / 2**20:g} megapixels", "density"
            )
        spec = {"density": density, "repeats": source.tileable}
        material = prepare_material(spec, material, weftex.read_image).stored
    return with_border(material, **wanted)


def _stem(given: Mapping[str, Any], usual: str) -> str:
    """Return what files are called after, by the name that the page sent."""
    return stem_of(str(given.get("name") or usual).replace("%", "_"))[:_NAME] or "result"


def _suffix(like: Picture, form: Any, name: str) -> str:
    """The suffix that is asked for, or that of the material's file, if the pixels fit."""
    able, floats = formats_of(like), like.pixels.dtype.kind == "f"
    if form is None:
        own = written_as(like.path, floats).lower().replace(".jpeg", ".jpg").replace("tiff", "tif")
        return own if own in able else ".exr" if floats else ".png"
    if form not in able:
        raise InvalidInputError(f"format of {name} is {shown(form)}; give one of {', '.join(able)}")
    return str(form)


def _lossless(like: Picture) -> str:
    """The suffix of a format that holds such a picture without loss."""
    able = formats_of(like)
    return next(one for one in (".png", ".exr", ".tif") if one in able)


def _write_picture(like: Picture, file: Path) -> None:
    how = {one: getattr(like, one) for one in ("alpha", "icc", "half", "density")}
    weftex.write_image(file, like.pixels, **how)


def _write_beside(made: Result, what: str, file: Path) -> Path:
    """Write one of `BESIDE`; return the file."""
    if what == "source":
        made.result.save(file)
    elif what == "report":
        weftex.pages.report(made.result.sample, made.result).save(file)
    else:
        write_text(file, json.dumps(made.recipe.as_json(), indent=1) + "\n")
    return file


def _ready(files: list[Path], name: str, session: Session) -> dict[str, Any]:
    """Make files ready to be downloaded, several as a zip; return the page's description."""
    if len(files) == 1:
        return session.store.downloads.add(files[0], files[0].name, session.key)
    target = files[0].with_name(".all.zip")  # no map's file has this name
    with zipfile.ZipFile(target, "w") as packed:  # uncompressed, as pictures are already
        for file in files:
            about = zipfile.ZipInfo(file.name)  # of 1980: no two exports differ
            about.external_attr = 0o644 << 16
            with file.open("rb") as source, packed.open(about, "w", force_zip64=True) as into:
                shutil.copyfileobj(source, into)
            file.unlink()
    return session.store.downloads.add(target, f"{name}.zip", session.key)


@route("POST", "/materials/{id}/borders")
@route("POST", "/results/{id}/borders")
async def borders(call: Call) -> Any:
    """Queue a job that says how each map wraps around; it ends one that is under way."""
    return await found(call, "borders", borders_of_maps, (await source_of(call)).material)


@route("GET", "/materials/{id}/borders/picture")
@route("GET", "/results/{id}/borders/picture")
async def borders_picture(call: Call) -> Any:
    """Show the borders of a map, in the middle of the picture."""
    material = (await source_of(call)).material
    name = call.query.get("map", material.main)
    return await reduced(call, await call.work(drawn_borders, material, name))


class Tiles(NamedTuple):
    """An atlas, and what its files are like."""

    atlas: Atlas
    material: Material


@route("POST", "/materials/{id}/atlases")
@route("POST", "/results/{id}/atlases")
async def add_atlas(call: Call) -> Any:
    """Queue a job that makes an atlas of the sample; it ends the one before it."""
    given = await call.object(*ATLAS)
    return await queued(call, tiles_of(await source_of(call), given), "atlas")


def tiles_of(source: Source, given: Mapping[str, Any]) -> Callable[[Job], None]:
    """Make an atlas of corner tiles of the sample, with the options of the command."""
    side = given.get("tile_size")
    given = {**given, "tile_size": [side, side] if isinstance(side, int) else side}
    own = {k: one.checked(given[k]) for k, one in ATLAS.items() if given.get(k) is not None}
    seed = 1 if source.made is None else source.made.recipe.seed
    name = id_of({"atlas": source.id, **own})

    def work(job: Job) -> None:
        def make() -> Tiles:
            return Tiles(atlas(source.sample, seed=seed, progress=job, **own), source.material)

        job.to_show = preview_of(source.sample)
        made = job.session.find(make, lambda one: 4 * one.atlas.image.nbytes, "atlas", name).atlas
        tile, sides = made.tile_size, made.image.shape
        count = {"tiles": made.colors**4, "tile": tile, "width": sides[1], "height": sides[0]}
        job.add({"id": name, "notes": made.notes, **count})

    return work


def tiles_for(call: Call) -> Tiles:
    """Return the atlas of an address."""
    gone = Refusal(410, "this atlas is no longer in memory; make it again")
    found: Tiles = call.session.recall("atlas", call.id, gone=gone)
    return found


@route("GET", "/atlases/{id}/picture")
async def atlas_picture(call: Call) -> Any:
    """Show an atlas, or with `plane` a plane of its tiles."""
    made = tiles_for(call).atlas

    def draw() -> Bytes:
        pixels = made.plane(_PLANE, _PLANE, seed=1) if "plane" in call.query else made.image
        return on_screen(made.synthesis.sample, pixels)

    return await reduced(call, await call.work(draw))


@route("POST", "/atlases/{id}/exports")
async def export_atlas(call: Call) -> Any:
    """Write the files of an atlas, ready to be downloaded."""
    given = await call.object("name")
    return await call.work(save_tiles, tiles_for(call), given, call.session)


def save_tiles(tiles: Tiles, given: Mapping[str, Any], session: Session) -> dict[str, Any]:
    """Write a grid for each map, the index and tilesets; return the page's description."""
    (made, material), maps, image, name = tiles, {}, "", _stem(given, "atlas")
    with session.store.downloads.new_folder() as folder:
        for one, like in material.pictures.items():
            stem = name if len(material.pictures) == 1 else f"{name}_{one}"
            file, is_main = label_of(stem) + _lossless(like), one == material.main
            maps[file], image = [one], file if is_main else image
            pixels = made.image if is_main else made.maps[one]
            _write_picture(replace(like, pixels=pixels), folder / file)
        texts = made.documents(name, image, maps if len(maps) > 1 else None)
        for suffix, text in texts.items():
            write_text(folder / f"{name}{suffix}", text)
        files = [folder / file for file in (*maps, *(f"{name}{suffix}" for suffix in texts))]
        return _ready(files, name, session)


@route("POST", "/results/{id}/sample")
async def use_as_sample(call: Call) -> Any:
    """Make a result a material."""
    source = await source_of(call)
    pictures = source.material.pictures
    return await call.work(_store, pictures, source.stem, source.tileable, call.session)


@route("POST", "/materials/{id}/estimates")
async def estimate(call: Call) -> Any:
    """Queue a job that makes a material with estimates of the maps that this one lacks."""
    invert = bool((await call.object("invert")).get("invert"))
    return await found(call, None, with_estimates, await loaded_of(call), invert, call.session)


def with_estimates(loaded: PreparedMaterial, invert: bool, session: Session) -> dict[str, Any]:
    """Store a material as uploads, with estimates of the maps it lacks; return its description."""
    invert = invert or (not loaded.exemplar.maps and light_joints(loaded.exemplar))
    estimated, own = estimate_maps(loaded.exemplar, invert=invert), loaded.stored
    pictures = {own.main: own.pictures[own.main]}
    like = replace(pictures[own.main], icc=None, half=False)
    for key in estimated.maps:
        one = estimated.map(key)
        pictures[key] = own.pictures.get(key) or replace(like, pixels=one.pixels, alpha=one.alpha)
    return _store(pictures, stem_of(own.name), estimated.tileable, session)


def _store(
    pictures: Mapping[str, Picture], name: str, tileable: bool, session: Session
) -> dict[str, Any]:
    """Store pictures as uploads, without loss; return the material that they make."""
    maps: dict[str, str] = {}
    with tempfile.TemporaryDirectory(dir=session.store.downloads.folder) as folder:
        for one, picture in pictures.items():
            stem = name if len(pictures) == 1 else one
            file = Path(folder) / f"{stem}{_lossless(picture)}"
            _write_picture(picture, file)
            maps[one] = file_in(file, session)["id"]
    spec: dict[str, Any] = {"maps": maps} if len(maps) == 1 else {"name": name, "maps": maps}
    return spec | ({"repeats": True} if tileable else {})
