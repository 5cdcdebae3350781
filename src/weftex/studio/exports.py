"""Results as files: any format that holds their pixels, maps by any scheme's names, batches."""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import weftex
from weftex.errors import InvalidInputError, did_you_mean, shown
from weftex.io.formats import written_as
from weftex.io.materials import Place
from weftex.io.materialx import materialx_document
from weftex.io.pictures import write_text
from weftex.io.presets import read_preset
from weftex.studio.results import formats_of
from weftex.studio.uploads import file_in, label_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from weftex.studio.downloads import Downloads
    from weftex.studio.sessions import Session
    from weftex.studio.synthesis import Result

#: What may stand beside the pictures.
BESIDE = ("mtlx", "source", "report", "recipe")
#: Presets that only rename.
SCHEMES = ("ambientcg", "polyhaven", "substance")
FIELDS = ("maps", "format", "names", "name", *BESIDE)
_NAME = 60  # characters
#: Of all files in a zip, as they have none of their own.
DATE = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True)
class ExportOptions:
    """What is to be taken of a result."""

    maps: tuple[str, ...]  # all of them if empty
    format: str | None  # a suffix; as the files of each map have it if None
    names: str | None  # one of `SCHEMES`
    name: str  # what files are called after
    beside: frozenset[str]  # of `BESIDE`

    @classmethod
    def of(cls, given: Mapping[str, Any], usual_name: str) -> ExportOptions:
        """Read what the page sent."""
        maps, form, names = (given.get(key) for key in ("maps", "format", "names"))
        if not isinstance(maps or [], list) or not all(isinstance(m, str) for m in maps or ()):
            raise InvalidInputError(f"maps is {shown(maps)}; it must be a list of names")
        if not isinstance(form, (str, type(None))):
            raise InvalidInputError(f"format is {shown(form)}; it must be a suffix")
        if names is not None and names not in SCHEMES:
            raise InvalidInputError(f"names is {shown(names)}{did_you_mean(str(names), SCHEMES)}")
        beside = frozenset(name for name in BESIDE if given.get(name))
        name = str(given.get("name") or usual_name)
        return cls(tuple(maps or ()), form, names, "", beside).named(name)

    def named(self, name: str) -> ExportOptions:
        """Return the same for files that are called after this."""
        stem = os.path.splitext(label_of(name.replace("%", "_")))[0][:_NAME] or "result"
        return replace(self, name=stem)


def export(made: Result, wanted: ExportOptions, downloads: Downloads, owner: str) -> dict[str, Any]:
    """Write the wanted parts of a result, one file or a zip; return the page's description."""
    with downloads.new_folder() as folder:
        files = write(made, wanted, folder)
        if len(files) == 1:
            return downloads.add(files[0], files[0].name, owner)
        target = folder / ".all.zip"  # no map's file has this name
        with zipfile.ZipFile(target, "w") as packed:
            for file in files:
                pack(packed, file, file.name)
                file.unlink()
        return downloads.add(target, f"{wanted.name}.zip", owner)


def write(made: Result, wanted: ExportOptions, folder: Path) -> list[Path]:
    """Write what is wanted of a result into a folder; the files."""
    files, written = [], _files(made, wanted)
    for name, file in written.items():
        like = made.pictures[name]
        how: dict[str, Any] = {"alpha": like.alpha, "icc": like.icc, "half": like.half}
        how["density"] = like.density
        weftex.write_image(folder / file, made.pixels(name), **how)
        files.append(folder / file)
    if "mtlx" in wanted.beside:
        files.append(_material_file(made, wanted, written, folder))
    if "source" in wanted.beside:
        files.append(folder / f"{wanted.name}.npz")
        made.result.save(files[-1])
    if "report" in wanted.beside:
        files.append(folder / f"{wanted.name}.html")
        weftex.pages.report(made.result.sample, made.result).save(files[-1])
    if "recipe" in wanted.beside:
        files.append(folder / f"{wanted.name}.weftex.json")
        write_text(files[-1], json.dumps(made.recipe.as_json(), indent=1) + "\n")
    return files


def as_sample(made: Result, downloads: Downloads, session: Session) -> dict[str, Any]:
    """Store the maps of a result as uploads, without loss; return the material that they make."""
    stem, options = made.stem, made.recipe.options
    maps: dict[str, str] = {}
    with tempfile.TemporaryDirectory(dir=downloads.folder) as folder:
        for name, like in made.pictures.items():
            able = formats_of(like)
            suffix = next(one for one in (".png", ".exr", ".tif") if one in able)
            file = Path(folder) / f"{stem if len(made.pictures) == 1 else name}{suffix}"
            how: dict[str, Any] = {"alpha": like.alpha, "icc": like.icc, "half": like.half}
            how["density"] = like.density
            weftex.write_image(file, made.pixels(name), **how)
            maps[name] = file_in(file, session)["id"]
    spec: dict[str, Any] = {"maps": maps} if len(maps) == 1 else {"name": stem, "maps": maps}
    if options.get("tileable") is True or options.get("axes") is True:
        spec["repeats"] = True
    return spec


def _files(made: Result, wanted: ExportOptions) -> dict[str, str]:
    """Names of files by maps, each of them once."""
    maps = wanted.maps or tuple(made.pictures)
    files: dict[str, str] = {}
    for name in maps:
        if name not in made.pictures:
            raise InvalidInputError(f"maps has {shown(name)}{did_you_mean(name, made.pictures)}")
        suffix = _suffix(made, wanted, name)
        if wanted.names is not None:
            stem = read_preset(wanted.names).stem(wanted.name, made.map(name).role)
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


def _material_file(
    made: Result, wanted: ExportOptions, files: dict[str, str], folder: Path
) -> Path:
    where = {made.map(name).role.name: Place(file) for name, file in files.items()}
    write_text(folder / f"{wanted.name}.mtlx", materialx_document(wanted.name, where))
    return folder / f"{wanted.name}.mtlx"


def pack(packed: zipfile.ZipFile, file: Path, name: str) -> None:
    """Put a file into a zip; pictures are packed already, and the date is no file's own."""
    about = zipfile.ZipInfo(name, DATE)
    about.external_attr = 0o644 << 16
    with file.open("rb") as source, packed.open(about, "w", force_zip64=True) as target:
        while chunk := source.read(2**20):
            target.write(chunk)
