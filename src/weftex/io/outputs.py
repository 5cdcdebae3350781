"""The files of an image or a map set: their pixels, made from those of the maps, and writing."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError
from weftex.io.formats import FORMATS, suffix_of, written_as
from weftex.io.pictures import Picture, check_output, write_bytes, write_image
from weftex.raster.levels import to_light, to_stored
from weftex.raster.mixing import middle_of, opposite, vectors_of
from weftex.roles import ROLES, UNUSED, width_of
from weftex.threads import in_turn, thread_count

Pixels = NDArray[Any]
#: Pixels by the names of maps.
PixelsOf = Callable[[str], Pixels]


class Part(NamedTuple):
    """A role in a file, and where its channels come from."""

    role: str
    source: str = ""  # the name of a map; without, `value` everywhere
    channel: int | None = None  # of a packed map
    reverse: bool = False
    strip: bool = False  # leave out the map's alpha
    value: float = 0.0


class OutputFile(NamedTuple):
    """A file to write."""

    name: str
    parts: tuple[Part, ...]
    dtype: np.dtype[Any]
    alpha: bool = False
    icc: bytes | None = None
    half: bool = False
    density: float | None = None

    def pixels(self, pixels_of: PixelsOf) -> Pixels:
        """Return the pixels of the file, from those of the maps."""
        made = {one: self._made(one, pixels_of(one.source)) for one in self.parts if one.source}
        first = next(iter(made.values()))
        if len(self.parts) == 1:
            return first
        top = 1.0 if self.dtype.kind == "f" else np.iinfo(self.dtype).max
        channels = []
        for one in self.parts:
            if one.source:
                pixels, width = np.atleast_3d(made[one]), width_of(one.role)
                narrow = pixels.shape[2] < width
                channels.append(pixels.repeat(width, 2) if narrow else pixels[..., :width])
            else:
                value = one.value * top if self.dtype.kind == "f" else round(one.value * top)
                channels.append(np.full((*first.shape[:2], 1), value, self.dtype))
        return np.concatenate(channels, axis=2)

    def _made(self, part: Part, pixels: Pixels) -> Pixels:
        if part.channel is not None:
            pixels = pixels[..., part.channel]
        elif part.strip:
            pixels = pixels[..., 0] if pixels.shape[2] == 2 else pixels[..., :-1]
        if part.reverse:
            pixels = reversed_map(pixels, part.role)
        return _converted(pixels, part.role, self.dtype, self.alpha and len(self.parts) == 1)


def reversed_map(pixels: Pixels, role: str) -> Pixels:
    """Return gloss of roughness, normals whose y points the other way, and the reverse."""
    if ROLES[role].kind != "normal":
        return opposite(pixels, 0.5)
    pixels = pixels.copy()
    pixels[..., 1] = opposite(pixels[..., 1], middle_of(pixels))
    return pixels


def _converted(pixels: Pixels, role: str, dtype: np.dtype[Any], alpha: bool) -> Pixels:
    """Return pixels in another type: scaled to its range, and rounded."""
    given, shows = pixels.dtype, ROLES[role]
    if given == dtype:
        return pixels
    if given.kind == dtype.kind == "u":
        low, high = np.iinfo(given).max, np.iinfo(dtype).max
        return ((pixels.astype(np.uint32) * high + low // 2) // low).astype(dtype)
    values = pixels / np.iinfo(given).max if given.kind == "u" else pixels.astype(np.float64)
    if shows.kind == "normal" and given.kind == "f":
        values = vectors_of(pixels, middle_of(pixels)) / 2 + 0.5
    if dtype.kind == "u":
        values = np.clip(values, 0, 1)
    if shows.srgb:
        colors = (..., slice(0, -1)) if alpha else ...
        values[colors] = (to_stored if dtype.kind == "u" else to_light)(values[colors])
    return (np.rint(values * np.iinfo(dtype).max) if dtype.kind == "u" else values).astype(dtype)


class OutputSet(NamedTuple):
    """The files of a picture or a set in a folder, and what else is to be said about them."""

    folder: str
    pictures: Mapping[str, Picture]  # what the files of maps are like, by name; the main one first
    files: tuple[OutputFile, ...]
    notes: tuple[str, ...] = ()
    name: str = ""
    material: str = ""  # one of `weftex.io.presets.MATERIALS`

    @property
    def main(self) -> str:
        """The name of the main picture."""
        return next(iter(self.pictures))

    def told(self) -> list[str]:
        """Return a line for each file, and the notes."""
        held = {one.name: [part.role for part in one.parts] for one in self.files}
        lines = [
            f"{name} holds {', '.join(role for role in roles if role != UNUSED)}"
            for name, roles in held.items()
        ]
        return [*lines, *self.notes]

    def documents(
        self, read: Callable[[str], bytes], pixels: tuple[int, int] = (1, 1)
    ) -> dict[str, bytes]:
        """Return the content of the material's files by their names.

        `read` gives the bytes of a picture, and `pixels` is the height and width of the first.
        """
        if not self.material:
            return {}
        from weftex.io.materials import Place, glb, materialx_document, usda, usdz

        where, alphas = {}, {one.name for one in self.files if one.alpha}
        for one in self.files:
            start = 0
            for part in one.parts:
                width = width_of(part.role) if len(one.parts) > 1 else 0
                where[part.role] = Place(one.name, start, width)
                start += width
        height, width = pixels
        density = self.files[0].density or height  # without one the plane is one meter high
        size = width / density, height / density
        if self.material == "gltf":
            return {f"{self.name}.glb": glb(self.name, where, alphas, size, read)}
        if self.material == "usd":
            stage = {f"{self.name}.usda": usda(self.name, where, alphas, size).encode()}
            images = {one.name: read(one.name) for one in self.files}
            return stage | {f"{self.name}.usdz": usdz(stage | images)}
        text = materialx_document(self.name, where, hextiled=self.material == "materialx-hextiled")
        return {f"{self.name}.mtlx": text.encode()}

    def check(self) -> None:
        """Refuse what cannot be written, before any work."""
        by_name: dict[str, OutputFile] = {}
        for one in self.files:
            if one.name in by_name:
                twins = [file.parts[0].source for file in (by_name[one.name], one)]
                raise InvalidInputError(
                    f"{' and '.join(twins)} would both be written to {one.name}; rename one of them"
                )
            by_name[one.name] = one
            like = one.pixels(lambda key: self.pictures[key].pixels[:1, :1])
            check_output(os.path.join(self.folder, one.name), like, alpha=one.alpha)
        for name in self.documents(lambda name: b""):
            check_output(os.path.join(self.folder, name), suffixes=(suffix_of(name),))

    def write(
        self,
        staged_path: Callable[[str], str],
        pixels_of: PixelsOf | None = None,
        threads: int | None = None,
    ) -> list[str]:
        """Write the files under the temporary names that `staged_path` returns for their paths.

        Pixels are asked for by the names of maps; by default they are those of the pictures.
        Returns the names of the files.
        """
        files, at_once = self.files, thread_count(threads)
        render = pixels_of or (lambda key: self.pictures[key].pixels)
        temporary = {one.name: staged_path(os.path.join(self.folder, one.name)) for one in files}
        shapes: dict[int, tuple[int, int]] = {}

        def write_one(number: int) -> None:
            one = files[number]
            how: dict[str, Any] = {"alpha": one.alpha, "icc": one.icc, "half": one.half}
            how |= {"density": one.density, "threads": max(1, at_once // len(files))}
            pixels = one.pixels(render)
            shapes[number] = pixels.shape[:2]
            write_image(temporary[one.name], pixels, **how)

        for _ in in_turn(write_one, range(len(files)), min(at_once, len(files))):
            pass  # the first that fails ends it
        documents = self.documents(lambda name: Path(temporary[name]).read_bytes(), shapes[0])
        for name, data in documents.items():
            write_bytes(staged_path(os.path.join(self.folder, name)), data)
        return [*temporary, *documents]


def fitted_file(name: str, key: str, like: Picture, role: str) -> tuple[OutputFile, list[str]]:
    """Return a file of one map in the format of its name, and notes on what that loses."""
    kept = kept_file("", key, like, role)._replace(name=name)
    form, given, notes = FORMATS.get(suffix_of(name)), like.pixels.dtype.name, list[str]()
    data = given.startswith("float") and not ROLES[role].srgb  # which may lie outside 0 to 1
    if form is None or data:
        return kept, notes
    if given not in form.types:
        dtype = next(one for one in ("float32", "uint16", "uint8") if one in form.types)
        kept = kept._replace(dtype=np.dtype(dtype))
        bits = ["float32 (linear light)", "float32"][not ROLES[role].srgb]
        what = bits if dtype == "float32" else f"{8 * kept.dtype.itemsize} bits"
        cut = "; values outside 0 to 1 are cut off"
        cut = cut if given.startswith("float") and dtype.startswith("uint") else ""
        notes.append(f"{given} became {what}, as {suffix_of(name)} does not hold {given}{cut}")
    if kept.alpha and not form.alpha:
        notes.append(f"alpha is left out, because {suffix_of(name)} cannot store it")
        kept = kept._replace(parts=(kept.parts[0]._replace(strip=True),), alpha=False)
    return kept, notes


def kept_file(stem: str, key: str, like: Picture, role: str = "color") -> OutputFile:
    """Return a file that holds one map as it is, in the format that it came in."""
    name = stem + written_as(like.path, like.pixels.dtype.kind == "f")
    how = like.alpha, like.icc, like.half, like.density
    return OutputFile(name, (Part(role, key),), like.pixels.dtype, *how)
