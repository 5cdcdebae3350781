"""Results, materials and atlases as files, in any format that holds their pixels."""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from numpy.typing import NDArray

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
from weftex.recipe.opening import PreparedMaterial, prepare_material, times_of
from weftex.studio.downloads import Downloads
from weftex.studio.jobs import Job
from weftex.studio.materials import id_of
from weftex.studio.pictures import formats_of
from weftex.studio.pictures import shown as shown_pixels
from weftex.studio.refusals import Refusal
from weftex.studio.results import preview_of
from weftex.studio.sessions import Session
from weftex.studio.synthesis import Result
from weftex.studio.uploads import file_in, label_of

#: What may stand beside the pictures of a result.
BESIDE = ("source", "report", "recipe")
#: What changes the pictures that are saved.
CHANGES = {"density": MATERIAL["density"], "pad": PAD, "crop": CROP}
FIELDS = ("maps", "format", "preset", "name", *BESIDE, *CHANGES)
_NAME = 60  # characters
_PLANE = 6  # tiles a side, of a plane that shows what an atlas is for
#: Of all files in a zip, as they have none of their own.
_DATE = (1980, 1, 1, 0, 0, 0)


class Source(NamedTuple):
    """What is checked and saved: a result, or a material as it is."""

    id: str
    material: Material
    stem: str
    sample: Exemplar
    tileable: bool
    made: Result | None

    @classmethod
    def of(cls, given: Result | PreparedMaterial) -> Source:
        """Return its pictures, and what atlases are made of."""
        if isinstance(given, Result):
            sample = given.result.sample
            return cls(given.id, given.material, given.stem, sample, given.tileable, given)
        stem = os.path.splitext(label_of(given.material.name))[0]
        own = id_of(given.spec), given.stored, stem, given.exemplar
        return cls(*own, given.exemplar.tileable, None)


@dataclass(frozen=True)
class ExportOptions:
    """What is to be taken of a result."""

    maps: tuple[str, ...]  # all of them if empty
    format: str | None  # a suffix; as the files of each map have it if None
    preset: str | None  # a name of `weftex.io.presets.presets`
    name: str  # what files are called after
    beside: frozenset[str]  # of `BESIDE`
    changes: dict[str, Any]  # of `CHANGES`

    @classmethod
    def of(cls, given: Mapping[str, Any], usual_name: str) -> ExportOptions:
        """Read what the page sent."""
        maps, form, preset = (given.get(key) for key in ("maps", "format", "preset"))
        if not isinstance(maps or [], list) or not all(isinstance(m, str) for m in maps or ()):
            raise InvalidInputError(f"maps is {shown(maps)}; it must be a list of names")
        if not isinstance(form, (str, type(None))):
            raise InvalidInputError(f"format is {shown(form)}; it must be a suffix")
        if preset is not None:
            if preset not in presets():
                known = did_you_mean(str(preset), presets())
                raise InvalidInputError(f"preset is {shown(preset)}{known}")
            if form is not None and not read_preset(preset).others:
                raise InvalidInputError(f"format has no effect beside the preset {preset}")
        changes = {
            key: one.checked(given[key])
            for key, one in CHANGES.items()
            if given.get(key) is not None
        }
        if {"pad", "crop"} <= changes.keys():
            raise InvalidInputError("pad and crop exclude each other")
        beside = frozenset(name for name in BESIDE if given.get(name))
        return cls(tuple(maps or ()), form, preset, _stem(given, usual_name), beside, changes)


def _stem(given: Mapping[str, Any], usual: str) -> str:
    """Return what files are called after, by the name that the page sent."""
    name = label_of(str(given.get("name") or usual).replace("%", "_"))
    return os.path.splitext(name)[0][:_NAME] or "result"


def export(
    source: Source, wanted: ExportOptions, downloads: Downloads, session: Session
) -> dict[str, Any]:
    """Write what is wanted of a result or a material; return the page's description of it."""
    if source.made is None and wanted.beside:
        raise InvalidInputError(f"{min(wanted.beside)} needs a result, and this is a material")
    with downloads.new_folder() as folder:
        files, notes = _write(source, wanted, folder, session.limits.output_pixels)
        return _ready(files, wanted.name, folder, downloads, session) | {"notes": notes}


