"""Results as files: any format that holds their pixels, maps as a preset wants them."""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

import weftex
from weftex.atlas import atlas
from weftex.errors import InvalidInputError, did_you_mean, shown
from weftex.io.formats import written_as
from weftex.io.packing import write_preset
from weftex.io.pictures import Picture, write_text
from weftex.io.presets import presets, read_preset
from weftex.prepare import estimate_maps, light_joints
from weftex.recipe.opening import PreparedMaterial
from weftex.studio.downloads import Downloads
from weftex.studio.results import formats_of
from weftex.studio.sessions import Session
from weftex.studio.synthesis import Result
from weftex.studio.uploads import file_in, label_of

#: What may stand beside the pictures.
BESIDE = ("source", "report", "recipe", "atlas")
FIELDS = ("maps", "format", "preset", "name", *BESIDE)
_NAME = 60  # characters
#: Of all files in a zip, as they have none of their own.
_DATE = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True)
class ExportOptions:
    """What is to be taken of a result."""

    maps: tuple[str, ...]  # all of them if empty
    format: str | None  # a suffix; as the files of each map have it if None
    preset: str | None  # a name of `weftex.io.presets.presets`
    name: str  # what files are called after
    beside: frozenset[str]  # of `BESIDE`

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
        beside = frozenset(name for name in BESIDE if given.get(name))
        name = label_of(str(given.get("name") or usual_name).replace("%", "_"))
        stem = os.path.splitext(name)[0][:_NAME] or "result"
        return cls(tuple(maps or ()), form, preset, stem, beside)


def export(made: Result, wanted: ExportOptions, downloads: Downloads, owner: str) -> dict[str, Any]:
    """Write the wanted parts of a result, one file or a zip; return the page's description."""
    with downloads.new_folder() as folder:
        files, notes = _write(made, wanted, folder)
        if len(files) == 1:
            return downloads.add(files[0], files[0].name, owner) | {"notes": notes}
        target = folder / ".all.zip"  # no map's file has this name
        with zipfile.ZipFile(target, "w") as packed:
            for file in files:
                _pack(packed, file)
                file.unlink()
        return downloads.add(target, f"{wanted.name}.zip", owner) | {"notes": notes}


def _write(made: Result, wanted: ExportOptions, folder: Path) -> tuple[list[Path], list[str]]:
    """Write what is wanted of a result into a folder; return the files, and a line a note."""
    names, notes = _files(made, wanted), list[str]()
    if wanted.preset is not None and not read_preset(wanted.preset).others:
        maps = {one: replace(made.pictures[one], pixels=made.pixels(one)) for one in names}
        roles = {one: made.map(one).role for one in names}
        written, notes = write_preset(maps, folder, wanted.preset, roles=roles, name=wanted.name)
        files = [folder / one for one in written]
    else:
        files = [folder / one for one in names.values()]
        for name, file in zip(names, files, strict=True):
            _write_map(made, name, file)
    if "source" in wanted.beside:
        files.append(folder / f"{wanted.name}.npz")
        made.result.save(files[-1])
    if "report" in wanted.beside:
        files.append(folder / f"{wanted.name}.html")
        weftex.pages.report(made.result.sample, made.result).save(files[-1])
    if "recipe" in wanted.beside:
        files.append(folder / f"{wanted.name}.weftex.json")
        write_text(files[-1], json.dumps(made.recipe.as_json(), indent=1) + "\n")
    if "atlas" in wanted.beside:
        files += _write_atlas(made, f"{wanted.name}_tiles", folder)
    return files, notes