def _ready(
    files: list[Path], name: str, folder: Path, downloads: Downloads, session: Session
) -> dict[str, Any]:
    """Make files ready to be downloaded, several as a zip; return the page's description."""
    if len(files) == 1:
        return downloads.add(files[0], files[0].name, session.key)
    target = folder / ".all.zip"  # no map's file has this name
    with zipfile.ZipFile(target, "w") as packed:
        for file in files:
            _pack(packed, file)
            file.unlink()
    return downloads.add(target, f"{name}.zip", session.key)


def _write(
    source: Source, wanted: ExportOptions, folder: Path, most: int
) -> tuple[list[Path], list[str]]:
    """Write what is wanted into a folder; return the files, and a line a note."""
    changed = _changed(source, wanted.changes, most)
    names, notes = _files(changed, wanted), list[str]()
    if wanted.preset is not None and not read_preset(wanted.preset).others:
        maps = {one: changed.pictures[one] for one in names}
        written, notes = write_preset(
            maps, folder, wanted.preset, roles=changed.roles, name=wanted.name
        )
        files = [folder / one for one in written]
    else:
        files = [folder / one for one in names.values()]
        for name, file in zip(names, files, strict=True):
            _write_picture(changed.pictures[name], file)
    made = source.made
    if made is None:
        return files, notes  # `export` refuses what stands beside results
    if "source" in wanted.beside:
        files.append(folder / f"{wanted.name}.npz")
        made.result.save(files[-1])
    if "report" in wanted.beside:
        files.append(folder / f"{wanted.name}.html")
        weftex.pages.report(made.result.sample, made.result).save(files[-1])
    if "recipe" in wanted.beside:
        files.append(folder / f"{wanted.name}.weftex.json")
        write_text(files[-1], json.dumps(made.recipe.as_json(), indent=1) + "\n")
    return files, notes


def _changed(source: Source, changes: Mapping[str, Any], most: int) -> Material:
    """Return the pictures to save: at another density, with a border or without one."""
    material = source.material
    if "density" in changes:
        spec = {"density": changes["density"], "repeats": source.tileable}
        pixels = material.pictures[material.main].pixels
        if pixels.shape[0] * pixels.shape[1] * times_of(material, spec) ** 2 > most:
            raise Refusal(
                413, f"density: the studio saves at most {most / 2**20:g} megapixels", "density"
            )
        material = prepare_material(spec, material, weftex.read_image).stored
    return with_border(material, **{key: changes[key] for key in changes if key != "density"})


class Tiles(NamedTuple):
    """An atlas, and what its files are like."""

    atlas: Atlas
    material: Material


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


def tiles_for(name: str, session: Session) -> Tiles:
    """Return an atlas of a session, or raise `Refusal`."""
    found: Tiles | None = session.recall("atlas", name)
    if found is None:
        raise Refusal(410, "this atlas is no longer in memory; make it again")
    return found


def tiles_picture(tiles: Tiles, plane: bool) -> NDArray[Any]:
    """Return an atlas, or a plane of its tiles, as a screen shows it."""
    made = tiles.atlas
    pixels = made.plane(_PLANE, _PLANE, seed=1) if plane else made.image
    return shown_pixels(made.synthesis.sample, pixels)


def save_tiles(
    tiles: Tiles, given: Mapping[str, Any], downloads: Downloads, session: Session
) -> dict[str, Any]:
    """Write a grid for each map, the index and tilesets; return the page's description."""
    (made, material), maps, name = tiles, {}, _stem(given, "atlas")
    with downloads.new_folder() as folder:
        for one, like in material.pictures.items():
            stem = name if len(material.pictures) == 1 else f"{name}_{one}"
            file = label_of(stem) + _lossless(like)
            maps[file] = [one]
            pixels = made.image if one == material.main else made.maps[one]
            _write_picture(replace(like, pixels=pixels), folder / file)
        image = next(file for file, (one,) in maps.items() if one == material.main)
        texts = made.documents(name, image, maps if len(maps) > 1 else None)
        for suffix, text in texts.items():
            write_text(folder / f"{name}{suffix}", text)
        files = [folder / file for file in (*maps, *(f"{name}{suffix}" for suffix in texts))]
        return _ready(files, name, folder, downloads, session)


def _write_picture(like: Picture, file: Path) -> None:
    how = {one: getattr(like, one) for one in ("alpha", "icc", "half", "density")}
    weftex.write_image(file, like.pixels, **how)


def _lossless(like: Picture) -> str:
    """The suffix of a format that holds such a picture without loss."""
    able = formats_of(like)
    return next(one for one in (".png", ".exr", ".tif") if one in able)


def _store(
    pictures: Mapping[str, Picture], name: str, downloads: Downloads, session: Session
) -> dict[str, Any]:
    """Store pictures as uploads, without loss; return the material that they make."""
    maps = {}
    with tempfile.TemporaryDirectory(dir=downloads.folder) as folder:
        for one, picture in pictures.items():
            stem = name if len(pictures) == 1 else one
            file = Path(folder) / f"{stem}{_lossless(picture)}"
            _write_picture(picture, file)
            maps[one] = file_in(file, session)["id"]
    return {"maps": maps} if len(maps) == 1 else {"name": name, "maps": maps}


def as_sample(made: Result, downloads: Downloads, session: Session) -> dict[str, Any]:
    """Store the maps of a result; return the material that they make."""
    spec = _store(made.material.pictures, made.stem, downloads, session)
    return spec | ({"repeats": True} if made.tileable else {})


def with_estimates(
    loaded: PreparedMaterial, invert: bool, downloads: Downloads, session: Session
) -> dict[str, Any]:
    """Store a material as uploads, with estimates of the maps it lacks; return its description."""
    invert = invert or (not loaded.exemplar.maps and light_joints(loaded.exemplar))
    found = estimate_maps(loaded.exemplar, invert=invert)
    own, name = loaded.stored.pictures, os.path.splitext(label_of(loaded.material.name))[0]
    main = own[loaded.material.main]
    pictures = {loaded.material.main: main}
    for key in found.maps:
        one = found.map(key)
        pictures[key] = own.get(key) or replace(main, pixels=one.pixels, alpha=one.alpha, icc=None)
    spec = _store(pictures, name, downloads, session)
    return spec | ({"repeats": True} if found.tileable else {})


def _files(material: Material, wanted: ExportOptions) -> dict[str, str]:
    """Names of files by maps, each of them once."""
    pictures = material.pictures
    maps = wanted.maps or tuple(pictures)
    files: dict[str, str] = {}
    for name in maps:
        if name not in pictures:
            raise InvalidInputError(f"maps has {shown(name)}{did_you_mean(name, pictures)}")
        suffix = _suffix(pictures[name], wanted, name)
        if wanted.preset is not None and read_preset(wanted.preset).others:
            stem = read_preset(wanted.preset).stem(wanted.name, material.roles[name])
        else:
            stem = wanted.name if len(pictures) == 1 else f"{wanted.name}_{name}"
        files[name] = label_of(stem) + suffix
    for file in files.values():
        twins = [other for other in files if files[other] == file]
        if len(twins) > 1:
            raise InvalidInputError(f"maps {' and '.join(twins)} would both be named {file}")
    return files


def _suffix(like: Picture, wanted: ExportOptions, name: str) -> str:
    """The suffix that is asked for, or that of the material's file, if the pixels fit."""
    able, floats = formats_of(like), like.pixels.dtype.kind == "f"
    if wanted.format is None:
        own = written_as(like.path, floats).lower().replace(".jpeg", ".jpg").replace("tiff", "tif")
        return own if own in able else ".exr" if floats else ".png"
    if wanted.format not in able:
        able_text = ", ".join(able)
        raise InvalidInputError(
            f"format of {name} is {shown(wanted.format)}; these hold it: {able_text}"
        )
    return wanted.format


def _pack(packed: zipfile.ZipFile, file: Path) -> None:
    """Store a file in a zip, uncompressed (pictures are packed already), with a fixed date."""
    about = zipfile.ZipInfo(file.name, _DATE)
    about.external_attr = 0o644 << 16
    with file.open("rb") as source, packed.open(about, "w", force_zip64=True) as target:
        while chunk := source.read(2**20):
            target.write(chunk)