def _write_atlas(made: Result, name: str, folder: Path) -> list[Path]:
    """Write corner tiles of the sample, a grid for each map, with index and tilesets."""
    tiles, main, maps = (
        atlas(made.result.sample, seed=made.recipe.seed),
        next(iter(made.pictures)),
        {},
    )
    for one, like in made.pictures.items():
        stem = name if len(made.pictures) == 1 else f"{name}_{one}"
        maps[label_of(stem) + _lossless(like)] = [one]
        pixels = tiles.image if one == main else tiles.maps[one]
        _write_picture(like, pixels, folder / [*maps][-1])
    texts = tiles.documents(name, next(iter(maps)), maps if len(maps) > 1 else None)
    for suffix, text in texts.items():
        write_text(folder / f"{name}{suffix}", text)
    return [folder / file for file in (*maps, *(f"{name}{suffix}" for suffix in texts))]


def _write_map(made: Result, name: str, file: Path) -> None:
    _write_picture(made.pictures[name], made.pixels(name), file)


def _write_picture(like: Picture, pixels: NDArray[Any], file: Path) -> None:
    how = {one: getattr(like, one) for one in ("alpha", "icc", "half", "density")}
    weftex.write_image(file, pixels, **how)


def _lossless(like: Picture) -> str:
    """The suffix of a format that holds such a picture without loss."""
    able = formats_of(like)
    return next(one for one in (".png", ".exr", ".tif") if one in able)


def as_sample(made: Result, downloads: Downloads, session: Session) -> dict[str, Any]:
    """Store the maps of a result as uploads, without loss; return the material that they make."""
    stem, options = made.stem, made.recipe.options
    maps: dict[str, str] = {}
    with tempfile.TemporaryDirectory(dir=downloads.folder) as folder:
        for name, like in made.pictures.items():
            suffix = _lossless(like)
            file = Path(folder) / f"{stem if len(made.pictures) == 1 else name}{suffix}"
            _write_map(made, name, file)
            maps[name] = file_in(file, session)["id"]
    spec: dict[str, Any] = {"maps": maps} if len(maps) == 1 else {"name": stem, "maps": maps}
    if options.get("tileable") is True or options.get("axes") is True:
        spec["repeats"] = True
    return spec


def with_estimates(
    loaded: PreparedMaterial, invert: bool, downloads: Downloads, session: Session
) -> dict[str, Any]:
    """Store a material as uploads, with estimates of the maps it lacks; return its description."""
    invert = invert or (not loaded.exemplar.maps and light_joints(loaded.exemplar))
    found = estimate_maps(loaded.exemplar, invert=invert)
    maps: dict[str, str] = {}
    with tempfile.TemporaryDirectory(dir=downloads.folder) as folder:
        for name in (loaded.material.main, *found.maps):
            one = found if name == loaded.material.main else found.map(name)
            suffix = ".exr" if one.pixels.dtype.kind == "f" else ".png"
            file = Path(folder) / f"{name}{suffix}"
            weftex.write_image(file, one.pixels, alpha=one.alpha, icc=one.icc)
            maps[name] = file_in(file, session)["id"]
    spec = {"name": os.path.splitext(label_of(loaded.material.name))[0], "maps": maps}
    return spec | ({"repeats": True} if found.tileable else {})


def _files(made: Result, wanted: ExportOptions) -> dict[str, str]:
    """Names of files by maps, each of them once."""
    maps = wanted.maps or tuple(made.pictures)
    files: dict[str, str] = {}
    for name in maps:
        if name not in made.pictures:
            raise InvalidInputError(f"maps has {shown(name)}{did_you_mean(name, made.pictures)}")
        suffix = _suffix(made, wanted, name)
        if wanted.preset is not None and read_preset(wanted.preset).others:
            stem = read_preset(wanted.preset).stem(wanted.name, made.map(name).role)
        else:
            stem = wanted.name if len(made.pictures) == 1 else f"{wanted.name}_{name}"
        files[name] = label_of(stem) + suffix
    for file in files.values():
        twins = [other for other in files if files[other] == file]
        if len(twins) > 1:
            raise InvalidInputError(f"maps {' and '.join(twins)} would both be named {file}")
    return files


def _suffix(made: Result, wanted: ExportOptions, name: str) -> str:
    """The suffix that is asked for, or that of the material's file, if the pixels fit."""
    like = made.pictures[name]
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
